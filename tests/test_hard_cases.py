"""The named collection of hard cases: the default road is exact, or says what it is."""

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest

import shakedown
from benchmarks.hard_cases import HARD_CASES
from shakedown.rational import exact_rows, solve_integers

SENSITIVE = {"condition 1e8", "condition 1e12", "condition 1e14"}  # the rounded rows have another optimum
DECIDED_EXACTLY = {"barely pulled off"}


def best_intersection(problem: shakedown.Problem) -> Fraction | None:
    """The largest λ of the exact intersections on the safe region: an enumeration, no simplex."""
    rows, best = exact_rows(problem), None
    for subset in combinations(range(2 * problem.n), problem.n + 1):
        solved = solve_integers([rows.matrix[i] for i in subset], [rows.right[i] for i in subset])
        if solved is None:
            continue
        x, scale = solved
        fits = all(
            sum(a * b for a, b in zip(row, x, strict=True)) <= g * scale
            for row, g in zip(rows.matrix, rows.right, strict=True)
        )
        if fits and x[-1] >= 0:
            value = Fraction(x[-1], scale)
            best = value if best is None else max(best, value)
    return best


@pytest.mark.parametrize("name", [n for n, make in HARD_CASES.items() if make().n <= 5])
def test_upper_bound_is_the_exact_optimum(name: str) -> None:
    problem = HARD_CASES[name]()
    upper, expected = shakedown.upper_bound(problem), best_intersection(problem)
    assert upper.exact
    if upper.status == "optimal" and expected is not None:
        low, high = upper.certified
        assert Fraction(low) <= expected <= Fraction(high)
        assert upper.load_factor == pytest.approx(float(expected), rel=1e-15)
    if upper.status == "infeasible":
        assert expected is None


@pytest.mark.parametrize("name", sorted(set(HARD_CASES) - SENSITIVE - DECIDED_EXACTLY))
def test_floats_alone_are_right_to_1e_9(name: str) -> None:
    problem = HARD_CASES[name]()
    exact, plain = (shakedown.upper_bound(problem, certify=c) for c in (True, False))
    assert plain.status == exact.status
    assert plain.load_factor == pytest.approx(exact.load_factor, rel=1e-9, abs=0, nan_ok=True)
    exact, plain = (shakedown.lower_bound(problem, certify=c) for c in (True, False))
    assert plain.status == exact.status
    if name != "barely pressed":
        assert plain.load_factor == pytest.approx(exact.load_factor, rel=1e-9, abs=1e-300, nan_ok=True)


@pytest.mark.parametrize("name", sorted(HARD_CASES))
def test_lower_never_exceeds_upper_and_both_are_certified(name: str) -> None:
    bounds = shakedown.shakedown_bounds(HARD_CASES[name]())
    if bounds.upper.status == "infeasible":
        assert bounds.lower.status == "infeasible"
        return
    if bounds.lower.status == "optimal":
        low, high = bounds.lower.certified
        assert low <= bounds.lower.load_factor <= high <= bounds.upper.certified[1]


@pytest.mark.parametrize("name", ["parallel rows", "far beyond critical friction", "wedged", "point loop"])
def test_unbounded_carries_an_exact_direction(name: str) -> None:
    upper = shakedown.upper_bound(HARD_CASES[name]())
    assert (upper.status, upper.exact, upper.certified) == ("unbounded", True, (np.inf, np.inf))
    assert upper.residual <= 1e-12


@pytest.mark.parametrize(
    "name", ["mixed units", "load factor 1e9", "large forces", "small lengths", "floating"]
)
def test_conic_road_follows_through_scales(name: str) -> None:
    problem = HARD_CASES[name]()
    conic, upper = shakedown.conic_upper_bound(problem), shakedown.upper_bound(problem)
    assert conic.load_factor == pytest.approx(upper.load_factor, rel=1e-9)


@pytest.mark.parametrize("name", sorted(HARD_CASES))
def test_every_case_has_critical_load_factors_or_says_why_not(name: str) -> None:
    problem = HARD_CASES[name]()
    if problem.n > 6:
        pytest.skip("counted elsewhere")
    critical = shakedown.critical_load_factors(problem, values=True)
    assert critical.regular + critical.degenerate == critical.total
    assert np.all(np.isfinite(critical.load_factors))
    assert len(critical.load_factors) == critical.regular
