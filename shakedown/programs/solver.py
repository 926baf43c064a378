"""The end of a program, by the road that its cones ask for: the simplex, or interior points."""

from collections.abc import Callable
from functools import partial

import numpy as np

from shakedown.ground.errors import SolverError
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.status import Status
from shakedown.programs.conic import Way, by_clarabel
from shakedown.programs.interior.dense_programs import cone_optimum
from shakedown.programs.program import Program, Solution, ended
from shakedown.programs.simplex import Simplex

DENSE_FROM = 60  # rows, from where on dense interior points are quicker
WAY = Way(1e-11, 0.99, rescaled=True, reduced=1e-6, stalled=True)
ROADS = 2


def solve(program: Program, road: int = 0) -> Solution:
    """The end of a program; of one with cones on the first road, from this one on, that comes to one.

    Without cones the simplex (:class:`Simplex`). With cones Clarabel, and dense interior points for one cone
    over the first columns, which come first where there are many rows: :data:`ROADS` in all.

    Raises
    ------
    SolverError
        If no road comes to an end.

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
    ways: list[Callable[[Program], Solution]] = [partial(by_clarabel, way=WAY), by_dense_points]
    failures = []
    for each in (ways[::-1] if program.linear >= DENSE_FROM else ways)[road:]:
        found = sought(each, program)
        if not isinstance(found, Missing):
            return found
        failures.append(found.reason)
    raise SolverError(failures[0])


def by_dense_points(program: Program) -> Solution:
    """The end of a program with one cone over its first columns, by dense interior points.

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
    rest = scaled.cost + y @ matrix  # what the cone takes up
    y = np.concatenate([y, rest[[rank, *range(rank)]]])
    return ended(scaled, scales, Status.OPTIMAL, x, y)
