"""The vertex of a linear program, solved again from its active rows: exact to round-off."""

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.programs.program import INF, Meeting, Point, Program


def polished(program: Program, x: FloatArray, y: FloatArray, meeting: Meeting) -> Point:
    """Solve the active rows as equalities; keep what violates the rows less."""
    try:
        sharp_x, sharp_y = sharpened(program, x, meeting)
    except np.linalg.LinAlgError:  # HiGHS left a singular basis: its own values are all there is
        pass
    else:
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
