"""Reduced scenes give the answer of the full form."""

import numpy as np
import pytest

import shakedown
from shakedown.motion.evolve import evolve
from shakedown.motion.reduced_scene import reduced_scene

TIMES = np.linspace(0.0, 1.5, 37)


def closed_joint(rng, n):
    """Weakly coupled nodes under ample pressure, of which some slip."""
    G = rng.normal(size=(2 * n, 2 * n))
    kappa = 0.05 * G @ G.T / (2 * n) + np.diag(np.repeat([1.0, 2.0], n))
    m = int(rng.integers(2, 7))
    size = rng.uniform(0.05, 1.5, n)
    return shakedown.Problem(
        A=kappa[:n, :n], B=kappa[n:, :n], C=kappa[n:, n:], f=0.4,
        q_w=size * rng.normal(size=(m, n)), p_w=2.0 + 0.2 * rng.normal(size=(m, n)),
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(12))
def test_same_path_and_long_term_state_as_the_full_form(seed):
    rng = np.random.default_rng(seed)
    problem = closed_joint(rng, int(rng.integers(2, 7)))
    start = 0.05 * rng.normal(size=problem.n)
    full = evolve(problem, 1.0, start, cycles=3)
    small = evolve(problem, 1.0, start, cycles=3, reduce=True)
    assert small.scene is not None
    a, b = full.history.at(TIMES), small.history.at(TIMES)
    for key in ("v", "w", "q", "p", "q_w", "p_w"):
        assert getattr(b, key) == pytest.approx(getattr(a, key), abs=1e-11), key
    for one, other in zip(full.cycles, small.cycles, strict=True):
        assert other.slip == pytest.approx(one.slip, abs=1e-11)
        assert other.dissipation == pytest.approx(one.dissipation, abs=1e-11)
    one = shakedown.long_term_state(problem, 1.0, start)
    other = shakedown.long_term_state(problem, 1.0, start, reduce=True)
    assert (other.outcome, other.period) == (one.outcome, one.period)
    assert other.final_slip == pytest.approx(one.final_slip, abs=1e-10)
    assert other.slip_per_cycle == pytest.approx(one.slip_per_cycle, abs=1e-10)


def test_something_is_left_out_and_what_is_left_out_does_not_move():
    kept = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        problem = closed_joint(rng, int(rng.integers(2, 7)))
        scene = reduced_scene(problem, 1.0)
        run = evolve(problem, 1.0, cycles=3)
        moved = np.ptp(run.history.v, axis=0) > 0
        opened = np.any([cycle.opened for cycle in run.cycles], axis=0)
        assert not np.any(moved & ~scene.moving)
        assert not np.any(opened & ~scene.separable)
        assert np.all(scene.clearance[~scene.moving] > 0)
        assert (scene.problem.C is None) == (not (scene.separable & scene.moving).any())
        kept.append(scene.moving.mean())
    assert min(kept) < 0.5
    assert max(kept) > 0.5


def test_nodes_that_separate_are_not_left_out():
    problem = shakedown.Problem(
        A=[[1.0, 0.2], [0.2, 1.0]], B=[[0.1, 0.0], [0.0, 0.1]], C=[[2.0, 0.3], [0.3, 2.0]], f=0.5,
        q_w=np.zeros((2, 2)), p_w=[[1.0, 1.0], [-0.5, 1.0]], q_mean=[0.0, 0.0], p_mean=[0.0, 0.0],
    )  # fmt: skip
    scene = reduced_scene(problem, 1.0)
    assert scene.separable[0]
    assert scene.moving[0]
    run = evolve(problem, 1.0, cycles=2, reduce=True)
    assert run.cycles[-1].opened[0]


def test_a_joint_that_never_moves_keeps_one_node():
    scene = reduced_scene(shakedown.example("block-33"), 1.0)
    assert scene.moving.sum() == 1
    assert scene.problem.C is None
    state = shakedown.long_term_state(shakedown.example("block-33"), 1.0, reduce=True)
    assert state.outcome == "shakedown"
    assert state.final_slip.shape == (33,)


def test_a_jump_falls_back_to_the_full_form():
    problem = shakedown.example("jump")
    run = evolve(problem, 1.0, problem.initial_slip[0], reduce=True)
    assert run.scene is None
    assert run.history.w[-1, 1] == pytest.approx(3.34427293, abs=1e-6)
