"""A linear objective over linear rows and one second-order cone, by interior points."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import clarabel
import numpy as np
from scipy import sparse

from shakedown.ground.errors import SolverError
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.programs.equilibration import power_of_two, typical_size
from shakedown.programs.interior.dense_programs import cone_optimum
from shakedown.programs.linear_program import INF, LinearProgram

DENSE_FROM = 60  # rows, from where on dense interior points are quicker
REDUCED = 1e-6  # what a solution must reach to be taken as a start
CUT, MOST_CUTS = 1e-7, 300  # how near to the cone cutting planes must come, relatively; as many as may be

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

    def solve(self, road: int = 0) -> ConeSolution:
        """The end on the first road, from this one on, that comes to one.

        In units in which rows, columns and right-hand sides are near 1: Clarabel's interior points with
        its own scaling on top, with shorter steps, without that scaling, to less accuracy; dense interior
        points, which come first where there are many rows; then linear programs that cut the
        cone (:func:`cut_cone`): :data:`ROADS` in all.

        Raises
        ------
        SolverError
            If no road comes to an end.
        """
        ways: list[Callable[[], ConeSolution]] = [partial(self._by_clarabel, way) for way in WAYS]
        ways.insert(0 if len(self.right) >= DENSE_FROM else len(ways), self._by_dense_points)
        failures = []
        ways.append(partial(cut_cone, self))
        for each in ways[road:]:
            found = sought(each)
            if not isinstance(found, Missing):
                return found
            failures.append(found.reason)
        raise SolverError(failures[0])

    def _by_dense_points(self) -> ConeSolution:
        scaled, units, row_units = self._scaled()
        optimum = cone_optimum(scaled.matrix, scaled.right, scaled.cost, scaled.rank, scaled.offset)
        if optimum is None:
            raise SolverError(f"the cone program of shape {self.matrix.shape} ended without an optimum")
        x, y = optimum
        return ConeSolution(Status.OPTIMAL, x * units, y * row_units)

    def _by_clarabel(self, way: "Way") -> ConeSolution:
        scaled, units, row_units = self._scaled()
        found = _clarabel(scaled, way)
        status = CLARABEL_ENDS.get(str(found.status))
        if status is None and str(found.status) in ("InsufficientProgress", "MaxIterations"):
            status = Status.OPTIMAL if max(found.r_prim, found.r_dual) <= REDUCED else None
        if status is None:
            raise SolverError(f"the cone program of shape {self.matrix.shape} ended as '{found.status}'")
        rows = len(self.right)
        x = np.array(found.x) * units if status != Status.INFEASIBLE else np.zeros(len(units))
        y = np.array(found.z[:rows]) * row_units
        return ConeSolution(status, x, y if status != Status.UNBOUNDED else np.zeros(rows))

    def _scaled(self) -> tuple["ConeProgram", FloatArray, FloatArray]:
        """The program in numbers near 1, and what one of its columns, of its multipliers, is."""
        row_scale, unit, size = self._scales()
        cost = self.cost * unit
        cost_scale = power_of_two(float(np.abs(cost).max()))
        scaled = ConeProgram(
            self.matrix * row_scale[:, None] * unit / size,
            self.right * row_scale / size,
            cost / cost_scale,
            self.rank,
            self.offset / size,
        )
        return scaled, unit, row_scale * (cost_scale / size)

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


class Way(NamedTuple):
    """How the interior points are followed: to which accuracy, in which steps, in whose scaling.

    Beyond what the data allow the solver goes astray; to ask for less is a way of its own.
    """

    accuracy: float
    step: float
    scaled: bool


WAYS = (Way(1e-11, 0.99, True), Way(1e-11, 0.9, True), Way(1e-11, 0.99, False), Way(1e-8, 0.9, True))
ROADS = len(WAYS) + 2


def _clarabel(program: ConeProgram, way: Way) -> clarabel.DefaultSolution:
    rows, columns = program.matrix.shape
    rank = program.rank
    cone = np.zeros((rank + 1, columns))
    cone[0, rank] = -1.0
    cone[np.arange(1, rank + 1), np.arange(rank)] = -1.0
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = way.accuracy
    settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = settings.reduced_tol_feas = REDUCED
    settings.presolve_enable = False
    settings.equilibrate_enable, settings.max_step_fraction = way.scaled, way.step
    return clarabel.DefaultSolver(
        sparse.csc_matrix((columns, columns)),
        program.cost,
        sparse.csc_matrix(np.vstack([program.matrix, cone])),
        np.concatenate([program.right, [-program.offset], np.zeros(rank)]),
        [clarabel.NonnegativeConeT(rows), clarabel.SecondOrderConeT(rank + 1)],
        settings,
    ).solve()


def cut_cone(program: ConeProgram) -> ConeSolution:
    """The program by linear programs over planes that touch the cone (Kelley), by simplex.

    What they find is outside the cone; the plane that touches it next to there is added until the
    solution is in it to round-off. The planes begin with those of a box, and the multipliers of the
    rows are those of the last program.

    Raises
    ------
    SolverError
        If a linear program has no end, or the cuts do not come to one.
    """
    rank, (rows, count) = program.rank, program.matrix.shape
    planes = np.vstack([np.eye(rank), -np.eye(rank)])
    for _ in range(MOST_CUTS):
        cuts = np.zeros((len(planes) + 1, count))
        cuts[:-1, :rank], cuts[:, rank] = planes, -1.0
        end = LinearProgram(
            np.vstack([program.matrix, cuts]),
            cost=program.cost,
            lower=np.full(rows + len(cuts), -INF),
            upper=np.concatenate([program.right, np.full(len(cuts), -program.offset)]),
            column_lower=np.full(count, -INF),
            column_upper=np.full(count, INF),
        ).solve()
        if end.status == Status.INFEASIBLE:
            break  # so is the program itself, but nothing proves it
        if end.vertex is None:
            break  # a ray of the planes need not be one of the cone
        x = end.vertex.x
        length = float(np.linalg.norm(x[:rank]))
        if length + program.offset <= x[rank] * (1.0 + CUT):
            return ConeSolution(Status.OPTIMAL, x, -end.vertex.multipliers[:rows])
        planes = np.vstack([planes, x[:rank] / length])
    raise SolverError(f"the cone program of shape {program.matrix.shape} has no end by cutting planes")
