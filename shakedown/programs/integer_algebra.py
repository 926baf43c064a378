"""Linear algebra in integers, without round-off (FLINT), and conversion back to floats."""

from __future__ import annotations

from math import inf, nextafter
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from flint import fmpq_mat, fmpz_mat

IntegerRows = list[list[int]]


def integer_matrix(rows: IntegerRows) -> fmpz_mat:
    """Rows of integers as a FLINT matrix."""
    from flint import fmpz_mat  # not needed where only floats are used

    return fmpz_mat(rows)


def integer_column(numbers: list[int]) -> fmpz_mat:
    """Integers as a FLINT matrix of one column."""
    return integer_matrix([[x] for x in numbers])


def solve_integers(matrix: IntegerRows, right: list[int]) -> tuple[list[int], int] | None:
    """The solution of a square system as (numerators, common denominator > 0); None where singular.

    Examples
    --------
    >>> solve_integers([[2, 1], [1, 3]], [1, 1])
    ([2, 1], 5)
    >>> solve_integers([[1, 2], [2, 4]], [1, 1]) is None
    True
    """
    return solve_matrix(integer_matrix(matrix), right)


def solve_matrix(matrix: fmpz_mat, right: list[int]) -> tuple[list[int], int] | None:
    """:func:`solve_integers` for a FLINT matrix."""
    if not right:
        return [], 1
    try:
        solution = cast("fmpq_mat", matrix.solve(integer_column(right)))
    except ZeroDivisionError:
        return None
    numerators, denominator = solution.numer_denom()
    return [int(x) for x in numerators.entries()], int(denominator)


def product(matrix: fmpz_mat, vector: list[int]) -> list[int]:
    """Matrix times vector.

    Examples
    --------
    >>> product(integer_matrix([[1, 2], [3, 4]]), [1, -1])
    [-1, -1]
    """
    if not vector:
        return [0] * matrix.nrows()
    return [int(x) for x in (matrix * integer_column(vector)).entries()]


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
