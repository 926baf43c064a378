"""The solution of a ``DiscProgram``, by the interior points of ``self_dual``."""

from collections.abc import Callable
from dataclasses import replace

from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import SolverError
from shakedown.ground.status import Status
from shakedown.ground.work_limit import on_one_thread
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.reaction_unknowns import in_reactions
from shakedown.programs.self_dual import USABLE, Enough, Points, SelfDualSolution, never, solve_self_dual


@on_one_thread
def solve_discs(
    program: DiscProgram, usable: float = USABLE, begun: Points = (), enough: Enough = never
) -> SelfDualSolution:
    """The solution of a program, with the points on the way to it; one less accurate than ``usable`` is none.

    ``begun`` is the way to the end of a program that differs little, a head start where there are many nodes.
    A point on the way, (y, w) and multipliers, that is ``enough`` is an end, however inaccurate.

    Raises
    ------
    SolverError
        If it comes to no end.

    Examples
    --------
    The largest w such that (1 − y, w) is within a circle of radius 1 about the origin, and |y| ≤ 0.2:

    >>> import numpy as np
    >>> program = DiscProgram(
    ...     blocks=np.array([[[0.0], [1.0], [0.0]]]), node=np.array([0]),
    ...     extra=np.array([[[0.0], [0.0], [1.0]]]), right=np.array([[1.0, 1.0, 0.0]]),
    ...     rows=np.array([[1.0], [-1.0]]), rows_extra=np.zeros((2, 1)), rows_right=np.array([0.2, 0.2]),
    ...     cost=np.array([-1.0]),
    ... )
    >>> end = solve_discs(program)
    >>> str(end.status), end.x.round(6)
    ('optimal', array([0.2, 0.6]))
    """
    faster, end = in_reactions(program), None
    if faster is not None:
        in_y, shared = faster.in_y, _with(faster.in_z, begun)
        end = solve_self_dual(faster, usable, shared, lambda x, multipliers: enough(in_y(x), multipliers))
        end = replace(end, x=faster.in_y(end.x), path=_with(faster.in_y, end.path))
    if end is None or end.status == Status.UNDECIDED:
        end = solve_self_dual(program, usable, enough=enough)
    if end.status == Status.UNDECIDED:
        raise SolverError(
            f"the program of {len(program.node)} discs ended without an answer, {end.accuracy:.1e} from one"
        )
    return end


def _with(change: Callable[[FloatArray], FloatArray], points: Points) -> Points:
    """The same points in other unknowns."""
    return tuple(point._replace(x=change(point.x)) for point in points)
