"""Integer linear algebra without round-off: exact rows of a problem, exact solutions, outward rounding."""

from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from importlib import import_module
from importlib.util import find_spec
from math import inf, nextafter

import numpy as np
from numpy.typing import NDArray

from shakedown.model.loading import loading
from shakedown.model.problem import FloatArray, Problem

IntegerRows = list[list[int]]
FLINT_FROM = 12  # below, plain Python is done before flint is imported
HAS_FLINT = find_spec("flint") is not None


@dataclass(frozen=True)
class ExactRows:
    """The 2n constraint rows of the problem as stored, each times a positive number that makes it whole.

    Attributes
    ----------
    matrix
        [G | d], 2n rows of n + 1 integers.
    right
        g, 2n integers.
    parts, shifts
        Those positive numbers are parts · 2^−shift.
    """

    matrix: IntegerRows
    right: list[int]
    parts: int
    shifts: list[int]

    def factor(self, row: int) -> Fraction:
        """The positive number by which a row was multiplied."""
        return Fraction(self.parts) / Fraction(2) ** self.shifts[row]


def exact_rows(problem: Problem) -> ExactRows:
    """The rows of ``constraints(problem)`` without any round-off.

    Every stored number is a binary fraction, so the rows are rational: the sample
    mean divides by m. A column of the loading that ``loading`` takes as constant
    is constant here too.

    Examples
    --------
    >>> import shakedown
    >>> loop = {"q_w": [[1.0], [-1.0]], "p_w": [[3.0], [3.0]]}
    >>> rows = exact_rows(shakedown.Problem(A=[[2.0]], B=[[0.5]], f=0.5, **loop))
    >>> [[x / rows.matrix[0][1] for x in row] for row in rows.matrix], rows.right[0] / rows.matrix[0][1]
    ([[1.75, 1.0], [-2.25, 1.0]], 1.5)
    """
    loop = loading(problem)
    A, B, f = _whole(problem.A), _whole(problem.B), _whole(problem.f)
    fB = _Whole(f.numbers[:, None] * B.numbers, f.shift + B.shift)
    backward, forward = _difference(A, fB), _difference(_Whole(-A.numbers, A.shift), fB)
    q, q_mean, q_parts = _split(problem.q_w, problem.q_mean, loop.q1)
    p, p_mean, p_parts = _split(problem.p_w, problem.p_mean, loop.p1)
    q, q_mean, p, p_mean = q * p_parts, q_mean * p_parts, p * q_parts, p_mean * q_parts
    fp, fp_mean = f * p, f * p_mean
    parts = p_parts * q_parts
    d = [_extreme(_difference(q, fp)), _extreme(_difference(-q, fp))]
    g = [_difference(fp_mean, q_mean), _difference(fp_mean, -q_mean)]
    matrix: IntegerRows = []
    right: list[int] = []
    shifts: list[int] = []
    for j in range(problem.n):
        for G_side, d_side, g_side in zip((backward, forward), d, g, strict=True):
            shift = min(G_side.shift, d_side.shift, g_side.shift)
            row = [int(x) * parts << (G_side.shift - shift) for x in G_side.numbers[j]]
            matrix.append([*row, int(d_side.numbers[j]) << (d_side.shift - shift)])
            right.append(int(g_side.numbers[j]) << (g_side.shift - shift))
            shifts.append(shift)
    return ExactRows(matrix, right, parts, shifts)


@dataclass(frozen=True)
class _Whole:
    """Integers times a power of two: numbers · 2^shift."""

    numbers: NDArray[np.object_]
    shift: int

    def __mul__(self, other: "_Whole | int") -> "_Whole":
        if isinstance(other, int):
            return _Whole(self.numbers * other, self.shift)
        return _Whole(self.numbers * other.numbers, self.shift + other.shift)

    def __neg__(self) -> "_Whole":
        return _Whole(-self.numbers, self.shift)


def _whole(array: FloatArray) -> _Whole:
    mantissa, exponent = np.frexp(array)
    shift = int(exponent[array != 0].min(initial=10_000)) - 53 if np.any(array) else 0
    whole = np.ldexp(mantissa, 53).astype(np.int64).astype(object)
    lifts = np.where(array != 0, exponent - 53 - shift, 0).astype(object)
    return _Whole(whole * 2**lifts, shift)


