"""The second road to the bounds: interior points, by Clarabel or by any solver that cvxpy knows.

Less sharp than the simplex road; it is here to be compared with.
"""

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import inf, nan

import clarabel
import numpy as np
from scipy import sparse

from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIDES, checked, node_numbers, require_plane
from shakedown.joint.constraints import GAP, Constraints, constraints, step_loads
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.cone_program import CLARABEL_ENDS
from shakedown.programs.equilibration import equilibration, typical_size

# The tolerance that Clarabel is asked for and the length of its steps; the second where the first stalls.
ATTEMPTS = ((1e-11, 0.99), (1e-9, 0.9))
REDUCED = 1e-8  # what it must reach


@dataclass(frozen=True, eq=False, repr=False)
class ConicBound(Result):
    """A bound from an interior-point solver.

    Attributes
    ----------
    status
        Optimal, infeasible, unbounded or undecided (the solver stopped short of its
        tolerances: what it had is not reported as a number).
    load_factor
        λ_max or λ_1; inf where it does not exist because nothing limits it, NaN
        where infeasible or undecided.
    node
        The node that collapses (λ_1 only), else −1.
    slip : (n,)
        The safe slip or the witness [length]; NaN unless optimal.
    solver
        Name of the solver.
    reduced_accuracy
        Whether the solver reached its reduced tolerances only (1e-8 instead of 1e-11).
    """

    status: Status
    load_factor: float
    node: int
    slip: FloatArray
    solver: str
    reduced_accuracy: bool = False


@checked
def conic_upper_bound(
    problem: Problem,
    *,
    open_nodes: Iterable[int] = (),
    solver: str | None = None,
    tolerances: Tolerances = DEFAULT,
) -> ConicBound:
    """λ_max from |q| ≤ f p at every node and every load step: the program (5.16) as it stands.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    open_nodes
        The nodes that stay open (:func:`upper_bound`); with them the extreme load step of
        every row is taken alone.
    solver
        Name of a linear-programming solver, called through cvxpy; by default Clarabel,
        called directly.
    tolerances
        ``equilibration_sweeps`` is used.

    Examples
    --------
    >>> import shakedown
    >>> round(conic_upper_bound(shakedown.example("two-node")).load_factor, 6)
    0.739146
    """
    require_plane("upper bound", problem)
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    if zone.open_nodes:
        bound = _bound_in_zone(zone.constraints, solver, tolerances)
        return replace(bound, slip=zone.slips(bound.slip))
    rows, steps = constraints(problem), step_loads(problem)
    taken = np.zeros(steps.shape, dtype=bool)
    taken[rows.step, np.arange(len(rows.step))] = True  # few of all rows matter: these first
    while True:  # ends: every round takes further rows, and there are finitely many
        step, row = np.nonzero(taken)
        matrix = np.column_stack([rows.coefficients[row], steps[step, row]])
        bound = extreme_load_factor(matrix, rows.g[row], -1.0, solver, tolerances)
        if bound.status != Status.OPTIMAL:
            return bound
        excess = rows.G @ bound.slip + bound.load_factor * steps - rows.g
        terms = np.abs(rows.G) @ np.abs(bound.slip) + np.abs(bound.load_factor * steps) + np.abs(rows.g)
        violated = ~taken & (excess > tolerances.second_road * terms)
        if not violated.any():
            return bound
        taken |= violated


def _bound_in_zone(rows: Constraints, solver: str | None, tolerances: Tolerances) -> ConicBound:
    """λ_max of closed and open nodes; gaps, most of which never close, where they are broken."""
    taken = rows.side != GAP
    while True:
        matrix = np.column_stack([rows.coefficients, rows.d])[taken]
        bound = extreme_load_factor(matrix, rows.g[taken], -1.0, solver, tolerances)
        bound = replace(bound, slip=rows.slips(bound.slip))
        violated = ~taken
        if bound.status == Status.OPTIMAL:
            excess = rows.relative_excess(bound.slip, bound.load_factor)
            violated &= excess > tolerances.second_road
        if bound.status == Status.INFEASIBLE or not violated.any():
            return bound
        taken |= violated


@checked
def conic_lower_bound(
    problem: Problem,
    *,
    nodes: Iterable[int] | None = None,
    solver: str | None = None,
    tolerances: Tolerances = DEFAULT,
) -> ConicBound:
    """λ_1 from one program per node, its two rows reversed and every other row kept.

    As on the first road there must be a safe slip under the mean load, and λ_1 is λ_max
    where all safe slips vanish before any node collapses. A node that collapses at λ = 0
    is the last one asked: none can collapse earlier.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    nodes
        The nodes whose programs are solved, in this order; by default all. The first collapse
        of some nodes is an upper bound of λ_1.
    solver, tolerances
        As for :func:`conic_upper_bound`.

    Examples
    --------
    >>> import shakedown
    >>> round(conic_lower_bound(shakedown.example("two-node")).load_factor, 6)
    0.657373
    """
    require_plane("first collapse", problem, NO_SIDES)
    rows = constraints(problem)
    matrix = np.column_stack([rows.coefficients, rows.d])
    start = extreme_load_factor(matrix, rows.g, +1.0, solver, tolerances)
    if start.status == Status.UNDECIDED:
        return start
    if start.status != Status.OPTIMAL or _unsafe(rows, matrix, start, tolerances):
        return _nothing(Status.INFEASIBLE, rows.n, start.solver)
    found = [extreme_load_factor(matrix, rows.g, -1.0, solver, tolerances)]  # λ_max: λ_1 is never larger
    for node in range(problem.n) if nodes is None else node_numbers("nodes", nodes, problem.n):
        sign = np.where(rows.node == node, -1.0, 1.0)
        end = extreme_load_factor(matrix * sign[:, None], rows.g * sign, +1.0, solver, tolerances)
        found.append(replace(end, node=node) if end.status != Status.INFEASIBLE else found[0])
        if found[-1].load_factor <= tolerances.feasibility:
            break
    decided = [end for end in found if end.status != Status.UNDECIDED]
    best = min(decided, key=lambda end: end.load_factor, default=found[0])
    open_ends = len(decided) < len(found)
    if open_ends and not best.load_factor <= tolerances.feasibility:  # a program left open may end lower
        return _nothing(Status.UNDECIDED, rows.n, start.solver)
    return best


