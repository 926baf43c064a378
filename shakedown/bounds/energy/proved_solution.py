"""The solution of a program over discs: interior points, then Newton's method on what is active."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from shakedown.bounds.discs.polished_solution import polished
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import FOUR_DIGITS
from shakedown.ground.status import Status
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.disc_solver import solve_discs
from shakedown.programs.self_dual import Enough, Points, never

# Accuracy that is enough: what w is worth at y, and what the multipliers prove, is computed anew.

Value = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class ProvedSolution:
    """The end of max w_last over a :class:`DiscProgram`.

    Attributes
    ----------
    status
        How it ended.
    y, w : (r,), (p,)
        The solution.
    discs, rows : (K, 3), (k,)
        Multipliers; of an infeasible program those that prove it.
    proved
        What the multipliers prove w_last not to exceed.
    path
        The points on the way.
    """

    status: Status
    y: FloatArray
    w: FloatArray
    discs: FloatArray
    rows: FloatArray
    proved: float = np.nan
    path: Points = ()

    @property
    def value(self) -> float:
        """The largest w_last."""
        return float(self.w[-1])


def proved_solution(
    program: DiscProgram, value: Value, begun: Points = (), enough: Enough = never
) -> ProvedSolution:
    """The solution of a program, polished, with the value that the discs allow there in floats.

    Parameters
    ----------
    program
        Maximise w_last.
    value
        The w that the discs allow at a given y in floats, with the largest w_last.
    begun
        The way to the optimum of a program that differs little.
    enough
        Whether a y on the way is as good as the optimum.

    Raises
    ------
    SolverError
        If no method comes to an end.
    """
    r = program.rank
    end = solve_discs(program, FOUR_DIGITS, begun, lambda x: enough(x[:r]))
    if not enough(end.x[:r]):
        end = polished(program, end)
    discs, rows, _ = program.parts(end.multipliers)
    best = ProvedSolution(end.status, end.x[:r], end.x[r:], discs, rows, path=end.path)
    if end.status != Status.OPTIMAL:
        return best
    w = value(best.y)
    best = replace(best, w=w if np.all(np.isfinite(w)) else best.w)
    return replace(best, proved=proved(program, best))


def balance(program: DiscProgram, discs: FloatArray, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What multipliers of discs and rows add up to in the columns y and w."""
    tail = np.zeros(0 if program.norm is None else program.rank + 1)
    whole = program.transposed(np.concatenate([discs.ravel(), rows, tail]))
    return whole[: program.rank], whole[program.rank :]


def proved(program: DiscProgram, end: ProvedSolution) -> float:
    """The value that multipliers prove not to be exceeded at any y up to twice as far as that of the end.

    Weak duality, with what is left of the balance at its worst there.
    """
    of_y, of_w = balance(program, end.discs, end.rows)
    right = float(np.einsum("ij,ij", end.discs, program.right) + end.rows @ program.rows_right)
    length = float(np.linalg.norm(of_y))
    if program.norm is None:
        return (right + 2 * float(np.linalg.norm(end.y)) * length) / _pull(of_w)
    # of_w = pull · target + weight · norm, and the length of y may weigh as much as `weight`
    norm, pull = program.norm, of_w
    weight = float(of_w[0] / norm[0])
    pull = of_w - weight * norm
    short = max(length - weight, 0.0)
    value = right - weight * program.offset + 2 * float(np.linalg.norm(end.y)) * short
    return value / _pull(pull)


def _pull(of_w: FloatArray) -> float:
    return float(of_w[-1]) if of_w[-1] > 0 else np.nan
