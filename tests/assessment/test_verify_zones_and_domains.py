"""Verification of partly open joints and of load domains: no prediction is believed unsupported."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import verify
from shakedown.assessment.plan import OUTSIDE
from shakedown.joint.contact_zone import contact_zone
from shakedown.report.facts import notes, sheet_as_text
from shakedown.report.limit_facts import decided_by
from shakedown.report.run_facts import verify_sheet
from tests.command import document, run
from tests.partly_open import SOME, partly_open, zone_bound

RECEDING = shakedown.example("receding-block")
DOMAIN = replace(shakedown.example("two-node"), load_path="domain")


@pytest.mark.parametrize("seed", SOME[2:3])
def test_predictions_of_zones_agree(seed):
    problem = partly_open(seed)
    result = verify(problem, random_states=1)
    upper = result.limits.upper
    assert not result.disagreements
    in_zone = [one for one in result.runs if one.open_nodes]
    if upper.status == "optimal" and upper.open_nodes:
        assert len(in_zone) >= 2
        assert all(one.predicted == "shakedown" and one.agrees for one in in_zone)
        assert all(one.simulation.open_nodes == upper.open_nodes for one in in_zone)
        beyond = [one for one in result.runs if one.region == OUTSIDE]
        assert beyond
        assert {one.predicted for one in beyond if not one.simulation.proved} <= {"either"}


def test_the_receding_block_is_predicted_and_agrees():
    result = verify(RECEDING, random_states=0, load_factors=[0.1, 0.3])
    judged = [(one.initial, one.agrees) for one in result.runs if one.agrees is not None]
    assert judged == [("safe", True)]
    assert result.second.upper.load_factor == pytest.approx(result.limits.upper.load_factor, rel=1e-7)
    assert not result.disagreements


def test_a_wrong_zone_is_reported_not_believed():
    result = verify(RECEDING, random_states=0, open_nodes=[16])
    assert result.limits.upper.status == "infeasible"
    assert all(one.agrees is None for one in result.runs)
    shown = {each.label: each.shown for each in decided_by(result.assessment)}
    assert (shown["open nodes"], shown["safe slip"]) == ("node 16 (FE 144)", "none")


def test_a_zone_that_was_not_found_is_an_open_question(monkeypatch):
    """Shakedown in another zone neither agrees with "slips or opens" nor contradicts it."""
    problem, known = partly_open(SOME[0]), zone_bound(SOME[0])
    closed = contact_zone(problem, ())
    monkeypatch.setattr("shakedown.bounds.upper.chosen_zone", lambda *given: (closed, True))
    missed = verify(problem, random_states=0, load_factors=[0.5 * known.load_factor])
    monkeypatch.setattr("shakedown.bounds.upper.chosen_zone", lambda *given: (closed, False))
    denied = verify(problem, random_states=0, load_factors=[0.5 * known.load_factor])
    unsearched = verify(problem, random_states=0, load_factors=[0.5 * known.load_factor], open_nodes=())
    for report in (missed, denied, unsearched):
        state = report.runs[1].simulation
        assert (state.outcome, state.open_nodes) == ("shakedown", known.open_nodes)
        assert not report.agrees
    assert missed.runs[1].predicted == "either"
    assert any(question.startswith("λ_max is open: no contact zone") for question in missed.open_questions)
    assert (denied.runs[1].predicted, denied.runs[1].agrees) == ("slips or opens", False)
    assert unsearched.runs[1].agrees is None
    assert any("a zone that λ_max is not about" in question for question in unsearched.open_questions)


@pytest.fixture(scope="module")
def of_domain():
    return shakedown.verify(DOMAIN, random_states=1)


def test_predictions_end_where_every_path_is_proved(of_domain):
    assert of_domain.agrees, of_domain.disagreements
    assert of_domain.limits.lower.guarantee == "evidence"
    proved = of_domain.limits.universal.load_factor
    assert proved < of_domain.limits.lower.load_factor
    for found in of_domain.runs:
        if found.region == "below λ_U":
            assert found.simulation.load_factor < proved
            assert found.predicted == "shakedown"
        elif found.region == "between" and not found.proved and found.initial != "safe":
            assert found.predicted == "either"
    assert {found.region for found in of_domain.runs} == {"below λ_U", "between", "above λ_max"}


def test_it_is_said_for_which_paths_the_limits_hold(of_domain):
    text = " ".join(sheet_as_text(verify_sheet(of_domain, details=True)).split())
    for note in (notes.load_domain, notes.one_path):
        assert text.count(note) == 1
    assert "all corners passed" in text
    assert "load domain of 50 corners" in text
    assert of_domain.to_dict()["problem"]["load_path"] == "domain"


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
