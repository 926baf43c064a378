"""HiGHS: its options, a program as it takes it, its bases, and the rungs on which it is asked again."""

from functools import cache

import highspy
import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import SolverError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.programs.program import INF, Meeting, Program, columnwise

PRIMAL, DUAL = 4, 1  # HiGHS's simplex strategies
TOLERANCE = 1e-10  # the smallest that HiGHS accepts
MOST_PIVOTS = 200  # for each row and column; on stiffness that is round-off the simplex may go in circles
REDUCED_TOLERANCE = 1e-7  # HiGHS's own
_BASIC = highspy.HighsBasisStatus.kBasic

OPTIONS: dict[str, bool | int | float | str] = {
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
EXACT_RUNGS = 2  # of the rungs; after them HiGHS's own tolerances, for data at the end of double precision
RUNGS: tuple[dict[str, float | str], ...] = (
    {},
    {"simplex_strategy": DUAL},
    {**_LOOSE},
    {**_LOOSE, "solver": "ipm"},  # with a crossover to a vertex: another method altogether
)

STATUSES = {
    highspy.HighsModelStatus.kOptimal: Status.OPTIMAL,
    highspy.HighsModelStatus.kInfeasible: Status.INFEASIBLE,
    highspy.HighsModelStatus.kUnbounded: Status.UNBOUNDED,
}


def meeting_of(basis: highspy.HighsBasis) -> Meeting:
    """Of a basis of the solver: the rows that are not in it, the columns that are."""
    rows = np.flatnonzero([status != _BASIC for status in basis.row_status])
    return rows, np.flatnonzero([status == _BASIC for status in basis.col_status])


def basis_of(program: Program, meeting: Meeting) -> highspy.HighsBasis:
    """The other way round."""
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
    """HiGHS that prints nothing: version 1.16 announces itself while it is made, where the answers go."""

    def enableCallbacks(self) -> None:  # the first that its constructor calls
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
