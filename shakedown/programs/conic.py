"""Programs with cones by interior points: Clarabel called directly, or any solver that cvxpy knows."""

import warnings
from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import clarabel
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.constants import CONE, FloatArray
from shakedown.ground.errors import SolverError, UsageError
from shakedown.ground.status import Status
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.program import Program, ProgramScales, Sides, Solution, columnwise

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


def by_clarabel(program: Program) -> Solution:
    """The solution of a program by Clarabel, in numbers near 1.

    Raises
    ------
    SolverError
        If it ends without an answer.
    """
    form = _conic_form(program)
    matrix = sparse.csc_matrix(columnwise(form.matrix), shape=form.matrix.shape)
    status, x, z, reduced = interior_points(matrix, form.right, form.cost, (*form.counts, program.cones))
    return form.end(status, x, z, reduced)


def discs_by_clarabel(program: DiscProgram) -> tuple[Status, FloatArray, bool]:
    """The solution (y, w) of a program over discs by Clarabel, its status, whether it is of reduced accuracy.

    Over (z, w) with z = G y for every node and row once: every disc has three numbers of z then, and with N
    orthonormal Nᵀ z = 0 keeps the accuracy that y of a stiff joint would lose.

    Raises
    ------
    SolverError
        If it ends without an answer.
    """
    r, limits = program.rank, len(program.limits)
    G = np.vstack([program.blocks.reshape(CONE * len(program.blocks), r), program.rows])
    basis, triangle = np.linalg.qr(G, mode="complete")
    of_rows = len(G) - len(program.rows) + np.arange(len(program.rows))
    of_discs = (CONE * program.node[:, None] + np.arange(CONE)).ravel()
    places = np.append(of_rows, of_discs)
    chosen = sparse.csr_matrix((np.ones(limits), (np.arange(limits), places)), shape=(limits, len(G)))
    loads = sparse.csr_matrix(np.vstack([program.rows_extra, program.loads]))
    matrix = sparse.bmat([[sparse.csr_matrix(basis[:, r:].T), None], [chosen, loads]], format="csc")
    right = np.concatenate([np.zeros(len(G) - r), program.rows_right, program.right.ravel()])
    cost = np.append(np.zeros(len(G)), program.cost)
    kinds = (len(G) - r, len(program.rows), [CONE] * len(program.node))
    status, x, _, reduced = interior_points(matrix, right, cost, kinds)
    y = np.linalg.solve(triangle[:r], basis[:, :r].T @ x[: len(G)])
    return status, np.append(y, x[len(G) :]), reduced


def interior_points(
    matrix: sparse.csc_matrix,
    right: FloatArray,
    cost: FloatArray,
    kinds: tuple[int, int, Sequence[int]],
) -> tuple[Status, FloatArray, FloatArray, bool]:
    """Minimise costᵀ x by Clarabel: the status, x, multipliers, whether it is of reduced accuracy.

    ``kinds`` says how many rows of right − M x are zero, how many after them are ≥ 0, and the sizes of the
    cones that the others are in.

    Raises
    ------
    SolverError
        If it ends without an answer.
    """
    settings = clarabel.DefaultSettings()
    settings.verbose = settings.presolve_enable = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = ACCURACY
    settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = settings.reduced_tol_feas = REDUCED
    equal, less, sizes = kinds
    cones = [clarabel.ZeroConeT(equal)] * bool(equal) + [clarabel.NonnegativeConeT(less)] * bool(less)
    for count in sizes:  # Clarabel 0.10 does not accept cones of one row
        cones.append(clarabel.SecondOrderConeT(count) if count > 1 else clarabel.NonnegativeConeT(1))
    end = clarabel.DefaultSolver(_no_square(len(cost)), cost, matrix, right, cones, settings).solve()
    status, word = _ENDS.get(str(end.status)), str(end.status)
    if status is None:
        raise SolverError(f"the cone program of shape {matrix.shape} ended as '{word}'")
    reduced = word not in ("Solved", "PrimalInfeasible", "DualInfeasible")
    return status, np.array(end.x), np.array(end.z), reduced


