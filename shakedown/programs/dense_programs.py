"""Dense linear programs in any units: the rows that meet in an optimum."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from shakedown.ground.constants import CONE, FloatArray
from shakedown.ground.status import Status
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.self_dual import solve_self_dual


def meeting_rows(matrix: FloatArray, right: FloatArray, cost: FloatArray) -> NDArray[np.intp] | None:
    """The rows of M x ≤ right with the largest multipliers at the optimum of cᵀ x, as many as columns.

    Columns without an entry are left out. The result must be checked: it is a guess where the optimum is
    degenerate.

    Returns
    -------
        Indices of rows; None where no optimum is found.

    Examples
    --------
    >>> square = np.vstack([np.eye(2), -np.eye(2)])
    >>> meeting_rows(square, np.ones(4), np.array([-1.0, -2.0]))
    array([0, 1])
    """
    used = matrix.any(axis=0)
    if not used.any():
        return None
    inner = matrix[:, used]
    sizes = _sizes(inner)
    inner = inner / sizes[:, None]
    try:
        factor = cholesky(inner.T @ inner)
    except np.linalg.LinAlgError:
        return None
    inner = _in_units_of(factor, inner)
    lengths = _sizes(inner)
    limits = right / (sizes * lengths)
    slope = _in_units_of(factor, cost[None, used])[0]
    inner, needed = inner / lengths[:, None], int(used.sum())
    end = solve_self_dual(
        DiscProgram(
            blocks=np.zeros((0, CONE, 0)),
            node=np.zeros(0, dtype=np.intp),
            extra=np.zeros((0, CONE, needed)),
            right=np.zeros((0, CONE)),
            rows=np.zeros((len(right), 0)),
            rows_extra=inner,
            rows_right=limits / _unit(limits),
            cost=slope / _sizes(slope[None])[0],
        )
    )
    if end.status != Status.OPTIMAL or needed > len(right):
        return None
    hardest = np.argsort(end.slack / end.multipliers, kind="stable")
    pushing = hardest[: max(needed, int(np.sum(end.slack < end.multipliers)))]
    return np.sort(_without_spare(inner, end.multipliers, pushing))


def _without_spare(matrix: FloatArray, multipliers: FloatArray, rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """As many rows as columns, with multipliers ≥ 0; where more rows meet, they are removed one by one."""
    spare = len(rows) - matrix.shape[1]
    y = multipliers[rows]
    others = (
        np.linalg.qr(matrix[rows], mode="complete")[0][:, matrix.shape[1] :] if spare else np.zeros((0, 0))
    )
    while others.shape[1]:  # each round removes one row and one direction in which the multipliers are free
        way = others[:, 0] if others[:, 0].max() > -others[:, 0].min() else -others[:, 0]
        with np.errstate(divide="ignore"):
            leaving = int(np.argmin(np.where(way > 0, y / way, np.inf)))
        y = np.delete(y - y[leaving] / way[leaving] * way, leaving)
        others = others[:, 1:] - np.outer(way, others[leaving, 1:] / way[leaving])
        others, rows = np.delete(others, leaving, axis=0), np.delete(rows, leaving)
    return rows


def _in_units_of(factor: FloatArray, matrix: FloatArray) -> FloatArray:
    """M R⁻¹ of an upper factor R."""
    return np.asarray(solve_triangular(factor, matrix.T, trans=1).T, dtype=float)


def _sizes(rows: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(rows, axis=1)
    return np.where(lengths > 0, lengths, 1.0)


def _unit(limits: FloatArray) -> float:
    """The median of the limits that are not zero."""
    weighing = np.abs(limits[limits != 0])
    return float(np.median(weighing)) if weighing.size else 1.0
