"""The solution of a program: by the simplex without cones, else by the first of several methods with one."""

from dataclasses import dataclass
from math import inf

import numpy as np

from shakedown.ground.constants import DENSE_FROM, SIX_DIGITS, FloatArray
from shakedown.ground.errors import Missing, SolverError, sought
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.programs.conic import ClarabelSettings, by_clarabel
from shakedown.programs.dense_programs import cone_optimum
from shakedown.programs.program import INF, Program, Solution, solution_of
from shakedown.programs.simplex import Simplex

SETTINGS = ClarabelSettings(1e-11, 0.99, rescaled=True, reduced=SIX_DIGITS, stalled=True)


def solve(program: Program) -> Solution:
    """The solution of a program; of one with cones by the first method that comes to one.

    Without cones the simplex (:class:`Simplex`). With cones interior points: Clarabel's, and dense ones for
    one cone over the first columns, which come first where there are many rows.

    Raises
    ------
    SolverError
        If no method comes to an end.

    Examples
    --------
    >>> import numpy as np
    >>> rows = np.array([[-1.0, -1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    >>> nearest = solve(Program(rows, np.array([-2.0, 0, 0, 0]), cost=np.array([0.0, 0.0, 1.0]), cones=(3,)))
    >>> nearest.x.round(6), nearest.multipliers.round(6)
    (array([1.      , 1.      , 1.414214]), array([ 0.707107,  1.      , -0.707107, -0.707107]))
    """
    if not program.cones:
        return Simplex(program).solve()
    methods = [lambda each: by_clarabel(each, SETTINGS), by_dense_points]
    if program.linear >= DENSE_FROM:
        methods.reverse()
    failures = []
    for each in methods:
        found = sought(each, program)
        if not isinstance(found, Missing):
            return found
        failures.append(found.reason)
    raise SolverError(failures[0])


def by_dense_points(program: Program) -> Solution:
    """The solution of a program with one cone over its first columns, by dense interior points.

    Raises
    ------
    SolverError
        If it has other cones or bounds, or no optimum is found.
    """
    if program.rank is None:
        raise SolverError(f"the cone program of shape {program.matrix.shape} has other cones or bounds")
    rank, linear, (scaled, scales) = program.rank, program.linear, program.scaled()
    matrix, right = scaled.matrix[:linear], scaled.right[:linear]
    optimum = cone_optimum(matrix, right, scaled.cost, rank, -float(scaled.right[linear]))
    if optimum is None:
        raise SolverError(f"the cone program of shape {program.matrix.shape} ended without an optimum")
    x, y = optimum
    rest = scaled.cost + y @ matrix  # the part balanced by the cone
    y = np.concatenate([y, rest[[rank, *range(rank)]]])
    return solution_of(scaled, scales, Status.OPTIMAL, x, y)


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
