"""A linear objective over linear rows and one second-order cone, by interior points."""

from dataclasses import dataclass

import clarabel
import numpy as np
from scipy import sparse

from shakedown.errors import SolverError
from shakedown.interior.dense_programs import cone_optimum
from shakedown.model.problem import FloatArray
from shakedown.model.status import Status
from shakedown.programs.equilibration import power_of_two, typical_size

DENSE_FROM = 60  # rows, from where on dense interior points are quicker
GAP, REDUCED = 1e-11, 1e-6  # what is asked for; what a solution must reach to be taken as a start

CLARABEL_ENDS = {  # what Clarabel's words mean; others are no answer
    "Solved": Status.OPTIMAL,
    "AlmostSolved": Status.OPTIMAL,
    "PrimalInfeasible": Status.INFEASIBLE,
    "AlmostPrimalInfeasible": Status.INFEASIBLE,
    "DualInfeasible": Status.UNBOUNDED,
    "AlmostDualInfeasible": Status.UNBOUNDED,
}


@dataclass(frozen=True)
class ConeSolution:
    """How a :class:`ConeProgram` ended.

    Attributes
    ----------
    status
        ``"optimal"`` with ``x``; ``"infeasible"`` with multipliers that prove it;
        ``"unbounded"`` with the direction ``x`` that proves it.
    x : (N,)
        The solution, to about ten digits; zero where infeasible.
    multipliers : (R,)
        y ≥ 0 of the rows; zero where unbounded.
    """

    status: Status
    x: FloatArray
    multipliers: FloatArray


@dataclass(frozen=True)
class ConeProgram:
    """Minimise cᵀ x subject to M x ≤ right and ‖(x_0, …, x_{r−1})‖ + offset ≤ x_r.

    Attributes
    ----------
    matrix : (R, N)
        M.
    right : (R,)
        Upper row bounds.
    cost : (N,)
        c.
    rank
        r, number of columns under the norm; 0 leaves ``offset ≤ x_0``.
    offset
        Part of the radius that is taken already, ≥ 0.

    Examples
    --------
    >>> import numpy as np
    >>> nearest = ConeProgram(np.array([[-1.0, -1.0, 0.0]]), np.array([-2.0]), np.array([0.0, 0.0, 1.0]), 2)
    >>> solution = nearest.solve()
    >>> solution.x.round(6), solution.multipliers.round(6)
    (array([1.      , 1.      , 1.414214]), array([0.707107]))
    """

    matrix: FloatArray
    right: FloatArray
    cost: FloatArray
    rank: int
    offset: float = 0.0

    def solve(self, dense: bool = True) -> ConeSolution:
        """Solve in units in which rows, columns and right-hand sides are near 1.

        Many rows by dense interior points, if they find an optimum and are not ruled out; else by Clarabel.

        Raises
        ------
        SolverError
            If the solver ends without an answer.
        """
        row_scale, unit, size = self._scales()
        cost = self.cost * unit
        cost_scale = power_of_two(float(np.abs(cost).max()))
        scaled = (
            self.matrix * row_scale[:, None] * unit / size,
            self.right * row_scale / size,
            cost / cost_scale,
            self.rank,
            self.offset / size,
        )
        optimum = cone_optimum(*scaled) if dense and len(self.right) >= DENSE_FROM else None
        if optimum is not None:
            x, y = optimum
            return ConeSolution(Status.OPTIMAL, x * unit, y * row_scale * (cost_scale / size))
        found = _clarabel(*scaled)
        status = CLARABEL_ENDS.get(str(found.status))
        if status is None and str(found.status) in ("InsufficientProgress", "MaxIterations"):
            status = Status.OPTIMAL if max(found.r_prim, found.r_dual) <= REDUCED else None
        if status is None:
            raise SolverError(f"the cone program of shape {self.matrix.shape} ended as '{found.status}'")
        rows = len(self.right)
        x = np.array(found.x) * unit if status != Status.INFEASIBLE else np.zeros(len(unit))
        y = np.array(found.z[:rows]) * row_scale * (cost_scale / size)
        return ConeSolution(status, x, y if status != Status.UNBOUNDED else np.zeros(rows))

    def _scales(self) -> tuple[FloatArray, FloatArray, float]:
        """Row scales, units of the columns, and the size of what is left on the right: powers of two.

        The columns of the cone share one unit, in which rows and right-hand sides are
        near 1; each other column has the one in which it weighs as much as they do.
        """
        matrix, cone = np.abs(self.matrix), self.rank + 1
        slopes = matrix[:, :cone].max(axis=1)
        row_scale = np.array([1.0 / power_of_two(float(slope)) for slope in slopes])
        inside = slopes > 0
        size = typical_size(np.append(np.abs(self.right[inside]) * row_scale[inside], self.offset))
        unit = np.full(matrix.shape[1], size)
        for j in range(cone, len(unit)):
            unit[j] = size / typical_size(matrix[inside, j] * row_scale[inside])
        heaviest = (matrix * unit / size)[~inside].max(axis=1, initial=0.0)
        row_scale[~inside] = [1.0 / power_of_two(float(weight)) for weight in heaviest]
        return row_scale, unit, size


def _clarabel(
    matrix: FloatArray, right: FloatArray, cost: FloatArray, rank: int, offset: float
) -> clarabel.DefaultSolution:
    rows, columns = matrix.shape
    cone = np.zeros((rank + 1, columns))
    cone[0, rank] = -1.0
    cone[np.arange(1, rank + 1), np.arange(rank)] = -1.0
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = GAP
    settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = settings.reduced_tol_feas = REDUCED
    settings.presolve_enable = False
    return clarabel.DefaultSolver(
        sparse.csc_matrix((columns, columns)),
        cost,
        sparse.csc_matrix(np.vstack([matrix, cone])),
        np.concatenate([right, [-offset], np.zeros(rank)]),
        [clarabel.NonnegativeConeT(rows), clarabel.SecondOrderConeT(rank + 1)],
        settings,
    ).solve()
