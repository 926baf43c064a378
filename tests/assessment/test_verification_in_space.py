"""Prediction against simulation with two tangential directions."""

import json
from dataclasses import replace

import numpy as np
import pytest
from command import run

import shakedown
from shakedown import Problem
from shakedown.ground.errors import Missing
from shakedown.ground.work_limit import limited_work
from shakedown.motion.evolution import Evolution
from shakedown.motion.space import space_events


@pytest.fixture(scope="module")
def found():
    return shakedown.verify(shakedown.example("two-node-3d"), random_states=1)


@pytest.fixture(scope="module")
def told(found):
    """The document, and what was followed or sought once more for it."""
    followed, sought = [], []
    assert found.nodes.slip_range.shape == (2,)  # λ = 1 alone is looked at instant by instant
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Evolution, "cycle", lambda self, **_: followed.append(self))
        patched.setattr("shakedown.long_term.state.energy_ball", lambda *_, **__: sought.append(_))
        return found.to_dict(), followed + sought


def test_bounds_and_simulations_agree(found):
    assert found.agrees
    assert not found.notes
    regions = {run.region for run in found.runs}
    assert {"below λ_U", "between", "above λ_max"} <= regions
    for each in found.runs:
        assert each.simulation.residual < 1e-7
        if each.region == "below λ_U" or each.in_ball:
            assert each.simulation.outcome == "shakedown"
            assert each.agrees
    assert found.second.lower is None
    assert found.second.upper.load_factor == pytest.approx(found.limits.upper.load_factor, rel=1e-7)


def test_the_simulated_limit_lies_between_the_bounds(found):
    limits = found.limits
    proved, transient = limits.energy.load_factor, found.transient
    assert proved * (1 - 1e-9) <= transient.load_factor <= limits.upper.load_factor
    assert transient.proved <= transient.load_factor
    assert transient.cycling > transient.load_factor


def test_the_document_says_what_there_is(found, told):
    document = json.loads(json.dumps(told[0]))
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
    assert isinstance(limits.ball_at(1.01 * upper), Missing)


@pytest.mark.usefixtures("no_transient_limit")
def test_of_many_pairs_few_states_are_simulated_unless_more_are_asked_for(monkeypatch):
    joint = Problem(A=[[2, 0], [0, 2]], B=[[0, 0]], f=0.4, q_w=[[0.4, 0], [0.4, 1]], p_w=[[1], [1]])
    assert shakedown.verify(joint, load_factors=[0.5]).settings.random_states == 3
    monkeypatch.setattr("shakedown.bounds.registry.FEW_NODES", 0)
    assert shakedown.verify(joint, load_factors=[0.5]).settings.random_states == 1
    assert shakedown.verify(joint, load_factors=[0.5], random_states=2).settings.random_states == 2


@pytest.mark.usefixtures("no_transient_limit")
def test_the_command_answers(tmp_path):
    code, out, err = run("verify", "one-node-3d", "--random", "0", "--load-factor", "0.5", cwd=tmp_path)
    assert code == 0, err
    assert "Simulation agrees with the limits" in out
    assert max(map(len, out.splitlines())) <= 80


@pytest.mark.usefixtures("no_transient_limit")
def test_transient_load_steps_come_first():
    problem = shakedown.example("one-node-3d")
    before = replace(problem, q_transient=0.5 * problem.q_w[:2], p_transient=problem.p_w[:2])
    found = shakedown.verify(before, random_states=0, load_factors=[0.5])
    assert found.agrees
    assert found.runs[0].simulation.outcome == "shakedown"


def test_runs_that_take_too_much_work_are_said_to_be_open(monkeypatch):
    """Within their first cycle: nothing is claimed of them, and what is known without them stays."""
    monkeypatch.setattr(space_events, "EFFORT", 1)
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
