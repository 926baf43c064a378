"""Bounds in exact arithmetic: the optimum between two neighbouring floats, or the proof of a status."""

from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf, nan

import numpy as np

from shakedown.model.constraints import Constraints, constraints
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.rigid_slips import rigid_slips
from shakedown.model.status import Status
from shakedown.programs.exact_program import ExactProgram, ExactVertex, exact_vertex, proves_at_most
from shakedown.programs.exact_rows import ExactRows, exact_rows
from shakedown.programs.integer_algebra import enclosure
from shakedown.programs.linear_program import Solution
from shakedown.programs.verified_vertex import verified_vertex
from shakedown.programs.vertex import without_round_off
from shakedown.tolerances import Tolerances

UPPER_CERTIFIED_UP_TO = 250  # nodes: one program, half a second; several where it is degenerate
LOWER_CERTIFIED_UP_TO = 40  # nodes: one program per node, about a second

NO_VERTEX = "exact arithmetic found no vertex from where the float solution ended"
ROUND_OFF = "the exact answer rests on the round-off of the stored stiffness"


@dataclass(frozen=True)
class Certificate:
    """What exact arithmetic says about a bound.

    Attributes
    ----------
    status
        Optimal, infeasible or unbounded.
    low, high
        Neighbouring floats with the exact load factor between them, equal where it
        is a float itself; NaN where infeasible, inf where unbounded.
    load_factor
        The float nearest to it.
    slip : (n,)
        The exact slip, or where unbounded the direction, rounded; NaN where infeasible.
    multipliers : (2n,)
        The exact multipliers ≥ 0 of the rows that prove it, rounded; where
        infeasible (Farkas) the largest is 1.
    rows
        Indices of the rows that meet in the exact vertex, or that carry a multiplier.
    """

    status: Status
    low: float
    high: float
    load_factor: float
    slip: FloatArray
    multipliers: FloatArray
    rows: tuple[int, ...]


@dataclass(frozen=True)
class NoCertificate:
    """Exact arithmetic was tried and does not vouch for the answer; why, in words."""

    reason: str


def certified_upper(
    problem: Problem, outcome: Solution, tolerances: Tolerances
) -> Certificate | NoCertificate:
    """The exact λ_max, started from the basis in which the float solution ended.

    Parameters
    ----------
    problem
        The problem as stored.
    outcome
        End of the linear program max λ over the columns (v, λ).
    tolerances
        ``stored_digits`` is used.

    Returns
    -------
        The certificate, or why there is none: no regular basis was found, or the
        answer rests on the round-off of the stored stiffness.
    """
    doubt = rigid_slips(problem).doubt
    if doubt:
        return NoCertificate(doubt)
    rows = exact_rows(problem)
    program = _upper_program(rows)
    start = _start(program, outcome)
    end = verified_vertex(program, *start) or exact_vertex(program, *start)
    if end is None:
        return NoCertificate(NO_VERTEX)
    return _accepted(_certificate(program, end, rows), problem, outcome, tolerances)


def rests_on_round_off(
    rows: Constraints, slip: FloatArray, load_factor: float, tolerances: Tolerances
) -> bool:
    """Whether a slip is so large that the last digits of the stored stiffness make the answer.

    A body held by the contact alone has rigid motions without resistance. Stored, they
    have one of the size of round-off, and exact arithmetic would build on it.
    """
    terms = np.abs(rows.G) @ np.abs(slip)
    forces = np.abs(rows.g) + (abs(load_factor) * np.abs(rows.d) if np.isfinite(load_factor) else 0.0)
    return bool(np.finfo(float).eps * terms.max() > tolerances.stored_digits * forces.max())


def starts_safe(problem: Problem, outcome: Solution, tolerances: Tolerances) -> bool | None:
    """Whether there is a safe slip at load factor 0, exactly; None where that stays open.

    ``outcome`` is the end of the linear program min λ subject to every row.
    """
    if rigid_slips(problem).doubt:
        return None
    rows = exact_rows(problem)
    program = replace(_upper_program(rows), cost=[0] * problem.n + [-1])
    end = exact_vertex(program, *_start(program, outcome))
    if end is None or end.status != Status.OPTIMAL or end.x[-1] != 0:
        return None if end is None else False
    slip = _rounded(end.x[:-1], end.x_scale)
    return None if rests_on_round_off(constraints(problem), slip, 0.0, tolerances) else True


def certified_lower(
    problem: Problem, outcomes: dict[int, Solution], first: int, tolerances: Tolerances
) -> tuple[int, Certificate | NoCertificate]:
    """The exact λ_1 and its node: one node solved exactly, the others proved to collapse no earlier.

    Parameters
    ----------
    problem
        The problem as stored.
    outcomes
        End of the linear program min λ of every node.
    first
        The node that collapses first in floats.
    tolerances
        ``stored_digits`` and ``cancellation`` are used.
    """
    doubt = rigid_slips(problem).doubt
    if doubt:
        return first, NoCertificate(doubt)
    rows = exact_rows(problem)
    program = _collapse_program(rows, first)
    best = exact_vertex(program, *_start(program, outcomes[first]))
    if best is None or best.status != Status.OPTIMAL:
        return first, NoCertificate(NO_VERTEX)
    node = first
    for j in range(problem.n):
        if best.x[-1] == 0:
            break
        if j == first:
            continue
        earlier = _collapses_earlier(_collapse_program(rows, j), outcomes[j], best)
        if isinstance(earlier, NoCertificate):
            return first, earlier
        if earlier is not None:
            best, node = earlier, j
    certificate = _certificate(_collapse_program(rows, node), best, rows)
    return node, _accepted(certificate, problem, outcomes[node], tolerances)


