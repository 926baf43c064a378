"""Units do not matter: powers of two on stiffness, loads or lengths change no bit of the long-term state."""

from functools import cache

import numpy as np
import pytest

import shakedown
from benchmarks.problems import in_units
from tests.joints import any_joint


def agree(one, other, force, length):
    assert (one.outcome, one.period, one.cycles_simulated) == (
        other.outcome, other.period, other.cycles_simulated,
    )  # fmt: skip
    assert one.reason == other.reason
    assert np.array_equal(length * one.final_slip, other.final_slip)
    assert np.array_equal(length * one.slip_per_cycle, other.slip_per_cycle, equal_nan=True)
    energies = [one.dissipation_per_cycle * force * length, other.dissipation_per_cycle]
    assert np.array_equal(*energies, equal_nan=True)


@cache
def drawn():
    """Thirty joints and their long-term states."""
    rng = np.random.default_rng(0)
    joints = [any_joint(rng) for _ in range(30)]
    return [(joint, shakedown.long_term_state(joint, 1.0, max_cycles=40)) for joint in joints]


@pytest.mark.parametrize(("force", "length"), [(2.0**30, 2.0**-20), (2.0**-40, 1.0)])
def test_the_long_term_state_does_not_depend_on_units(force, length):
    for problem, one in drawn():
        other = shakedown.long_term_state(in_units(problem, force, length), 1.0, max_cycles=40)
        agree(one, other, force, length)
    assert [one.outcome for _, one in drawn()].count("cyclic-slip") > 5


@pytest.mark.parametrize("seed", [195, 451, 1182])
def test_a_singular_system_of_moving_nodes_is_forgotten(seed):
    """Joints whose rate problem meets singular combinations of states on its way."""
    problem = any_joint(np.random.default_rng(seed))
    one = shakedown.long_term_state(problem, 1.0, max_cycles=40)
    agree(one, shakedown.long_term_state(in_units(problem, 2.0**30, 1.0), 1.0, max_cycles=40), 2.0**30, 1.0)
