"""The solution of a program over limits with what its multipliers prove: discs, or rows alone."""

from collections.abc import Callable
from dataclasses import replace
from math import inf

import numpy as np

from shakedown.bounds.discs.scaled_solution import ProvedSolution, balance, polished, proved
from shakedown.bounds.energy.ball_limits import Places
from shakedown.ground.constants import DENSE_FROM, FOUR_DIGITS, NEGLIGIBLE, FloatArray
from shakedown.ground.errors import Missing, sought
from shakedown.ground.status import Status
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.program import Program, ball
from shakedown.programs.self_dual import Enough, Points, SelfDualSolution, never, solve_discs
from shakedown.programs.solver import solve, widest

Value = Callable[[FloatArray], FloatArray]
SHARP = NEGLIGIBLE / 10  # relative gap between a value and what its multipliers prove, of rows alone
FIRST_ROWS = 40  # with these, and a quarter of all, most programs are solved in one or two rounds


def solution(program: DiscProgram) -> SelfDualSolution:
    """The solution of a program to four digits: what it is worth, and what it proves, is to be computed anew.

    Raises ``SolverError`` if no method comes to an end.
    """
    end = sought(_of_rows, program) if _is_of_rows(program) else Missing("")
    return solve_discs(program, FOUR_DIGITS) if isinstance(end, Missing) else end


def proved_solution(
    program: DiscProgram,
    value: Value,
    begun: Points = (),
    enough: Enough = never,
) -> ProvedSolution:
    """The solution of a program, polished, with the value that the limits allow there in floats.

    Parameters
    ----------
    program
        Maximise w_last.
    value
        The w that the limits allow at a given y in floats, with the largest w_last.
    begun
        The way to the optimum of a program that differs little.
    enough
        Whether a y on the way, or the multipliers there, are as good as the optimum.

    Raises
    ------
    SolverError
        If no method comes to an end.
    """
    if _is_of_rows(program):
        found = sought(_proved_of_rows, program, value)
        if not isinstance(found, Missing) and _is_clear(program, found):
            return found
    r = program.rank

    def known(x: FloatArray, multipliers: FloatArray) -> bool:
        return enough(x[:r], multipliers)

    end = solve_discs(program, FOUR_DIGITS, begun, known)
    return _proved(program, value, end if known(end.x, end.multipliers) else polished(program, end))


def contradiction(program: DiscProgram, end: ProvedSolution) -> float:
    """By how much multipliers fail to prove that the limits contradict each other (Farkas)."""
    of_y, of_w = balance(program, end.discs, end.rows)
    weight = 0.0 if program.norm is None else float(of_w[0])
    value = -float(np.einsum("ij,ij", end.discs, program.right) + end.rows @ program.rows_right)
    value += weight * program.offset
    if not value > 0:
        return inf
    terms = np.einsum("ij,ij", np.abs(end.discs), np.abs(program.right))
    sizes = float(terms + np.abs(end.rows) @ np.abs(program.rows_right))
    return max(float(np.linalg.norm(of_y)) - weight, abs(float(of_w[-1])), 0.0) / max(sizes, value)


def _is_clear(program: DiscProgram, found: ProvedSolution) -> bool:
    """Whether the simplex has come to an optimum, or interior points to an end that proves itself."""
    if found.status == Status.INFEASIBLE:
        return contradiction(program, found) <= NEGLIGIBLE
    if program.norm is None or found.status == Status.UNBOUNDED:
        return True
    return abs(found.proved - found.value) <= SHARP * abs(found.value)


def _proved_of_rows(program: DiscProgram, value: Value) -> ProvedSolution:
    end = _of_rows(program)
    return _proved(program, value, end if program.norm is None else polished(program, end))


def _proved(program: DiscProgram, value: Value, end: SelfDualSolution) -> ProvedSolution:
    """An end with the value at its y, and what its multipliers prove."""
    y, w = np.split(end.x, [program.rank])
    discs, rows, _ = program.parts(end.multipliers)
    found = ProvedSolution(end.status, y, w, discs, rows, path=end.path)
    if end.status != Status.OPTIMAL:
        return found
    allowed = value(y)
    found = replace(found, w=allowed if np.all(np.isfinite(allowed)) else w)
    return replace(found, proved=proved(program, found))


def _is_of_rows(program: DiscProgram) -> bool:
    """Whether there are no discs, and few rows if there is no cone: of many interior points do."""
    return len(program.node) == 0 and (program.norm is not None or len(program.rows) < DENSE_FROM)


def _of_rows(program: DiscProgram) -> SelfDualSolution:
    """The solution of a program without discs, by the simplex or within one cone by interior points.

    Few rows decide: they are added as they turn out to be violated. The solution is a combination of
    the rows that carry a multiplier, so k rows need no more than k unknowns in the place of y.
    """
    matrix, right = np.hstack([program.rows, program.rows_extra]), program.rows_right
    everything, rank = np.arange(len(right)), program.rank
    chosen = _first_rows(program)
    while True:  # ends: every round takes further rows, and there are finitely many
        rows = program.rows[chosen]
        basis = np.linalg.qr(rows.T)[0] if len(chosen) < rank else np.eye(rank)
        inner = np.hstack([rows @ basis, program.rows_extra[chosen]])
        columns, within = inner.shape[1], program.norm is not None
        r = columns - len(program.cost)
        found = solve(
            Program(
                np.vstack([inner, ball(r, columns)]) if within else inner,
                np.concatenate([right[chosen], [-program.offset, *np.zeros(r)] if within else []]),
                np.append(np.zeros(r), program.cost),
                cones=(r + 1,) if within else (),
            )
        )
        x = np.append(basis @ found.x[:r], found.x[r:])
        if found.status == Status.OPTIMAL:
            terms = np.maximum(np.abs(matrix) @ np.abs(x), np.abs(right))
            excess = (matrix @ x - right) / np.where(terms > 0, terms, 1.0)
            added = np.setdiff1d(np.flatnonzero(excess > NEGLIGIBLE), chosen)
            if not added.size:
                break
            worst = added[np.argsort(-excess[added])[: max(FIRST_ROWS, len(chosen))]]
            chosen = np.union1d(chosen, worst)
        elif found.status == Status.INFEASIBLE or len(chosen) == len(everything):
            break
        else:
            chosen = everything
    multipliers = np.zeros(len(program.limits))
    multipliers[chosen] = found.multipliers[: len(chosen)]
    if found.status == Status.INFEASIBLE and not within:  # of the rows that contradict each other most
        multipliers[chosen] = widest(inner, np.ones(len(chosen)), right[chosen], cap=1.0).multipliers
    if within:
        tail = found.multipliers[len(chosen) :]
        multipliers[len(right) :] = np.append(tail[0], basis @ tail[1:])
    return SelfDualSolution(found.status, x, program.limits - program.times(x), multipliers, 0.0, ())


def _first_rows(program: DiscProgram) -> Places:
    """The rows that limit w_last first at y = 0, and those without y."""
    slack, last = np.array(program.rows_right), program.rows_extra[:, -1]
    if program.norm is not None:
        slack = slack - program.offset * program.rows_extra[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        first = np.where(last > 0, slack / last, np.where(slack < 0, -np.inf, np.inf))
    first = np.where(program.rows.any(axis=1), first, -np.inf)
    return np.sort(np.argsort(first, kind="stable")[: FIRST_ROWS + len(first) // 4])
