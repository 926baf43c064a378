"""A joint followed at fixed load steps: cycles, order of the error, starts, ends that are no cycle."""

from dataclasses import replace

import numpy as np
import pytest
from joints_in_space import embedded, random_joint

import shakedown
from shakedown import Problem
from shakedown.motion.checked_law import law_violation
from shakedown.motion.fixed_steps import FixedSteps
from shakedown.motion.method import Motion, walk


def joint(pressure=3.0) -> Problem:
    return random_joint(np.random.default_rng(0), 4, pressure=pressure, m=24)


def test_what_a_cycle_did_is_what_its_load_steps_say():
    problem = joint(0.3)
    motion: Motion = FixedSteps(problem, 1.3)
    first, second = motion.cycle(record=True), motion.cycle(record=True)
    history = motion.history
    assert history.v.shape == (2 * problem.m, 8)
    before = np.vstack([np.zeros(8), history.v[:-1]])
    slip = np.where(np.repeat(history.w > 0, 2, axis=1), 0.0, history.v - before)
    closing = (history.w == 0) & (np.vstack([np.zeros(4), history.w[:-1]]) > 0)
    assert closing.any()
    still = ~closing.any(axis=0)
    length = problem.law.size(slip)
    np.testing.assert_allclose((first.slip + second.slip)[still], length.sum(axis=0)[still], rtol=1e-9)
    held = np.where(np.repeat(closing, 2, axis=1), 0.0, slip)
    assert law_violation(problem.f, history.q, history.p, history.w, held, motion.scale).max() < 1e-10
    assert first.opened.any()
    assert second.dissipation == pytest.approx(second.work.sum())
    np.testing.assert_array_equal(second.end_slip, history.v[-1])


def test_what_a_cycle_of_one_node_ends_with_stays_so():
    joint = Problem(A=np.eye(2), B=np.zeros((1, 2)), f=0.3, q_w=[[1.0, 0.0], [0.0, 1.0]], p_w=[[2.0], [2.0]])
    motion = FixedSteps(joint, 1.0)
    first = motion.cycle().end_slip
    kept = first.copy()
    motion.cycle()
    np.testing.assert_array_equal(first, kept)
    assert (motion.state.u[:2] != kept).any()


def test_loaded_in_one_direction_is_the_plane():
    plane = shakedown.example("two-node")
    one, other = walk(FixedSteps(plane, 0.9), 3), walk(FixedSteps(embedded(plane), 0.9), 3)
    size = np.abs(one.end_slip).max()
    np.testing.assert_allclose(other.end_slip[:, ::2], one.end_slip, atol=1e-11 * size)
    np.testing.assert_allclose(other.slip, one.slip, atol=1e-11 * size)
    np.testing.assert_allclose(other.dissipation, one.dissipation, rtol=1e-10)


def test_a_start_that_the_law_does_not_allow_becomes_one_that_it_does():
    problem = joint()
    motion = FixedSteps(problem, 1.0, np.full(8, 2.0))
    motion.cycle(record=True)
    first = motion.history.rows(np.arange(1))
    assert motion.problem.law.excess(problem.A @ np.full(8, 2.0) + problem.q_w[0], problem.p_w[0]).max() > 1
    excess = problem.law.excess(first.q, np.where(first.w > 0, 0.0, first.p))
    assert excess.max() < 1e-11 * motion.scale.force


def test_transient_load_steps_come_first():
    problem = joint()
    pushed = replace(problem, q_transient=np.full((3, 8), 4.0), p_transient=np.full((3, 4), 3.0))
    motion = FixedSteps(pushed, 0.2)
    assert len(motion.history) == 3
    assert motion.history.cycle[0] == -3 / 24
    assert np.abs(motion.start).max() == 0.0
    assert np.abs(motion.state.u).max() > 0.0


def test_what_cannot_be_followed_stops_with_a_reason():
    A = np.kron([[1.0, -1.0], [-1.0, 1.0]], np.eye(2))
    loop = {"q_w": [[0.0] * 4, [1.0, 0.0] * 2], "p_w": np.ones((2, 2)), "q_mean": [0.0] * 4}
    free = FixedSteps(Problem(A=A, B=np.zeros((2, 4)), f=0.5, **loop), 1.0)
    assert free.cycle() is None
    assert free.stop.slides_away
    assert not any(len(getattr(free.history, key)) for key in free.history.__dataclass_fields__)
    assert free.stop.reason == "the body slides away at load step 1"
    pulled = {"q_w": np.zeros((2, 4)), "p_w": [[1.0, 1.0], [1.0, -1.0]]}
    held = FixedSteps(Problem(A=np.eye(4), B=np.zeros((2, 4)), f=0.5, **pulled), 1.0)
    assert held.cycle() is None
    assert held.stop.reason == "node 1 lifts off at load step 1, and the problem has no C"
    assert held.cycle() is None
