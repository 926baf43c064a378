"""The rows of a problem as a linear program, and its bounds in exact arithmetic."""

from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import CONVERGED, FloatArray
from shakedown.ground.errors import Missing
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.constraints import Constraints, constraints, loading, pressure_stiffness, rows_of
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs import exact_program
from shakedown.programs.exact_program import ExactProgram, ExactVertex
from shakedown.programs.program import INF, Program, Solution, without_round_off
from shakedown.programs.simplex import ChebyshevCentre, chebyshev_centre


def load_factor_program(rows: Constraints, towards: float, tolerances: Tolerances = DEFAULT) -> Program:
    """Maximise (−1) or minimise (+1) λ ≥ 0 over the columns (v, λ), subject to every row in the plane."""
    return Program(
        np.column_stack([rows.coefficients, rows.d]),
        rows.g,
        cost=np.append(np.zeros(rows.n), towards),
        lower=np.append(np.full(rows.n, -INF), 0.0),
        tolerances=tolerances,
    )


def contradiction(rows: Constraints, tolerances: Tolerances) -> ChebyshevCentre:
    """How far the rows exclude every safe slip at any load factor, and the multipliers that show it."""
    matrix = np.column_stack([rows.coefficients, rows.d])
    sizes = np.abs(matrix).max(axis=1)
    norms = np.where(sizes > 0, sizes, 1.0)
    return chebyshev_centre(matrix, norms, rows.g, cap=INF, signed=rows.n, tolerances=tolerances)


Exact = NDArray[np.object_]  # fractions (FLINT's fmpq), element by element


@dataclass(frozen=True)
class ExactRows:
    """The constraint rows of the problem as stored, each scaled to integers by a positive number.

    Attributes
    ----------
    matrix
        [G | d], r rows of n + 1 integers; zero in the columns of pinned slips.
    right
        g, r integers.
    factors
        Those positive numbers.
    """

    matrix: exact_program.IntegerRows
    right: list[int]
    factors: list[Fraction]


@once_per_problem
def exact_rows(problem: Problem) -> ExactRows:
    """The rows of ``constraints(problem)``, in the unknowns of programs, without any round-off.

    Built once per problem. The columns of pinned slips are zero, and so are pressures without friction that
    are round-off: exact arithmetic would take what stands there for a spring.

    Every stored number is a binary fraction, so the rows are rational: the sample
    mean divides by m. A column of the loading that ``loading`` takes as constant, or as without a mean,
    is so here too.

    Examples
    --------
    >>> import shakedown
    >>> loop = {"q_w": [[1.0], [-1.0]], "p_w": [[3.0], [3.0]]}
    >>> rows = exact_rows(shakedown.Problem(A=[[2.0]], B=[[0.5]], f=0.5, **loop))
    >>> [[x / rows.matrix[0][1] for x in row] for row in rows.matrix], rows.right[0] / rows.matrix[0][1]
    ([[1.75, 1.0], [-2.25, 1.0]], 1.5)
    """
    rigid = rigid_slips(problem)
    A, B = (exact_numbers(rigid.columns(part)) for part in (problem.A, pressure_stiffness(problem)))
    loop = loading(problem)
    q0 = _mean(problem.q_w, problem.q_mean, loop.q0)
    p0 = _mean(problem.p_w, problem.p_mean, loop.p0)
    law = Law(exact_numbers(problem.f))
    q1, p1 = (
        np.where((periodic != 0.0).any(axis=0), exact_numbers(samples) - mean, mean - mean)
        for periodic, samples, mean in ((loop.q1, problem.q_w, q0), (loop.p1, problem.p_w, p0))
    )
    d = law.load_terms(q1, p1).max(axis=0)  # the largest of ±q¹ − f p¹ over the load steps
    return _whole(np.column_stack([law.stiffness(A, B), d, law.cone(q0, p0)]))


