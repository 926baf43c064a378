"""Certified bounds against an independent exact enumeration in Python fractions."""

from dataclasses import replace
from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest

import shakedown
from benchmarks.problems import joint
from benchmarks.rational_reference import fraction_rows, solve_fractions
from shakedown import Problem
from shakedown.bounds import largest_load_factor
from shakedown.bounds.certificate import certified_lower, load_factor_program
from shakedown.bounds.lower import collapse_limits, collapses
from shakedown.ground.status import Status
from shakedown.joint.constraints import constraints
from shakedown.programs.program import Program, Solution
from shakedown.programs.simplex import Simplex


def exact_bounds(problem: Problem) -> tuple[Fraction, Fraction]:
    """(λ_1, λ_max): smallest positive and largest load factor of the feasible intersections."""
    matrix, right = fraction_rows(problem)
    feasible = []
    for subset in combinations(range(2 * problem.n), problem.n + 1):
        x = solve_fractions([matrix[i] for i in subset], [right[i] for i in subset])
        if x is not None and all(
            sum(a * b for a, b in zip(row, x, strict=True)) <= g for row, g in zip(matrix, right, strict=True)
        ):
            feasible.append(x[-1])
    return min(value for value in feasible if value > 0), max(feasible)


def graded_joint(seed: int, n: int, decades: float) -> Problem:
    """A joint in which every node has units of its own, up to so many decades up or down."""
    force = 10.0 ** np.random.default_rng(seed).uniform(-decades, decades, n)
    return joint(seed, n, m=5, units=(force, 1.0 / force))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("n", [1, 2, 3])
def test_enclosure_contains_the_exact_bounds(seed: int, n: int) -> None:
    problem = graded_joint(seed, n, decades=seed % 3)
    bounds, (collapse, largest) = shakedown.shakedown_bounds(problem), exact_bounds(problem)
    for bound, value in ((bounds.lower, collapse), (bounds.upper, largest)):
        low, high = bound.certified
        assert Fraction(low) <= value <= Fraction(high)
        assert low <= bound.load_factor <= high
        assert high - low <= np.spacing(low)


def test_farkas_multipliers_are_exact() -> None:
    problem = shakedown.example("two-node")
    problem = replace(problem, p_w=problem.p_w - 9000.0)
    upper, (matrix, right) = shakedown.upper_bound(problem), fraction_rows(problem)
    assert (upper.status, np.isnan(upper.load_factor), upper.exact) == ("infeasible", True, True)
    assert "mean load" in upper.reason
    lower = shakedown.lower_bound(problem)
    assert (lower.status, np.isnan(lower.load_factor)) == ("infeasible", True)
    support = np.flatnonzero(upper.multipliers)
    assert len(support) == 3
    weights = solve_fractions(
        [[matrix[i][j] for i in support] for j in range(2)] + [[Fraction(1)] * 3],
        [Fraction(0), Fraction(0), Fraction(1)],
    )
    assert min(weights) > 0
    assert sum(w * right[i] for w, i in zip(weights, support, strict=True)) < 0
    assert sum(w * matrix[i][2] for w, i in zip(weights, support, strict=True)) >= 0
    np.testing.assert_allclose(
        upper.multipliers[support] / upper.multipliers.sum(), [float(w) for w in weights], rtol=1e-12
    )


def test_unbounded_direction_is_exact() -> None:
    problem = replace(shakedown.example("two-node"), f=2.5)
    upper, (matrix, _), rows = shakedown.upper_bound(problem), fraction_rows(problem), constraints(problem)
    moved, load = rows.G @ upper.direction, np.abs(rows.d)
    terms = np.maximum(np.abs(rows.G) @ np.abs(upper.direction), load)
    assert upper.residual == pytest.approx(((moved + rows.d) / terms).max())
    assert upper.residual <= 0
    assert (upper.status, upper.certified, upper.exact) == ("unbounded", (np.inf, np.inf), True)
    assert upper.reason.startswith("wedging")
    assert shakedown.lower_bound(problem).guarantee == "evidence"
    ray = [*(Fraction(x) for x in upper.direction), Fraction(1)]
    assert all(sum(a * b for a, b in zip(row, ray, strict=True)) <= 0 for row in matrix)


@pytest.mark.parametrize("tilt", [1e-13, -1e-13, 3e-16, -3e-16])
def test_nearly_parallel_rows_are_decided_exactly(tilt: float) -> None:
    """Two nodes with nearly the same stiffness: the active rows differ by less than any tolerance."""
    loads = {"q_w": [[1.0, 0.5], [-1.0, -0.5], [0.2, 0.7]], "p_w": [[4.0, 3.0], [4.5, 2.5], [3.0, 3.5]]}
    problem = Problem(A=[[2.0, 1.0], [1.0, 1.0 + tilt]], B=[[0.3, 0.1], [0.3, 0.1]], f=0.3, **loads)
    bounds, (_, largest) = shakedown.shakedown_bounds(problem), exact_bounds(problem)
    low, high = bounds.upper.certified
    assert Fraction(low) <= largest <= Fraction(high)


