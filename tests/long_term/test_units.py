"""Units do not matter: powers of two on stiffness, loads or lengths change no bit of the long-term state."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown


def random_joint(rng):
    """Any rank of κ from n on, whole numbers now and then, friction far above the thresholds too."""
    n, m = int(rng.integers(1, 5)), int(rng.integers(2, 7))
    rank = int(rng.integers(n, 2 * n + 1)) if rng.random() < 0.7 else 2 * n
    whole = rng.random() < 0.4
    G = rng.integers(-2, 3, (2 * n, rank)).astype(float) if whole else rng.normal(size=(2 * n, rank))
    kappa = G @ G.T
    p_w = rng.uniform(0.5, 3.0, n) + rng.normal(size=(m, n)) * rng.uniform(0.05, 1.2)
    q_w = 0.6 * rng.normal(size=(m, n))
    if rng.random() < 0.3:
        p_w, q_w = np.round(4 * p_w) / 4, np.round(4 * q_w) / 4
    return shakedown.Problem(
        A=kappa[:n, :n], B=kappa[n:, :n], C=kappa[n:, n:], f=rng.uniform(0.2, 3.0), q_w=q_w, p_w=p_w
    )


def in_units(problem, force, length):
    """The same joint in units of force and length 1/``force`` and 1/``length`` times as large."""
    stiffness = force / length
    return replace(
        problem, A=stiffness * problem.A, B=stiffness * problem.B, C=stiffness * problem.C,
        q_w=force * problem.q_w, p_w=force * problem.p_w,
    )  # fmt: skip


def agree(one, other, force, length):
    assert (one.outcome, one.period, one.cycles_simulated) == (
        other.outcome, other.period, other.cycles_simulated,
    )  # fmt: skip
    assert one.reason == other.reason
    assert np.array_equal(length * one.final_slip, other.final_slip)
    assert np.array_equal(length * one.slip_per_cycle, other.slip_per_cycle, equal_nan=True)
    energies = [one.dissipation_per_cycle * force * length, other.dissipation_per_cycle]
    assert np.array_equal(*energies, equal_nan=True)


@pytest.mark.parametrize(("force", "length"), [(2.0**30, 1.0), (2.0**-40, 1.0), (1.0, 2.0**-20)])
@pytest.mark.parametrize("seed", range(3))
def test_the_long_term_state_does_not_depend_on_units(seed, force, length):
    rng, drawn = np.random.default_rng(seed), []
    for _ in range(60):
        problem = random_joint(rng)
        one = shakedown.long_term_state(problem, 1.0, max_cycles=40)
        other = shakedown.long_term_state(in_units(problem, force, length), 1.0, max_cycles=40)
        agree(one, other, force, length)
        drawn.append(one.outcome)
    assert drawn.count("cyclic-slip") > 5


@pytest.mark.parametrize("seed", [195, 451, 931, 1182])
def test_a_singular_system_of_moving_nodes_is_forgotten(seed):
    """Joints whose rate problem meets singular combinations of states on its way."""
    problem = random_joint(np.random.default_rng(seed))
    one = shakedown.long_term_state(problem, 1.0, max_cycles=40)
    agree(one, shakedown.long_term_state(in_units(problem, 2.0**30, 1.0), 1.0, max_cycles=40), 2.0**30, 1.0)