@cache
def _no_square(columns: int) -> sparse.csc_matrix:
    """A zero quadratic term."""
    return sparse.csc_matrix((columns, columns))


def by_cvxpy(program: Program, solver: str, accuracy: float = ACCURACY) -> Solution:
    """The solution of a program by a solver of this name through cvxpy; raises as :func:`by_clarabel`.

    And ``UsageError`` if cvxpy is not installed.
    """
    try:
        import cvxpy as cp  # slow to import and needed only here
    except ImportError:
        raise UsageError(
            f"solver: {solver!r} needs cvxpy, found none: pip install 'shakedown-bounds[solvers]'"
        ) from None

    form = _conic_form(program)
    x, ends = cp.Variable(len(form.cost)), np.cumsum([0, *form.counts, *program.cones]).tolist()
    parts = [(form.matrix[rows], form.right[rows]) for rows in (slice(*each) for each in pairwise(ends))]
    (same, value), (below, most), *cones = parts
    limits = [same @ x == value] if len(value) else []  # cvxpy 1.6 cannot multiply an empty matrix
    limits += [below @ x <= most] if len(most) else []
    limits += [cp.SOC(right[0] - matrix[0] @ x, right[1:] - matrix[1:] @ x) for matrix, right in cones]
    told = cp.Problem(cp.Minimize(form.cost @ x), limits)
    keys = ("tol_gap_abs", "tol_gap_rel", "tol_feas") if solver == "CLARABEL" else ()
    with warnings.catch_warnings():  # an inaccurate answer is a status here, not a warning
        warnings.simplefilter("ignore", UserWarning)
        try:
            told.solve(solver=solver, **dict.fromkeys(keys, accuracy))
        except cp.SolverError as error:
            raise SolverError(f"{solver}: {error}") from None
    if told.status not in list(Status):
        raise SolverError(f"the program of shape {program.matrix.shape} ended as '{told.status}'")
    if told.status != Status.OPTIMAL:
        return form.end(Status(told.status), np.full(x.size, np.nan), np.full(ends[-1], np.nan), False)
    duals = [np.ravel(part.value) for each in limits for part in each.dual_variables]
    return form.end(Status.OPTIMAL, np.array(x.value, dtype=float), np.concatenate(duals), False)


class _ConicForm(NamedTuple):
    """Minimise cᵀ x: right − M x is zero in the first rows, ≥ 0 in the next, in cones in the last."""

    matrix: FloatArray
    right: FloatArray
    cost: FloatArray
    counts: tuple[int, int]
    used: NDArray[np.bool_]  # columns; those in no row stay zero
    parts: list[Sides]
    program: Program
    scales: ProgramScales

    def end(self, status: Status, x: FloatArray, z: FloatArray, reduced: bool) -> Solution:
        """The solution of the program in the original form."""
        whole, y, start = np.zeros(len(self.used)), np.zeros(len(self.program.right)), 0
        whole[self.used] = x if status != Status.INFEASIBLE else np.nan
        for _, right, row, sign in self.parts:
            if row[0] >= 0:  # multipliers of bounds follow from the balance
                y[row] += sign * z[start : start + len(row)] if status != Status.UNBOUNDED else np.nan
            start += len(right)
        program, scales = self.program, self.scales
        value = scales.value(float(program.cost @ whole)) if status == Status.OPTIMAL else np.nan
        return Solution(status, value, reduced, program, scales, lambda _: (whole * scales.x, y * scales.y))


def _conic_form(given: Program) -> _ConicForm:
    program, scales = given.scaled()
    linear, same = program.linear, (program.left == program.right)[: program.linear]
    equal = np.flatnonzero(same)
    parts = program.inequalities(without=same if equal.size else None)
    less = sum(len(part.row) for part in parts)
    parts = [program.sides(equal)] * bool(equal.size) + parts
    if program.cones:
        parts.append(program.sides(np.arange(linear, len(program.right))))
    matrix, right = (np.concatenate([part[k] for part in parts]) for k in range(2))
    used = matrix.any(axis=0) | (program.cost != 0)
    matrix = matrix if used.all() else matrix[:, used]
    return _ConicForm(matrix, right, program.cost[used], (equal.size, less), used, parts, program, scales)
