"""Linear programs: data, scaling, solutions and their polish; products rounded once."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from math import frexp, fsum, ldexp, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import HALVINGS, FloatArray, Mask
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances


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


def power_of_two(size: float) -> float:
    """The power of two next to a size; 1 for the size zero.

    Examples
    --------
    >>> [power_of_two(size) for size in (0.0, 0.3, 0.7, 0.71, 1.41, 1.42)]
    [1.0, 0.25, 0.5, 1.0, 1.0, 2.0]
    >>> power_of_two(5e-324), power_of_two(1.7e308) == 2.0**1023
    (5e-324, True)
    """
    if size <= 0:
        return 1.0
    mantissa, exponent = frexp(size)  # exact, so that powers of two in units change only the exponent
    # halfway between two powers of two, on the scale of exponents
    return ldexp(1.0, min(exponent, 1023) if mantissa >= sqrt(0.5) else exponent - 1)


def median_size(sizes: FloatArray) -> float:
    """The median of the sizes that are neither zero nor infinite; 0 where there are none."""
    finite = sizes[np.isfinite(sizes) & (sizes > 0)]
    return float(np.median(finite)) if finite.size else 0.0


def typical_size(sizes: FloatArray, otherwise: float = 1.0) -> float:
    """The power of two next to that median."""
    median = median_size(sizes)
    return power_of_two(median) if median else otherwise


def equilibration(
    matrix: FloatArray, sweeps: int = DEFAULT.equilibration_sweeps, priced: Mask | slice = slice(None)
) -> tuple[FloatArray, FloatArray]:
    """Row and column scales, powers of two, that bring every row and column near the size 1.

    Scaling by powers of two is free of round-off. Zero rows and columns keep the scale 1.
    The units of the columns are taken out first: a power of two in them changes no bit of
    what follows. A row with one entry takes any scale, so it says nothing of the unit of its column where
    another row does; so it is in the columns with a cost alone, where they are known: the others are a
    means, and what little they change in another row may be round-off.
    """
    size = np.abs(matrix)
    alone = (np.count_nonzero(size, axis=1) == 1) & size[:, priced].any(axis=1)
    coupling = np.where(alone[:, None], 0.0, size)
    coupling = np.where(coupling.any(axis=0), coupling, size)
    units = np.ldexp(1.0, -np.frexp(coupling.max(axis=0, initial=0.0))[1])
    size, coupling = size * units, coupling * units
    rows, columns = np.ones(matrix.shape[0]), np.ones(matrix.shape[1])
    for _ in range(sweeps):
        scaled, shared = (part * rows[:, None] * columns for part in (size, coupling))
        rows /= np.sqrt(_nonzero(np.maximum.reduce(scaled, axis=1, initial=0.0)))
        columns /= np.sqrt(_nonzero(np.maximum.reduce(shared, axis=0, initial=0.0)))
    rows /= _nonzero(np.maximum.reduce(size * rows[:, None] * columns, axis=1, initial=0.0))
    return np.exp2(np.round(np.log2(rows))), np.exp2(np.round(np.log2(columns))) * units


def _nonzero(size: FloatArray) -> FloatArray:
    return np.where(size > 0, size, 1.0)


INF = float("inf")


@dataclass(frozen=True, eq=False)
class Program:
    """Minimise cᵀ x subject to left ≤ M x ≤ right and lower ≤ x ≤ upper.

    Attributes
    ----------
    matrix : (R, N)
        M.
    right : (R,)
        Right sides of the rows.
    cost : (N,)
        c.
    left
        Left sides of the rows: (R,), or one for all.
    lower, upper
        Bounds of the columns: (N,), or one for all.
    tolerances
        ``equilibration_sweeps`` and ``cancellation`` are used.

    Examples
    --------
    >>> row, cost = np.array([[-1.0, -1.0]]), np.array([1.0, 3.0])
    >>> cheapest = Program(row, np.array([-2.0]), cost, lower=np.zeros(2))
    >>> cheapest.violation(np.array([2.0, 0.0])), cheapest.violation(np.array([1.0, 0.5]))
    (0.0, 0.5)
    """

    matrix: FloatArray
    right: FloatArray
    cost: FloatArray
    left: FloatArray = field(default_factory=partial(np.array, -INF))
    lower: FloatArray = field(default_factory=partial(np.array, -INF))
    upper: FloatArray = field(default_factory=partial(np.array, INF))
    tolerances: Tolerances = DEFAULT

    @cached_property
    def scales(self) -> ProgramScales:
        """The units in which the program has numbers near 1."""
        row, column = equilibration(self.matrix, self.tolerances.equilibration_sweeps, self.cost != 0)
        empty = ~self.matrix.any(axis=1)
        sizes = (np.abs(self.right) * row)[~empty]
        if np.any(self.left > -INF):
            sizes = np.concatenate([(np.abs(self.left) * row)[~empty], sizes])
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
            self.left * row / size,
            np.full(columns, self.lower) / unit,
            np.full(columns, self.upper) / unit,
            self.tolerances,
        )
        return program, scales

    def violation(self, x: FloatArray) -> float:
        """The largest violation of a row or a bound by x; NaN where x is NaN."""
        value = self.matrix @ x
        excess = np.maximum(value - self.right, self.left - value)
        bounds = np.maximum(x - self.upper, self.lower - x)
        return float(max(excess.max(initial=0.0), bounds.max(initial=0.0), 0.0))


Meeting = tuple[NDArray[np.intp], NDArray[np.intp]]  # rows held as equalities, columns that they determine
Point = tuple[FloatArray, FloatArray]  # x and multipliers
NOWHERE = np.array([], dtype=np.intp), np.array([], dtype=np.intp)


def polished(program: Program, x: FloatArray, y: FloatArray, meeting: Meeting) -> Point:
    """Solve the active rows as equalities; keep what violates the rows less."""
    try:
        sharp_x, sharp_y = sharpened(program, x, meeting)
    except np.linalg.LinAlgError:  # HiGHS left a singular basis: its own values are all there is
        sharp_x, sharp_y = x, y
    if program.violation(sharp_x) <= max(program.violation(x), 16 * np.finfo(float).eps):
        x = sharp_x
    if np.all(np.isfinite(sharp_y)):
        y = sharp_y
    return cleaned(program, x), y


def sharpened(program: Program, x: FloatArray, meeting: Meeting) -> Point:
    """x and multipliers from the active rows as equalities, the columns that are not free as they are.

    Raises ``LinAlgError`` where these rows do not meet in one point.
    """
    (active, free), matrix, x = meeting, program.matrix, x.copy()
    left, right = program.left[active], program.right[active]
    square, y = matrix[np.ix_(active, free)], np.zeros(len(matrix))
    value = matrix[active] @ x
    target = np.where(np.abs(right - value) <= np.abs(value - left), right, left)
    fixed = np.ones(len(x), dtype=bool)
    fixed[free] = False
    inverse: FloatArray = np.asarray(np.linalg.inv(square), dtype=float)
    x[free] = refined(inverse, square, target - matrix[np.ix_(active, fixed)] @ x[fixed])
    y[active] = refined(inverse.T, square.T, program.cost[free])
    return x, -y


def cleaned(program: Program, x: FloatArray) -> FloatArray:
    """x without what round-off leaves of zeros, within its bounds."""
    sides = np.abs(np.stack([program.left, program.right]))
    largest = np.where(sides < INF, sides, 0.0).max(axis=0)
    threshold = program.tolerances.cancellation * len(x)
    clean = without_round_off(program.matrix, x, largest, threshold)
    dear = ~program.matrix.any(axis=0) & (program.cost != 0)  # in no row, but not for nothing at its bound
    return np.clip(np.where(dear, x, clean), program.lower, program.upper)


def without_round_off(matrix: FloatArray, x: FloatArray, right: FloatArray, threshold: float) -> FloatArray:
    """x with zero where it counts for nothing in any row of matrix · x ≤ right.

    An entry whose share in every row is below ``threshold`` times the largest term
    of that row is what round-off left of zero.

    Examples
    --------
    >>> import numpy as np
    >>> rows = np.array([[1.0, 1.0], [1.0, -1.0]])
    >>> without_round_off(rows, np.array([1.0, 3e-17]), np.ones(2), threshold=2e-15)
    array([1., 0.])
    """
    shares = np.abs(matrix * x)
    terms = np.maximum(shares.max(axis=1, initial=0.0), np.abs(right))
    return np.where(np.all(shares <= threshold * terms[:, None], axis=0), 0.0, x)


def refined(inverse: FloatArray, matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solve a square system with its inverse and one step of refinement in extended precision."""
    x = inverse @ right
    residual = right - matrix.astype(np.longdouble) @ x
    return np.asarray(x + inverse @ residual.astype(float))


