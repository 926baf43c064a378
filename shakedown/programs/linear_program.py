"""Small dense linear programs: dimensionless inside, solved by HiGHS, exact to round-off."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cache, cached_property, partial

import highspy
import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import SolverError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.programs.equilibration import equilibration, power_of_two, typical_size
from shakedown.programs.interior.dense_programs import meeting_rows
from shakedown.programs.vertex import End, Vertex, cleaned, polished, sharpened, violation

INF = highspy.kHighsInf
PRIMAL, DUAL = 4, 1  # HiGHS's simplex strategies
DENSE_FROM = 80  # columns, from where on dense interior points are the quicker road to the first vertex
TOLERANCE = 1e-10  # the smallest that HiGHS accepts
MOST_PIVOTS = 200  # for each row and column; on stiffness that is round-off the simplex may go in circles
FINEST = 1e-13  # of a reduced cost: what is larger is no round-off, and where slips are large it counts
FINER = 2.0**14  # by how much costs are larger where HiGHS's tolerance leaves such a reduced cost
REDUCED_TOLERANCE = 1e-7  # HiGHS's own
OWN_SCALING = 4  # of HiGHS's simplex: the strongest
_BASIC = highspy.HighsBasisStatus.kBasic

_OPTIONS: dict[str, bool | int | float | str] = {
    "output_flag": False,
    "presolve": "off",
    "solver": "simplex",
    "parallel": "off",
    "simplex_strategy": PRIMAL,  # with free columns the dual simplex often fails to prove infeasibility
    "primal_simplex_bound_perturbation_multiplier": 0.0,  # its clean-up sometimes ends without a verdict
    "simplex_scale_strategy": 0,  # the data are equilibrated here, so that the tolerances mean one thing
    "primal_feasibility_tolerance": TOLERANCE,
    "dual_feasibility_tolerance": TOLERANCE,
    "small_matrix_value": 1e-12,
}
_LOOSE = {f"{side}_feasibility_tolerance": REDUCED_TOLERANCE for side in ("primal", "dual")}


Meeting = tuple[NDArray[np.intp], NDArray[np.intp]]  # rows that meet, the columns that they determine


@dataclass(frozen=True)
class Solution:
    """How a linear program ended.

    Attributes
    ----------
    status
        Optimal with a vertex, infeasible or unbounded without.
    value
        cᵀ x to the accuracy of the solver, without polish; NaN unless optimal.
    reduced_accuracy
        Whether the solver reached an answer only at loosened tolerances.
    """

    status: Status
    value: float
    reduced_accuracy: bool
    _met: Callable[[], Meeting] = field(repr=False)
    _sharp: Callable[[Meeting], Vertex | None] = field(repr=False)

    @cached_property
    def _meeting(self) -> Meeting:
        return self._met()

    @cached_property
    def active(self) -> NDArray[np.intp]:
        """The rows held as equalities at the end, (K,)."""
        return self._meeting[0]

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """The columns that they determine, (K,); every other column is at a bound, or zero."""
        return self._meeting[1]

    @cached_property
    def vertex(self) -> Vertex | None:
        """The optimal vertex, solved again from its active rows when first asked for; or None."""
        return self._sharp(self._meeting)


class LinearProgram:
    """Minimise cᵀ x subject to lower ≤ M x ≤ upper and column bounds.

    The data are handed to HiGHS once, equilibrated by powers of two; afterwards
    only bounds change and every solve starts from the last basis. The vertex
    is solved again from its active rows, so that it is exact to round-off and
    not only to the feasibility tolerance; what round-off leaves of a zero is zero.

    Parameters
    ----------
    matrix : (R, N)
        M.
    cost : (N,)
        c.
    lower, upper : (R,)
        Row bounds; ±``INF`` where there is none.
    column_lower, column_upper : (N,)
        Column bounds; ∓``INF`` where there is none.
    tolerances
        ``equilibration_sweeps`` and ``cancellation`` are used.

    Examples
    --------
    >>> import numpy as np
    >>> program = LinearProgram(np.array([[1.0, 2.0], [3.0, 1.0]]), cost=np.array([-1.0, -1.0]),
    ...     lower=np.full(2, -INF), upper=np.array([4.0, 6.0]),
    ...     column_lower=np.zeros(2), column_upper=np.full(2, INF))
    >>> program.solve().vertex.x
    array([1.6, 1.2])
    """

    def __init__(
        self,
        matrix: FloatArray,
        *,
        cost: FloatArray,
        lower: FloatArray,
        upper: FloatArray,
        column_lower: FloatArray,
        column_upper: FloatArray,
        tolerances: Tolerances = DEFAULT,
    ) -> None:
        self.cancellation = tolerances.cancellation * matrix.shape[1]
        self.row_scale, self.column_scale = equilibration(matrix, tolerances.equilibration_sweeps)
        self.matrix = matrix * self.row_scale[:, None] * self.column_scale
        self.size = typical_size(np.abs(np.concatenate([lower, upper])) * np.tile(self.row_scale, 2))
        self.cost, self.cost_scale = self._scaled_cost(cost)
        self.lower, self.upper = self._scaled(lower), self._scaled(upper)
        unit = self.column_scale * self.size
        self.columns = column_lower / unit, column_upper / unit
        self._solved = False  # the first solve may go by interior points; the next ones start from a basis

    @cached_property
    def _highs(self) -> highspy.Highs:
        """The solver; made when first asked, for where the active rows are known none is needed."""
        return _highs(self.matrix, self.cost, self.lower, self.upper, *self.columns)

    def hold_basis(self) -> "LinearProgram":
        """Make the solver at once: quicker where many solves follow, each from the basis of the last."""
        _ = self._highs
        return self

    def _told(self) -> highspy.Highs | None:
        """The solver where it has been made already, and must be told of changes."""
        return self.__dict__.get("_highs")

    def _scaled(self, bounds: FloatArray, rows: NDArray[np.intp] | slice = slice(None)) -> FloatArray:
        return bounds * self.row_scale[rows] / self.size

    def _scaled_cost(self, cost: FloatArray) -> tuple[FloatArray, float]:
        scaled = cost * self.column_scale
        scale = 1.0 / power_of_two(np.abs(scaled).max())
        return scaled * scale, scale

    def set_cost(self, cost: FloatArray) -> None:
        """Change what is minimised; the basis stays, and with it the feasible vertex."""
        self.cost, self.cost_scale = self._scaled_cost(cost)
        if highs := self._told():
            highs.changeColsCost(len(cost), np.arange(len(cost), dtype=np.int32), self.cost)

    def set_rows(self, rows: NDArray[np.intp], lower: FloatArray, upper: FloatArray) -> None:
        """Change the bounds of some rows; the basis stays."""
        self.lower[rows], self.upper[rows] = self._scaled(lower, rows), self._scaled(upper, rows)
        if highs := self._told():
            for i in rows:
                highs.changeRowBounds(int(i), self.lower[i], self.upper[i])

    def set_columns(self, columns: NDArray[np.intp], lower: FloatArray, upper: FloatArray) -> None:
        """Change the bounds of some columns; the basis stays."""
        unit = self.column_scale[columns] * self.size
        self.columns[0][columns], self.columns[1][columns] = lower / unit, upper / unit
        if highs := self._told():
            for j in columns:
                highs.changeColBounds(int(j), self.columns[0][j], self.columns[1][j])

    def solve(self) -> Solution:
        """Solve from the current basis.

        Raises
        ------
        SolverError
            If HiGHS ends without an answer, also from scratch, by the dual method, at loosened tolerances,
            in its own scaling and by interior points.
        """
        found, self._solved = None if self._solved else self._dense(), True
        if found is not None:
            return found
        attempts: tuple[Callable[[], Status | None], ...] = (
            self._warm,
            self._cold,
            self._dual,
            self._loosened,
            self._rescaled,
            self._interior,
        )
        for attempt in attempts:
            status = attempt()
            if status is not None:
                break
        if status is None and self._highs.getModelStatus() == highspy.HighsModelStatus.kUnbounded:
            status = Status.UNBOUNDED  # it cannot be, but no road has another answer
        if status is None:
            reason = self._highs.modelStatusToString(self._highs.getModelStatus())
            raise SolverError(f"the linear program of shape {self.matrix.shape} ended as '{reason}'")
        reduced = attempt in attempts[3:]
        if status == Status.OPTIMAL and not reduced:
            self._finish()
        basis = self._highs.getBasis()
        if status != Status.OPTIMAL:
            return Solution(status, np.nan, reduced, lambda: _basic(basis), lambda _: None)
        solution = self._highs.getSolution()
        end = self._end(np.array(solution.col_value), np.array(solution.row_dual))
        sharp = partial(_polished, end, self.cancellation)
        return Solution(status, self._value(end.x), reduced, lambda: _basic(basis), sharp)

    def at(self, active: NDArray[np.intp], fixed: Iterable[int] = ()) -> Solution | None:
        """The vertex in which these rows meet, if it is optimal to the solver's tolerances.

        No solver is asked. Columns that are ``fixed``, and those without an entry, are at a bound, or
        zero where they have none; there must be as many rows as other columns. None where they have
        no vertex, where it breaks another row or bound, or where a multiplier has the wrong sign.
        """
        held: NDArray[np.bool_] = np.asarray(~self.matrix.any(axis=0))
        held[list(fixed)] = True
        idle, free = np.flatnonzero(held), np.flatnonzero(~held)
        x = np.zeros(len(held))
        low, high = self.columns[0][idle] > -INF, self.columns[1][idle] < INF
        x[idle] = np.select([low, high], [self.columns[0][idle], self.columns[1][idle]])
        end = self._end(x, np.zeros(len(self.matrix)))
        try:
            x, y = sharpened(end, active, free)
        except np.linalg.LinAlgError:
            return None
        rest = (self.cost - y @ self.matrix)[idle]
        wrong = (
            np.where(self.upper < INF, y, -y).max(initial=0.0),  # what a limit does is to push back
            np.select([low, high], [-rest, rest], np.abs(rest)).max(initial=0.0),
        )
        if not (np.max(wrong) <= FINEST and violation(end, x) <= TOLERANCE):  # nor is NaN a vertex
            return None
        vertex, meeting = cleaned(end, x, y, self.cancellation), (active, free)
        return Solution(Status.OPTIMAL, self._value(x), False, lambda: meeting, lambda _: vertex)

    def _dense(self) -> Solution | None:
        """The vertex that dense interior points lead to, where that is quicker than the first simplex."""
        rows, columns = self.matrix.shape
        if self._told() is not None or not DENSE_FROM <= columns <= rows:  # a wide one is square in memory
            return None
        bounds = np.eye(columns)
        parts = (
            (self.matrix, self.upper, np.arange(rows)),
            (-self.matrix, -self.lower, np.arange(rows)),
            (bounds, self.columns[1], -1 - np.arange(columns)),
            (-bounds, -self.columns[0], -1 - np.arange(columns)),
        )
        kept = [right < INF for _, right, _ in parts]
        matrix, right, names = (
            np.concatenate([part[k][chosen] for part, chosen in zip(parts, kept, strict=True)])
            for k in range(3)
        )
        found = meeting_rows(matrix, right, self.cost)
        if found is None:
            return None
        named = names[found]
        return self.at(np.sort(named[named >= 0]), -1 - named[named < 0])

    def _end(self, x: FloatArray, y: FloatArray) -> End:
        rows, columns = (
            (self.lower.copy(), self.upper.copy()),
            (self.columns[0].copy(), self.columns[1].copy()),
        )
        units = self.column_scale * self.size, self.row_scale / self.cost_scale
        return End(self.matrix, self.cost, x, y, rows, columns, *units)

    def _value(self, x: FloatArray) -> float:
        return float(self.cost @ x) * self.size / self.cost_scale

    def _warm(self) -> Status | None:
        """From where the last solve ended, be it optimal or infeasible: few pivots away as a rule."""
        self._highs.run()
        status = _STATUSES.get(self._highs.getModelStatus())
        return None if status == Status.UNBOUNDED and self._limited() else status

    def _limited(self) -> bool:
        """Whether the columns that cost something are at most at their bounds: nothing is unbounded then."""
        best = np.where(self.cost > 0, self.columns[0], self.columns[1])
        return bool(np.all(np.isfinite(best[self.cost != 0])))

    def _finish(self) -> None:
        """Go on where a reduced cost is more than round-off: the solver takes 1e-10 for none.

        Along a slip with little resistance even that much can change the optimum.
        """
        if self._left_to_gain() <= FINEST:
            return
        basis, columns = self._highs.getBasis(), np.arange(len(self.cost), dtype=np.int32)
        self._highs.changeColsCost(len(columns), columns, self.cost * FINER)
        done = self._warm() == Status.OPTIMAL
        basis = self._highs.getBasis() if done else basis
        self._highs.changeColsCost(len(columns), columns, self.cost)
        self._highs.setBasis(basis)
        self._highs.run()

    def _left_to_gain(self) -> float:
        """The largest multiplier, of a row or of a column, with the wrong sign."""
        end = self._highs.getSolution()
        y, rest = np.array(end.row_dual), np.array(end.col_dual)
        x, (low, high) = np.array(end.col_value), self.columns
        pulls = np.where(rest > 0, x > low, x < high) * np.abs(rest)
        sides = np.where(self.upper == self.lower, 0.0, np.where(self.upper < INF, y, -y))
        sides[(self.upper < INF) & (self.lower > -INF)] = 0.0
        return float(max(pulls.max(initial=0.0), sides.max(initial=0.0)))

    def _cold(self) -> Status | None:
        self._highs.clearSolver()
        return self._warm()

    def _dual(self) -> Status | None:
        return self._with(simplex_strategy=DUAL)

    def _loosened(self) -> Status | None:
        """At HiGHS's own tolerances, for data at the end of double precision; the vertex is polished."""
        return self._with(**_LOOSE)

    def _rescaled(self) -> Status | None:
        """In the scaling that HiGHS finds by itself."""
        return self._with(**_LOOSE, simplex_scale_strategy=OWN_SCALING)

    def _interior(self) -> Status | None:
        """By interior points, with a crossover to a vertex: another method altogether."""
        return self._with(**_LOOSE, solver="ipm")

    def _with(self, **options: float | str) -> Status | None:
        """From scratch with other options, which are put back afterwards."""
        for name, value in options.items():
            self._highs.setOptionValue(name, value)
        status = self._cold()
        for name in options:
            self._highs.setOptionValue(name, _OPTIONS[name])
        return status


