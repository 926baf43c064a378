"""Small dense linear programs: dimensionless inside, solved by HiGHS, exact to round-off."""

from dataclasses import dataclass

import highspy
import numpy as np
from numpy.typing import NDArray

from shakedown.errors import SolverError
from shakedown.model.problem import FloatArray
from shakedown.programs.equilibration import equilibration, power_of_two, typical_size

INF = highspy.kHighsInf
PRIMAL, DUAL = 4, 1
TOLERANCE = 1e-10  # the smallest that HiGHS accepts

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


@dataclass(frozen=True)
class Vertex:
    """An optimal vertex of a :class:`LinearProgram`.

    Attributes
    ----------
    x : (N,)
        The solution.
    multipliers : (R,)
        Row multipliers y with yᵀ M = cᵀ on the columns that are not at a bound
        (y ≤ 0 at an upper, y ≥ 0 at a lower row bound).
    """

    x: FloatArray
    multipliers: FloatArray


@dataclass(frozen=True)
class Solution:
    """How a linear program ended.

    Attributes
    ----------
    status
        ``"optimal"`` with a vertex, ``"infeasible"`` or ``"unbounded"`` without.
    active : (K,)
        The rows held as equalities at the end.
    free : (K,)
        The columns that they determine; every other column is at a bound, or zero.
    vertex
        The optimal vertex, or None.
    """

    status: str
    active: NDArray[np.intp]
    free: NDArray[np.intp]
    vertex: Vertex | None = None