def _unsafe(rows: Constraints, matrix: FloatArray, start: ConicBound, tolerances: Tolerances) -> bool:
    """Whether the smallest load factor with a safe slip is not zero, to the accuracy of the road.

    Where all terms of a row vanish at a safe slip, what the solver leaves of them is all that there is
    to compare with: its own accuracy, in its own units, is allowed besides.
    """
    terms = np.abs(rows.G) @ np.abs(start.slip) + np.abs(rows.g)
    row_scale, column_scale = equilibration(matrix, tolerances.equilibration_sweeps)
    asked = REDUCED if start.reduced_accuracy else ATTEMPTS[0][0]
    left = asked * _load_unit(rows.g * row_scale, column_scale) / row_scale
    allowed = max(tolerances.second_road, tolerances.feasibility) * terms + left
    return bool(np.any(rows.excess(start.slip, 0.0) > allowed))


def extreme_load_factor(
    matrix: FloatArray, right: FloatArray, towards: float, solver: str | None, tolerances: Tolerances
) -> ConicBound:
    """The largest (towards −1) or smallest (+1) λ ≥ 0 with matrix · (v, λ) ≤ right.

    Solvers with absolute tolerances need numbers near 1: rows and columns are scaled,
    and the unit of load is a typical right-hand side, or where there is none that of the loop.
    """
    count = matrix.shape[1]
    kept = np.append(matrix[:, :-1].any(axis=0), True)
    if not kept.all():  # slips that no row knows stay zero
        part = extreme_load_factor(matrix[:, kept], right, towards, solver, tolerances)
        slip = np.zeros(count - 1)
        slip[kept[:-1]] = part.slip
        return replace(part, slip=slip if part.status == Status.OPTIMAL else np.full(count - 1, nan))
    row_scale, column_scale = equilibration(matrix, tolerances.equilibration_sweeps)
    size = _load_unit(right * row_scale, column_scale)
    positive = np.append(np.zeros(count - 1), -1.0)
    scaled = np.vstack([matrix * row_scale[:, None] * column_scale, positive])
    limits = np.append(right * row_scale / size, 0.0)
    cost = np.append(np.zeros(count - 1), towards)
    name = solver or "CLARABEL"
    solve = _by_clarabel if solver is None else lambda c, M, b: _by_cvxpy(c, M, b, name)
    status, x, reduced = solve(cost, scaled, limits)
    if status != Status.OPTIMAL:
        return _nothing(status, count - 1, name)
    x = x * column_scale * size
    return ConicBound(status, float(x[-1]), -1, x[:-1], name, reduced)


def _load_unit(right: FloatArray, column_scale: FloatArray) -> float:
    """The size of the right-hand sides; where all are zero, that at which the scaled load factor is λ."""
    return typical_size(np.abs(right)) if right.any() else 1.0 / float(column_scale[-1])


def _nothing(status: Status, n: int, solver: str) -> ConicBound:
    value = inf if status == Status.UNBOUNDED else nan
    return ConicBound(status, value, -1, np.full(n, nan), solver)


def _by_clarabel(cost: FloatArray, matrix: FloatArray, right: FloatArray) -> tuple[Status, FloatArray, bool]:
    """Minimise cost · x subject to matrix · x ≤ right: status, x, and whether only to reduced accuracy."""
    count, table = len(cost), sparse.csc_matrix(matrix)
    nothing, cone = sparse.csc_matrix((count, count)), [clarabel.NonnegativeConeT(len(right))]
    for tolerance, step in ATTEMPTS:
        settings = clarabel.DefaultSettings()
        settings.verbose = settings.equilibrate_enable = False  # the data come equilibrated
        settings.max_step_fraction = step
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
        settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = settings.reduced_tol_feas = REDUCED
        end = clarabel.DefaultSolver(nothing, cost, table, right, cone, settings).solve()
        name = str(end.status)
        if name in CLARABEL_ENDS:
            return (
                CLARABEL_ENDS[name],
                np.array(end.x),
                name.startswith("Almost") or tolerance > ATTEMPTS[0][0],
            )
    return Status.UNDECIDED, np.full(count, nan), False


def _by_cvxpy(
    cost: FloatArray, matrix: FloatArray, right: FloatArray, solver: str
) -> tuple[Status, FloatArray, bool]:
    """The same through cvxpy, for any solver that it knows."""
    import cvxpy as cp  # slow to import, and needed only here

    x = cp.Variable(len(cost))
    program = cp.Problem(cp.Minimize(cost @ x), [matrix @ x <= right])
    keys = ("tol_gap_abs", "tol_gap_rel", "tol_feas") if solver == "CLARABEL" else ()
    sharp = dict.fromkeys(keys, ATTEMPTS[0][0])
    with warnings.catch_warnings():  # an inaccurate answer is a status here, not a warning
        warnings.simplefilter("ignore", UserWarning)
        try:
            program.solve(solver=solver, **sharp)
        except cp.SolverError:
            return Status.UNDECIDED, np.full(len(cost), nan), False
    if program.status not in list(Status):
        return Status.UNDECIDED, np.full(len(cost), nan), False
    return Status(program.status), np.array(x.value, dtype=float), False