def test_a_mean_load_beyond_friction_by_its_last_bit_alone_is_too_much_without_dispute() -> None:
    mean = 0.1 + 0.2  # a little more than 0.1 · 3
    loads = {"q_w": [[mean + 1.0], [mean - 1.0]], "p_w": [[3.0], [3.0]], "q_mean": [mean], "p_mean": [3.0]}
    found = shakedown.upper_bound(Problem(A=[[0.0]], B=[[0.0]], f=0.1, **loads))
    assert (found.status, found.disputed) == (Status.INFEASIBLE, False)


def test_a_certificate_that_takes_too_many_pivots_is_left():
    """Where the coupling is round-off all nodes lose their ranges next to λ_max, by slips without end."""
    n, rng, t = 21, np.random.default_rng(0), 2 * np.pi * np.arange(12)[:, None] / 12
    A = 2.1 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    q_w = np.cos(t) * rng.normal(size=n) + np.sin(t) * rng.normal(size=n)
    alone = Problem(A=A, B=np.zeros((n, n)), f=0.4, q_w=q_w, p_w=4 + np.cos(2 * t) * rng.normal(size=n))
    lower = shakedown.lower_bound(replace(alone, B=1e-16 * rng.normal(size=(n, n))), certify=True)
    assert lower.certified is None
    assert "exact arithmetic" in lower.uncertified
    assert lower.load_factor == pytest.approx(shakedown.lower_bound(alone).load_factor, rel=1e-12)


@pytest.mark.parametrize("said", [Status.OPTIMAL, Status.INFEASIBLE, Status.UNBOUNDED])
@pytest.mark.parametrize(
    "problem",
    [joint(), replace(shakedown.example("two-node"), f=20.0), replace(joint(6, 3), p_w=-np.ones((6, 3)))],
    ids=["limited", "wedging", "pulled off"],
)
def test_what_floats_say_at_loosened_tolerances_changes_no_exact_answer(
    monkeypatch: pytest.MonkeyPatch, problem: Problem, said: Status
) -> None:
    expected, solve = shakedown.upper_bound(problem), largest_load_factor.solve

    def loosened(program: Program) -> Solution:
        monkeypatch.setattr(largest_load_factor, "solve", solve)
        zero = np.zeros(len(program.cost)), np.zeros(len(program.right))
        left = zero if said == Status.OPTIMAL else None
        return replace(solve(program), status=said, reduced_accuracy=True, _left=left)

    monkeypatch.setattr(largest_load_factor, "solve", loosened)
    found = shakedown.upper_bound(replace(problem))
    assert (found.reduced_accuracy, found.status, found.missing) == (True, expected.status, ())
    assert found.load_factor == pytest.approx(expected.load_factor, nan_ok=True)
    assert found.least_load_factor == pytest.approx(expected.least_load_factor, nan_ok=True)
    assert found.residual <= 1e-12


A, B = 2.0 * np.eye(3) + 0.5 * (np.eye(3, k=1) + np.eye(3, k=-1)), np.diag([-0.5, 0.0], 1)
WHOLE = Problem(A=A, B=B, f=0.5, q_w=[[-4.0, -3.0, 0.0], [-1.0, -3.0, -4.0]], p_w=np.full((2, 3), 4.0))


@pytest.mark.parametrize(
    ("drawn", "middle"),  # at a later collapse of the last the slip of the middle node is zero
    [(joint(37, 3, 1.0), -30.0), (joint(31, 3, 2.0), -30.0), (joint(39, 3, 2.0), -30.0), (WHOLE, 0.0)],
)
def test_whichever_node_floats_call_the_first_the_exact_answer_is_the_first_collapse(drawn, middle) -> None:
    away = np.array([0.0, middle, 0.0])
    problem = replace(drawn, q_w=drawn.q_w - drawn.A @ away, p_w=drawn.p_w - drawn.B @ away)
    rows, program = constraints(problem), Simplex(load_factor_program(constraints(problem), +1.0))
    ends = collapses(rows, program, collapse_limits(rows), all_nodes=True)
    loosened = {node: replace(end, reduced_accuracy=True) for node, end in ends.items()}
    firsts = [node for node, end in ends.items() if end.optimal]
    found = [certified_lower(problem, loosened, first, shakedown.Tolerances()) for first in firsts]
    assert len(found) == 2
    assert {node for node, _ in found} == {min(firsts, key=lambda node: ends[node].value)}
    assert {proved.load_factor for _, proved in found} == {float(exact_bounds(problem)[0])}


@pytest.mark.parametrize("seed", range(3))
def test_nodes_with_units_of_their_own_have_the_same_limits_of_collapse(seed: int) -> None:
    force = 4.0 ** np.random.default_rng(seed).integers(-9, 9, 5)
    joints = [joint(seed, 5, units=(unit, 1.0 / unit)) for unit in (np.ones(5), force)]
    one, other = (collapse_limits(constraints(each)) for each in joints)
    assert one.load_factors[one.known].min() == pytest.approx(shakedown.lower_bound(joints[0]).load_factor)
    np.testing.assert_array_equal(other.known, one.known)
    np.testing.assert_allclose(other.load_factors, one.load_factors, rtol=1e-12)