def exact_numbers(array: FloatArray) -> Exact:
    """Stored numbers as fractions, element by element."""
    from flint import fmpq

    flat = [fmpq(*x.as_integer_ratio()) for x in array.ravel().tolist()]
    exact = np.empty(len(flat), dtype=object)
    exact[:] = flat
    return exact.reshape(array.shape)


def _mean(samples: FloatArray, given: FloatArray | None, in_floats: FloatArray) -> Exact:
    if given is not None:
        return exact_numbers(in_floats)
    return np.asarray(exact_numbers(np.where(in_floats != 0.0, samples, 0.0)).sum(axis=0) / len(samples))


def _whole(rows: Exact) -> ExactRows:
    """Every row times the least common denominator of its entries."""
    from flint import fmpq_mat

    matrix: exact_program.IntegerRows = []
    right: list[int] = []
    factors: list[Fraction] = []
    for row in rows.tolist():
        numerators, denominator = fmpq_mat(1, len(row), row).numer_denom()
        *left, last = (int(x) for x in numerators.entries())
        matrix.append(left)
        right.append(last)
        factors.append(Fraction(int(denominator)))
    return ExactRows(matrix, right, factors)


UPPER_CERTIFIED_UP_TO = 250  # nodes: one program, seconds; several where it is degenerate
LOWER_CERTIFIED_UP_TO = 40  # nodes: one program per node, about a second


NO_VERTEX = "exact arithmetic came to no vertex in a few steps from the solution in floating-point numbers"


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
    multipliers : (r,)
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
class Disputed(Missing):
    """Raised where exact arithmetic on the stored digits contradicts floats by more than the data allow."""


def certified_upper(problem: Problem, outcome: Solution, tolerances: Tolerances) -> Certificate | Missing:
    """The exact λ_max, started from the basis in which the float solution ended.

    Parameters
    ----------
    problem
        The problem as stored.
    outcome
        End of the linear program max λ over the columns (v, λ).
    tolerances
        ``agreement`` and ``feasibility`` are used.

    Returns
    -------
        The certificate, or why there is none: no regular basis was found, or the
        answer rests on the round-off of the stored stiffness.
    """
    doubt = rigid_slips(problem).doubt
    if doubt:
        return Missing(doubt)
    rows = exact_rows(problem)
    program = _upper_program(rows)
    start = _start(program, outcome)
    end = exact_program.exact_vertex(program, *start)
    if end is None:
        return Missing(NO_VERTEX)
    return _accepted(_certificate(program, end, rows), problem, outcome, tolerances)


