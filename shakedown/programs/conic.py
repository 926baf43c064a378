"""Programs over discs by other interior points: Clarabel called directly, or any solver that cvxpy knows."""

import warnings
from typing import NamedTuple

import clarabel
import numpy as np
from scipy import sparse

from shakedown.ground.constants import CONE, FloatArray
from shakedown.ground.errors import SolverError, UsageError
from shakedown.ground.status import Status
from shakedown.programs.disc_program import DiscProgram

_ENDS = {  # the meaning of Clarabel's statuses; others are no answer
    "Solved": Status.OPTIMAL,
    "AlmostSolved": Status.OPTIMAL,
    "PrimalInfeasible": Status.INFEASIBLE,
    "AlmostPrimalInfeasible": Status.INFEASIBLE,
    "DualInfeasible": Status.UNBOUNDED,
    "AlmostDualInfeasible": Status.UNBOUNDED,
}


ACCURACY = 1e-11  # asked for: the highest, for data already scaled to numbers near 1
REDUCED = 1e-8  # accuracy that a result must reach where more is not possible

Found = tuple[Status, FloatArray, bool]  # status, the solution, whether it is of reduced accuracy


def solve_conic(program: DiscProgram, solver: str | None = None) -> Found:
    """The solution (y, w) of a program of discs and rows by Clarabel, or by a solver of cvxpy.

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
    form = _conic_form(program)
    status, x, reduced = _by_clarabel(form) if solver is None else _by_cvxpy(form, solver)
    y = np.linalg.solve(form.triangle, form.basis.T @ x[: len(form.basis)])
    return status, np.append(y, x[len(form.basis) :]), reduced


class _ConicForm(NamedTuple):
    """Minimise costᵀ (z, w): right − M (z, w) is 0 in the first rows, ≥ 0 in the next, in discs in the last.

    z = G y for every node and row once: every disc has three numbers of z then, and with N orthonormal
    Nᵀ z = 0 keeps the accuracy that y of a stiff joint would lose. G is ``basis`` times ``triangle``. Without
    discs z is y.
    """

    matrix: sparse.csc_matrix
    right: FloatArray
    cost: FloatArray
    equal: int
    less: int
    basis: FloatArray
    triangle: FloatArray


def _conic_form(program: DiscProgram) -> _ConicForm:
    r, limits, less = program.rank, len(program.limits), len(program.rows)
    if not len(program.node):
        rows = sparse.csc_matrix(np.hstack([program.rows, program.rows_extra]))
        return _ConicForm(rows, program.rows_right, program.costs, 0, less, np.eye(r), np.eye(r))
    G = np.vstack([program.blocks.reshape(CONE * len(program.blocks), r), program.rows])
    basis, triangle = np.linalg.qr(G, mode="complete")
    of_rows = len(G) - less + np.arange(less)
    of_discs = (CONE * program.node[:, None] + np.arange(CONE)).ravel()
    places = np.append(of_rows, of_discs)
    chosen = sparse.csr_matrix((np.ones(limits), (np.arange(limits), places)), shape=(limits, len(G)))
    loads = sparse.csr_matrix(np.vstack([program.rows_extra, program.loads]))
    matrix = sparse.bmat([[sparse.csr_matrix(basis[:, r:].T), None], [chosen, loads]], format="csc")
    right = np.concatenate([np.zeros(len(G) - r), program.rows_right, program.right.ravel()])
    cost = np.append(np.zeros(len(G)), program.cost)
    return _ConicForm(matrix, right, cost, len(G) - r, less, basis[:, :r], triangle[:r])


def _by_clarabel(form: _ConicForm) -> Found:
    settings = clarabel.DefaultSettings()
    settings.verbose = settings.presolve_enable = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = ACCURACY
    settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = settings.reduced_tol_feas = REDUCED
    cones = [clarabel.ZeroConeT(form.equal)] * bool(form.equal)
    cones += [clarabel.NonnegativeConeT(form.less)] * bool(form.less)
    cones += [clarabel.SecondOrderConeT(CONE)] * ((len(form.right) - form.equal - form.less) // CONE)
    no_square = sparse.csc_matrix((len(form.cost), len(form.cost)))
    end = clarabel.DefaultSolver(no_square, form.cost, form.matrix, form.right, cones, settings).solve()
    status, word = _ENDS.get(str(end.status)), str(end.status)
    if status is None:
        raise SolverError(f"the cone program of shape {form.matrix.shape} ended as '{word}'")
    return status, np.array(end.x), word not in ("Solved", "PrimalInfeasible", "DualInfeasible")


def _by_cvxpy(form: _ConicForm, solver: str) -> Found:
    try:
        import cvxpy as cp  # slow to import and needed only here
    except ImportError:
        raise UsageError(
            f"solver: {solver!r} needs cvxpy, found none: pip install 'shakedown-bounds[solvers]'"
        ) from None

    x = cp.Variable(len(form.cost))
    slack, first = form.right - form.matrix @ x, form.equal + form.less
    limits = [slack[form.equal : first] >= 0]
    if form.equal:
        limits.append(slack[: form.equal] == 0)
    if first < len(form.right):
        limits.append(
            cp.SOC(slack[first::CONE], cp.vstack([slack[first + 1 :: CONE], slack[first + 2 :: CONE]]))
        )
    told = cp.Problem(cp.Minimize(form.cost @ x), limits)
    keys = ("tol_gap_abs", "tol_gap_rel", "tol_feas") if solver == "CLARABEL" else ()
    with warnings.catch_warnings():  # an inaccurate answer is a status here, not a warning
        warnings.simplefilter("ignore", UserWarning)
        try:
            told.solve(solver=solver, **dict.fromkeys(keys, ACCURACY))
        except cp.SolverError as error:
            raise SolverError(f"{solver}: {error}") from None
    if told.status not in list(Status):
        raise SolverError(f"the cone program of shape {form.matrix.shape} ended as '{told.status}'")
    status = Status(told.status)
    known = np.array(x.value, dtype=float) if status == Status.OPTIMAL else np.full(x.size, np.nan)
    return status, known, False
