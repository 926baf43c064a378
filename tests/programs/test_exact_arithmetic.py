"""Exact linear algebra against Python fractions, outward rounding, linear programs from any start."""

from contextlib import nullcontext
from fractions import Fraction
from itertools import combinations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from benchmarks.rational_reference import solve_fractions
from shakedown.programs.exact_program import ExactProgram, enclosure, exact_vertex, solve_integers

LAW = settings(derandomize=True, deadline=None, max_examples=20)


@LAW
@given(seed=st.integers(0, 10_000), n=st.integers(1, 7))
def test_fractions_agree(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    matrix, right = rng.integers(-9, 10, (n, n)).tolist(), rng.integers(-9, 10, n).tolist()
    plain = solve_fractions([[Fraction(a) for a in row] for row in matrix], [Fraction(b) for b in right])
    with pytest.raises(ZeroDivisionError) if plain is None else nullcontext():
        numerators, denominator = solve_integers(matrix, right)
        assert [Fraction(x, denominator) for x in numerators] == plain


@LAW
@given(numerator=st.integers(-(10**40), 10**40), denominator=st.integers(1, 10**30))
def test_enclosure_is_tight(numerator: int, denominator: int) -> None:
    low, high = enclosure(numerator, denominator)
    assert Fraction(low) <= Fraction(numerator, denominator) <= Fraction(high)
    assert high == low or high == np.nextafter(low, np.inf)


@LAW
@given(seed=st.integers(0, 10_000), n=st.integers(1, 3))
def test_every_start_ends_at_the_same_value(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    matrix = rng.integers(-3, 4, (2 * n + 2, n)).tolist()
    program = ExactProgram(matrix, rng.integers(-2, 6, 2 * n + 2).tolist(), rng.integers(-3, 4, n).tolist())
    starts = [list(rows) for rows in combinations(range(2 * n + 2), n)]
    ends = [exact_vertex(program, rows, list(range(n))) for rows in starts]
    meet = [np.linalg.matrix_rank([matrix[i] for i in rows]) == n for rows in starts]
    assert [end is not None for end in ends] == meet  # every vertex leads to an end
    ends = [end for end in ends if end is not None]
    assert len({end.status for end in ends}) <= 1
    for end in ends:
        if end.status == "unbounded":
            assert all(sum(a * b for a, b in zip(row, end.x, strict=True)) <= 0 for row in matrix)
            continue
        assert min(end.y.values(), default=0) >= 0
        balance = [sum(y * matrix[i][j] for i, y in end.y.items()) for j in range(n)]
        value = sum(y * program.right[i] for i, y in end.y.items())
        if end.status == "infeasible":
            assert balance == [0] * n
            assert value < 0
        else:
            assert balance == [c * end.y_scale for c in program.cost]
            reached = sum(c * x for c, x in zip(program.cost, end.x, strict=True))
            sides = [sum(a * b for a, b in zip(row, end.x, strict=True)) for row in matrix]
            assert all(side <= g * end.x_scale for side, g in zip(sides, program.right, strict=True))
            assert Fraction(reached, end.x_scale) == Fraction(value, end.y_scale)
