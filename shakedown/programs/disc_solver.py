"""The end of a program over discs: by interior points of its own, else by the roads of every cone program."""

from dataclasses import dataclass, replace

import numpy as np

from shakedown.ground.errors import SolverError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.programs.interior.disc_program import DiscProgram
from shakedown.programs.interior.self_dual import USABLE, SelfDualEnd, self_dual_end
from shakedown.programs.interior.small_cones import TRIPLE
from shakedown.programs.program import Program
from shakedown.programs.solver import solve

ACCURATE = 1e-9  # of an end: less is said to be of reduced accuracy
MOST_ENTRIES = 40_000_000  # of the matrix of a program that is written out disc by disc


@dataclass(frozen=True)
class DiscSolution:
    """How a program ended, part by part.

    Attributes
    ----------
    status
        Optimal, infeasible or unbounded.
    y, w : (r,), (p,)
        The solution; the ray of an unbounded program.
    discs, rows : (K, 3), (k,)
        Multipliers in the cones; of an infeasible program those that prove it.
    """

    status: Status
    y: FloatArray
    w: FloatArray
    discs: FloatArray
    rows: FloatArray


def solved(program: DiscProgram, tolerances: Tolerances = DEFAULT, usable: float = USABLE) -> DiscSolution:
    """The end of a program, to about ten digits; see :func:`disc_end`.

    Examples
    --------
    The largest w such that (1 − y, w) is within a circle of radius 1 about the origin, and |y| ≤ 0.2:

    >>> program = DiscProgram(
    ...     blocks=np.array([[[0.0], [1.0], [0.0]]]), node=np.array([0]),
    ...     extra=np.array([[[0.0], [0.0], [1.0]]]), right=np.array([[1.0, 1.0, 0.0]]),
    ...     rows=np.array([[1.0], [-1.0]]), rows_extra=np.zeros((2, 1)), rows_right=np.array([0.2, 0.2]),
    ...     cost=np.array([-1.0]),
    ... )
    >>> end = solved(program)
    >>> str(end.status), end.y.round(6), end.w.round(6)
    ('optimal', array([0.2]), array([0.6]))
    """
    end, r = disc_end(program, tolerances, usable), program.rank
    discs, rows, _ = program.parts(end.multipliers)
    return DiscSolution(end.status, end.x[:r], end.x[r:], discs, rows)


def disc_end(program: DiscProgram, tolerances: Tolerances = DEFAULT, usable: float = USABLE) -> SelfDualEnd:
    """The end of a program, with the points on the way to it; less accurate than ``usable`` by other roads.

    Raises
    ------
    SolverError
        If no road comes to an end.
    """
    end = self_dual_end(program, usable)
    return (
        replace(_second_road(program, tolerances), path=end.path) if end.status == Status.UNDECIDED else end
    )


def _second_road(program: DiscProgram, tolerances: Tolerances) -> SelfDualEnd:
    """The end of the same program, with one cone of its own for every disc."""
    told = _written_out(program, tolerances)
    found, k, discs = solve(told), len(program.rows), TRIPLE * len(program.node)
    y, x = np.nan_to_num(found.multipliers), np.nan_to_num(found.x)
    y = np.concatenate([y[k : k + discs], y[:k], y[k + discs :]])
    slack, accuracy = program.limits - program.times(x), ACCURATE
    if found.optimal:
        accuracy = max(abs(each) for each in found.residuals)
    if found.status == Status.UNBOUNDED:
        x = x / -float(program.costs @ x)
        slack = -program.times(x)
    return SelfDualEnd(found.status, x, slack, y, accuracy, ())


def _written_out(program: DiscProgram, tolerances: Tolerances) -> Program:
    K, columns, r = len(program.node), len(program.costs), program.rank
    rows = TRIPLE * K + len(program.rows)
    if rows * columns > MOST_ENTRIES:
        raise SolverError(f"the program of {K} discs ended without an answer")
    discs = program.columns(np.arange(K)).reshape(TRIPLE * K, columns)
    parts = [np.hstack([program.rows, program.rows_extra]), discs]
    right, cones = [program.rows_right, program.right.ravel()], (TRIPLE,) * K
    if program.norm is not None:
        bound = np.zeros((r + 1, columns))
        bound[0, r:], bound[1:, :r] = -program.norm, -np.eye(r)
        parts.append(bound)
        right.append(np.append(-program.offset, np.zeros(r)))
        cones += (r + 1,)
    return Program(np.vstack(parts), np.concatenate(right), program.costs, cones, tolerances=tolerances)
