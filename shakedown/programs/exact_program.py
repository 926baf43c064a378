"""Linear programs at a vertex in exact arithmetic."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import inf, nextafter
from typing import TYPE_CHECKING, cast

from shakedown.ground.status import Status

if TYPE_CHECKING:
    from flint import fmpq_mat, fmpz_mat


IntegerRows = list[list[int]]


def integer_matrix(rows: IntegerRows) -> fmpz_mat:
    """Rows of integers as a FLINT matrix."""
    from flint import fmpz_mat  # not needed where only floats are used

    return fmpz_mat(rows)


def solve_integers(matrix: IntegerRows, right: list[int]) -> tuple[list[int], int]:
    """The solution of a square system as (numerators, common denominator > 0).

    Raises
    ------
    ZeroDivisionError
        If it is singular.

    Examples
    --------
    >>> solve_integers([[2, 1], [1, 3]], [1, 1])
    ([2, 1], 5)
    """
    if not right:
        return [], 1
    solution = cast("fmpq_mat", integer_matrix(matrix).solve(integer_matrix([[x] for x in right])))
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
    return [int(x) for x in (matrix * integer_matrix([[x] for x in vector])).entries()]


def enclosure(numerator: int, denominator: int) -> tuple[float, float]:
    """The narrowest [low, high] of two floats around a fraction (denominator > 0).

    Examples
    --------
    >>> low, high = enclosure(1, 10)
    >>> low < 0.1 <= high, enclosure(3, 4)
    (True, (0.75, 0.75))
    >>> enclosure(10**400, 1), enclosure(-(10**400), 1)
    ((1.7976931348623157e+308, inf), (-inf, -1.7976931348623157e+308))
    """
    try:
        near = numerator / denominator  # correctly rounded
    except OverflowError:
        return (nextafter(inf, 0.0), inf) if numerator > 0 else (-inf, nextafter(-inf, 0.0))
    p, q = near.as_integer_ratio()
    above = p * denominator - numerator * q
    low = nextafter(near, -inf) if above > 0 else near
    return low, nextafter(near, inf) if above < 0 else near


MAX_WORK = 2 * 10**7  # pivots times the cube of their size: seconds, where the start is far off


@dataclass(frozen=True)
class ExactProgram:
    """Maximise cost · x subject to matrix · x ≤ right, in integers."""

    matrix: IntegerRows
    right: list[int]
    cost: list[int]

    @cached_property
    def table(self) -> fmpz_mat:
        """The matrix as a FLINT matrix."""
        return integer_matrix(self.matrix)

    def columns(self, chosen: list[int]) -> ExactProgram:
        """The program in some of its columns, all others held at zero."""
        if chosen == list(range(len(self.cost))):
            return self
        matrix = [[row[j] for j in chosen] for row in self.matrix]
        return ExactProgram(matrix, self.right, [self.cost[j] for j in chosen])


@dataclass(frozen=True)
class ExactVertex:
    """The exact end of an :class:`ExactProgram`.

    Attributes
    ----------
    status
        Optimal; infeasible; unbounded (there is a ray of improvement;
        whether there is a feasible point as well is not examined).
    x, x_scale
        The solution, or the ray, as numerators and common denominator > 0.
    y, y_scale
        Multipliers ≥ 0 by row that prove optimality or infeasibility, likewise.
    """

    status: Status
    x: list[int]
    x_scale: int
    y: dict[int, int]
    y_scale: int


class PivotBudget:
    """The budget of the pivots of one or several programs, in multiplications of their systems."""

    def __init__(self, left: float) -> None:
        self.left = left

    def pivots(self, size: int) -> Iterator[None]:
        """Pivots, as long as the budget lasts; what is optimal at once costs nothing."""
        yield
        each = max(size, 1) ** 3
        while self.left >= each:
            self.left -= each
            yield


def exact_vertex(
    program: ExactProgram, active: list[int], free: list[int], budget: PivotBudget | None = None
) -> ExactVertex | None:
    """Check the vertex where the active rows meet; move on from it where it is not the best.

    Parameters
    ----------
    program
        The linear program.
    active
        The rows taken as equalities.
    free
        The columns they determine; the others are zero, which is right as long as the
        multipliers balance them as well, and is changed where they do not.
    budget
        What pivots may cost, where several programs share it; else ``MAX_WORK``, or one pivot.

    Returns
    -------
        The exact end, or None if the rows do not meet in a point or pivoting came
        to no end.

    Examples
    --------
    >>> program = ExactProgram([[1, 0], [0, 1], [-1, 0], [0, -1]], [2, 3, 0, 0], [1, 1])
    >>> end = exact_vertex(program, [2, 3], [0, 1])
    >>> end.status.value, end.x, end.y
    ('optimal', [2, 3], {0: 1, 1: 1})
    """
    active, free, budget = list(active), sorted(free), budget or PivotBudget(max(MAX_WORK, len(active) ** 3))
    while len(active) == len(free):  # ends, as every round frees another column
        try:
            end = _simplex(program.columns(free), active, budget)
        except ZeroDivisionError:
            return None
        if end is None:
            return None
        loose = _unbalanced(program, free, end)
        if loose is None:
            x = dict(zip(free, end.x, strict=False))  # zero in the columns left out
            return replace(end, x=[x.get(j, 0) for j in range(len(program.cost))])
        free = sorted([*free, loose])
        active += _completion(program, active, free)
    return None


def proves_at_most(program: ExactProgram, active: list[int], free: list[int], value: tuple[int, int]) -> bool:
    """Whether the multipliers of the active rows prove cost · x ≤ a fraction (numerator, denominator).

    Examples
    --------
    >>> program = ExactProgram([[2, 0], [0, 1], [-1, 0], [0, -1]], [5, 3, 0, 0], [1, 0])
    >>> [proves_at_most(program, [0, 1], [0, 1], at_most) for at_most in ((2, 1), (9, 4), (5, 2), (3, 1))]
    [False, False, True, True]
    >>> [proves_at_most(program, rows, free, (9, 1)) for rows, free in (([2, 1], [0, 1]), ([1], [1]))]
    [False, False]
    """
    if len(active) != len(free):
        return False
    try:
        weights, scale = _weights(program.columns(free), active, [program.cost[j] for j in free])
    except ZeroDivisionError:
        return False
    y = {i: weight for i, weight in zip(active, weights, strict=True) if weight}
    loose = _unbalanced(program, free, ExactVertex(Status.OPTIMAL, [], 1, y, scale))
    bound = sum(weight * program.right[i] for i, weight in y.items())
    return min(weights, default=0) >= 0 and loose is None and bound * value[1] <= value[0] * scale


def _unbalanced(program: ExactProgram, free: list[int], end: ExactVertex) -> int | None:
    """A column among those held at zero in which the multipliers of the end do not balance."""
    if end.status == Status.UNBOUNDED:
        return None
    for j in sorted(set(range(len(program.cost))) - set(free)):
        target = program.cost[j] * end.y_scale if end.status == Status.OPTIMAL else 0
        if sum(weight * program.matrix[i][j] for i, weight in end.y.items()) != target:
            return j
    return None


def _completion(program: ExactProgram, active: list[int], free: list[int]) -> list[int]:
    """One more row that makes the active rows regular in the free columns, if there is one."""
    for i in range(len(program.matrix)):
        if i not in active:
            square = [[program.matrix[k][j] for j in free] for k in [*active, i]]
            if integer_matrix(square).det() != 0:
                return [i]
    return []


def _simplex(program: ExactProgram, basis: list[int], budget: PivotBudget) -> ExactVertex | None:
    """Change ``basis`` in place, by dual pivots until every row holds, then by primal ones to the optimum."""
    start, cost = _weights(program, basis, program.cost), program.cost
    if any(y < 0 for y in start[0]):  # to become feasible, any cost for which the basis is optimal will do
        cost = [sum(program.matrix[i][j] for i in basis) for j in range(len(cost))]
    for _ in budget.pivots(len(basis)):
        at = solve_integers([program.matrix[i] for i in basis], [program.right[i] for i in basis])
        values = product(program.table, at[0])
        excess = [value - right * at[1] for value, right in zip(values, program.right, strict=True)]
        violated = next((i for i, each in enumerate(excess) if each > 0), None)
        weights = _weights(program, basis, program.cost if violated is None else cost)
        if violated is not None:
            alpha, scale = _weights(program, basis, program.matrix[violated])
            pairs = [(y, a, k) for y, a, k in zip(weights[0], alpha, basis, strict=True) if a > 0]
            if not pairs:
                farkas = {k: -a for k, a in zip(basis, alpha, strict=True) if a} | {violated: scale}
                return ExactVertex(Status.INFEASIBLE, [], 1, farkas, scale)
            basis[basis.index(_least_ratio(pairs))] = violated
            continue
        leaving = min((k for y, k in zip(weights[0], basis, strict=True) if y < 0), default=None)
        if leaving is None:
            multipliers = {k: y for y, k in zip(weights[0], basis, strict=True) if y}
            return ExactVertex(Status.OPTIMAL, *at, multipliers, weights[1])
        edge = solve_integers([program.matrix[k] for k in basis], [-(k == leaving) for k in basis])
        slopes = product(program.table, edge[0])
        blocking = [(-excess[i], slope, i) for i, slope in enumerate(slopes) if slope > 0 and i not in basis]
        if not blocking:
            return ExactVertex(Status.UNBOUNDED, *edge, {}, 1)
        basis[basis.index(leaving)] = _least_ratio(blocking)
    return None


def _weights(program: ExactProgram, basis: list[int], target: list[int]) -> tuple[list[int], int]:
    """y with Σ y_k row_k = target."""
    columns = range(len(program.cost))
    return solve_integers([[program.matrix[i][j] for i in basis] for j in columns], target)


def _least_ratio(pairs: list[tuple[int, int, int]]) -> int:
    """The index of the smallest numerator / denominator > 0; the smallest index among equals.

    Examples
    --------
    >>> _least_ratio([(1, 2, 5), (2, 4, 3), (3, 6, 4), (1, 1, 0)])
    3
    """
    return min(pairs, key=lambda pair: (Fraction(pair[0], pair[1]), pair[2]))[2]
