"""Uniqueness with all nodes closed: principal minors one by one, the cheap proofs, and units."""

from dataclasses import replace
from fractions import Fraction
from itertools import combinations, product

import numpy as np
import pytest

import shakedown
from benchmarks.problems import chain
from shakedown import Problem
from shakedown.bounds.coupling import coupling, first_to_lose, scaled_stiffness, unique_in_contact


def exact_determinant(matrix) -> Fraction:
    """By expansion, in fractions."""
    if len(matrix) == 1:
        return matrix[0][0]
    minors = ([row[:j] + row[j + 1 :] for row in matrix[1:]] for j in range(len(matrix)))
    return sum(((-1) ** j * matrix[0][j] * exact_determinant(m) for j, m in enumerate(minors)), Fraction(0))


def exactly_unique(problem: Problem) -> bool:
    """Every principal minor of A + S f B, in exact arithmetic."""
    n = problem.n
    A, B = ([[Fraction(x) for x in row] for row in M.tolist()] for M in (problem.A, problem.B))
    f = [Fraction(x) for x in problem.f.tolist()]
    for k in range(1, n + 1):
        for chosen, signs in product(combinations(range(n), k), product((1, -1), repeat=k)):
            rows = [
                [A[i][j] + s * f[i] * B[i][j] for j in chosen] for i, s in zip(chosen, signs, strict=True)
            ]
            if exact_determinant(rows) <= 0:
                return False
    return True


def integer_joint(seed: int) -> Problem:
    """Small whole numbers: thresholds that are hit exactly, minors that vanish exactly."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 5))
    off = np.triu(rng.integers(-1, 2, (n, n)), 1)
    A = off + off.T + 4.0 * np.eye(n)
    B = rng.integers(-1, 2, (n, n)) * (rng.random((n, n)) < 0.6)
    f = rng.choice([0.25, 0.5, 1.0, 2.0, 4.0])
    return Problem(A=A, B=B, f=f, q_w=np.zeros((1, n)), p_w=np.ones((1, n)))


@pytest.mark.parametrize("block", range(2))
def test_the_answer_is_that_of_exact_principal_minors(block: int) -> None:
    for seed in range(40 * block, 40 * block + 40):
        problem = integer_joint(seed)
        answer = unique_in_contact(problem)
        assert answer.unique is exactly_unique(problem), (seed, answer)
        assert bool(answer) is answer.unique


@pytest.mark.parametrize("n", [9, 40, 250])
def test_many_nodes_by_a_cheap_proof(n: int) -> None:
    weak = replace(chain(n), f=0.05)
    assert unique_in_contact(weak).unique is True
    strong = replace(weak, f=1e3)
    assert unique_in_contact(strong).unique is not True


@pytest.mark.parametrize("seed", range(2))
def test_energy_proves_what_dominance_cannot(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(60, 60))
    kappa = root @ root.T / 60 + 0.3 * np.eye(60)
    dense = Problem(A=kappa[:30, :30], B=kappa[30:, :30], f=0.1, q_w=np.zeros((1, 30)), p_w=np.ones((1, 30)))
    assert coupling(dense).ratio > 1
    assert unique_in_contact(dense).argument == "every motion stores more energy than friction can feed it"


def test_friction_at_the_threshold_counts_as_above() -> None:
    problem = Problem(A=[[2.0]], B=[[1.0]], f=2.0, q_w=[[0.0]], p_w=[[1.0]])
    assert unique_in_contact(problem).unique is False
    assert unique_in_contact(replace(problem, f=2.0 * (1 - 1e-8))).unique is True
    assert unique_in_contact(problem, tolerances=shakedown.Tolerances(feasibility=0.2)).unique is False
    assert (
        unique_in_contact(replace(problem, f=1.8), tolerances=shakedown.Tolerances(feasibility=0.2)).unique
        is False
    )


def test_a_double_root_ends_uniqueness() -> None:
    """det(A + t S B) = (1 − t/2)² touches zero: a defective double eigenvalue, parted by round-off."""
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s], [s, c]])
    B = turn @ np.array([[-0.5, 1.0], [0.0, -0.5]]) @ turn.T
    problem = Problem(A=np.eye(2), B=B, f=1.0, q_w=np.zeros((1, 2)), p_w=np.ones((1, 2)))
    stiffness = scaled_stiffness(problem, np.ones(2), shakedown.Tolerances())
    same = first_to_lose(stiffness, [(0, 1)])
    assert same.factor / stiffness.friction_unit <= 2.0 * (1 + 1e-6)
