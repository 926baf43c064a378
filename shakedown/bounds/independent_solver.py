"""The bounds by an independent solver: interior points, by Clarabel or by any solver that cvxpy knows.

Less sharp than the simplex; it is here to be compared with.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from math import inf, nan

import numpy as np

from shakedown.bounds.certificate import load_factor_program
from shakedown.bounds.discs.disc_rows import DiscRows, zone_rows
from shakedown.bounds.discs.scaled_solution import scaled_discs
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import Missing, sought
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIDES, checked, node_numbers, require_plane
from shakedown.joint.constraints import Constraints, Side, constraints
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.conic import ACCURACY, REDUCED, by_clarabel, by_cvxpy, discs_by_clarabel
from shakedown.programs.program import Program


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
        The safe slip or the critical slip state [length]; NaN unless optimal.
    solver
        Name of the solver.
    reduced_accuracy
        Whether the solver reached its reduced tolerances only (1e-8 instead of 1e-11).
    unit
        The load factor that is 1 in the numbers of the solver: next to nothing beside it is nothing to it.
    """

    status: Status
    load_factor: float
    node: int
    slip: FloatArray
    solver: str
    reduced_accuracy: bool = False
    unit: float = 1.0


@checked
def conic_upper_bound(
    problem: Problem,
    *,
    open_nodes: Iterable[int] = (),
    solver: str | None = None,
    tolerances: Tolerances = DEFAULT,
) -> ConicBound:
    """λ_max by interior points: the program (5.16) over the extreme load step of every row or disc.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    open_nodes
        The nodes that stay open (:func:`upper_bound`).
    solver
        Name of a linear-programming solver, called through cvxpy (the extra ``solvers``); by default
        Clarabel, called directly.
    tolerances
        ``equilibration_sweeps`` is used.

    Examples
    --------
    >>> import shakedown
    >>> round(conic_upper_bound(shakedown.example("two-node")).load_factor, 6)
    0.739146
    """
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    limits = zone.constraints
    if problem.directions == 1:
        bound = _over_rows(limits, solver, tolerances)
        return replace(bound, slip=zone.slips(limits.slips(bound.slip)))

    rows = zone_rows(zone)

    def end(towards: float) -> ConicBound:
        if solver is None:
            return _end(partial(_over_discs, rows, towards), rows.half_spaces.n, "CLARABEL")
        found = extreme_load_factor(load_factor_program(limits, towards, tolerances), solver)
        return replace(found, slip=limits.slips(found.slip))

    bound = end(-1.0)
    if bound.status == Status.UNBOUNDED:  # as far as anything is safe
        start = end(+1.0)
        bound = bound if start.status == Status.OPTIMAL else start
    return replace(bound, slip=zone.slips(bound.slip))


def _over_rows(rows: Constraints, solver: str | None, tolerances: Tolerances) -> ConicBound:
    """λ_max in the plane; rows of gaps, most of which never matter, are added where they are violated.

    All of them at once make Clarabel call the load factor of some zones unbounded.
    """
    taken, most = rows.side != Side.GAP, load_factor_program(rows, towards=-1.0, tolerances=tolerances)
    while True:
        bound = extreme_load_factor(replace(most, matrix=most.matrix[taken], right=rows.g[taken]), solver)
        violated = ~taken
        if bound.status == Status.OPTIMAL:
            excess = rows.relative_excess(rows.slips(bound.slip), bound.load_factor)
            violated &= excess > tolerances.agreement
        if bound.status == Status.INFEASIBLE or not violated.any():
            return bound
        taken |= violated


def _over_discs(rows: DiscRows, towards: float) -> ConicBound:
    """An extreme λ of a joint in space by Clarabel; raises ``SolverError`` where it comes to none."""
    scaled = scaled_discs(rows, towards)
    status, x, reduced = discs_by_clarabel(scaled.program)
    if status != Status.OPTIMAL:
        return _nothing(status, rows.half_spaces.n, "CLARABEL")
    unit = scaled.load_unit
    slip = rows.half_spaces.slips(scaled.slips(x))
    return ConicBound(status, float(x[-1]) * unit, -1, slip, "CLARABEL", reduced, unit)


@checked
def conic_lower_bound(
    problem: Problem,
    *,
    nodes: Iterable[int] | None = None,
    solver: str | None = None,
    tolerances: Tolerances = DEFAULT,
) -> ConicBound:
    """λ_1 from one program per node, its two rows reversed and every other row kept.

    As for the simplex there must be a safe slip under the mean load, and λ_1 is λ_max
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
    least = load_factor_program(rows, towards=+1.0, tolerances=tolerances)
    start = extreme_load_factor(least, solver)
    if start.status == Status.UNDECIDED:
        return start
    if start.status != Status.OPTIMAL or _unsafe(rows, least, start, tolerances):
        return _nothing(Status.INFEASIBLE, rows.n, start.solver)
    most = least.with_signs(cost=-1.0)
    found = [extreme_load_factor(most, solver)]  # λ_max: λ_1 is never larger
    for node in range(problem.n) if nodes is None else node_numbers("nodes", nodes, problem.n):
        own_reversed = least.with_signs(np.where(rows.limits_of(node), -1.0, 1.0))
        end = extreme_load_factor(own_reversed, solver)
        found.append(replace(end, node=node) if end.status != Status.INFEASIBLE else found[0])
        if found[-1].load_factor <= tolerances.feasibility:
            break
    decided = [end for end in found if end.status != Status.UNDECIDED]
    best = min(decided, key=lambda end: end.load_factor, default=found[0])
    open_ends = len(decided) < len(found)
    if open_ends and not best.load_factor <= tolerances.feasibility:  # an unfinished program might end lower
        return _nothing(Status.UNDECIDED, rows.n, start.solver)
    return best


def _unsafe(rows: Constraints, program: Program, start: ConicBound, tolerances: Tolerances) -> bool:
    """Whether the smallest load factor with a safe slip is not zero, to the accuracy of the solver.

    Where all terms of a row vanish at a safe slip, what the solver leaves of them is all that there is
    to compare with: its own accuracy, in its own units, is allowed besides.
    """
    terms = np.abs(rows.G) @ np.abs(start.slip) + np.abs(rows.g)
    asked = REDUCED if start.reduced_accuracy else ACCURACY
    left = asked * program.scales.size / program.scales.row
    allowed = max(tolerances.agreement, tolerances.feasibility) * terms + left
    return bool(np.any(rows.excess(start.slip, 0.0) > allowed))


def extreme_load_factor(program: Program, solver: str | None = None) -> ConicBound:
    """The solution of a program whose last unknown is the load factor, by interior points."""
    name, size = solver or "CLARABEL", len(program.cost) - 1

    def end() -> ConicBound:
        found = by_clarabel(program) if solver is None else by_cvxpy(program, solver)
        if not found.optimal:
            return _nothing(found.status, size, name)
        unit, reduced = float(program.scales.x[-1]), found.reduced_accuracy
        return ConicBound(found.status, float(found.x[-1]), -1, found.x[:-1], name, reduced, unit)

    return _end(end, size, name)


def _end(attempt: Callable[[], ConicBound], size: int, solver: str) -> ConicBound:
    """The result of a solver; undecided where it does not finish."""
    found = sought(attempt)
    return _nothing(Status.UNDECIDED, size, solver) if isinstance(found, Missing) else found


def _nothing(status: Status, n: int, solver: str) -> ConicBound:
    value = inf if status == Status.UNBOUNDED else nan
    return ConicBound(status, value, -1, np.full(n, nan), solver)