def exact_products(matrix: FloatArray, x: FloatArray) -> FloatArray:
    """M x with every entry rounded once: products split without error, their sums rounded once.

    Examples
    --------
    >>> exact_products(np.array([[1e16, 1.0, -1e16]]), np.ones(3))
    array([1.])

    The square of 0.1 and 0.01, as floats, differ by 9.02e-19; floats give 1.7e-18:

    >>> exact_products(np.array([[0.1, -1.0]]), np.array([0.1, 0.01]))
    array([9.02056208e-19])
    """
    found = np.empty(len(matrix))
    x_high = _high(x)
    x_low = x - x_high
    for i, row in enumerate(matrix):
        high = _high(row)
        low, product = row - high, row * x
        rest = low * x_low - (((product - high * x_high) - low * x_high) - high * x_low)
        found[i] = fsum(np.concatenate([product, rest]).tolist())
    return found


def _high(values: FloatArray) -> FloatArray:
    """The first 26 bits."""
    lifted = (2.0 ** (HALVINGS // 2) + 1.0) * values
    return np.asarray(lifted - (lifted - values))


@dataclass(frozen=True, eq=False)
class Solution:
    """The result of a program; computed and checked when first read.

    Attributes
    ----------
    status
        Optimal, infeasible or unbounded.
    reduced_accuracy
        Whether the solver reached an answer only at loosened tolerances.
    solved, scales
        The program in numbers near 1, as it was solved, and its units.
    """

    status: Status
    reduced_accuracy: bool
    solved: Program = field(repr=False)
    scales: ProgramScales = field(repr=False)
    _left: Point | None = field(repr=False)  # as the solver left it
    _meeting: Callable[[], Meeting] = field(repr=False)

    @cached_property
    def meeting(self) -> Meeting:
        """The rows held as equalities at the end and the columns that they determine, (K,) each.

        Every other column is at a bound, or zero.
        """
        return self._meeting()

    @cached_property
    def _ends(self) -> Point:
        if self._left is None:
            rows, columns = self.solved.matrix.shape
            return np.full(columns, np.nan), np.full(rows, np.nan)
        x, y = polished(self.solved, *self._left, self.meeting)
        return x * self.scales.x, y * self.scales.row / self.scales.cost

    @property
    def optimal(self) -> bool:
        """Whether there is a solution."""
        return self.status == Status.OPTIMAL

    @property
    def value(self) -> float:
        """cᵀ x to the accuracy of the solver, without polish; NaN unless optimal."""
        if self._left is None:
            return nan
        return float(self.solved.cost @ self._left[0]) * self.scales.size / self.scales.cost

    @property
    def x(self) -> FloatArray:
        """The solution, (N,); NaN where there is none."""
        return self._ends[0]

    @property
    def multipliers(self) -> FloatArray:
        """Multipliers y of the rows, (R,): ≥ 0 at a right side, ≤ 0 at a left one.

        c + Mᵀ y = 0 except at column bounds. NaN where there is no solution.
        """
        return self._ends[1]
