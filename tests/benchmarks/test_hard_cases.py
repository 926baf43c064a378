"""The named collection of hard cases: the default method is exact, or says what it is."""

from fractions import Fraction
from functools import cache
from math import inf

import numpy as np
import pytest

import shakedown
from benchmarks.hard_cases import HARD_CASES
from benchmarks.rational_reference import fraction_rows, load_factor_range

SENSITIVE = {"condition 1e8", "condition 1e12", "condition 1e14"}  # the rounded rows have another optimum
UNRESOLVED = {"condition 1e14"}  # whether the softest motion meets a spring or round-off, nobody can tell
DECIDED_EXACTLY = {"barely pulled off"}
SMALL = sorted(name for name, make in HARD_CASES.items() if make().n <= 6)
ROWS = {name: fraction_rows(HARD_CASES[name]()) for name in SMALL}


@cache
def safe_range(name: str) -> tuple[Fraction, Fraction | float] | None:
    """The range of safe load factors of a small case, in rational arithmetic."""
    return load_factor_range(*ROWS[name])


@pytest.mark.parametrize("name", sorted(UNRESOLVED))
def test_nothing_is_certified_where_round_off_may_be_a_spring(name: str) -> None:
    bounds = shakedown.shakedown_bounds(HARD_CASES[name](), certify=True)
    for bound in (bounds.upper, bounds.lower):
        assert bound.certified is None
        assert "hardly more than its error: give stiffness_accuracy" in bound.uncertified


@pytest.mark.parametrize("name", sorted(set(SMALL) - UNRESOLVED))
def test_upper_bound_is_the_exact_optimum(name: str) -> None:
    upper, safe = shakedown.upper_bound(HARD_CASES[name]()), safe_range(name)
    assert upper.exact
    assert (safe is None) == (upper.status == "infeasible")
    if safe is None:
        return
    assert (safe[1] == inf) == (upper.status == "unbounded")
    low, high = upper.certified
    assert low <= safe[1] <= high
    assert upper.load_factor == pytest.approx(float(safe[1]), rel=1e-15)


@pytest.mark.parametrize("name", sorted(set(HARD_CASES) - SENSITIVE - DECIDED_EXACTLY))
def test_floats_alone_are_right_to_1e_9(name: str) -> None:
    problem = HARD_CASES[name]()
    for bound, size in ((shakedown.upper_bound, 0.0), (shakedown.lower_bound, 1e-300)):
        exact, plain = (bound(problem, certify=c) for c in (True, False))
        assert plain.status == exact.status
        if bound is shakedown.upper_bound or name != "barely pressed":
            assert plain.load_factor == pytest.approx(exact.load_factor, rel=1e-9, abs=size, nan_ok=True)


@pytest.mark.parametrize("name", sorted(set(HARD_CASES) - UNRESOLVED))
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
