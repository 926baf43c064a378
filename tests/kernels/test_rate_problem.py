"""The rate problem by three roads: pivoting, complete enumeration, Lemke's method."""

import numpy as np
import pytest

from shakedown.kernels.active_set import active_set, change_states, factorize, largest_residual, solve
from shakedown.kernels.rate_problem import (
    AIR,
    APEX,
    INSIDE,
    ON_BACKWARD,
    ON_FORWARD,
    pivot_to_solution,
    rates,
)
from shakedown.kernels.rate_search import (
    SOLVED,
    admissible_start,
    enumerate_states,
    lemke_states,
    solve_rates,
)

TOLERANCE = 1e-12


def random_instant(seed, n, f=0.3):
    """A stiffness with a unique evolution, random places of the nodes and a random change of load."""
    rng = np.random.default_rng(seed)
    G = rng.normal(size=(2 * n, 2 * n))
    kappa = G @ G.T / (2 * n) + 1.5 * np.eye(2 * n)
    assert np.linalg.eigvalsh(kappa)[0] > f * np.linalg.norm(kappa[n:], 2) / 2
    place = rng.choice([INSIDE, ON_BACKWARD, ON_FORWARD, APEX, AIR], n)
    return kappa, np.full(n, f), place, rng.normal(size=2 * n)


def set_up(kappa, f, place, welded):
    act, rate = active_set(kappa, f), rates(len(f))
    rate.place[:], rate.welded[:] = place, welded
    start = np.array([admissible_start(p, 2 if p == AIR else 0) for p in place])
    assert change_states(act, start)
    return act, rate, start


@pytest.mark.parametrize("seed", range(40))
def test_three_roads_to_the_rates(seed):
    instant = random_instant(seed, n=1 + seed % 5)
    act, rate, _ = set_up(*instant)
    assert pivot_to_solution(act, rate, TOLERANCE)
    expected = rate.motion.copy()
    for road in (enumerate_states, lemke_states):
        act, rate, start = set_up(*instant)
        assert road(act, rate, start, TOLERANCE)
        assert rate.motion == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("seed", range(10))
def test_many_nodes_at_their_limits(seed):
    """Too many for enumeration: pivoting and Lemke's method."""
    instant = random_instant(1000 + seed, n=25, f=0.2)
    act, rate, _ = set_up(*instant)
    assert solve_rates(act, rate, TOLERANCE) == SOLVED
    assert rate.pivots[1] == 0
    expected = rate.motion.copy()
    act, rate, start = set_up(*instant)
    assert not enumerate_states(act, rate, start, TOLERANCE)
    assert lemke_states(act, rate, start, TOLERANCE)
    assert rate.motion == pytest.approx(expected, abs=1e-9)


def test_inverse_follows_changes_of_state():
    """Bordering and removal against a matrix that is set up and factorized afresh."""
    rng = np.random.default_rng(0)
    kappa, f, *_ = random_instant(5, n=8)
    act, fresh = active_set(kappa, f), active_set(kappa, f)
    for _ in range(300):
        wanted = act.state.copy()
        wanted[rng.integers(0, 8, 2)] = rng.choice([0, 1, -1, 2], 2)
        assert change_states(act, wanted)
        fresh.state[:] = wanted
        assert factorize(fresh)
        assert np.array_equal(act.state, wanted)
        load, one, other = rng.normal(size=16), np.empty(16), np.empty(16)
        solve(act, load, one)
        solve(fresh, load, other)
        assert one == pytest.approx(other, abs=1e-11)
        assert act.meta[1] == fresh.meta[1]
        assert largest_residual(act, load + kappa @ one) <= 1e-12


def test_a_singular_set_of_moving_nodes_is_refused():
    stiffness = np.array([[1.0, -1.0], [-1.0, 1.0]])
    kappa = np.block([[stiffness, np.zeros((2, 2))], [np.zeros((2, 2)), np.eye(2)]])
    act = active_set(kappa, np.array([0.3, 0.3]))
    assert change_states(act, np.array([1, 0]))
    assert not change_states(act, np.array([1, 1]))
