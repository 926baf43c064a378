"""Scaling of rows and columns to magnitude 1 by powers of two, free of round-off."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import frexp, ldexp, sqrt

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT

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
    cost: float = 1.0

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

    def with_cost(self, cost: FloatArray) -> tuple[FloatArray, "ProgramScales"]:
        """A cost in numbers near 1, and the scales with its own."""
        scaled = cost * self.column
        scale = 1.0 / power_of_two(np.abs(scaled).max())
        return scaled * scale, ProgramScales(self.row, self.column, self.size, scale)


def power_of_two(size: float) -> float:
    """The power of two next to a size; 1 for the size zero."""
    if size <= 0:
        return 1.0
    mantissa, exponent = frexp(size)  # exact, so that powers of two in units change only the exponent
    return ldexp(1.0, min(exponent, 1023) if mantissa >= _HALFWAY else exponent - 1)


def typical_size(sizes: FloatArray, otherwise: float = 1.0) -> float:
    """The power of two next to the median of the sizes that are neither zero nor infinite."""
    finite = np.sort(sizes[np.isfinite(sizes) & (sizes > 0)])
    half = finite.size // 2
    return power_of_two(0.5 * float(finite[half] + finite[-1 - half])) if finite.size else otherwise


def equilibration(
    matrix: FloatArray, sweeps: int = DEFAULT.equilibration_sweeps, cones: Sequence[int] = ()
) -> tuple[FloatArray, FloatArray]:
    """Row and column scales, powers of two, that bring every row and column near the size 1.

    Scaling by powers of two is free of round-off. Zero rows and columns keep the scale 1.
    The units of the columns are taken out first: a power of two in them changes no bit of
    what follows. The last rows, those of ``cones`` of these sizes, have one scale for every cone.
    """
    size = np.abs(matrix)
    units = np.ldexp(1.0, -np.frexp(size.max(axis=0, initial=0.0))[1])
    size = size * units
    rows, columns = np.ones(matrix.shape[0]), np.ones(matrix.shape[1])
    for _ in range(sweeps):
        scaled = size * rows[:, None] * columns
        rows /= _root(_row_sizes(scaled, cones))
        columns /= _root(np.maximum.reduce(scaled, axis=0, initial=0.0))
    rows /= _nonzero(_row_sizes(size * rows[:, None] * columns, cones))
    return np.exp2(np.round(np.log2(rows))), np.exp2(np.round(np.log2(columns))) * units


def ball_scales(
    matrix: FloatArray, right: FloatArray, linear: int, rank: int
) -> tuple[FloatArray, FloatArray, float]:
    """Scales of rows and columns, and the size of right sides, with one cone over the first columns.

    The cone is ‖(x_0, …, x_{r−1})‖ + offset ≤ x_r; its rows follow the ``linear`` ones. Its columns share one
    unit, in which rows and right sides are near 1; every other column has a unit in which it weighs as much.
    """
    sizes = np.abs(matrix[:linear])
    slopes = sizes[:, : rank + 1].max(axis=1)
    rows = np.array([1.0 / power_of_two(float(slope)) for slope in slopes])
    inside = slopes > 0
    size = typical_size(np.append(np.abs(right[:linear][inside]) * rows[inside], -right[linear]))
    columns = np.ones(matrix.shape[1])
    for j in range(rank + 1, len(columns)):
        columns[j] = 1.0 / typical_size(sizes[inside, j] * rows[inside])
    heaviest = (sizes * columns)[~inside].max(axis=1, initial=0.0)
    rows[~inside] = [1.0 / power_of_two(float(weight)) for weight in heaviest]
    return np.append(rows, np.ones(rank + 1)), columns, size


def _row_sizes(matrix: FloatArray, cones: Sequence[int]) -> FloatArray:
    sizes: FloatArray = np.maximum.reduce(matrix, axis=1, initial=0.0)
    if cones:
        first = len(sizes) - sum(cones)
        starts = first + np.cumsum([0, *cones[:-1]])
        sizes[first:] = np.repeat(np.maximum.reduceat(sizes, starts), cones)
    return sizes


def _root(size: FloatArray) -> FloatArray:
    root: FloatArray = np.sqrt(_nonzero(size))
    return root


def _nonzero(size: FloatArray) -> FloatArray:
    return np.where(size > 0, size, 1.0)
