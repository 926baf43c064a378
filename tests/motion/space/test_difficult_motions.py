"""Motions that round-off could decide: rises from nothing, closing nodes, jumps in every cycle, bodies far away."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from benchmarks.implicit_steps import ImplicitSteps
from shakedown import Outcome, Problem
from shakedown.motion import viscous_jump
from shakedown.motion.checked_law import law_resolution, law_violation, scales
from shakedown.motion.course import EventKind
from shakedown.motion.evolution import Evolution, evolve
from shakedown.motion.method import walk
from tests.joints_in_space import of_verdicts, random_joint

FLOATING, STIFF, BOTH = "floating", "stiff and soft", "floating, stiff and soft"
DRIFTING = of_verdicts(FLOATING, 35, 3)  # a joint of three nodes that jumps once a cycle and drifts
LOAD_FACTOR = 0.93  # at which it does so, above its λ_max


@pytest.mark.parametrize("n", [3, 6, 12])
def test_loads_in_proportion_are_one_implicit_step(n):
    """The load rises from nothing and pulls some nodes apart; no reaction turns on the way."""
    rng = np.random.default_rng(0)
    held = random_joint(rng, n)
    pressure = np.stack([np.zeros(n), held.p_w[0] - 3.6 * held.p_w.min() * rng.integers(0, 2, n)])
    joint = replace(held, q_transient=np.stack([np.zeros(2 * n), held.q_w[0]]), p_transient=pressure)
    path = evolve(joint, 1.0, cycles=1).history
    risen = path.rows(path.kind == EventKind.LOAD_STEP).rows([2])  # after the start and the first of two rows
    step = ImplicitSteps(joint.kappa, joint.f, 2, np.abs(joint.q_transient).max())
    slip = step.follow(np.zeros(2 * n), np.zeros(n), joint.q_transient, joint.p_transient).v[-1]
    np.testing.assert_allclose(risen.v[0], slip, rtol=0.0, atol=1e-8 * np.abs(slip).max())
    assert len(set(risen.state[0])) > 1


@pytest.mark.parametrize(("seed", "steps"), [(6, (0.0, 1.0)), (24, (0.0, 1.0)), (18, (0.0, 0.5, 1.0, 0.5))])
def test_a_joint_that_is_unloaded_to_nothing_goes_on(seed, steps):
    """There no reaction has a direction: the motion "did not come to rest" where small implicit steps go on."""
    n, m = 4, len(steps)
    rng = np.random.default_rng([seed, m // 4 * 2])
    root = rng.normal(size=(3 * n, 3 * n))
    kappa, f = root @ root.T + 0.2 * np.eye(3 * n), rng.uniform(0.1, 0.8, n)
    q, p = np.outer(steps, rng.normal(size=2 * n)), np.outer(steps, rng.normal(size=n) + 4.0)
    joint = Problem(
        A=kappa[: 2 * n, : 2 * n], B=kappa[2 * n :, : 2 * n], C=kappa[2 * n :, 2 * n :], f=f, q_w=q, p_w=p
    )
    run = evolve(joint, 1.0, cycles=3)
    assert run.stop is None
    loads = [np.vstack([0.0 * load[:1], np.tile(load, (2, 1)), load[:1]]) for load in (q, p)]
    exact = run.history.at(np.arange(2 * m + 1) / m).v
    steps = ImplicitSteps(kappa, f, 2, np.abs(q).max())
    found = steps.follow(np.zeros(2 * n), np.zeros(n), *loads, parts=100).v
    np.testing.assert_allclose(found, exact, rtol=0.0, atol=1e-3 * np.abs(exact).max())


def violation_on_the_way(motion):
    """How far reactions and gaps are outside the law; slips between rows are no straight lines."""
    problem, h = motion.problem, motion.history
    scale = scales(problem, motion.load_factor)
    return law_violation(problem.f, h.q, h.p, h.w, np.zeros_like(h.v), scale).max()


def test_small_implicit_steps_reach_the_same_state():
    """A cycle in which a soft node closes while all slip."""
    problem = of_verdicts(STIFF, 18, 1)
    passed = Evolution(problem, 0.9776574724999321)
    assert passed.cycle(record=True) is not None
    assert violation_on_the_way(passed) <= law_resolution(problem, passed.tolerances)
    h, joint = passed.history, ImplicitSteps(problem.kappa, problem.f, 2, passed.scale.force)
    first = int(np.flatnonzero(h.kind == EventKind.CLOSES)[-1])
    last = first + int(np.flatnonzero(h.kind[first:] == EventKind.LOAD_STEP)[0])
    ends = [first, last]
    steps = joint.follow(h.v[first], h.w[first], h.q_w[ends], h.p_w[ends], parts=400)
    way = np.abs(h.v[last] - h.v[first]).max()
    np.testing.assert_allclose(h.v[last], steps.v[-1], rtol=0.0, atol=1e-3 * way)


def test_a_node_that_sticks_does_not_leave_its_cone():
    """Step by step it was allowed to be a little further outside: 9e-6 in the end, of a pressure of 2e-6."""
    motion = Evolution(of_verdicts(STIFF, 22, 2), 1.8901743697598445)
    assert motion.advance(544) == 544
    assert len(walk(motion, 4, record=True).records) == 4
    assert violation_on_the_way(motion) <= 1e-8


def test_cycles_with_a_jump_repeat_and_their_drift_is_ratchetting():
    motion = Evolution(DRIFTING, LOAD_FACTOR)
    motion.advance(30)
    states = [motion.state.u]
    for _ in range(3):
        assert len(motion.cycle().jumps) == 1
        states.append(motion.state.u)
    drifts = np.diff(states, axis=0)
    assert np.ptp(drifts, axis=0).max() <= 1e-7 * np.abs(drifts).max()
    found = shakedown.long_term_state(DRIFTING, LOAD_FACTOR)
    assert found.outcome == Outcome.RATCHETTING
    drift = drifts[0, DRIFTING.layout.slips]
    np.testing.assert_allclose(found.drift / found.period, drift, rtol=0.0, atol=1e-5 * np.abs(drift).max())


def test_shorter_steps_lead_to_the_same_end(monkeypatch):
    (jump,) = Evolution(DRIFTING, LOAD_FACTOR).cycle().jumps
    monkeypatch.setattr(viscous_jump, "ACCURACY", 0.03 * viscous_jump.ACCURACY)
    monkeypatch.setattr(viscous_jump, "DISTANCE_RATIO", 1.1)
    (finer,) = Evolution(DRIFTING, LOAD_FACTOR).cycle().jumps
    way = np.abs(jump.v_after - jump.v_before).max()
    assert finer.steps > 2 * jump.steps
    np.testing.assert_allclose(finer.v_after, jump.v_after, rtol=0.0, atol=1e-2 * way)
    np.testing.assert_allclose(finer.work, jump.work, rtol=0.0, atol=1e-2 * jump.work.max())


def test_a_jump_that_stands_still_is_tried_from_farther_away():
    """Within 1e-9 of where it began it stood, next to an apex, and was called one that does not come to rest."""
    found = shakedown.long_term_state(of_verdicts(STIFF, 10, 0), 2.1069736009012625)
    assert found.outcome == Outcome.CYCLIC_SLIP
    assert found.jumps


@pytest.mark.parametrize(
    ("kind", "seed", "number", "load_factor"),
    [(FLOATING, 24, 0, 20), (FLOATING, 22, 0, 40), (BOTH, 14, 1, 12), (BOTH, 19, 0, 12), (BOTH, 28, 0, 6)],
)
def test_a_body_that_nothing_holds_slides_away(kind, seed, number, load_factor):
    """At first round-off of the stiffness held the only closed node; later a slide was sought too far away."""
    motion = Evolution(of_verdicts(kind, seed, number), load_factor)
    motion.advance(2)
    assert motion.stop.slides_away
    assert np.abs(motion.state.u).max() <= 1e6 * motion.scale.length
