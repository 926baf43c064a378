"""The linear programs in slip and load factor over the rows of a joint or a zone."""

import numpy as np

from shakedown.model.constraints import Constraints
from shakedown.programs.linear_program import INF, LinearProgram
from shakedown.tolerances import DEFAULT, Tolerances


def load_factor_program(rows: Constraints, towards: float, tolerances: Tolerances = DEFAULT) -> LinearProgram:
    """Maximise (−1) or minimise (+1) λ ≥ 0 over the columns (v, λ), subject to every row."""
    return LinearProgram(
        np.column_stack([rows.G, rows.d]),
        cost=np.append(np.zeros(rows.n), towards),
        lower=np.full(len(rows.g), -INF),
        upper=rows.g,
        column_lower=np.append(np.full(rows.n, -INF), 0.0),
        column_upper=np.full(rows.n + 1, INF),
        tolerances=tolerances,
    )
