"""Programs without cones: HiGHS from basis to basis, exact to round-off; the point with most slack."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache, partial
from math import inf

import highspy
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from shakedown.ground.constants import CONE, DENSE_FROM, ROUND_OFF, FloatArray
from shakedown.ground.errors import SolverError
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.programs.conic import by_clarabel
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.exact_program import cleaned, polished, sharpened
from shakedown.programs.program import INF, Meeting, Point, Program, Solution, columnwise, median_size
from shakedown.programs.self_dual import solve_self_dual

FINER = 2.0**14  # factor on costs where HiGHS's tolerance leaves a notable reduced cost
TOLERANCE = 1e-10  # the smallest that HiGHS accepts
MOST_PIVOTS = 200  # per row and column; on stiffness that is round-off the simplex may cycle
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


def basis_of(program: Program, meeting: Meeting) -> highspy.HighsBasis:
    """The basis of the solver from active rows and basic columns."""
    basis = highspy.HighsBasis()
    held = np.isin(np.arange(len(program.right)), meeting[0])
    free = np.isin(np.arange(len(program.cost)), meeting[1])
    basis.row_status = _statuses(~held, program.left, program.right)
    basis.col_status = _statuses(free, program.lower, program.upper)
    basis.valid = True
    return basis


def _statuses(basic: NDArray[np.bool_], low: FloatArray, high: FloatArray) -> list[highspy.HighsBasisStatus]:
    status = highspy.HighsBasisStatus
    return [
        _BASIC if inside else status.kUpper if right < INF else status.kLower if left > -INF else status.kZero
        for inside, left, right in zip(basic, low, high, strict=True)
    ]


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
    rows, columns = program.matrix.shape
    model = highspy.HighsLp()
    model.num_row_, model.num_col_ = rows, columns
    model.col_cost_ = program.cost
    model.row_lower_, model.row_upper_ = program.left, program.right
    model.col_lower_, model.col_upper_ = program.lower, program.upper
    model.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    by_columns = columnwise(program.matrix)
    model.a_matrix_.value_, model.a_matrix_.index_, model.a_matrix_.start_ = by_columns
    highs = SilentHighs()
    highs.passOptions(_options())
    highs.setOptionValue("simplex_iteration_limit", MOST_PIVOTS * (rows + columns))
    if highs.passModel(model) == highspy.HighsStatus.kError:
        raise SolverError(f"HiGHS refuses the linear program of shape {program.matrix.shape}")
    return highs


class Simplex:
    """The state of a solver between solves of one program: its sides, bounds and cost may change.

    The data are handed to HiGHS once, equilibrated by powers of two, and every solve starts from the
    basis of the last. Where there is none yet and the program is large, dense interior points lead to
    it. The vertex is solved again from its active rows, so that it is exact to round-off and
    not only to the feasibility tolerance; what round-off leaves of a zero is zero.

    Examples
    --------
    >>> import numpy as np
    >>> held = Simplex(Program(np.array([[1.0, 2.0], [3.0, 1.0]]), np.array([4.0, 6.0]),
    ...     cost=np.array([-1.0, -1.0]), lower=np.zeros(2)))
    >>> held.solve().x
    array([1.6, 1.2])
    """

    def __init__(self, program: Program, *, dense: bool = True) -> None:
        """Hold a program; ``dense`` is for those whose first solve ends at an optimum, far from the start."""
        self.program, self.scales = program.scaled()
        self._may_be_dense = dense
        self._meeting: Meeting | None = None  # of the last vertex, if not found by the solver
        self._made: highspy.Highs | None = None

    @property
    def _highs(self) -> highspy.Highs:
        """The solver, created on first use, as none is needed where the active rows are known."""
        if self._made is None:
            self._made = made(self.program)
            if self._meeting is not None:
                self._made.setBasis(basis_of(self.program, self._meeting))
        return self._made

    def set_rows(self, rows: NDArray[np.intp], left: FloatArray, right: FloatArray) -> None:
        """Change the sides of some rows; the basis stays."""
        program, unit, size = self.program, self.scales.row[rows], self.scales.size
        program.left[rows], program.right[rows] = left * unit / size, right * unit / size
        if self._made:
            for i in rows:
                self._made.changeRowBounds(int(i), program.left[i], program.right[i])

    def solve(self) -> Solution:
        """Solve from the current basis.

        Raises
        ------
        SolverError
            If HiGHS ends without an answer, also from scratch at its own tolerances.
        """
        found = self._dense()
        if found is not None:
            self._meeting = found.meeting
            return found
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
        if status != Status.OPTIMAL:
            return self._end(status, np.nan, reduced, _nowhere, lambda: meeting_of(basis))
        solution = self._highs.getSolution()
        x, y = np.array(solution.col_value), -np.array(solution.row_dual)
        sharp = partial(_polished, x, y)
        return self._end(status, float(self.program.cost @ x), reduced, sharp, lambda: meeting_of(basis))

    def _end(
        self,
        status: Status,
        value: float,
        reduced: bool,
        point: Callable[[Solution], Point],
        meeting: Callable[[], Meeting],
    ) -> Solution:
        """A solution of the present program, unaffected by later changes of sides and bounds."""
        now = self.program
        kept = replace(
            now, left=now.left.copy(), right=now.right.copy(), lower=now.lower.copy(), upper=now.upper.copy()
        )
        return Solution(status, self.scales.value(value), reduced, kept, self.scales, point, meeting)

    def at(self, active: NDArray[np.intp], fixed: Iterable[int] = ()) -> Solution | None:
        """The vertex in which these rows meet, if it is optimal to the solver's tolerances.

        No solver is asked. Columns that are ``fixed``, and those without an entry, are at a bound, or
        zero where they have none; there must be as many rows as other columns. None where they have
        no vertex, where it breaks another row or bound, or where a multiplier has the wrong sign.
        """
        program = self.program
        held: NDArray[np.bool_] = np.asarray(~program.matrix.any(axis=0))
        held[list(fixed)] = True
        idle, meeting = np.flatnonzero(held), (active, np.flatnonzero(~held))
        x = np.zeros(len(held))
        low, high = program.lower[idle] > -INF, program.upper[idle] < INF
        x[idle] = np.select([low, high], [program.lower[idle], program.upper[idle]])
        try:
            x, y = sharpened(program, x, meeting)
        except np.linalg.LinAlgError:
            return None
        rest = (program.cost + y @ program.matrix)[idle]
        wrong = (
            np.where(program.right < INF, -y, y).max(initial=0.0),  # a limit can only push back
            np.select([low, high], [-rest, rest], np.abs(rest)).max(initial=0.0),
        )
        # a larger reduced cost is not round-off, and matters where slips are large
        if not (np.max(wrong) <= ROUND_OFF and program.violation(x) <= TOLERANCE):  # NaN is rejected, too
            return None
        point, value = (cleaned(program, x) * self.scales.x, y * self.scales.y), float(program.cost @ x)
        return self._end(Status.OPTIMAL, value, False, lambda _: point, lambda: meeting)

    def _dense(self) -> Solution | None:
        """The vertex found by dense interior points, where that is faster than the first simplex."""
        rows, columns = self.program.matrix.shape
        first = self._may_be_dense and not self._made and self._meeting is None
        if not first or not DENSE_FROM <= columns <= rows:
            return None  # a wide program would need a large square matrix
        sides = self.program.inequalities()
        matrix, right, named = (np.concatenate([part[k] for part in sides]) for k in range(3))
        found = meeting_rows(matrix, right, self.program.cost)
        if found is None:
            return None
        named = named[found]
        return self.at(np.sort(named[named >= 0]), -1 - named[named < 0])

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
        self._highs.changeColsCost(len(columns), columns, self.program.cost * FINER)
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


def _polished(x: FloatArray, y: FloatArray, end: Solution) -> Point:
    sharp = polished(end.solved, x, y, end.meeting)
    return sharp[0] * end.scales.x, sharp[1] * end.scales.y


def _nowhere(end: Solution) -> Point:
    rows, columns = end.solved.matrix.shape
    return np.full(columns, np.nan), np.full(rows, np.nan)


def meeting_rows(matrix: FloatArray, right: FloatArray, cost: FloatArray) -> NDArray[np.intp] | None:
    """The rows of M x ≤ right with the largest multipliers at the optimum of cᵀ x, as many as columns.

    Columns without an entry are left out. The result must be checked: it is a guess where the optimum is
    degenerate.

    Returns
    -------
        Indices of rows; None where no optimum is found.

    Examples
    --------
    >>> square = np.vstack([np.eye(2), -np.eye(2)])
    >>> meeting_rows(square, np.ones(4), np.array([-1.0, -2.0]))
    array([0, 1])
    """
    used = matrix.any(axis=0)
    if not used.any():
        return None
    inner = matrix[:, used]
    sizes = _sizes(inner)
    inner = inner / sizes[:, None]
    try:
        factor = cholesky(inner.T @ inner)
    except np.linalg.LinAlgError:
        return None
    inner = _in_units_of(factor, inner)
    lengths = _sizes(inner)
    limits = right / (sizes * lengths)
    slope = _in_units_of(factor, cost[None, used])[0]
    inner, needed = inner / lengths[:, None], int(used.sum())
    end = solve_self_dual(
        DiscProgram(
            blocks=np.zeros((0, CONE, 0)),
            node=np.zeros(0, dtype=np.intp),
            extra=np.zeros((0, CONE, needed)),
            right=np.zeros((0, CONE)),
            rows=np.zeros((len(right), 0)),
            rows_extra=inner,
            rows_right=limits / (median_size(np.abs(limits)) or 1.0),
            cost=slope / _sizes(slope[None])[0],
        )
    )
    if end.status != Status.OPTIMAL or needed > len(right):
        return None
    hardest = np.argsort(end.slack / end.multipliers, kind="stable")
    pushing = hardest[: max(needed, int(np.sum(end.slack < end.multipliers)))]
    return np.sort(_without_spare(inner, end.multipliers, pushing))


def _without_spare(matrix: FloatArray, multipliers: FloatArray, rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """As many rows as columns, with multipliers ≥ 0; where more rows meet, they are removed one by one."""
    spare = len(rows) - matrix.shape[1]
    y = multipliers[rows]
    others = (
        np.linalg.qr(matrix[rows], mode="complete")[0][:, matrix.shape[1] :] if spare else np.zeros((0, 0))
    )
    while others.shape[1]:  # each round removes one row and one direction in which the multipliers are free
        way = others[:, 0] if others[:, 0].max() > -others[:, 0].min() else -others[:, 0]
        with np.errstate(divide="ignore"):
            leaving = int(np.argmin(np.where(way > 0, y / way, np.inf)))
        y = np.delete(y - y[leaving] / way[leaving] * way, leaving)
        others = others[:, 1:] - np.outer(way, others[leaving, 1:] / way[leaving])
        others, rows = np.delete(others, leaving, axis=0), np.delete(rows, leaving)
    return rows


def _in_units_of(factor: FloatArray, matrix: FloatArray) -> FloatArray:
    """M R⁻¹ of an upper factor R."""
    return np.asarray(solve_triangular(factor, matrix.T, trans=1).T, dtype=float)


def _sizes(rows: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(rows, axis=1)
    return np.where(lengths > 0, lengths, 1.0)


def solve(program: Program) -> Solution:
    """The solution of a program: without cones by the simplex, with cones by Clarabel's interior points.

    Raises
    ------
    SolverError
        If the method comes to no end.

    Examples
    --------
    >>> import numpy as np
    >>> rows = np.array([[-1.0, -1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    >>> nearest = solve(Program(rows, np.array([-2.0, 0, 0, 0]), cost=np.array([0.0, 0.0, 1.0]), cones=(3,)))
    >>> nearest.x.round(6), nearest.multipliers.round(6)
    (array([1.      , 1.      , 1.414214]), array([ 0.707107,  1.      , -0.707107, -0.707107]))
    """
    return by_clarabel(program) if program.cones else Simplex(program).solve()


@dataclass(frozen=True)
class Widest:
    """The point x with the largest margin, and the multipliers ≥ 0 that prove that no larger one exists."""

    x: FloatArray
    margin: float
    multipliers: FloatArray
    reduced_accuracy: bool


def widest(
    matrix: FloatArray,
    norms: FloatArray,
    right: FloatArray,
    *,
    cap: float,
    signed: int | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Widest:
    """Maximise t ≤ cap subject to M x + t·norms ≤ right, and x ≥ 0 in the column ``signed``.

    The multipliers satisfy yᵀ M = 0 (≥ 0 in the column ``signed``), yᵀ norms = 1 and
    yᵀ right = t, as long as t < cap.
    """
    rows, columns = matrix.shape
    lower = np.full(columns + 1, -INF)
    if signed is not None:
        lower[signed] = 0.0
    upper = np.full(columns + 1, INF)
    upper[-1] = cap
    cost = np.append(np.zeros(columns), -1.0)
    program = Program(
        np.column_stack([matrix, norms]), right, cost, lower=lower, upper=upper, tolerances=tolerances
    )
    end = solve(program)
    if not end.optimal:  # rows without a norm contradict each other, whatever t
        return Widest(np.zeros(columns), -inf, np.zeros(rows), end.reduced_accuracy)
    return Widest(end.x[:-1], float(end.x[-1]), end.multipliers, end.reduced_accuracy)
