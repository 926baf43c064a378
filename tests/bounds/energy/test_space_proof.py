"""The steps of the proof in space, number by number; zones, transients, means of their own, load domains."""

from dataclasses import replace

import numpy as np
import pytest
from bounds.energy.joints import gammas, space_joint

from shakedown import Problem, energy_ball, energy_bound
from shakedown.joint.constraints import loading
from shakedown.joint.contact_zone import contact_zone

STATES = 4000


def by_node(vectors: np.ndarray) -> np.ndarray:
    return vectors.reshape(*vectors.shape[:-1], -1, 2)


def in_the_ball(problem: Problem, split: bool, seed: int):
    """(A e), p, q, p*, q* of random states in the largest ball at 0.3, under random loads of the loop."""
    rng = np.random.default_rng(seed)
    load_factor = 0.3
    ball = energy_ball(problem, load_factor, split=split)
    radius = min(ball.radius, 10.0 * np.abs(problem.p_w).max())
    directions = rng.normal(size=(STATES, ball.metric.inverse.shape[1]))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    e = radius / ball.metric.unit * rng.random((STATES, 1)) ** 0.2 * (directions @ ball.metric.inverse.T)
    q_w, p_w = loading(problem).at(load_factor)
    steps = rng.integers(problem.m, size=STATES)
    centre_q, centre_p = q_w[steps] + problem.A @ ball.slip, p_w[steps] + problem.B @ ball.slip
    z, change = e @ problem.A, e @ problem.B.T
    length = np.sqrt(np.einsum("ij,ij->i", e, z))
    return ball, by_node(z), change, by_node(centre_q), centre_p, length


@pytest.mark.parametrize("split", [False, True])
@pytest.mark.parametrize("seed", range(2))
def test_the_lemmas_hold_state_by_state(seed, split):
    """Docs/energy.md: the split of a pressure, Lemma 1 for every state beyond a limit, Lemma 2."""
    problem = space_joint(seed, 1 + seed % 3, friction=0.9)
    ball, z, change, centre_q, centre_p, length = in_the_ball(problem, split, seed)
    f, share, scale = problem.f, ball.share, np.abs(problem.p_w).max()
    gamma = gammas(problem, share)
    rest = change - np.einsum("ij,kij->ki", share, z)
    assert np.all(np.abs(rest) <= gamma * length[:, None] + 1e-10 * scale)
    q, p = centre_q + z, centre_p + change
    size = np.linalg.norm(q, axis=2)
    margin = f * centre_p - np.sqrt(1 + f**2 * (share**2).sum(axis=1)) * np.linalg.norm(centre_q, axis=2)
    beyond = (size >= f * p) & (size > 0)
    assert beyond.any()
    n = -q / np.where(size > 0, size, 1.0)[..., None]
    left = (1 + f * np.einsum("ij,kij->ki", share, n)) * np.einsum("kij,kij->ki", z, n)
    assert np.all((left + margin - f * gamma * length[:, None])[beyond] <= 1e-10 * scale)
    assert np.all(left[beyond] <= 1e-10 * scale)  # slip lowers the energy of the difference
    assert np.all(p[size <= f * p] > 0)  # what is within its limit bears pressure


def test_open_nodes_keep_their_gap():
    """Every state of the ball of a zone leaves the open node open: the gap row, checked in the whole joint."""
    problem = space_joint(7, 4)
    opened = replace(problem, p_w=problem.p_w - 9.0 * (np.arange(4) == 2))
    zone = contact_zone(opened, [2])
    ball = energy_ball(opened, 0.3, open_nodes=[2])
    assert ball.open_nodes == (2,)
    assert ball.status == "optimal"
    rng = np.random.default_rng(0)
    loads = loading(opened).at(0.3)
    for _ in range(200):
        state = ball.at(rng.normal(size=6), 1 - 1e-9)
        u = zone.displacements(state[opened.layout.slips_of(zone.closed_nodes)], *loads)
        assert np.all(u[:, opened.layout.gaps][:, 2] > 0)
    bound = energy_bound(opened, ball.slip, open_nodes=[2])
    assert bound.load_factor > 0.3
    assert bound.residual <= 1e-13
    assert np.all(np.isin([node for node, _ in bound.active], range(4)))
    assert energy_bound(opened, ball.slip).status == "infeasible"


def test_transient_steps_are_further_ones_without_load_factor():
    problem = space_joint(2, 3)
    middle = energy_ball(problem, 0.0).slip
    plain = energy_bound(problem, middle, split=False, certify=False)
    loop = loading(problem)
    harmless = replace(problem, q_transient=loop.q0[None], p_transient=loop.p0[None])
    assert energy_bound(harmless, middle, split=False, certify=False).load_factor == pytest.approx(
        plain.load_factor, rel=1e-9
    )
    late = 0.9 * plain.load_factor
    q, p = loop.at(late)
    hard = replace(problem, q_transient=q, p_transient=p)
    assert energy_bound(hard, middle, split=False, certify=False).load_factor == pytest.approx(
        plain.load_factor, rel=1e-9
    )
    q, p = loop.at(1.1 * plain.load_factor)
    harder = energy_bound(replace(problem, q_transient=q, p_transient=p), middle, split=False, certify=False)
    assert harder.status == "infeasible" or harder.load_factor < plain.load_factor
    ball = energy_ball(replace(problem, q_transient=q, p_transient=p), 0.1, transient=False, split=False)
    assert ball.radius == pytest.approx(energy_ball(problem, 0.1, split=False).radius, rel=1e-9)


def test_order_of_the_load_steps_and_steps_between_do_not_matter():
    problem = space_joint(4, 3)
    shuffled = np.random.default_rng(0).permutation(problem.m)
    between = replace(
        problem,
        q_w=np.vstack([problem.q_w[shuffled], 0.5 * (problem.q_w[0] + problem.q_w[5])]),
        p_w=np.vstack([problem.p_w[shuffled], 0.5 * (problem.p_w[0] + problem.p_w[5])]),
        q_mean=loading(problem).q0,
        p_mean=loading(problem).p0,
    )
    middle = energy_ball(problem, 0.0).slip
    one, same = (energy_bound(each, middle, certify=False) for each in (problem, between))
    assert same.load_factor == pytest.approx(one.load_factor, rel=1e-10)
