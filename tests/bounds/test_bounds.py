"""Bounds against cited values, brute force, constructed optima and the laws of scaling."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from joints import creeping

import shakedown
from benchmarks.problems import joint
from shakedown import Problem
from shakedown.joint.constraints import constraints


def collapse_by_brute_force(problem: Problem) -> float:
    """The smallest positive one-pair intersection that lies on the safe region (n 2ⁿ⁻¹ subsets)."""
    rows, best = constraints(problem), np.inf
    matrix = np.column_stack([rows.G, rows.d])
    for pair in range(problem.n):
        others = [i for i in range(problem.n) if i != pair]
        for sides in product((0, 1), repeat=len(others)):
            subset = [2 * pair, 2 * pair + 1, *(2 * i + s for i, s in zip(others, sides, strict=True))]
            if np.linalg.cond(matrix[subset]) > 1e12:
                continue
            x = np.linalg.solve(matrix[subset], rows.g[subset])
            if 0 < x[-1] < best and rows.relative_excess(x[:-1], x[-1]).max() < 1e-10:
                best = x[-1]
    return float(best)


def positive_combination(G: np.ndarray, pair: int) -> tuple[list[int], np.ndarray]:
    """n + 1 rows, two of them of one node, with positive multipliers y such that yᵀ G = 0."""
    n = G.shape[1]
    others = [j for j in range(n) if j != pair]
    for sides in product((0, 1), repeat=n - 1):
        subset = [2 * pair, 2 * pair + 1, *(2 * j + s for j, s in zip(others, sides, strict=True))]
        y = np.linalg.svd(G[subset].T)[2][-1]
        y = y if y.sum() > 0 else -y
        if y.min() > 0:
            return subset, y
    raise AssertionError("no choice of sides closes the region")


def test_two_node_system_has_the_thesis_bounds() -> None:
    bounds = shakedown.shakedown_bounds(shakedown.example("two-node"))
    assert bounds.lower.load_factor == pytest.approx(0.6573734697246544, rel=1e-12)
    assert bounds.upper.load_factor == pytest.approx(0.7391455673806329, rel=1e-12)
    np.testing.assert_allclose(bounds.lower.slip, [1.53656435, 1.59365716], atol=1e-8)
    np.testing.assert_allclose(bounds.upper.slip, [-0.15634934, 1.28772669], atol=1e-8)


@pytest.mark.parametrize(
    ("name", "f", "lower", "upper"),
    [
        ("block-9", 0.5, 0.0, 4.715032),
        ("block-9", 0.2, 1.219830, 1.730955),
        ("three-node", 0.5, 3.096, 10 / 3),
    ],
)
def test_known_systems(name: str, f: float, lower: float, upper: float) -> None:
    bounds = shakedown.shakedown_bounds(replace(shakedown.example(name), f=f))
    assert bounds.lower.load_factor == pytest.approx(lower, abs=5e-7)
    assert bounds.upper.load_factor == pytest.approx(upper, abs=5e-7)
    if lower == 0:
        assert f"some locked-in slip lifts node {bounds.lower.node} off" in bounds.lower.reason


@pytest.mark.parametrize("n", [1, 2, 4, 6])
@pytest.mark.parametrize("seed", range(2))
def test_lower_bound_is_the_smallest_feasible_intersection(n: int, seed: int) -> None:
    problem = joint(seed, n)
    lower = shakedown.lower_bound(problem)
    assert lower.load_factor > 0
    brute = collapse_by_brute_force(problem)
    critical = shakedown.critical_load_factors(problem)
    assert lower.load_factor == pytest.approx(brute, rel=1e-11)
    assert critical.smallest_feasible.load_factor == pytest.approx(brute, rel=1e-11)
    assert critical.smallest_positive.load_factor <= lower.load_factor * (1 + 1e-11)
    assert lower.load_factor <= shakedown.upper_bound(problem).load_factor * (1 + 1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_constructed_optimum_is_found(seed: int) -> None:
    """Build the loads backwards from a chosen vertex and its multipliers."""
    rng = np.random.default_rng(seed)
    problem = joint(seed, 4)
    rows = constraints(problem)
    slip, load_factor = rng.normal(size=4), 0.7
    subset, y = positive_combination(rows.G, pair=2)
    assert np.abs(y @ rows.G[subset]).max() < 1e-12
    amplitude = rng.uniform(0.5, 1.5, 4)
    quiet = Problem(A=problem.A, B=problem.B, f=problem.f, q_w=np.zeros((1, 4)), p_w=np.zeros((1, 4)))
    slack = np.where(np.isin(np.arange(8), subset), 0.0, rng.uniform(0.1, 1.0, 8))
    g = rows.G @ slip + load_factor * np.repeat(amplitude, 2) + slack
    p0, q0 = (g[::2] + g[1::2]) / (2 * problem.f), (g[1::2] - g[::2]) / 2
    loop = np.array([[1.0], [-1.0]]) * amplitude
    built = replace(quiet, q_w=q0 + loop, p_w=np.tile(p0, (2, 1)))
    upper = shakedown.upper_bound(built)
    assert upper.load_factor == pytest.approx(load_factor, rel=1e-11)
    np.testing.assert_allclose(upper.slip, slip, atol=1e-9)


def test_zero_amplitude_is_told_from_wedging() -> None:
    problem = shakedown.example("two-node")
    point = replace(problem, q_w=problem.q_w[:1], p_w=problem.p_w[:1])
    upper = shakedown.upper_bound(point)
    assert upper.status == "unbounded"
    assert upper.reason.startswith("zero-amplitude loop")
    uncoupled = shakedown.lower_bound(replace(point, B=np.zeros((2, 2))))
    assert (uncoupled.status, uncoupled.load_factor, uncoupled.node) == ("unbounded", np.inf, -1)
    A = problem.A
    assert uncoupled.coupling_ratio == pytest.approx(abs(A[0, 1]) / np.sqrt(A[0, 0] * A[1, 1]))
    assert uncoupled.guarantee == "proved"


def test_a_floating_body_without_coupling_shakes_down_below_the_upper_bound() -> None:
    """Its safe slips vanish all together: no single node collapses, and λ_1 is λ_max (Melan)."""
    bounds = shakedown.shakedown_bounds(creeping())
    assert bounds.upper.load_factor == pytest.approx(5 / 9, rel=1e-12)
    assert bounds.lower.load_factor == bounds.upper.load_factor
    assert (bounds.lower.node, bounds.lower.guarantee) == (-1, "proved")
    assert "vanish together" in bounds.lower.reason
    assert bounds.lower.coupling_ratio == pytest.approx(1.0)


def test_the_round_off_of_a_rigid_motion_is_no_answer() -> None:
    """The stored stiffness of a floating block resists rigid motion by 1e-15; no bound may build on that."""
    bounds = shakedown.shakedown_bounds(shakedown.example("receding-block"))
    assert bounds.upper.status == bounds.lower.status == "infeasible"
    assert bounds.upper.certified is None
