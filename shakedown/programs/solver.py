"""The solution of a program: by the simplex without cones, else by the first of several methods with one."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import inf

import numpy as np

from shakedown.ground.errors import Missing, SolverError, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import ITERATIONS, SEVEN_DIGITS, SIX_DIGITS
from shakedown.ground.size_limits import DENSE_FROM, MANY_ROWS
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.programs.conic import ClarabelSettings, by_clarabel
from shakedown.programs.dense_programs import cone_optimum
from shakedown.programs.program import INF, Program, Solution, solution_of
from shakedown.programs.simplex import Simplex

SETTINGS = tuple(
    ClarabelSettings(accuracy, step, rescaled, reduced=SIX_DIGITS, stalled=True)
    for accuracy, step, rescaled in (
        (1e-11, 0.99, True),
        (1e-11, 0.9, True),
        (1e-11, 0.99, False),
        (1e-8, 0.9, True),
    )
)
METHOD_COUNT = len(SETTINGS) + 2


def solve(program: Program, first: int = 0) -> Solution:
    """The solution of a program; of one with cones by the first method, from this one on, that comes to one.

    Without cones the simplex (:class:`Simplex`). With cones Clarabel's interior points with its own scaling
    on top, with shorter steps, without that scaling, to less accuracy; dense interior points, for one cone
    over the first columns, which come first where there are many rows; of few rows then linear programs that
    cut the cones (:func:`cut_cones`), which take minutes where there are more. Each has the last word on some
    joints with stiffness next to the end of double precision.

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
    methods: list[Callable[[Program], Solution]] = [partial(by_clarabel, asked=each) for each in SETTINGS]
    methods.insert(0 if program.linear >= DENSE_FROM else len(methods), by_dense_points)
    failures = []
    for each in (*methods, cut_cones)[first:]:
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


def cut_cones(program: Program) -> Solution:
    """The program by linear programs over planes that touch its cones (Kelley), by simplex.

    What they find is outside the cones; the plane that touches a cone next to there is added until the
    solution is in all to round-off. The planes begin with those of a box.

    Raises
    ------
    SolverError
        If a linear program has no end, the cuts do not come to one, or there are too many rows for them.
    """
    if len(program.right) > MANY_ROWS:
        raise SolverError(f"the cone program of shape {program.matrix.shape} is too large for cutting planes")
    blocks = list(program.blocks())
    planes = [np.vstack([np.eye(count - 1), -np.eye(count - 1)]) for count in program.cones]
    for _ in range(ITERATIONS):
        end = Simplex(_cut(program, planes)).solve()
        if not end.optimal:
            break  # nothing proves that it is infeasible itself; a ray need not be one of the cones
        inside = True
        for k, rows in enumerate(blocks):
            u, terms = program.right[rows] - program.matrix[rows] @ end.x, np.abs(program.matrix[rows][0])
            length = float(np.linalg.norm(u[1:]))
            if length > u[0] + SEVEN_DIGITS * float(terms @ np.abs(end.x)):
                planes[k], inside = np.vstack([planes[k], u[1:] / length]), False
        if inside:
            scaled, scales = program.scaled()
            y = _of_cones(program, planes, end.multipliers)
            return solution_of(scaled, scales, Status.OPTIMAL, end.x / scales.x, y / scales.y)
    raise SolverError(f"the cone program of shape {program.matrix.shape} has no end by cutting planes")


def _cut(program: Program, planes: list[FloatArray]) -> Program:
    """The linear program in which u_0 ≥ 0 and u_0 ≥ w · (u_1, …) for its planes w replace each cone."""
    matrix, right = [program.matrix[: program.linear]], [program.right[: program.linear]]
    for rows, known in zip(program.blocks(), planes, strict=True):
        directions = np.vstack([known, np.zeros(known.shape[1])])
        block, sides = program.matrix[rows], program.right[rows]
        matrix.append(block[0] - directions @ block[1:])
        right.append(sides[0] - directions @ sides[1:])
    left = np.full(len(program.right), program.left)[: program.linear]
    cut = sum(len(known) + 1 for known in planes)
    return replace(
        program,
        matrix=np.vstack(matrix),
        right=np.concatenate(right),
        cones=(),
        left=np.append(left, np.full(cut, -INF)),
    )


def _of_cones(program: Program, planes: list[FloatArray], y: FloatArray) -> FloatArray:
    """Multipliers of the rows in cones, from those of the planes that touch them."""
    found, start = [y[: program.linear]], program.linear
    for known in planes:
        weights = y[start : start + len(known) + 1]
        found += [weights.sum(keepdims=True), -weights[:-1] @ known]
        start += len(weights)
    return np.concatenate(found)


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
