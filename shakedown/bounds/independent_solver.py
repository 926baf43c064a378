"""The bounds by an independent solver: interior points, by Clarabel or by any solver that cvxpy knows.

Less sharp than the simplex; it is here to be compared with.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from math import inf, nan
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.linalg import qr

from shakedown.bounds.row_programs import load_factor_program, reversed_rows
from shakedown.ground.errors import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import CONE
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIDES, checked, node_numbers, require_plane
from shakedown.joint.constraints import Constraints, Side, constraints
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import MOTION_ROUND_OFF
from shakedown.programs.conic import ClarabelSettings, by_clarabel, by_cvxpy, interior_points
from shakedown.programs.program import Program
from shakedown.programs.scaling import ProgramScales

# The highest accuracy, for data already scaled to numbers near 1.
SETTINGS = ClarabelSettings(1e-11, 0.99, rescaled=False, reduced=1e-8)


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
    if problem.directions > 1:
        rows = _without_round_off(zone.constraints)
        bound = _bound_over_discs(rows, solver, tolerances)
    else:
        rows = zone.constraints
        bound = _bound_in_zone(rows, solver, tolerances)
    return replace(bound, slip=zone.slips(rows.slips(bound.slip)))


def _without_round_off(rows: Constraints) -> Constraints:
    """The limits of a joint in space, without right-hand sides that are only the round-off of a mean."""
    size = np.maximum(np.abs(rows.g), np.abs(rows.d))
    of_cones = np.repeat(np.maximum.reduceat(size, rows.heads), rows.cones)
    return replace(rows, g=np.where(np.abs(rows.g) <= MOTION_ROUND_OFF * of_cones, 0.0, rows.g))


def _bound_over_discs(rows: Constraints, solver: str | None, tolerances: Tolerances) -> ConicBound:
    """λ_max of a joint in space; where it is unbounded, as far as anything is safe."""

    def end(towards: float) -> ConicBound:
        if solver is not None:
            return extreme_load_factor(load_factor_program(rows, towards, tolerances), solver)
        told = _sparse(rows, towards, tolerances)
        return _end(partial(told.end, SETTINGS), rows.n, "CLARABEL")

    bound = end(-1.0)
    start = end(+1.0) if bound.status == Status.UNBOUNDED else bound
    return bound if start.status == Status.OPTIMAL else start


class _SparseDiscs(NamedTuple):
    """An extreme λ over (z, λ) in numbers near 1, z = G v once for every node, as Clarabel takes it."""

    matrix: sparse.csc_matrix
    right: FloatArray
    cost: FloatArray
    kinds: tuple[int, int, tuple[int, ...]]
    scales: ProgramScales
    slips: FloatArray  # those of every z, (dn, z)

    def end(self, asked: ClarabelSettings) -> ConicBound:
        """The solution of the program; raises ``SolverError`` where it comes to none."""
        status, x, _, reduced = interior_points(self.matrix, self.right, self.cost, self.kinds, asked)
        if status != Status.OPTIMAL:
            return _nothing(status, len(self.slips), "CLARABEL")
        unit = float(self.scales.x[-1])
        return ConicBound(status, float(x[-1]) * unit, -1, self.slips @ x[:-1], "CLARABEL", reduced, unit)


def _sparse(rows: Constraints, towards: float, tolerances: Tolerances) -> _SparseDiscs:
    """The discs of a node at all load steps over one z_i = G_i v; what no slip changes of z is zero.

    So every disc has three numbers of z, and one dense row for every node is left: Nᵀ z = 0 with N
    orthonormal, which keeps the accuracy that slips of a stiff joint would lose.
    """
    discs = int((rows.side == Side.DISC).sum()) // CONE
    node = rows.node[: CONE * discs : CONE]
    new = np.append(True, np.diff(node) != 0)
    triple, others = np.arange(CONE), np.arange(CONE * discs, len(rows.g))
    first, own = np.flatnonzero(new), np.cumsum(new) - 1
    chosen = np.append((CONE * first[:, None] + triple).ravel(), others)
    place = np.append((CONE * own[:, None] + triple).ravel(), CONE * len(first) + np.arange(len(others)))
    d, g = np.zeros((2, len(chosen)))  # the largest of the loads of a node, for its scale
    np.maximum.at(d, place, np.abs(rows.d))
    np.maximum.at(g, place, np.repeat(np.maximum.reduceat(np.abs(rows.g), rows.heads), rows.cones))
    parts = {name: getattr(rows, name)[chosen] for name in ("G", "node", "side", "step")}
    once = replace(rows, d=d, g=g, **parts)
    program = load_factor_program(once, towards, tolerances)
    scales = program.scales
    row, column, count = scales.row[place], scales.column, len(chosen)
    basis, triangle, order = qr(program.matrix[:, :-1] * scales.row[:, None] * column[:-1], pivoting=True)
    pivots = np.abs(np.diag(triangle))
    rank = int((pivots > count * np.finfo(float).eps * pivots[0]).sum())
    slips = np.zeros((rows.n, count))
    slips[order[:rank]] = np.linalg.solve(triangle[:rank, :rank], basis[:, :rank].T)
    loads = sparse.csc_matrix((rows.d * row * column[-1])[:, None])
    limits = sparse.hstack([sparse.csr_matrix((np.ones(len(place)), (np.arange(len(place)), place))), loads])
    limits = sparse.csr_matrix(limits)[np.append(others, np.arange(CONE * discs))]
    zero = np.zeros((count - rank + 1, count + 1))
    zero[:-1, :-1], zero[-1, -1] = basis[:, rank:].T, -1.0  # the last one is λ ≥ 0
    right = (rows.g * row / scales.size)[np.append(others, np.arange(CONE * discs))]
    return _SparseDiscs(
        sparse.csc_matrix(sparse.vstack([sparse.csr_matrix(zero), limits])),
        np.append(np.zeros(len(zero)), right),
        np.append(np.zeros(count), towards),
        (count - rank, 1 + len(others), (CONE,) * discs),
        scales,
        slips * scales.x[:-1, None],
    )


def _bound_in_zone(rows: Constraints, solver: str | None, tolerances: Tolerances) -> ConicBound:
    """λ_max of a zone; gap rows, most of which never matter, are added where they are violated."""
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
        end = extreme_load_factor(reversed_rows(least, rows.limits_of(node)), solver)
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
    asked = SETTINGS.reduced if start.reduced_accuracy else SETTINGS.accuracy
    left = asked * program.scales.size / program.scales.row
    allowed = max(tolerances.agreement, tolerances.feasibility) * terms + left
    return bool(np.any(rows.excess(start.slip, 0.0) > allowed))


def extreme_load_factor(program: Program, solver: str | None = None) -> ConicBound:
    """The solution of a program whose last unknown is the load factor, by interior points."""
    name, size = solver or "CLARABEL", len(program.cost) - 1

    def end() -> ConicBound:
        if solver is None:
            found = by_clarabel(program, SETTINGS)
        else:
            found = by_cvxpy(program, solver, SETTINGS.accuracy)
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
