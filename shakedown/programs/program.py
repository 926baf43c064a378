"""Linear programs and cone programs: data, scaling, solutions."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import frexp, ldexp, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import ROUND_OFF, FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances

_HALFWAY = sqrt(0.5)  # halfway between two powers of two, on the scale of exponents


@dataclass(frozen=True)
class ProgramScales:
    """Powers of two that scale a program to numbers near 1.

    Attributes
    ----------
    row, column
        What rows and columns are multiplied by.
    size
        The size of the right sides then.
    cost
        What the cost is multiplied by in units of the columns.
    """

    row: FloatArray
    column: FloatArray
    size: float
    cost: float

    @property
    def x(self) -> FloatArray:
        """The size of 1 in x in the units of the program, (N,)."""
        return self.column * self.size

    @property
    def y(self) -> FloatArray:
        """The size of 1 in a multiplier in the units of the program, (R,)."""
        return self.row / self.cost

    def value(self, scaled: float) -> float:
        """The value of a cost in the units of the program."""
        return scaled * self.size / self.cost


def power_of_two(size: float) -> float:
    """The power of two next to a size; 1 for the size zero."""
    if size <= 0:
        return 1.0
    mantissa, exponent = frexp(size)  # exact, so that powers of two in units change only the exponent
    return ldexp(1.0, min(exponent, 1023) if mantissa >= _HALFWAY else exponent - 1)


def median_size(sizes: FloatArray) -> float:
    """The median of the sizes that are neither zero nor infinite; 0 where there are none."""
    finite = sizes[np.isfinite(sizes) & (sizes > 0)]
    return float(np.median(finite)) if finite.size else 0.0


def typical_size(sizes: FloatArray, otherwise: float = 1.0) -> float:
    """The power of two next to that median."""
    median = median_size(sizes)
    return power_of_two(median) if median else otherwise


def equilibration(
    matrix: FloatArray, sweeps: int = DEFAULT.equilibration_sweeps, cones: Sequence[int] = ()
) -> tuple[FloatArray, FloatArray]:
    """Row and column scales, powers of two, that bring every row and column near the size 1.

    Scaling by powers of two is free of round-off. Zero rows and columns keep the scale 1.
    The units of the columns are taken out first: a power of two in them changes no bit of
    what follows. The last rows, those of ``cones`` of these sizes, have one scale for every cone.
    A row with one entry takes any scale, so it says nothing of the unit of its column where another row does.
    """
    size = np.abs(matrix)
    alone = np.count_nonzero(size, axis=1) == 1
    alone[len(size) - sum(cones) :] = False
    coupling = np.where(alone[:, None], 0.0, size)
    coupling = np.where(coupling.any(axis=0), coupling, size)
    units = np.ldexp(1.0, -np.frexp(coupling.max(axis=0, initial=0.0))[1])
    size, coupling = size * units, coupling * units
    rows, columns = np.ones(matrix.shape[0]), np.ones(matrix.shape[1])
    for _ in range(sweeps):
        scaled, shared = (part * rows[:, None] * columns for part in (size, coupling))
        rows /= np.sqrt(_nonzero(_row_sizes(scaled, cones)))
        columns /= np.sqrt(_nonzero(np.maximum.reduce(shared, axis=0, initial=0.0)))
    rows /= _nonzero(_row_sizes(size * rows[:, None] * columns, cones))
    return np.exp2(np.round(np.log2(rows))), np.exp2(np.round(np.log2(columns))) * units


def _row_sizes(matrix: FloatArray, cones: Sequence[int]) -> FloatArray:
    sizes: FloatArray = np.maximum.reduce(matrix, axis=1, initial=0.0)
    if cones:
        first = len(sizes) - sum(cones)
        starts = first + np.cumsum([0, *cones[:-1]])
        sizes[first:] = np.repeat(np.maximum.reduceat(sizes, starts), cones)
    return sizes


def _nonzero(size: FloatArray) -> FloatArray:
    return np.where(size > 0, size, 1.0)


INF = float("inf")


class Sides(NamedTuple):
    """Rows of M x ≤ right: ``sign`` times those that ``row`` names; −1 − the column for its bounds."""

    matrix: FloatArray
    right: FloatArray
    row: NDArray[np.intp]
    sign: float


class Residuals(NamedTuple):
    """Residuals of the optimality conditions at x and multipliers, computed anew.

    ``primal`` is the largest violation of a row, a bound or a cone, ``dual`` of the balance Mᵀ y + c = 0 or
    of a sign of y, ``gap`` by how much cᵀ x exceeds what y proves, relative to its terms.
    """

    primal: float
    dual: float
    gap: float


@dataclass(frozen=True, eq=False)
class Program:
    """Minimise cᵀ x subject to left ≤ M x ≤ right, lower ≤ x ≤ upper, and the last rows in cones.

    Attributes
    ----------
    matrix : (R, N)
        M.
    right : (R,)
        Right sides of the rows.
    cost : (N,)
        c.
    cones
        Sizes of second-order cones, which the last rows are in, in this order: with u = right − M x each
        has ‖(u_1, …)‖ ≤ u_0 over its own rows.
    left
        Left sides of the rows that are in no cone: (R,), or one for all.
    lower, upper
        Bounds of the columns: (N,), or one for all.
    tolerances
        ``equilibration_sweeps`` and ``cancellation`` are used.

    Examples
    --------
    >>> row, cost = np.array([[-1.0, -1.0]]), np.array([1.0, 3.0])
    >>> cheapest = Program(row, np.array([-2.0]), cost, lower=np.zeros(2))
    >>> cheapest.residuals(np.array([2.0, 0.0]), np.array([1.0]))
    Residuals(primal=0.0, dual=0.0, gap=0.0)
    """

    matrix: FloatArray
    right: FloatArray
    cost: FloatArray
    cones: tuple[int, ...] = ()
    left: FloatArray = field(default_factory=partial(np.array, -INF))
    lower: FloatArray = field(default_factory=partial(np.array, -INF))
    upper: FloatArray = field(default_factory=partial(np.array, INF))
    tolerances: Tolerances = DEFAULT

    @property
    def linear(self) -> int:
        """The number of rows, the first ones, that are in no cone."""
        return len(self.right) - sum(self.cones)

    def blocks(self) -> Iterator[slice]:
        """The rows of every cone."""
        start = self.linear
        for count in self.cones:
            yield slice(start, start + count)
            start += count

    @cached_property
    def scales(self) -> ProgramScales:
        """The units in which the program has numbers near 1."""
        row, column = equilibration(self.matrix, self.tolerances.equilibration_sweeps, self.cones)
        empty = ~self.matrix.any(axis=1) & (np.arange(len(row)) < self.linear)
        sizes = (np.abs(self.right) * row)[~empty]
        if np.any(self.left > -INF):
            sizes = np.concatenate([(np.abs(self.left) * row)[~empty], sizes])
        if self.cones:  # those that are more than round-off of the largest
            known = sizes[np.isfinite(sizes)]
            sizes = known[known > ROUND_OFF * known.max(initial=0.0)]
        size = typical_size(sizes, otherwise=0.0)
        if size == 0.0:  # all right sides are zero: the column with the largest cost keeps its unit
            size = 1.0 / float(column[np.abs(self.cost * column).argmax()])
        for k in np.flatnonzero(empty & np.isfinite(self.right) & (self.right != 0.0)):
            row[k] = size / power_of_two(abs(float(self.right[k])))  # nothing else tells its unit
        return ProgramScales(row, column, size, 1.0 / power_of_two(np.abs(self.cost * column).max()))

    def scaled(self) -> tuple["Program", ProgramScales]:
        """The program in numbers near 1, with sides and bounds of its own for every row and column."""
        scales, columns, unit = self.scales, len(self.cost), self.scales.x
        row, size = scales.row, scales.size
        program = Program(
            self.matrix * row[:, None] * scales.column,
            self.right * row / size,
            self.cost * scales.column * scales.cost,
            self.cones,
            self.left * row / size,
            np.full(columns, self.lower) / unit,
            np.full(columns, self.upper) / unit,
            self.tolerances,
        )
        return program, scales

    def with_signs(self, rows: FloatArray | float = 1.0, cost: float = 1.0) -> "Program":
        """The program with other signs of rows, which have right sides alone, or of the cost."""
        signs = np.broadcast_to(rows, len(self.right))
        other = replace(
            self, matrix=self.matrix * signs[:, None], right=self.right * signs, cost=self.cost * cost
        )
        vars(other)["scales"] = self.scales  # known already, as they depend on sizes only
        return other

    def sides(self, rows: NDArray[np.intp], sign: float = 1.0) -> Sides:
        """Right (+1) or left (−1) sides of some rows."""
        right = self.right if sign > 0 else -self.left
        matrix = self.matrix[rows] if sign > 0 else -self.matrix[rows]
        return Sides(matrix, right[rows], rows, sign)

    def inequalities(self, without: NDArray[np.bool_] | None = None) -> list[Sides]:
        """Rows that have a right, rows that have a left side, upper and lower bounds; without some rows."""
        linear, parts = self.linear, []
        for side, sign in ((self.right[:linear], 1.0), (-self.left[:linear], -1.0)):
            limited = side < INF if without is None else (side < INF) & ~without
            if limited.any():
                parts.append(self.sides(np.flatnonzero(limited), sign))
        for bound, sign in ((self.upper, 1.0), (-self.lower, -1.0)):
            columns = np.flatnonzero(bound < INF)
            if columns.size:
                matrix = np.zeros((len(columns), len(self.cost)))
                matrix[np.arange(len(columns)), columns] = sign
                parts.append(Sides(matrix, bound[columns], -1 - columns, sign))
        return parts

    def violation(self, x: FloatArray) -> float:
        """The largest violation of a row, a bound or a cone by x; NaN where x is NaN."""
        value = self.matrix @ x
        excess = np.maximum(value - self.right, self.left - value)
        for rows in self.blocks():
            excess[rows] = _outside((self.right - value)[rows])
        bounds = np.maximum(x - self.upper, self.lower - x)
        return float(max(excess.max(initial=0.0), bounds.max(initial=0.0), 0.0))

    def residuals(self, x: FloatArray, y: FloatArray) -> Residuals:
        """Residuals of the optimality conditions; most meaningful in the scaled program."""
        rest, side = self.cost + y @ self.matrix, np.where(y > 0, self.right, self.left)
        wrong = np.where(np.isfinite(side), 0.0, np.abs(y))
        for rows in self.blocks():
            side[rows], wrong[rows] = self.right[rows], _outside(y[rows])
        bound = np.where(rest > 0, self.lower, self.upper)
        loose = np.where(np.isfinite(bound), 0.0, np.abs(rest))
        proved = [
            float(weights @ np.where(np.isfinite(ends), ends, 0.0))
            for weights, ends in ((-y, side), (rest, bound))
        ]
        size = max(float(np.abs(self.cost) @ np.abs(x)), *map(abs, proved))
        return Residuals(
            self.violation(x),
            float(max(wrong.max(initial=0.0), loose.max(initial=0.0))),
            float(self.cost @ x - sum(proved)) / (size or 1.0),
        )


def columnwise(matrix: FloatArray) -> tuple[FloatArray, NDArray[np.int32], NDArray[np.int32]]:
    """A matrix by columns, as solvers take it: values, their rows, and where each column starts."""
    transposed = np.ascontiguousarray(matrix.T)
    nonzero = transposed != 0
    starts = np.concatenate([[0], np.cumsum(nonzero.sum(axis=1))]).astype(np.int32)
    return transposed[nonzero], np.nonzero(nonzero)[1].astype(np.int32), starts


def _outside(u: FloatArray) -> float:
    return float(np.linalg.norm(u[1:]) - u[0])


Meeting = tuple[NDArray[np.intp], NDArray[np.intp]]  # rows held as equalities, columns that they determine
Point = tuple[FloatArray, FloatArray]  # x and multipliers
NOWHERE = np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)


@dataclass(frozen=True, eq=False)
class Solution:
    """The result of a program; computed and checked when first read.

    Attributes
    ----------
    status
        Optimal, infeasible or unbounded.
    value
        cᵀ x to the accuracy of the solver, without polish; NaN unless optimal.
    reduced_accuracy
        Whether the solver reached an answer only at loosened tolerances.
    solved, scales
        The program in numbers near 1, as it was solved, and its units.
    """

    status: Status
    value: float
    reduced_accuracy: bool
    solved: Program = field(repr=False)
    scales: ProgramScales = field(repr=False)
    _point: Callable[["Solution"], Point] = field(repr=False)
    _meeting: Callable[[], Meeting] = field(repr=False, default=lambda: NOWHERE)

    @cached_property
    def meeting(self) -> Meeting:
        """The rows held as equalities at the end and the columns that they determine, (K,) each.

        Every other column is at a bound, or zero. Both are empty where a program has cones.
        """
        return self._meeting()

    @cached_property
    def _ends(self) -> Point:
        return self._point(self)

    @property
    def optimal(self) -> bool:
        """Whether there is a solution."""
        return self.status == Status.OPTIMAL

    @property
    def x(self) -> FloatArray:
        """The solution, (N,); NaN where there is none; the ray of an unbounded program with cones."""
        return self._ends[0]

    @property
    def multipliers(self) -> FloatArray:
        """Multipliers y of the rows, (R,): ≥ 0 at a right side, ≤ 0 at a left one.

        c + Mᵀ y = 0 except at column bounds. NaN where there is no solution; for an infeasible program with
        cones the multipliers that prove it.
        """
        return self._ends[1]

    @cached_property
    def residuals(self) -> Residuals:
        """Residuals of the optimality conditions, in the scaled program."""
        return self.solved.residuals(self.x / self.scales.x, self.multipliers / self.scales.y)
