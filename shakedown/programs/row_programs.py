"""Linear programs over rows of limits: the extreme load factor, and the point with the largest margin."""

from dataclasses import dataclass
from math import inf

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import Constraints
from shakedown.programs.linear_program import INF, LinearProgram


def load_factor_program(rows: Constraints, towards: float, tolerances: Tolerances = DEFAULT) -> LinearProgram:
    """Maximise (−1) or minimise (+1) λ ≥ 0 over the columns (v, λ), subject to every row."""
    return LinearProgram(
        np.column_stack([rows.coefficients, rows.d]),
        cost=np.append(np.zeros(rows.n), towards),
        lower=np.full(len(rows.g), -INF),
        upper=rows.g,
        column_lower=np.append(np.full(rows.n, -INF), 0.0),
        column_upper=np.full(rows.n + 1, INF),
        tolerances=tolerances,
    )


@dataclass(frozen=True)
class Widest:
    """The point x with the largest margin, and the multipliers ≥ 0 that prove that no larger one exists."""

    x: FloatArray
    margin: float
    multipliers: FloatArray
    reduced_accuracy: bool


def widest(
    matrix: FloatArray,
    norms: FloatArray,
    right: FloatArray,
    *,
    cap: float,
    signed: int | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Widest:
    """Maximise t ≤ cap subject to M x + t·norms ≤ right, and x ≥ 0 in the column ``signed``.

    The multipliers satisfy yᵀ M = 0 (≥ 0 in the column ``signed``), yᵀ norms = 1 and
    yᵀ right = t, as long as t < cap.
    """
    rows, columns = matrix.shape
    lower = np.full(columns + 1, -INF)
    if signed is not None:
        lower[signed] = 0.0
    upper = np.full(columns + 1, INF)
    upper[-1] = cap
    program = LinearProgram(
        np.column_stack([matrix, norms]),
        cost=np.append(np.zeros(columns), -1.0),
        lower=np.full(rows, -INF),
        upper=right,
        column_lower=lower,
        column_upper=upper,
        tolerances=tolerances,
    )
    end = program.solve()
    if end.vertex is None:  # rows without a norm contradict each other, whatever t
        return Widest(np.zeros(columns), -inf, np.zeros(rows), end.reduced_accuracy)
    x, multipliers = end.vertex.x, -end.vertex.multipliers
    return Widest(x[:-1], float(x[-1]), multipliers, end.reduced_accuracy)