def certified_lower(
    problem: Problem, outcomes: dict[int, Solution], first: int, tolerances: Tolerances
) -> tuple[int, Certificate | Missing]:
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
        ``agreement`` and ``feasibility`` are used.
    """
    doubt = rigid_slips(problem).doubt
    if doubt:
        return first, Missing(doubt)
    rows = exact_rows(problem)
    program = _collapse_program(rows, first)
    # of all pivots, as every node takes dozens where the coupling is round-off
    budget = exact_program.PivotBudget(5e5)
    best = exact_program.exact_vertex(program, *_start(program, outcomes[first]), budget)
    if best is None or best.status != Status.OPTIMAL:
        return first, Missing(NO_VERTEX)
    node = first
    for j in range(problem.n):
        if best.x[-1] == 0:
            break
        if j == first:
            continue
        earlier = _collapses_earlier(_collapse_program(rows, j), outcomes[j], best, budget)
        if isinstance(earlier, Missing):
            return first, earlier
        if earlier is not None:
            best, node = earlier, j
    certificate = _certificate(_collapse_program(rows, node), best, rows)
    found = _accepted(certificate, problem, outcomes[first], tolerances)
    return (first if isinstance(found, Missing) else node), found


def _collapses_earlier(
    program: ExactProgram, outcome: Solution, best: ExactVertex, budget: exact_program.PivotBudget
) -> ExactVertex | Missing | None:
    """The earlier collapse of a node, if it is below the best one; None where it is proved not to be."""
    start, value = _start(program, outcome), (-best.x[-1], best.x_scale)
    if outcome.status == Status.OPTIMAL and exact_program.proves_at_most(program, *start, value):
        return None
    end = exact_program.exact_vertex(program, *start, budget)
    if end is None or end.status == Status.UNBOUNDED:
        return Missing(NO_VERTEX)
    if end.status == Status.OPTIMAL and end.x[-1] * best.x_scale < best.x[-1] * end.x_scale:
        return end
    return None


def _accepted(
    certificate: Certificate, problem: Problem, outcome: Solution, tolerances: Tolerances
) -> Certificate | Missing:
    """The certificate, unless it contradicts what the floats say: then these stand, without certificate.

    ``outcome`` is what they say of λ_max, or of the collapse of a node. The two may differ as far as the
    round-off of the stored data shifts λ.
    """
    rows = constraints(problem)
    plain = inf if outcome.status == Status.UNBOUNDED else nan
    plain = float(outcome.x[-1]) if outcome.optimal else plain
    exact = certificate.load_factor
    margin = _left_open(problem, rows, outcome)
    agree = outcome.status == certificate.status and _agree(plain, exact, margin, rows, tolerances)
    # or in floats the limits still meet in a point, but at no load factor
    agree |= certificate.status == Status.INFEASIBLE and _agree(plain, 0.0, margin, rows, tolerances)
    if agree or outcome.reduced_accuracy:  # floats at loosened tolerances contradict nothing
        return certificate
    digits, floats = (
        f"{value:.10g}" if np.isfinite(value) else str(status)
        for value, status in ((exact, certificate.status), (plain, outcome.status))
    )
    why = "the exact answer depends on round-off in the stored stiffness"
    return Disputed(f"{why}: {digits} on all its digits, {floats} in floats")


def _left_open(problem: Problem, rows: Constraints, outcome: Solution) -> float:
    """How far the round-off of the stored stiffness and loads can shift λ at the vertex of the floats."""
    if not outcome.optimal:
        return 0.0
    slip, load_factor = rows.slips(outcome.x[:-1]), outcome.x[-1]
    stiffness = problem.law.stiffness_terms(problem.A, problem.B)
    terms = stiffness @ np.abs(slip) + np.abs(rows.g) + abs(load_factor) * np.abs(rows.d)
    return float(CONVERGED * (np.abs(outcome.multipliers) @ terms))


def _agree(one: float, two: float, margin: float, rows: Constraints, tolerances: Tolerances) -> bool:
    """Whether two load factors agree within the accuracy of the data and of floats."""
    if not (np.isfinite(one) and np.isfinite(two)):
        return one == two or (np.isnan(one) and np.isnan(two))
    scale = float(np.abs(rows.g).max()) / (float(np.abs(rows.d).max()) or inf)
    allowed = margin + tolerances.agreement * max(abs(one), abs(two)) + tolerances.feasibility * scale
    return bool(abs(one - two) <= allowed)


def significant(
    rows: Constraints, slip: FloatArray, load_factor: float, tolerances: Tolerances
) -> FloatArray:
    """Slip and load factor (n + 1,), with entries that change no row beyond its round-off set to zero."""
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
    for i in rows_of(node).tolist():
        matrix[i], right[i] = [-x for x in matrix[i]], -right[i]
    return replace(program, matrix=matrix, right=right, cost=[-x for x in program.cost])


def _start(program: ExactProgram, outcome: Solution) -> tuple[list[int], list[int]]:
    """Active rows and free columns; where λ is at its bound 0, the last row is active."""
    active, free = (each.tolist() for each in outcome.meeting)
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
        low, high = exact_program.enclosure(value, end.x_scale)
        near = value / end.x_scale
    carrying = tuple(np.flatnonzero(multipliers).tolist())
    return Certificate(end.status, low, high, near, slip, multipliers, carrying)


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
