"""The wedging threshold: its witness, a stated end of the search, and joints that make the search hard."""

import numpy as np
import pytest

import shakedown
from benchmarks.problems import joint
from shakedown import Problem
from shakedown.bounds.friction_thresholds import PROGRAMS
from shakedown.ground.constants import SIX_DIGITS


def sparse_joint(seed: int) -> Problem:
    """Whole numbers and empty rows: witnesses with idle nodes, where what is to spare vanishes."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    if seed % 3 == 0:
        off = np.triu(rng.integers(-1, 2, (n, n)) * (n < 5), 1)
        A, B = off + off.T + 4.0 * np.eye(n), rng.integers(-1, 2, (n, n)).astype(float)
    elif seed % 3 == 1:
        A = np.diag(1.0 + rng.integers(0, 3, n))
        B = rng.normal(size=(n, n)) * (rng.random((n, n)) < 0.3)
    else:  # κ singular
        root = rng.integers(-2, 3, (2 * n, max(1, n - 1))).astype(float)
        kappa = root @ root.T
        A, B = kappa[:n, :n], kappa[n:, :n]
    return Problem(A=A, B=B, f=0.3, q_w=np.zeros((1, n)), p_w=np.ones((1, n)))


def test_the_smallest_hard_case_ends_at_once() -> None:
    """Only v = (1, 0) is wedged at f = 4, and node 1 is idle there."""
    problem = Problem(
        A=4 * np.eye(2),
        B=[[1.0, -1.0], [0.0, 1.0]],
        C=4 * np.eye(2),
        f=0.3,
        q_w=[[1.0, 0.0], [-1.0, 0.0]],
        p_w=np.full((2, 2), 3.0),
    )
    wedged = shakedown.friction_thresholds(problem).wedging
    assert wedged.value == pytest.approx(4.0, rel=1e-8)
    assert wedged.programs <= PROGRAMS


def test_sparse_and_integer_joints_end_with_a_bracket() -> None:
    known = 0
    for seed in range(12):
        problem = sparse_joint(seed)
        limits = shakedown.friction_thresholds(problem)
        wedged = limits.wedging
        assert wedged.programs <= PROGRAMS
        assert wedged.low <= wedged.high
        assert bool(wedged.reason) == np.isnan(wedged.value)
        known += not wedged.reason
        if np.isfinite(wedged.high):
            v = wedged.slip
            terms = np.abs(problem.A) @ np.abs(v) + wedged.high * np.abs(problem.B) @ np.abs(v)
            excess = np.abs(problem.A @ v) - wedged.high * (problem.B @ v)
            assert np.all(excess <= 1e-9 * terms)
            assert np.any(problem.B @ v > 0)
            if not wedged.reason:
                assert wedged.low >= wedged.high * (1 - SIX_DIGITS)
    assert known >= 10  # of 12


def test_a_node_whose_pressure_no_slip_changes_bears_none() -> None:
    """(A v)_2 = 0 leaves a plane of slips, which is scanned; as an inequality of a program it hid the threshold."""
    A = np.array([[0.959, -0.1595, -0.105], [-0.1595, 0.957, -0.0775], [-0.105, -0.0775, 0.926]])
    B = np.array([[-0.362, 0.032, 0.009], [0.054, -0.305, 0.032], [0.0, 0.0, 0.0]])
    plane = np.linalg.svd(A[2:])[2][1:]
    angles = np.linspace(0.0, 2 * np.pi, 200_001)
    q, p = (matrix[:2] @ plane.T @ [np.cos(angles), np.sin(angles)] for matrix in (A, B))
    needed = np.max(np.abs(q) / np.where(p > 0, p, np.nan), axis=0)
    problem = Problem(A=A, B=B, f=0.3, q_w=np.zeros((1, 3)), p_w=np.ones((1, 3)))
    wedged = shakedown.friction_thresholds(problem).wedging
    assert wedged.value == pytest.approx(np.nanmin(needed), rel=1e-4)
    assert not wedged.reason


def test_many_nodes_are_not_searched_and_say_so() -> None:
    limits = shakedown.friction_thresholds(joint(0, 101, coupling=0.1))
    wedged = limits.wedging
    assert (wedged.low, wedged.high, wedged.programs) == (limits.uniqueness_in_contact.low, np.inf, 0)
    assert np.isnan(wedged.value)
    assert "100 nodes" in wedged.reason


def test_coupling_of_the_size_of_round_off_is_none() -> None:
    """A condensation leaves 1e-16 where symmetry has 0."""
    A = 2 * np.eye(2) + 0.5
    problem = Problem(
        A=A, B=[[1e-16, -3e-16], [0.0, 2e-16]], f=0.3, q_w=np.zeros((1, 2)), p_w=np.ones((1, 2))
    )
    limits = shakedown.friction_thresholds(problem)
    assert np.all(np.isinf(limits.single_node))
    assert np.isinf(limits.uniqueness_in_contact.value)
    assert np.isinf(limits.wedging.value)