def _difference(a: _Whole, b: _Whole) -> _Whole:
    shift = min(a.shift, b.shift)
    return _Whole(a.numbers * 2 ** (a.shift - shift) - b.numbers * 2 ** (b.shift - shift), shift)


def _split(samples: FloatArray, mean: FloatArray | None, periodic: FloatArray) -> tuple[_Whole, _Whole, int]:
    """Periodic part (m, n) and mean (n,), both times ``parts``, and ``parts``."""
    moving = np.any(periodic != 0, axis=0).astype(int).astype(object)
    if mean is None:
        w = _whole(samples)
        total, parts = w.numbers.sum(axis=0), len(samples)
        return _Whole((parts * w.numbers - total) * moving, w.shift), _Whole(total, w.shift), parts
    both = _whole(np.vstack([samples, mean]))
    constant = both.numbers[-1]
    return _Whole((both.numbers[:-1] - constant) * moving, both.shift), _Whole(constant, both.shift), 1


def _extreme(w: _Whole) -> _Whole:
    return _Whole(reduce(np.maximum, w.numbers), w.shift)


def integers(matrix: FloatArray) -> IntegerRows:
    """Floats as integers: every row times a power of two of its own."""
    return [[int(x) for x in _whole(row).numbers] for row in matrix]


def solve_integers(matrix: IntegerRows, right: list[int]) -> tuple[list[int], int] | None:
    """The solution of a square system as (numerators, common denominator > 0); None where singular.

    Examples
    --------
    >>> solve_integers([[2, 1], [1, 3]], [1, 1])
    ([2, 1], 5)
    >>> solve_integers([[1, 2], [2, 4]], [1, 1]) is None
    True
    """
    if HAS_FLINT and len(matrix) > FLINT_FROM:
        return _solve_flint(matrix, right)
    return solve_bareiss(matrix, right)


def _solve_flint(matrix: IntegerRows, right: list[int]) -> tuple[list[int], int] | None:
    flint = import_module("flint")
    try:
        solution = flint.fmpz_mat(matrix).solve(flint.fmpz_mat([[x] for x in right]))
    except ZeroDivisionError:
        return None
    numerators, denominator = solution.numer_denom()
    return [int(x) for x in numerators.entries()], int(denominator)


def solve_bareiss(matrix: IntegerRows, right: list[int]) -> tuple[list[int], int] | None:
    """``solve_integers`` by fraction-free elimination (Bareiss 1968), in plain Python."""
    n = len(matrix)
    rows = [[*row, x] for row, x in zip(matrix, right, strict=True)]
    previous = 1
    for k in range(n):
        pivot = next((i for i in range(k, n) if rows[i][k] != 0), None)
        if pivot is None:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(k + 1, n):
            rows[i] = _eliminated(rows[i], rows[k], k, previous)
        previous = rows[k][k]
    return _back_substituted(rows)


def _eliminated(row: list[int], pivot: list[int], k: int, previous: int) -> list[int]:
    head, factor = pivot[k], row[k]
    rest = zip(row[k + 1 :], pivot[k + 1 :], strict=True)
    return [0] * (k + 1) + [(head * x - factor * y) // previous for x, y in rest]


def _back_substituted(rows: IntegerRows) -> tuple[list[int], int]:
    """Numerators over the determinant: every division is without remainder (Cramer's rule)."""
    n = len(rows)
    determinant = rows[-1][n - 1]
    x = [0] * n
    for i in reversed(range(n)):
        rest = rows[i][n] * determinant - sum(rows[i][j] * x[j] for j in range(i + 1, n))
        x[i] = rest // rows[i][i]
    return (x, determinant) if determinant > 0 else ([-value for value in x], -determinant)


def enclosure(numerator: int, denominator: int) -> tuple[float, float]:
    """The narrowest [low, high] of two floats around a fraction (denominator > 0).

    Examples
    --------
    >>> low, high = enclosure(1, 10)
    >>> low < 0.1 <= high, enclosure(3, 4)
    (True, (0.75, 0.75))
    """
    try:
        near = numerator / denominator  # correctly rounded
    except OverflowError:
        return (nextafter(inf, 0.0), inf) if numerator > 0 else (-inf, nextafter(-inf, 0.0))
    p, q = near.as_integer_ratio()
    difference = p * denominator - numerator * q
    if difference > 0:
        return nextafter(near, -inf), near
    return (near, nextafter(near, inf)) if difference < 0 else (near, near)
