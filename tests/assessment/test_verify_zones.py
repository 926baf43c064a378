"""Verification of partly open joints: what is predicted, and that no prediction is believed unsupported."""

import pytest

import shakedown
from shakedown import verify
from shakedown.assessment.plan import OUTSIDE
from shakedown.joint.contact_zone import contact_zone
from shakedown.report.limit_facts import decided_by
from tests.partly_open import SOME, partly_open, zone_bound

RECEDING = shakedown.example("receding-block")


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
        run = report.runs[1]
        assert (run.simulation.outcome, run.simulation.open_nodes) == ("shakedown", known.open_nodes)
        assert not report.agrees
    assert missed.runs[1].predicted == "either"
    assert any(question.startswith("λ_max is open: no contact zone") for question in missed.open_questions)
    assert (denied.runs[1].predicted, denied.runs[1].agrees) == ("slips or opens", False)
    assert unsearched.runs[1].agrees is None
    assert any("a zone that λ_max is not about" in question for question in unsearched.open_questions)
