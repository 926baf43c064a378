"""A load domain from file to report: only its hull is spoken of, and one path of many is simulated."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.report.answer_words import limits_in_words
from shakedown.report.assessment_words import certain_in_words
from shakedown.report.bound_words import bounds_in_words
from shakedown.report.data_page import loading_rows
from shakedown.report.limit_words import transient_in_words
from shakedown.report.run_words import as_given_in_words
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
        elif found.region == "between" and not found.case.proved and found.initial != "safe":
            assert found.predicted == "either"
    assert {found.region for found in report.runs} == {"below λ_U", "between", "above λ_max"}


def test_the_words_say_for_which_paths_they_hold(report):
    text = " ".join(
        [
            *certain_in_words(report.limits),
            *bounds_in_words(report.limits),
            as_given_in_words(report.as_given, "", DOMAIN, report.limits.universal),
            transient_in_words(report.transient, DOMAIN),
            *limits_in_words(report),
        ]
    )
    assert "The load steps are the corners of a load domain." in text
    assert "one path of many" in text
    assert "with the corners of the load domain in their order, the joint" in text
    assert "cannot shake down on a path that returns to all corners" in text
    assert "(two nodes)" not in text
    assert "λ_1, λ_U and what is simulated hold for this order" not in text
    loop = shakedown.verify(shakedown.example("two-node"), random_states=0, load_factors=[0.5])
    text = " ".join(limits_in_words(loop))
    assert "λ_E, λ_S and λ_max hold for every path through these load steps; λ_1, λ_U and what is" in text


def test_the_data_and_the_documents_name_it(report):
    assert ("load path", "any inside the domain of these corners") in loading_rows(DOMAIN)
    assert report.to_dict()["problem"]["load_path"] == "domain"


def test_the_commands_say_it(tmp_path):
    path = str(tmp_path / "domain.npz")
    shakedown.save_problem(path, DOMAIN)
    text = run("solve", path, "--details")[1]
    assert "load domain of 50 corners" in text
    assert "λ_U, from every state 0.6035788" in " ".join(text.split())
    assert "swing" in text
    found = document("solve", path)
    assert found["problem"]["load_path"] == "domain"
    assert found["lower"]["guarantee"] == "evidence"
    assert found["universal"]["argument"] == "swing"
    said = " ".join(run("simulate", path, "--load-factor", "0.5")[1].split())
    assert "followed here in the order given: one path of many." in said


def test_a_sweep_of_a_domain_keeps_it():
    found = shakedown.sweep(DOMAIN, {"f": [0.35]}, bounds=("lower", "universal"))
    (point,) = found.points
    assert point.guarantee == "evidence"
    assert point.load_factor("universal") == pytest.approx(0.6035788, abs=1e-7)
    assert np.isfinite(point.load_factor("lower"))
