"""Linear programs: HiGHS from basis to basis, exact to round-off; the point with most slack; polygons."""

from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import inf

import highspy
import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import ROUND_OFF, THREE_DIGITS, FloatArray
from shakedown.ground.errors import SolverError
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.programs.program import INF, Meeting, Program, Solution, sharpened

REFINED_COSTS = 2.0**14  # factor on costs where HiGHS's tolerance leaves a notable reduced cost
TOLERANCE = 1e-10  # the smallest that HiGHS accepts
_BASIC = highspy.HighsBasisStatus.kBasic
LOOSENED = ("primal_feasibility_tolerance", "dual_feasibility_tolerance")

OPTIONS: dict[str, bool | int | float | str] = {
    "output_flag": False,
    "presolve": "off",
    "solver": "simplex",
    "parallel": "off",
    # With free columns the dual simplex often fails to prove infeasibility.
    "simplex_strategy": int(highspy.simplex_constants.SimplexStrategy.kSimplexStrategyPrimal),
    "primal_simplex_bound_perturbation_multiplier": 0.0,  # its clean-up may end without a verdict
    "simplex_scale_strategy": 0,  # the data are equilibrated here, so that tolerances have a fixed meaning
    **dict.fromkeys(LOOSENED, TOLERANCE),
    "small_matrix_value": 1e-12,
}
STATUSES = {
    highspy.HighsModelStatus.kOptimal: Status.OPTIMAL,
    highspy.HighsModelStatus.kInfeasible: Status.INFEASIBLE,
    highspy.HighsModelStatus.kUnbounded: Status.UNBOUNDED,
}


def meeting_of(basis: highspy.HighsBasis) -> Meeting:
    """The active rows and the basic columns of a basis of the solver."""
    rows = np.flatnonzero([status != _BASIC for status in basis.row_status])
    return rows, np.flatnonzero([status == _BASIC for status in basis.col_status])


class SilentHighs(highspy.Highs):
    """HiGHS without output: version 1.16 prints a banner to stdout when it is created."""

    def enableCallbacks(self) -> None:  # the first call of its constructor
        self.setOptionValue("output_flag", False)
        super().enableCallbacks()


@cache
def _options() -> highspy.HighsOptions:
    highs = SilentHighs()
    for name, value in OPTIONS.items():
        if highs.setOptionValue(name, value) != highspy.HighsStatus.kOk:
            raise SolverError(f"HiGHS {highs.version()} does not take the option {name} = {value}")
    return highs.getOptions()


def made(program: Program) -> highspy.Highs:
    """The solver with a program in numbers near 1."""
    model = highspy.HighsLp()
    model.num_row_, model.num_col_ = program.matrix.shape
    model.col_cost_ = program.cost
    model.row_lower_, model.row_upper_ = program.left, program.right
    model.col_lower_, model.col_upper_ = program.lower, program.upper
    model.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    transposed = np.ascontiguousarray(program.matrix.T)
    nonzero = transposed != 0
    model.a_matrix_.value_ = transposed[nonzero]
    model.a_matrix_.index_ = np.nonzero(nonzero)[1].astype(np.int32)
    model.a_matrix_.start_ = np.append(0, np.cumsum(nonzero.sum(axis=1))).astype(np.int32)
    highs = SilentHighs()
    highs.passOptions(_options())
    # pivots; on stiffness that is round-off the simplex may cycle
    highs.setOptionValue("simplex_iteration_limit", 200 * sum(program.matrix.shape))
    if highs.passModel(model) == highspy.HighsStatus.kError:
        raise SolverError(f"HiGHS refuses the linear program of shape {program.matrix.shape}")
    return highs


