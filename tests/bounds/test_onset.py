"""First slip and first opening: below it the simulation stays where it starts, above it a node slips."""

from dataclasses import replace

import numpy as np
import pytest
from joints import any_joint
from joints_in_space import random_joint

import shakedown
from shakedown import Problem
from shakedown.bounds.onset import first_opening, first_slip
from shakedown.ground.status import Status
from shakedown.joint.constraints import loop_path, transient_path

NEAR = 1e-6
QUARTERS = 2 * np.pi * np.arange(4) / 4


def one_node(f: float = 0.5, **changed) -> Problem:
    """q = 2 sin t + v, p = 3 + cos t + v/2: at v = 0 |q| = f p where 2 λ = f · 3, p = 0 at λ = 3."""
    loop = {"q_w": 2 * np.sin(QUARTERS)[:, None], "p_w": 3 + np.cos(QUARTERS)[:, None]}
    return replace(Problem(A=[[1.0]], B=[[0.5]], f=f, **loop), **changed)


def stuck(problem: Problem, load_factor: float, slip: np.ndarray) -> np.ndarray:
    """The excess |q| − f p of all nodes at all load steps, without slip, (k + m, n)."""
    path = np.vstack([transient_path(problem), loop_path(problem, load_factor)])
    q, p = problem.layout.split(path)
    return problem.law.excess(q + problem.A @ slip, p + problem.B @ slip)


def moves(problem: Problem, load_factor: float, slip: np.ndarray) -> bool:
    run = shakedown.simulate(problem, load_factor, slip, cycles=1)
    return bool((run.final_slip != slip).any() or (run.slip_per_cycle > 0).any())


def test_one_node_in_closed_form():
    joint = one_node()
    found, opening = first_slip(joint), first_opening(joint)
    assert (found.load_factor, found.node, found.step) == (pytest.approx(0.75), 0, 1)
    assert (opening.load_factor, opening.node, opening.step) == (pytest.approx(3.0), 0, 2)
    assert first_slip(joint, [0.5]).load_factor == pytest.approx((0.5 * 3.25 - 0.5) / 2)
    assert first_opening(joint, [0.5]).load_factor == pytest.approx(3.25)


@pytest.mark.parametrize(
    "name", ["one-node", "two-node", "block-9", "press-fit", "one-node-3d", "four-node-3d"]
)
def test_nothing_slips_below_it_and_a_node_does_above(name):
    joint = shakedown.example(name)
    start, found = np.zeros(joint.layout.slip_size), first_slip(joint)
    assert not moves(joint, found.load_factor * (1 - NEAR), start)
    assert moves(joint, found.load_factor * (1 + 1e-3), start)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("space", [False, True])
def test_the_law_holds_at_every_load_step_up_to_there_and_not_beyond(seed, space):
    rng = np.random.default_rng(seed)
    joint = random_joint(rng, 3, pressure=8.0) if space else any_joint(rng)
    slip = 0.02 * rng.normal(size=joint.layout.slip_size)
    found, opening = first_slip(joint, slip), first_opening(joint, slip)
    if found.status == Status.INFEASIBLE:
        assert stuck(joint, 0.0, slip).max() > 0
        return
    assert found.status == Status.OPTIMAL
    assert found.load_factor <= opening.load_factor
    assert stuck(joint, found.load_factor * (1 - NEAR), slip).max() < 0
    beyond = stuck(joint, found.load_factor * (1 + NEAR), slip)
    row = found.step + len(beyond) - joint.m
    assert beyond[row, found.node] > 0
    assert np.unravel_index(beyond.argmax(), beyond.shape)[1] == found.node
    if opening.status == Status.OPTIMAL:
        p = joint.layout.split(loop_path(joint, opening.load_factor))[1] + joint.B @ slip
        assert p.min() == pytest.approx(0.0, abs=1e-9 * np.abs(p).max())


def test_nodes_without_friction_move_freely_and_shift_the_others():
    """v_1 = −q_1(t) at A = [[2, 1], [1, 1]] adds −q_1 to q_0, so that q_0 − q_1 is held against f p."""
    q_w = np.column_stack([np.sin(QUARTERS), -np.sin(QUARTERS)])
    joint = Problem(A=[[2, 1], [1, 1]], B=np.zeros((2, 2)), f=[0.5, 0.0], q_w=q_w, p_w=np.full((4, 2), 3.0))
    found = first_slip(joint)
    assert (found.load_factor, found.node) == (pytest.approx(0.75), 0)
    still = one_node(f=0.0)  # opens where p = 3 + λ cos t − λ sin t is zero
    assert first_slip(still).load_factor == first_opening(still).load_factor == pytest.approx(3.0)


def test_what_slips_or_opens_already_without_the_varying_load_or_never_says_so():
    mean = first_slip(one_node(q_mean=[2.0], p_mean=[3.0]))
    before = first_slip(one_node(q_transient=[[0.0], [2.0]], p_transient=[[3.0], [3.0]]))
    assert (mean.load_factor, mean.status, mean.node) == (0.0, Status.INFEASIBLE, 0)
    assert "constant part" in mean.reason
    assert (before.load_factor, before.step) == (0.0, -1)
    assert "transient" in before.reason
    opened = first_opening(one_node(), [-7.0])
    assert (opened.load_factor, opened.status) == (0.0, Status.INFEASIBLE)
    found = first_slip(one_node(q_mean=[np.nextafter(0.5 * 3.0, 2.0)], p_mean=[3.0]))
    assert (found.load_factor, found.status) == (0.0, Status.OPTIMAL)  # by round-off: it is on its limit
    quiet = Problem(A=[[1.0]], B=[[0.0]], f=0.5, q_w=[[0.0], [0.0]], p_w=[[2.0], [2.0]])
    assert (first_slip(quiet).load_factor, first_slip(quiet).status) == (np.inf, Status.UNBOUNDED)
    assert first_slip(quiet).node == -1