class LinearProgram:
    """Minimise cᵀ x subject to lower ≤ M x ≤ upper and column bounds.

    The data are handed to HiGHS once, equilibrated by powers of two; afterwards
    only bounds change and every solve starts from the last basis. The vertex
    is solved again from its active rows, so that it is exact to round-off and
    not only to the feasibility tolerance.

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
    ) -> None:
        self.row_scale, self.column_scale = equilibration(matrix)
        self.matrix = matrix * self.row_scale[:, None] * self.column_scale
        self.size = typical_size(np.abs(np.concatenate([lower, upper])) * np.tile(self.row_scale, 2))
        cost = cost * self.column_scale
        self.cost_scale = 1.0 / power_of_two(np.abs(cost).max())
        self.cost = cost * self.cost_scale
        self.lower, self.upper = self._scaled(lower), self._scaled(upper)
        unit = self.column_scale * self.size
        self._columns = column_lower / unit, column_upper / unit
        self._home: highspy.HighsBasis | None = None
        self._highs = _highs(self.matrix, self.cost, self.lower, self.upper, *self._columns)

    def _scaled(self, bounds: FloatArray, rows: NDArray[np.intp] | slice = slice(None)) -> FloatArray:
        return bounds * self.row_scale[rows] / self.size

    def set_rows(self, rows: NDArray[np.intp], lower: FloatArray, upper: FloatArray) -> None:
        """Change the bounds of some rows; the basis stays."""
        self.lower[rows], self.upper[rows] = self._scaled(lower, rows), self._scaled(upper, rows)
        for i in rows:
            self._highs.changeRowBounds(int(i), self.lower[i], self.upper[i])

    def set_columns(self, columns: NDArray[np.intp], lower: FloatArray, upper: FloatArray) -> None:
        """Change the bounds of some columns; the basis stays."""
        unit = self.column_scale[columns] * self.size
        self._columns[0][columns], self._columns[1][columns] = lower / unit, upper / unit
        for j in columns:
            self._highs.changeColBounds(int(j), self._columns[0][j], self._columns[1][j])

    def solve(self) -> Solution:
        """Solve from the current basis.

        Raises
        ------
        SolverError
            If HiGHS ends without an answer, also from scratch and by the dual method.
        """
        for attempt in (self._warm, self._from_home, self._cold, self._dual, self._loose):
            status = attempt()
            if status is not None:
                break
        if status is None:
            reason = self._highs.modelStatusToString(self._highs.getModelStatus())
            raise SolverError(f"the linear program of shape {self.matrix.shape} ended as '{reason}'")
        basis, basic = self._highs.getBasis(), highspy.HighsBasisStatus.kBasic
        active = np.array([i for i, s in enumerate(basis.row_status) if s != basic], dtype=np.intp)
        free = np.array([j for j, s in enumerate(basis.col_status) if s == basic], dtype=np.intp)
        if status == "optimal":
            self._home = basis
        return Solution(status, active, free, self._vertex(active, free) if status == "optimal" else None)

    def _warm(self) -> str | None:
        """From where the last solve ended, be it optimal or infeasible: few pivots away as a rule."""
        return self._run()

    def _from_home(self) -> str | None:
        """From the last optimal basis."""
        if self._home is None:
            return None
        self._highs.setBasis(self._home)
        return self._run()

    def _cold(self) -> str | None:
        self._highs.clearSolver()
        return self._run()

    def _dual(self) -> str | None:
        self._highs.clearSolver()
        self._highs.setOptionValue("simplex_strategy", DUAL)
        status = self._run()
        self._highs.setOptionValue("simplex_strategy", PRIMAL)
        return status

    def _loose(self) -> str | None:
        """At HiGHS's own tolerances, for data at the end of double precision; the vertex is polished."""
        self._highs.clearSolver()
        for side in ("primal", "dual"):
            self._highs.setOptionValue(f"{side}_feasibility_tolerance", 1e-7)
        status = self._run()
        for side in ("primal", "dual"):
            self._highs.setOptionValue(f"{side}_feasibility_tolerance", TOLERANCE)
        return status

    def _run(self) -> str | None:
        self._highs.run()
        status = self._highs.getModelStatus()
        names = {
            highspy.HighsModelStatus.kOptimal: "optimal",
            highspy.HighsModelStatus.kInfeasible: "infeasible",
            highspy.HighsModelStatus.kUnbounded: "unbounded",
        }
        return names.get(status)

    def _vertex(self, active: NDArray[np.intp], free: NDArray[np.intp]) -> Vertex:
        solution = self._highs.getSolution()
        x = np.array(solution.col_value)
        y = np.array(solution.row_dual)
        x, y = self._polished(x, y, active, free)
        return Vertex(
            x=x * self.column_scale * self.size,
            multipliers=y * self.row_scale / self.cost_scale,
        )

    def _polished(
        self, x: FloatArray, y: FloatArray, active: NDArray[np.intp], free: NDArray[np.intp]
    ) -> tuple[FloatArray, FloatArray]:
        """Solve the active rows as equalities; keep what violates the rows less."""
        square = self.matrix[np.ix_(active, free)]
        at_upper = np.abs(self.upper[active] - self.matrix[active] @ x) <= np.abs(
            self.matrix[active] @ x - self.lower[active]
        )
        target = np.where(at_upper, self.upper[active], self.lower[active])
        fixed = np.ones(len(x), dtype=bool)
        fixed[free] = False
        rest = target - self.matrix[np.ix_(active, fixed)] @ x[fixed]
        try:
            sharp_x, sharp_y = x.copy(), np.zeros_like(y)
            sharp_x[free] = refined_solve(square, rest)
            sharp_y[active] = refined_solve(square.T, self.cost[free])
        except np.linalg.LinAlgError:  # HiGHS left a singular basis: its own values are all there is
            return x, y
        if self._violation(sharp_x) <= max(self._violation(x), 16 * np.finfo(float).eps):
            x = sharp_x
        if np.all(np.isfinite(sharp_y)):
            y = sharp_y
        return x, y

    def _violation(self, x: FloatArray) -> float:
        value = self.matrix @ x
        excess = np.maximum(value - self.upper, self.lower - value).max(initial=0.0)
        lower, upper = self._columns
        return float(max(excess, np.maximum(x - upper, lower - x).max(initial=0.0), 0.0))


def refined_solve(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solve a square system with one step of iterative refinement in extended precision.

    Raises ``numpy.linalg.LinAlgError`` if the matrix is exactly singular.
    """
    x = np.linalg.solve(matrix, right)
    residual = right - matrix.astype(np.longdouble) @ x
    return np.asarray(x + np.linalg.solve(matrix, residual.astype(float)))


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
    for name, value in _OPTIONS.items():
        if highs.setOptionValue(name, value) != highspy.HighsStatus.kOk:
            raise SolverError(f"HiGHS {highs.version()} does not take the option {name} = {value}")
    if highs.passModel(model) == highspy.HighsStatus.kError:
        raise SolverError(f"HiGHS refuses the linear program of shape {matrix.shape}")
    return highs
