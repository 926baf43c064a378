"""HiGHS: its options, its form of a program, its bases, and the sequence of settings for retries."""

from functools import cache

import highspy
import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import SolverError
from shakedown.ground.status import Status
from shakedown.programs.program import INF, Meeting, Program, columnwise

TOLERANCE = 1e-10  # the smallest that HiGHS accepts
MOST_PIVOTS = 200  # per row and column; on stiffness that is round-off the simplex may cycle
_BASIC = highspy.HighsBasisStatus.kBasic
_STRATEGY = highspy.simplex_constants.SimplexStrategy

OPTIONS: dict[str, bool | int | float | str] = {
    "output_flag": False,
    "presolve": "off",
    "solver": "simplex",
    "parallel": "off",
    # With free columns the dual simplex often fails to prove infeasibility.
    "simplex_strategy": int(_STRATEGY.kSimplexStrategyPrimal),
    "primal_simplex_bound_perturbation_multiplier": 0.0,  # its clean-up may end without a verdict
    "simplex_scale_strategy": 0,  # the data are equilibrated here, so that tolerances have a fixed meaning
    "primal_feasibility_tolerance": TOLERANCE,
    "dual_feasibility_tolerance": TOLERANCE,
    "small_matrix_value": 1e-12,
}
RUNGS: tuple[dict[str, float], ...] = (
    {},
    {"simplex_strategy": int(_STRATEGY.kSimplexStrategyDual)},
    {name: getattr(highspy.HighsOptions(), name) for name in OPTIONS if "feasibility" in name},
)
EXACT_RUNGS = len(RUNGS) - 1  # the last one: HiGHS's default tolerances, for data at the limit of doubles

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
