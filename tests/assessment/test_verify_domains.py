"""A load domain from file to report: only its hull is spoken of, and one path of many is simulated."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.report.facts import notes, sheet_as_text
from shakedown.report.run_facts import verify_sheet
from tests.command import document, run

DOMAIN = replace(shakedown.example("two-node"), load_path="domain")


@pytest.fixture(scope="module")
def report():
    return shakedown.verify(DOMAIN, random_states=1)


def test_predictions_end_where_every_path_is_proved(report):
    assert report.agrees, report.disagreements
    assert report.limits.lower.guarantee == "evidence"
    proved = report.limits.universal.load_factor
    assert proved < report.limits.lower.load_factor
    for found in report.runs:
        if found.region == "below λ_U":
            assert found.simulation.load_factor < proved
            assert found.predicted == "shakedown"
        elif found.region == "between" and not found.proved and found.initial != "safe":
            assert found.predicted == "either"
    assert {found.region for found in report.runs} == {"below λ_U", "between", "above λ_max"}


def test_it_is_said_for_which_paths_the_limits_hold(report):
    text = " ".join(sheet_as_text(verify_sheet(report, details=True)).split())
    for note in (notes.load_domain, notes.one_path):
        assert text.count(note) == 1
    assert "all corners passed" in text
    assert "load domain of 50 corners" in text
    assert report.to_dict()["problem"]["load_path"] == "domain"


def test_the_commands_say_it(tmp_path):
    path = str(tmp_path / "domain.npz")
    shakedown.save_problem(path, DOMAIN)
    text = run("solve", path, "--details")[1]
    assert "load domain of 50 corners" in text
    assert "λ_U from every state 0.6035" in " ".join(text.split())
    assert "least pressures" in text
    found = document("solve", path)
    assert found["problem"]["load_path"] == "domain"
    assert found["lower"]["guarantee"] == "evidence"
    assert found["universal"]["argument"] == "least pressures"
    said = " ".join(run("simulate", path, "--load-factor", "0.5")[1].split())
    assert "simulated in the order given: one path of many." in said


def test_a_sweep_of_a_domain_keeps_it():
    found = shakedown.sweep(DOMAIN, {"f": [0.35]}, bounds=("lower", "universal"))
    (point,) = found.points
    assert point["guarantee"] == "evidence"
    assert point["universal"]["load_factor"] == pytest.approx(0.6035788, abs=1e-7)
    assert np.isfinite(point["lower"]["load_factor"])
