"""Prediction against simulation with two tangential directions."""

import json
from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.ground.errors import Missing
from shakedown.ground.tolerances import DEFAULT
from shakedown.ground.work_limit import limited_work
from shakedown.joint.constraints import constraints
from shakedown.motion.space import space_events


@pytest.fixture(scope="module")
def found():
    return shakedown.verify(shakedown.example("two-node-3d"), random_states=1)


def test_bounds_and_simulations_agree(found):
    assert found.agrees
    assert not found.notes
    assert {"below λ_U", "between", "above λ_max"} <= {run.region for run in found.runs}
    for each in found.runs:
        assert each.simulation.residual < 1e-7
        if each.region == "below λ_U" or each.in_ball:
            assert each.simulation.outcome == "shakedown"
            assert each.agrees
        if each.initial == "safe" and each.region != "above λ_max":
            excess = constraints(each.simulation.problem).relative_excess(each.start, each.load_factor)
            assert excess.max() <= DEFAULT.feasibility
    transient = found.transient
    assert found.limits.energy.load_factor * (1 - 1e-9) <= transient.load_factor < transient.cycling
    assert transient.proved <= transient.load_factor <= found.limits.upper.load_factor
    assert found.second.lower is None
    assert found.second.upper.load_factor == pytest.approx(found.limits.upper.load_factor, rel=1e-7)


def test_the_document_says_what_there_is(found):
    document = json.loads(json.dumps(found.to_dict()))
    assert document["lower"] is document["box"] is document["friction"] is document["critical"] is None
    assert document["universal"]["load_factor"] == found.limits.universal.load_factor
    assert len(document["runs"]) == len(found.runs)
    assert len(document["nodes"]["slip_range_x"]) == 2
    assert np.isfinite(document["upper"]["certified"]).all()


def test_a_ball_of_the_plan_holds_what_is_proved():
    limits = shakedown.assess(shakedown.example("four-node-3d")).details
    energy, upper = limits.energy.load_factor, limits.upper.load_factor
    for load_factor in (0.9 * energy, 0.5 * (energy + upper)):
        ball = limits.ball_at(load_factor)
        assert ball.radius > 0
        assert limits.ball_at(load_factor) is ball
        assert bool(ball.contains(np.zeros(8))) == (load_factor < energy)
    assert ball.contains(0.5 * (limits.energy.slip + limits.upper.slip))  # safe halfway between the limits
    assert isinstance(limits.ball_at(1.01 * upper), Missing)


@pytest.mark.usefixtures("no_transient_limit")
def test_transient_load_steps_come_first():
    problem = shakedown.example("one-node-3d")
    before = replace(problem, q_transient=0.5 * problem.q_w[:2], p_transient=problem.p_w[:2])
    found = shakedown.verify(before, random_states=0, load_factors=[0.5])
    assert found.agrees
    assert found.transient is None  # the fixture does what it says
    assert found.runs[0].simulation.outcome == "shakedown"


def test_above_λ_max_other_starts_have_the_work_that_the_first_one_leaves(monkeypatch):
    """With as much as it takes a run comes to its end, with less it is cut; the first one is not."""
    problem = shakedown.example("two-node-3d")
    load_factor, starts = 1.05 * shakedown.upper_bound(problem).load_factor, (np.zeros(4), np.full(4, 1e-3))
    monkeypatch.setattr(space_events, "CALL_OPERATIONS", 1)

    def beyond(limits, start):
        found, work = limits.slip_beyond(load_factor, start, 1000)
        return work, "the computation allowed for a run is spent" in found.reason

    (first, _), (other, _) = (beyond(shakedown.assess(problem, start).details, start) for start in starts)
    for share, cut in ((1.1, False), (0.5, True)):
        monkeypatch.setattr("shakedown.assessment.every_limit.WORK_BEYOND", first + share * other)
        limits = shakedown.assess(problem).details
        assert [beyond(limits, start)[1] for start in starts] == [False, cut]


def test_runs_that_take_too_much_work_are_said_to_be_open(monkeypatch):
    """Within their first cycle: nothing is claimed of them, and what is known without them stays."""
    monkeypatch.setattr(space_events, "CALL_OPERATIONS", 1)
    monkeypatch.setattr("shakedown.assessment.verify.limited_work", lambda _: limited_work(1e3))
    cut = shakedown.verify(shakedown.example("two-node-3d"), random_states=1)
    open_runs = [each for each in cut.runs if each.simulation.outcome == "undecided"]
    assert open_runs
    assert all(each.agrees is None for each in open_runs)
    assert not cut.disagreements
    said = [text for text in cut.open_questions if "the computation allowed for a run is spent" in text]
    assert len(said) == len(open_runs)
    assert all(text.endswith("; simulate, which has no such limit, goes on with it") for text in said)
    assert cut.limits.upper.load_factor > 0.0
    assert cut.to_dict()
