"""The vertex of a linear program, solved again from its active rows: exact to round-off."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray

UNLIMITED = float("inf")


@dataclass(frozen=True)
class Vertex:
    """An optimal vertex of a :class:`LinearProgram`.

    Attributes
    ----------
    x : (N,)
        The solution.
    multipliers : (R,)
        Row multipliers y with yᵀ M = cᵀ on the columns that are not at a bound
        (y ≤ 0 at an upper, y ≥ 0 at a lower row bound).
    """

    x: FloatArray
    multipliers: FloatArray


class End(NamedTuple):
    """Where the solver stopped: values, multipliers and the equilibrated data, with their units.

    Attributes
    ----------
    matrix, cost
        M and c, equilibrated.
    x, y
        Values and row multipliers of the solver.
    rows, columns
        Lower and upper bounds of rows and columns.
    x_unit, y_unit
        What one of x, of y, is in the units of the user.
    """

    matrix: FloatArray
    cost: FloatArray
    x: FloatArray
    y: FloatArray
    rows: tuple[FloatArray, FloatArray]
    columns: tuple[FloatArray, FloatArray]
    x_unit: FloatArray
    y_unit: FloatArray


def polished(end: End, active: NDArray[np.intp], free: NDArray[np.intp], cancellation: float) -> Vertex:
    """Solve the active rows as equalities; keep what violates the rows less."""
    x, y = end.x, end.y
    try:
        sharp_x, sharp_y = sharpened(end, active, free)
    except np.linalg.LinAlgError:  # HiGHS left a singular basis: its own values are all there is
        pass
    else:
        if violation(end, sharp_x) <= max(violation(end, x), 16 * np.finfo(float).eps):
            x = sharp_x
        if np.all(np.isfinite(sharp_y)):
            y = sharp_y
    return cleaned(end, x, y, cancellation)


def sharpened(end: End, active: NDArray[np.intp], free: NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
    """x and y from the active rows as equalities, the columns that are not free as they are.

    Raises ``LinAlgError`` where these rows do not meet in one point.
    """
    matrix, x, (lower, upper) = end.matrix, end.x.copy(), end.rows
    square, y = matrix[np.ix_(active, free)], np.zeros_like(end.y)
    value = matrix[active] @ x
    at_upper = np.abs(upper[active] - value) <= np.abs(value - lower[active])
    target = np.where(at_upper, upper[active], lower[active])
    fixed = np.ones(len(x), dtype=bool)
    fixed[free] = False
    inverse: FloatArray = np.asarray(np.linalg.inv(square), dtype=float)
    x[free] = refined(inverse, square, target - matrix[np.ix_(active, fixed)] @ x[fixed])
    y[active] = refined(inverse.T, square.T, end.cost[free])
    return x, y


def cleaned(end: End, x: FloatArray, y: FloatArray, cancellation: float) -> Vertex:
    """Values and multipliers in the units of the user, without what round-off leaves of zeros."""
    bounds = np.abs(np.stack(end.rows))
    largest = np.where(bounds < UNLIMITED, bounds, 0.0).max(axis=0)
    x = np.clip(without_round_off(end.matrix, x, largest, cancellation), *end.columns)
    return Vertex(x=x * end.x_unit, multipliers=y * end.y_unit)


def violation(end: End, x: FloatArray) -> float:
    """By how much x breaks a row or a bound at most, in the equilibrated units; NaN where x is none."""
    value = end.matrix @ x
    excess = np.maximum(value - end.rows[1], end.rows[0] - value).max(initial=0.0)
    lower, upper = end.columns
    return float(max(excess, np.maximum(x - upper, lower - x).max(initial=0.0), 0.0))


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
