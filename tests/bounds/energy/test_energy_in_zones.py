"""Energy ball and λ_E of partly open joints: a second method, and motions from within the ball."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import shakedown
from shakedown import Problem, Status, energy_ball, energy_bound, long_term_state, upper_bound
from shakedown.joint.constraints import Side, loading
from shakedown.joint.contact_zone import contact_zone
from shakedown.motion.evolution import evolve
from tests.partly_open import SOME, partly_open, zone_bound

CASES = SOME[:3]


@cache
def with_a_ball(seed):
    """(problem, λ, ball) half-way to λ_max of the best zone of a joint, some nodes of which are open."""
    problem, upper = partly_open(seed), zone_bound(seed)
    assert upper.open_nodes
    load_factor = 0.5 * upper.load_factor
    ball = energy_ball(problem, load_factor, open_nodes=upper.open_nodes)
    assert ball.status == Status.OPTIMAL
    return problem, load_factor, ball


def test_open_nodes_limit_some():
    assert any(side == Side.GAP for seed in CASES for _, side in with_a_ball(seed)[2].active)


@pytest.mark.parametrize("seed", CASES)
def test_the_ball_touches_the_gaps_that_limit_it_and_no_other(seed):
    """A gap row is linear: over e with eᵀ A e ≤ R² it changes by at most R √(g A⁻¹ gᵀ)."""
    problem, load_factor, ball = with_a_ball(seed)
    zone = contact_zone(problem, ball.open_nodes)
    rows, centre = zone.constraints, ball.slip[list(zone.closed_nodes)]
    gaps = np.flatnonzero(rows.side == Side.GAP)
    slope = np.sqrt(np.einsum("ij,jk,ik->i", rows.G[gaps], np.linalg.inv(zone.joint.A), rows.G[gaps]))
    reach = -rows.excess(centre, load_factor)[gaps] / slope
    touched = [(int(node), Side.GAP) in ball.active for node in rows.node[gaps]]
    assert reach == pytest.approx(np.where(touched, ball.radius, np.maximum(reach, ball.radius)), rel=1e-9)


@pytest.mark.parametrize("seed", CASES)
def test_motions_from_within_the_ball_stay_in_the_zone_and_shake_down(seed):
    problem, load_factor, ball = with_a_ball(seed)
    zone, rng = contact_zone(problem, ball.open_nodes), np.random.default_rng(seed)
    closed = list(zone.closed_nodes)
    loop = loading(zone.joint).at(load_factor)
    tried = 0
    for _ in range(200):
        start = ball.at(rng.normal(size=len(closed)), 0.999)
        q, p = loop[0][0] + zone.joint.A @ start[closed], loop[1][0] + zone.joint.B @ start[closed]
        if (np.abs(q) > zone.joint.f * p).any():
            continue
        tried += 1
        run = evolve(problem, load_factor, start, open_nodes=ball.open_nodes, cycles=3)
        assert not any(cycle.opened[closed].any() for cycle in run.cycles)
        assert all(cycle.opened[list(ball.open_nodes)].all() for cycle in run.cycles)
        assert ball.contains(run.cycles[-1].end_slip)
        state = long_term_state(problem, load_factor, start, open_nodes=ball.open_nodes)
        assert state.outcome == "shakedown"
        assert state.open_nodes == ball.open_nodes
        assert state.proved
        assert state.energy_margin > 0
        if tried == 3:
            return


@pytest.mark.parametrize("seed", CASES)
def test_the_centre_with_its_radius_has_the_load_factor_of_the_ball(seed):
    problem, load_factor, ball = with_a_ball(seed)
    bound = energy_bound(problem, ball.slip, ball.radius * (1 - 1e-9), open_nodes=ball.open_nodes)
    assert bound.load_factor == pytest.approx(load_factor, rel=1e-6)
    assert bound.open_nodes == ball.open_nodes
    assert bound.certificate is None


@pytest.mark.parametrize("seed", CASES)
def test_the_bound_lies_below_that_of_the_zone_and_holds_its_state(seed):
    problem, _, ball = with_a_ball(seed)
    upper = upper_bound(problem, open_nodes=ball.open_nodes)
    bound = energy_bound(problem, upper.slip, open_nodes="auto")
    assert bound.open_nodes == upper.open_nodes
    assert 0 < bound.load_factor <= upper.load_factor * (1 + 1e-9)
    around = energy_ball(problem, 0.9 * bound.load_factor, around=upper.slip, open_nodes=upper.open_nodes)
    assert around.contains(upper.slip)
    assert bound.initial_slip == pytest.approx(upper.slip, rel=1e-9, abs=1e-12)


def test_transient_steps_count():
    problem, load_factor, ball = with_a_ball(CASES[0])
    lifted = replace(problem, q_transient=np.zeros((1, problem.n)), p_transient=np.full((1, problem.n), -9.0))
    assert energy_ball(lifted, load_factor, open_nodes=ball.open_nodes).status == Status.INFEASIBLE
    after = energy_ball(lifted, load_factor, open_nodes=ball.open_nodes, transient=False)
    assert after.radius == ball.radius
    pressed = replace(problem, q_transient=np.zeros((1, problem.n)), p_transient=np.full((1, problem.n), 1e3))
    shut = energy_ball(pressed, load_factor, open_nodes=ball.open_nodes)  # closes the open nodes
    assert shut.status == Status.INFEASIBLE


def test_a_gap_that_the_transient_narrows_limits_the_ball_there():
    loads = {"q_w": [[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0]], "p_w": [[3.0, -1.0]] * 2}
    before = {"q_transient": np.zeros((3, 4)), "p_transient": [[3.0, -0.9], [3.0, -0.5], [3.0, -0.7]]}
    B = 0.5 * np.eye(2, 4, k=-1)
    ball = energy_ball(Problem(A=np.eye(4), B=B, C=np.eye(2), f=5.0, **loads, **before), 0.5, open_nodes=[1])
    assert (1, -2) in ball.active


def test_with_all_nodes_closed_nothing_changes():
    joint = shakedown.example("block-9")
    assert energy_bound(joint, open_nodes="auto").load_factor == energy_bound(joint).load_factor
    assert energy_ball(joint, 2.0).open_nodes == ()
    assert energy_ball(joint, 2.0, open_nodes=[4]).status == Status.INFEASIBLE  # it is pressed shut