_STATUSES = {
    highspy.HighsModelStatus.kOptimal: Status.OPTIMAL,
    highspy.HighsModelStatus.kInfeasible: Status.INFEASIBLE,
    highspy.HighsModelStatus.kUnbounded: Status.UNBOUNDED,
}


def _polished(end: End, cancellation: float, meeting: Meeting) -> Vertex:
    return polished(end, *meeting, cancellation)


def _basic(basis: highspy.HighsBasis) -> Meeting:
    """Of a basis of the solver: the rows that are not in it, the columns that are."""
    rows = np.flatnonzero([status != _BASIC for status in basis.row_status])
    return rows, np.flatnonzero([status == _BASIC for status in basis.col_status])


@cache
def _options() -> highspy.HighsOptions:
    highs = highspy.Highs()
    for name, value in _OPTIONS.items():
        if highs.setOptionValue(name, value) != highspy.HighsStatus.kOk:
            raise SolverError(f"HiGHS {highs.version()} does not take the option {name} = {value}")
    return highs.getOptions()


def _highs(
    matrix: FloatArray,
    cost: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    column_lower: FloatArray,
    column_upper: FloatArray,
) -> highspy.Highs:
    rows, columns = matrix.shape
    model = highspy.HighsLp()
    model.num_row_, model.num_col_ = rows, columns
    model.col_cost_ = cost
    model.row_lower_, model.row_upper_ = lower, upper
    model.col_lower_, model.col_upper_ = column_lower, column_upper
    model.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    transposed = np.ascontiguousarray(matrix.T)
    nonzero = transposed != 0
    model.a_matrix_.start_ = np.concatenate([[0], np.cumsum(nonzero.sum(axis=1))]).astype(np.int32)
    model.a_matrix_.index_ = np.nonzero(nonzero)[1].astype(np.int32)
    model.a_matrix_.value_ = transposed[nonzero]
    highs = highspy.Highs()
    highs.passOptions(_options())
    highs.setOptionValue("simplex_iteration_limit", MOST_PIVOTS * (rows + columns))
    if highs.passModel(model) == highspy.HighsStatus.kError:
        raise SolverError(f"HiGHS refuses the linear program of shape {matrix.shape}")
    return highs