def _collapses_earlier(
    program: ExactProgram, outcome: Solution, best: ExactVertex
) -> ExactVertex | NoCertificate | None:
    """Where a node collapses at a smaller load factor than the best one; None where it is proved not to."""
    start, value = _start(program, outcome), (-best.x[-1], best.x_scale)
    if outcome.status == Status.OPTIMAL and proves_at_most(program, *start, value):
        return None
    end = exact_vertex(program, *start)
    if end is None or end.status == Status.UNBOUNDED:
        return NoCertificate(NO_VERTEX)
    if end.status == Status.OPTIMAL and end.x[-1] * best.x_scale < best.x[-1] * end.x_scale:
        return end
    return None


def _accepted(
    certificate: Certificate, problem: Problem, outcome: Solution, tolerances: Tolerances
) -> Certificate | NoCertificate:
    """The certificate, unless it contradicts the floats and rests on the round-off of the stiffness."""
    if certificate.status == Status.INFEASIBLE:
        return certificate
    if outcome.vertex is not None and certificate.status == Status.OPTIMAL:
        gap = abs(abs(outcome.vertex.x[-1]) - certificate.load_factor)
        if gap <= tolerances.stored_digits * certificate.load_factor:
            return certificate
    rows, slip, load_factor = constraints(problem), certificate.slip, certificate.load_factor
    doubtful = rests_on_round_off(rows, slip, load_factor, tolerances)
    if load_factor > 0 and np.isfinite(load_factor):
        doubtful |= significant(rows, slip, load_factor, tolerances)[-1] == 0
    return NoCertificate(ROUND_OFF) if doubtful else certificate


def significant(
    rows: Constraints, slip: FloatArray, load_factor: float, tolerances: Tolerances
) -> FloatArray:
    """Slip and load factor (n + 1,), with zero for what changes no row by more than its round-off."""
    matrix, x = np.column_stack([rows.G, rows.d]), np.append(slip, load_factor)
    return without_round_off(matrix, x, rows.g, tolerances.cancellation * len(x))


def _upper_program(rows: ExactRows) -> ExactProgram:
    """Maximise λ subject to every row and −λ ≤ 0, the last row."""
    n = len(rows.matrix[0]) - 1
    return ExactProgram([*rows.matrix, [0] * n + [-1]], [*rows.right, 0], [0] * n + [1])


def _collapse_program(rows: ExactRows, node: int) -> ExactProgram:
    """Maximise −λ with the two rows of a node reversed."""
    program = _upper_program(rows)
    matrix, right = list(program.matrix), list(program.right)
    for i in (2 * node, 2 * node + 1):
        matrix[i], right[i] = [-x for x in matrix[i]], -right[i]
    return replace(program, matrix=matrix, right=right, cost=[-x for x in program.cost])


def _start(program: ExactProgram, outcome: Solution) -> tuple[list[int], list[int]]:
    """Active rows and free columns; where λ is at its bound 0, the last row is active."""
    active, free = outcome.active.tolist(), outcome.free.tolist()
    last_row, last_column = len(program.matrix) - 1, len(program.cost) - 1
    if last_column not in free:
        return [*active, last_row], [*free, last_column]
    return active, free


def _certificate(program: ExactProgram, end: ExactVertex, rows: ExactRows) -> Certificate:
    n, multipliers = len(program.cost) - 1, _multipliers(end, rows)
    if end.status == Status.INFEASIBLE:
        slip, low, high, near = np.full(n, nan), nan, nan, nan
    elif end.status == Status.UNBOUNDED:
        slip, low, high, near = _rounded(end.x[:-1], end.x[-1]), inf, inf, inf
    else:
        value = abs(end.x[-1])
        slip = _rounded(end.x[:-1], end.x_scale)
        low, high = enclosure(value, end.x_scale)
        near = value / end.x_scale
    return Certificate(
        end.status, low, high, near, slip, multipliers, tuple(np.flatnonzero(multipliers).tolist())
    )


def _multipliers(end: ExactVertex, rows: ExactRows) -> FloatArray:
    """The multipliers of the rows themselves, not of their integer multiples."""
    values = np.zeros(len(rows.matrix))
    lifted = {i: Fraction(y) * rows.factors[i] for i, y in end.y.items() if i < len(values)}
    scale = (
        max(lifted.values(), default=Fraction(1))
        if end.status == Status.INFEASIBLE
        else Fraction(end.y_scale)
    )
    for i, value in lifted.items():
        values[i] = value / scale
    return values


def _rounded(numerators: list[int], denominator: int) -> FloatArray:
    return np.array([x / denominator for x in numerators])