class Simplex:
    """The state of a solver between solves of one program: its sides may change.

    The data are handed to HiGHS once, equilibrated by powers of two, and every solve starts from the
    basis of the last. The vertex is solved again from its active rows, so that it is exact to round-off and
    not only to the feasibility tolerance; what round-off leaves of a zero is zero.

    Examples
    --------
    >>> import numpy as np
    >>> held = Simplex(Program(np.array([[1.0, 2.0], [3.0, 1.0]]), np.array([4.0, 6.0]),
    ...     cost=np.array([-1.0, -1.0]), lower=np.zeros(2)))
    >>> held.solve().x
    array([1.6, 1.2])
    """

    def __init__(self, program: Program) -> None:
        """Hold a program."""
        self.program, self.scales = program.scaled()

    @cached_property
    def _highs(self) -> highspy.Highs:
        """The solver, created on first use, as none is needed where the active rows are known."""
        return made(self.program)

    def set_rows(self, rows: NDArray[np.intp], left: FloatArray, right: FloatArray) -> None:
        """Change the sides of some rows; the basis stays."""
        program, unit, size = self.program, self.scales.row[rows], self.scales.size
        program.left[rows], program.right[rows] = left * unit / size, right * unit / size
        if "_highs" in vars(self):
            for i in rows:
                self._highs.changeRowBounds(int(i), program.left[i], program.right[i])

    def solve(self) -> Solution:
        """Solve from the current basis.

        Raises
        ------
        SolverError
            If HiGHS ends without an answer, also from scratch at its own tolerances.
        """
        status = self._warm()
        reduced = status is None
        if reduced:
            status = self._loosened()
        if status is None:
            reason = self._highs.modelStatusToString(self._highs.getModelStatus())
            raise SolverError(f"the linear program of shape {self.program.matrix.shape} ended as '{reason}'")
        if status == Status.OPTIMAL and not reduced:
            self._finish()
        basis = self._highs.getBasis()
        left = None
        if status == Status.OPTIMAL:
            solution = self._highs.getSolution()
            left = np.array(solution.col_value), -np.array(solution.row_dual)
        return Solution(status, reduced, self._now(), self.scales, left, lambda: meeting_of(basis))

    def _now(self) -> Program:
        """The present program, unaffected by later changes of its sides."""
        return replace(self.program, left=self.program.left.copy(), right=self.program.right.copy())

    def at(self, active: NDArray[np.intp]) -> Solution | None:
        """The vertex in which these rows meet, if it is optimal to the solver's tolerances.

        No solver is asked. Columns without an entry are at a bound, or zero where they have none; there
        must be as many rows as other columns. None where they have no vertex, where it breaks another row or
        bound, or where a multiplier has the wrong sign.
        """
        program = self.program
        held: NDArray[np.bool_] = np.asarray(~program.matrix.any(axis=0))
        idle, meeting = np.flatnonzero(held), (active, np.flatnonzero(~held))
        x = np.zeros(len(held))
        low, high = program.lower[idle] > -INF, program.upper[idle] < INF
        x[idle] = np.select([low, high], [program.lower[idle], program.upper[idle]])
        try:
            x, y = sharpened(program, x, meeting)
        except np.linalg.LinAlgError:
            return None
        rest = program.cost[idle]
        wrong = (
            np.where(program.right < INF, -y, y).max(initial=0.0),  # a limit can only push back
            np.select([low, high], [-rest, rest], np.abs(rest)).max(initial=0.0),
        )
        # a larger reduced cost is not round-off, and matters where slips are large
        if not (np.max(wrong) <= ROUND_OFF and program.violation(x) <= TOLERANCE):  # NaN is rejected, too
            return None
        return Solution(Status.OPTIMAL, False, self._now(), self.scales, (x, y), lambda: meeting)

    def _warm(self) -> Status | None:
        """Solve from the end of the last solve, optimal or infeasible: usually few pivots away."""
        self._highs.run()
        status = STATUSES.get(self._highs.getModelStatus())
        return None if status == Status.UNBOUNDED and self._limited() else status

    def _loosened(self) -> Status | None:
        """Solve from scratch at HiGHS's own tolerances, for data at the limit of doubles."""
        self._highs.clearSolver()
        for name in LOOSENED:
            self._highs.setOptionValue(name, getattr(highspy.HighsOptions(), name))
        status = self._warm()
        for name in LOOSENED:
            self._highs.setOptionValue(name, TOLERANCE)
        return status

    def _limited(self) -> bool:
        """Whether bounds limit all columns with a cost, so that the program cannot be unbounded."""
        best = np.where(self.program.cost > 0, self.program.lower, self.program.upper)
        return bool(np.all(np.isfinite(best[self.program.cost != 0])))

    def _finish(self) -> None:
        """Continue where a reduced cost exceeds round-off, since the solver neglects 1e-10.

        Along a slip with little resistance even that much can change the optimum.
        """
        if self._left_to_gain() <= ROUND_OFF:
            return
        basis, columns = self._highs.getBasis(), np.arange(len(self.program.cost), dtype=np.int32)
        self._highs.changeColsCost(len(columns), columns, self.program.cost * REFINED_COSTS)
        done = self._warm() == Status.OPTIMAL
        basis = self._highs.getBasis() if done else basis
        self._highs.changeColsCost(len(columns), columns, self.program.cost)
        self._highs.setBasis(basis)
        self._highs.run()

    def _left_to_gain(self) -> float:
        """The largest multiplier, of a row or of a column, with the wrong sign."""
        end = self._highs.getSolution()
        y, rest = np.array(end.row_dual), np.array(end.col_dual)
        x, program = np.array(end.col_value), self.program
        pulls = np.where(rest > 0, x > program.lower, x < program.upper) * np.abs(rest)
        limited = program.right < INF
        sides = np.where(limited & (program.left > -INF), 0.0, np.where(limited, y, -y))
        return float(max(pulls.max(initial=0.0), sides.max(initial=0.0)))


