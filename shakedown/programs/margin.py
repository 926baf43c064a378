"""The point with the largest margin to rows."""

from dataclasses import dataclass
from math import inf

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.programs.program import INF, Program
from shakedown.programs.solver import solve


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
    cost = np.append(np.zeros(columns), -1.0)
    program = Program(
        np.column_stack([matrix, norms]), right, cost, lower=lower, upper=upper, tolerances=tolerances
    )
    end = solve(program)
    if not end.optimal:  # rows without a norm contradict each other, whatever t
        return Widest(np.zeros(columns), -inf, np.zeros(rows), end.reduced_accuracy)
    return Widest(end.x[:-1], float(end.x[-1]), end.multipliers, end.reduced_accuracy)
