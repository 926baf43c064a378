"""Frictional contact problems given by their compliance, of any rank: closed forms, the law, units, refusals."""

import numpy as np
import pytest

from benchmarks.friction_problems import FrictionStatus, solve_friction_problem
from shakedown import UsageError


def stack(n, rank, seed):
    """A compliance of n contacts and of lower rank, and velocities that press some of them together."""
    rng = np.random.default_rng(seed)
    H = rng.normal(size=(3 * n, rank))
    q = H @ rng.normal(size=rank)
    q[::3] -= 0.5 * np.abs(q).max() * rng.random(n)
    return H @ H.T, q + 0.01 * H @ rng.normal(size=rank), rng.uniform(0.2, 0.8, n)


def solvable(n, rank, seed):
    """As ``stack``, with q in the range of W, so that there are reactions."""
    W, q, mu = stack(n, rank, seed)
    return W, W @ np.linalg.lstsq(W, q, rcond=1e-10)[0], mu


def broken(r, u, q, mu):
    """The law, each condition by itself, relative to the largest reaction and velocity."""
    r, u = r.reshape(-1, 3) / max(np.abs(r).max(), 1e-3), u.reshape(-1, 3) / np.abs(q).max()
    size = np.linalg.norm(u[:, 1:], axis=1)
    against = np.abs(size[:, None] * r[:, 1:] + (mu * r[:, 0])[:, None] * u[:, 1:]).max()
    excess = (np.linalg.norm(r[:, 1:], axis=1) - mu * r[:, 0]).max()
    return max(-u[:, 0].min(), -r[:, 0].min(), np.abs(r[:, 0] * u[:, 0]).max(), excess, against)


def test_a_contact_sticks_slips_or_opens():
    found = solve_friction_problem(np.eye(9), [-1, 0.3, 0, -1, 3, 4, 1, 0, 0], [0.5, 0.5, 0.5])
    assert found.status == FrictionStatus.SOLVED
    np.testing.assert_allclose(found.r, [1, -0.3, 0, 1, -0.3, -0.4, 0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(found.u, [0, 0, 0, 0, 2.7, 3.6, 1, 0, 0], atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("rank", [0.5, 0.8, 1.0])
def test_the_law_holds_whatever_the_rank(seed, rank):
    n = 2 + 3 * seed
    W, q, mu = solvable(n, int(rank * 3 * n), seed)
    found = solve_friction_problem(W, q, mu)
    assert found.status == FrictionStatus.SOLVED
    np.testing.assert_allclose(found.u, W @ found.r + q, atol=1e-12 * np.abs(q).max())
    assert broken(found.r, found.u, q, mu) < 1e-8


def test_units_change_no_bit():
    W, q, mu = solvable(7, 12, 3)
    one = solve_friction_problem(W, q, mu)
    other = solve_friction_problem(2.0**14 * W, 2.0**-6 * q, mu)
    np.testing.assert_array_equal(2.0**-20 * one.r, other.r)
    assert one.residual == other.residual


def test_what_has_no_solution_is_said():
    """Two contacts face each other and W holds neither: their sum of velocities cannot be turned round."""
    opposed = np.array([1.0, 0.0, 0.0, -1.0, 0.0, 0.0])
    found = solve_friction_problem(np.outer(opposed, opposed), [-1.0, 0, 0, -1.0, 0, 0], [0.3, 0.3])
    assert found.status == FrictionStatus.UNSOLVED
    assert found.residual > 1e-6


@pytest.mark.parametrize(
    ("W", "q", "mu", "message"),
    [
        (np.eye(4), np.zeros(3), [0.5], "W: expected shape (3, 3) for 1 contacts, found (4, 4)"),
        (np.eye(3), np.zeros(4), [0.5], "q: expected shape (3,) for 1 contacts, found (4,)"),
        (np.eye(3), np.zeros(3), [-0.5], "mu: expected coefficients >= 0, found -0.5 at contact 0"),
        (
            np.triu(np.ones((3, 3))),
            np.zeros(3),
            [0.5],
            "W: expected a symmetric matrix, found one that is not",
        ),
        (
            -np.eye(3),
            np.zeros(3),
            [0.5],
            "W: expected a positive semi-definite matrix, found the eigenvalue -1",
        ),
        (np.eye(3), [np.nan, 0, 0], [0.5], "q: expected finite numbers, found nan"),
        (np.zeros((0, 0)), [], [], "mu: expected at least one contact, found none"),
    ],
)
def test_refused(W, q, mu, message):
    with pytest.raises(UsageError) as error:
        solve_friction_problem(W, q, mu)
    assert str(error.value) == message