def solve(program: Program) -> Solution:
    """The solution of a program.

    Raises
    ------
    SolverError
        If HiGHS comes to no end.
    """
    return Simplex(program).solve()


@dataclass(frozen=True)
class ChebyshevCentre:
    """The point x with the largest margin, and the multipliers ≥ 0 that prove that no larger one exists."""

    x: FloatArray
    margin: float
    multipliers: FloatArray
    reduced_accuracy: bool


def chebyshev_centre(
    matrix: FloatArray,
    norms: FloatArray,
    right: FloatArray,
    *,
    cap: float,
    signed: int | None = None,
    tolerances: Tolerances = DEFAULT,
) -> ChebyshevCentre:
    """Maximise t ≤ cap subject to M x + t·norms ≤ right, and x ≥ 0 in the column ``signed``.

    With the norms of the rows x is the Chebyshev centre of the polyhedron M x ≤ right. The multipliers
    satisfy yᵀ M = 0 (≥ 0 in the column ``signed``), yᵀ norms = 1 and yᵀ right = t, as long as t < cap.
    """
    rows, columns = matrix.shape
    lower = np.full(columns + 1, -INF)
    if signed is not None:
        lower[signed] = 0.0
    upper = np.append(np.full(columns, INF), cap)
    cost = np.append(np.zeros(columns), -1.0)
    program = Program(
        np.column_stack([matrix, norms]), right, cost, lower=lower, upper=upper, tolerances=tolerances
    )
    end = solve(program)
    if not end.optimal:  # rows without a norm contradict each other, whatever t
        return ChebyshevCentre(np.zeros(columns), -inf, np.zeros(rows), end.reduced_accuracy)
    return ChebyshevCentre(end.x[:-1], float(end.x[-1]), end.multipliers, end.reduced_accuracy)


def corners(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Corners of the polygon M x ≤ r, counter-clockwise, (c, 2).

    Empty where there is none, or none that is bounded and has an interior.

    Parameters
    ----------
    matrix, right : (k, 2), (k,)
        The sides. Rows of zeros are conditions that hold or do not.

    Examples
    --------
    >>> sides = np.array([[-1.0, 0.0], [0.0, -1.0], [1.0, 1.0], [0.0, 0.0]])
    >>> (corners(sides, np.array([0.0, 0.0, 2.0, 0.0])).round(9) + 0.0).tolist()
    [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]

    None where sides contradict each other, or leave one point, or where the polygon is unbounded:

    >>> [corners(sides, np.array([0.0, 0.0, *more])).shape for more in ((2.0, -1.0), (-1.0, 0.0), (0.0, 0.0))]
    [(0, 2), (0, 2), (0, 2)]
    >>> corners(sides[:2], np.zeros(2)).shape, corners(sides[[0, 1, 1]], np.zeros(3)).shape
    ((0, 2), (0, 2))
    """
    from scipy.spatial import HalfspaceIntersection, QhullError

    norms = np.linalg.norm(matrix, axis=1)
    steep = norms > 0
    if steep.sum() < 3 or (right[~steep] < 0).any():
        return np.empty((0, 2))
    sides, distance = matrix[steep] / norms[steep, None], right[steep] / norms[steep]
    size = float(np.abs(distance).max())
    far = size / THREE_DIGITS  # a corner that much farther than the sides belongs to an unbounded polygon
    found = chebyshev_centre(sides, np.ones(len(distance)), distance, cap=far)
    if not 0 < found.margin < 0.9 * far:
        return np.empty((0, 2))
    try:
        points = HalfspaceIntersection(np.column_stack([sides, -distance]), found.x).intersections
    except QhullError:
        return np.empty((0, 2))
    if not np.isfinite(points).all():
        return np.empty((0, 2))
    around = points - found.x
    return np.asarray(points[np.argsort(np.arctan2(around[:, 1], around[:, 0]))])
