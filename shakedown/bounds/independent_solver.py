"""The bounds by an independent solver: interior points, by Clarabel or by any solver that cvxpy knows.

Less sharp than the simplex; it is here to be compared with.
"""

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from math import inf, nan

import clarabel
import numpy as np
from scipy import sparse

from shakedown.bounds.disc_rows import DiscRows, zone_rows
from shakedown.bounds.scaled_solution import scaled_discs
from shakedown.ground.constants import CONE, FloatArray
from shakedown.ground.errors import Missing, SolverError, UsageError, attempt, not_installed
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIDES, checked, node_numbers, require_plane
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.disc_program import DiscProgram


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
        Those of the zone.

    Examples
    --------
    >>> import shakedown
    >>> round(conic_upper_bound(shakedown.example("two-node")).load_factor, 6)
    0.739146
    """
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    rows = zone_rows(zone)
    bound = _extreme(rows, -1.0, solver)
    if bound.status == Status.UNBOUNDED:  # as far as anything is safe
        start = _extreme(rows, +1.0, solver)
        bound = bound if start.status == Status.OPTIMAL else start
    return replace(bound, slip=zone.slips(bound.slip))


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
    rows = zone_rows(contact_zone(problem, ()))
    limits = rows.half_spaces
    start = _extreme(rows, +1.0, solver)
    if start.status == Status.UNDECIDED:
        return start
    if start.status != Status.OPTIMAL or _unsafe(rows, start, tolerances):
        return _nothing(Status.INFEASIBLE, limits.n, start.solver)
    found = [_extreme(rows, -1.0, solver)]  # λ_max: λ_1 is never larger
    for node in range(problem.n) if nodes is None else node_numbers("nodes", nodes, problem.n):
        sign = np.where(limits.limits_of(node), -1.0, 1.0)
        own = replace(limits, G=sign[:, None] * limits.G, d=sign * limits.d, g=sign * limits.g)
        end = _extreme(replace(rows, half_spaces=own), +1.0, solver)
        found.append(replace(end, node=node) if end.status != Status.INFEASIBLE else found[0])
        if found[-1].load_factor <= tolerances.feasibility:
            break
    decided = [end for end in found if end.status != Status.UNDECIDED]
    best = min(decided, key=lambda end: end.load_factor, default=found[0])
    open_ends = len(decided) < len(found)
    if open_ends and not best.load_factor <= tolerances.feasibility:  # an unfinished program might end lower
        return _nothing(Status.UNDECIDED, limits.n, start.solver)
    return best


def _unsafe(rows: DiscRows, start: ConicBound, tolerances: Tolerances) -> bool:
    """Whether the smallest load factor with a safe slip is not zero, to the accuracy of the solver.

    Where all terms of a row vanish at a safe slip, what the solver leaves of them is all that there is
    to compare with: its own accuracy, in its own units, is allowed besides.
    """
    limits, scaled = rows.half_spaces, scaled_discs(rows, +1.0)
    terms = np.abs(limits.G) @ np.abs(start.slip) + np.abs(limits.g)
    left = (REDUCED if start.reduced_accuracy else ACCURACY) * scaled.unit / scaled.row_scales
    allowed = max(tolerances.agreement, tolerances.feasibility) * terms + left
    return bool(np.any(limits.excess(start.slip, 0.0) > allowed))


def _extreme(rows: DiscRows, towards: float, solver: str | None) -> ConicBound:
    """The largest (−1) or smallest (+1) load factor; undecided where the solver does not finish."""
    scaled, size, name = scaled_discs(rows, towards), rows.half_spaces.n, solver or "CLARABEL"
    found = attempt(solve_conic, scaled.program, solver)
    if isinstance(found, Missing):
        return _nothing(Status.UNDECIDED, size, name)
    status, x, reduced = found
    if status != Status.OPTIMAL:
        return _nothing(status, size, name)
    slip, unit = rows.half_spaces.slips(scaled.slips(x)), scaled.load_unit
    return ConicBound(status, float(x[-1]) * unit, -1, slip, name, reduced, unit)


def _nothing(status: Status, n: int, solver: str) -> ConicBound:
    value = inf if status == Status.UNBOUNDED else nan
    return ConicBound(status, value, -1, np.full(n, nan), solver)


_ENDS = {  # the meaning of Clarabel's statuses; others are no answer
    "Solved": Status.OPTIMAL,
    "PrimalInfeasible": Status.INFEASIBLE,
    "DualInfeasible": Status.UNBOUNDED,
}


ACCURACY = 1e-11  # asked for: the highest, for data already scaled to numbers near 1
REDUCED = 1e-8  # accuracy that a result must reach where more is not possible
ConicAnswer = tuple[Status, FloatArray, bool]  # status, the solution, whether it is of reduced accuracy


def solve_conic(program: DiscProgram, solver: str | None = None) -> ConicAnswer:
    """The solution (y, w) of a program of discs and rows by Clarabel, or by a solver of cvxpy.

    In z = G y for every node and row once: every disc has three numbers of z then, and with N orthonormal
    Nᵀ z = 0 keeps the accuracy that y of a stiff joint would lose. Without discs z is y.

    Raises
    ------
    SolverError
        If it ends without an answer.
    UsageError
        If a solver is named and cvxpy is not installed.

    Examples
    --------
    >>> program = DiscProgram(
    ...     blocks=np.array([[[0.0], [1.0], [0.0]]]), node=np.array([0]),
    ...     extra=np.array([[[0.0], [0.0], [1.0]]]), right=np.array([[1.0, 1.0, 0.0]]),
    ...     rows=np.array([[1.0], [-1.0]]), rows_extra=np.zeros((2, 1)), rows_right=np.array([0.2, 0.2]),
    ...     cost=np.array([-1.0]),
    ... )
    >>> status, x, _ = solve_conic(program)
    >>> str(status), x.round(6)
    ('optimal', array([0.2, 0.6]))
    """
    r, less, limits = program.rank, len(program.rows), len(program.limits)
    by = _by_clarabel if solver is None else partial(_by_cvxpy, solver)
    if not len(program.node):
        rows = sparse.csc_matrix(np.hstack([program.rows, program.rows_extra]))
        return by(rows, program.rows_right, program.costs, 0, less)
    G = np.vstack([program.blocks.reshape(CONE * len(program.blocks), r), program.rows])
    basis, triangle = np.linalg.qr(G, mode="complete")
    of_rows = len(G) - less + np.arange(less)
    places = np.append(of_rows, CONE * program.node[:, None] + np.arange(CONE))
    chosen = sparse.csr_matrix((np.ones(limits), (np.arange(limits), places)), shape=(limits, len(G)))
    loads = sparse.csr_matrix(np.vstack([program.rows_extra, program.loads]))
    matrix = sparse.bmat([[sparse.csr_matrix(basis[:, r:].T), None], [chosen, loads]], format="csc")
    right = np.concatenate([np.zeros(len(G) - r), program.rows_right, program.right.ravel()])
    status, z, reduced = by(matrix, right, np.append(np.zeros(len(G)), program.cost), len(G) - r, less)
    y = np.linalg.solve(triangle[:r], basis[:, :r].T @ z[: len(G)])
    return status, np.append(y, z[len(G) :]), reduced


def _by_clarabel(
    matrix: sparse.csc_matrix, right: FloatArray, cost: FloatArray, equal: int, less: int
) -> ConicAnswer:
    """Minimise costᵀ x: right − M x is 0 in the first rows, ≥ 0 in the next, in discs in the last."""
    settings = clarabel.DefaultSettings()
    settings.verbose = settings.presolve_enable = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = ACCURACY
    settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = settings.reduced_tol_feas = REDUCED
    cones = [clarabel.ZeroConeT(equal)] * bool(equal)
    cones += [clarabel.NonnegativeConeT(less)] * bool(less)
    cones += [clarabel.SecondOrderConeT(CONE)] * ((len(right) - equal - less) // CONE)
    no_square = sparse.csc_matrix((len(cost), len(cost)))
    end = clarabel.DefaultSolver(no_square, cost, matrix, right, cones, settings).solve()
    word = str(end.status)
    status = _ENDS.get(word.removeprefix("Almost"))
    if status is None:
        raise SolverError(f"the cone program of shape {matrix.shape} ended as '{word}'")
    return status, np.array(end.x), word.startswith("Almost")


def _by_cvxpy(
    solver: str, matrix: sparse.csc_matrix, right: FloatArray, cost: FloatArray, equal: int, less: int
) -> ConicAnswer:
    try:
        import cvxpy as cp  # slow to import and needed only here
    except ImportError:
        raise UsageError(not_installed(f"solver {solver!r}", "cvxpy", "solvers")) from None

    x = cp.Variable(len(cost))
    slack, first = right - matrix @ x, equal + less
    limits = [slack[equal:first] >= 0]
    if equal:
        limits.append(slack[:equal] == 0)
    if first < len(right):
        limits.append(
            cp.SOC(slack[first::CONE], cp.vstack([slack[first + 1 :: CONE], slack[first + 2 :: CONE]]))
        )
    program = cp.Problem(cp.Minimize(cost @ x), limits)
    keys = ("tol_gap_abs", "tol_gap_rel", "tol_feas") if solver == "CLARABEL" else ()
    with warnings.catch_warnings():  # an inaccurate answer is a status here, not a warning
        warnings.simplefilter("ignore", UserWarning)
        try:
            program.solve(solver=solver, **dict.fromkeys(keys, ACCURACY))
        except cp.SolverError as error:
            raise SolverError(f"{solver}: {error}") from None
    if program.status not in list(Status):
        raise SolverError(f"the cone program of shape {matrix.shape} ended as '{program.status}'")
    status = Status(program.status)
    known = np.array(x.value, dtype=float) if status == Status.OPTIMAL else np.full(x.size, np.nan)
    return status, known, False
