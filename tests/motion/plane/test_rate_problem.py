"""The rate problem by two methods: pivoting and complete enumeration."""

import numpy as np
import pytest

from shakedown.ground.named_state import entered
from shakedown.ground.status import OPEN, STICK
from shakedown.motion.plane.active_set import (
    AIR,
    APEX,
    INSIDE,
    ON_BACKWARD,
    ON_FORWARD,
    active_set,
    rates,
    solve_rates,
)
from shakedown.motion.plane.event_loop import enumerate_states, take_wanted

TOLERANCE = 1e-12


@entered
def pivot(act, rate, tolerance):
    """Pivoting alone, which compiled loops call."""
    return solve_rates(act, rate, tolerance, False)


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
    assert take_states(act, rate, np.where(place == AIR, OPEN, STICK))
    return act, rate


def take_states(act, rate, states):
    rate.wanted[:] = states
    return take_wanted(act, rate)


@pytest.mark.parametrize("seed", range(10))
def test_pivoting_and_enumeration_find_the_same_rates(seed):
    instant = random_instant(seed, n=1 + seed % 5)
    act, rate = set_up(*instant)
    assert pivot(act, rate, TOLERANCE)
    expected = rate.motion.copy()
    act, rate = set_up(*instant)
    assert enumerate_states(act, rate, TOLERANCE)
    assert rate.motion == pytest.approx(expected, abs=1e-10)


def test_a_singular_set_of_moving_nodes_is_refused():
    stiffness = np.array([[1.0, -1.0], [-1.0, 1.0]])
    kappa = np.block([[stiffness, np.zeros((2, 2))], [np.zeros((2, 2)), np.eye(2)]])
    act = active_set(kappa, np.array([0.3, 0.3]))
    rate = rates(2)
    assert take_states(act, rate, np.array([1, 0]))
    assert not take_states(act, rate, np.array([1, 1]))
