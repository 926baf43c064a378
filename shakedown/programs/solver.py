"""The solution of a program, and the point with the most slack."""

from dataclasses import dataclass
from math import inf

import numpy as np

from shakedown.ground.constants import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.programs.conic import by_clarabel
from shakedown.programs.program import INF, Program, Solution
from shakedown.programs.simplex import Simplex


def solve(program: Program) -> Solution:
    """The solution of a program: without cones by the simplex, with cones by Clarabel's interior points.

    Raises
    ------
    SolverError
        If the method comes to no end.

    Examples
    --------
    >>> import numpy as np
    >>> rows = np.array([[-1.0, -1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    >>> nearest = solve(Program(rows, np.array([-2.0, 0, 0, 0]), cost=np.array([0.0, 0.0, 1.0]), cones=(3,)))
    >>> nearest.x.round(6), nearest.multipliers.round(6)
    (array([1.      , 1.      , 1.414214]), array([ 0.707107,  1.      , -0.707107, -0.707107]))
    """
    return by_clarabel(program) if program.cones else Simplex(program).solve()


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
