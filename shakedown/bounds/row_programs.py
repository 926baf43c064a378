"""Programs over all rows of a joint: the extreme load factor, how far the rows contradict each other."""

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import Constraints
from shakedown.programs.program import INF, Program
from shakedown.programs.solver import Widest, widest


def load_factor_program(rows: Constraints, towards: float, tolerances: Tolerances = DEFAULT) -> Program:
    """Maximise (−1) or minimise (+1) λ ≥ 0 over the columns (v, λ), subject to every row."""
    return Program(
        np.column_stack([rows.coefficients, rows.d]),
        rows.g,
        cost=np.append(np.zeros(rows.n), towards),
        cones=() if len(rows.heads) == len(rows.g) else tuple(rows.cones.tolist()),
        lower=np.append(np.full(rows.n, -INF), 0.0),
        tolerances=tolerances,
    )


def reversed_rows(program: Program, chosen: NDArray[np.bool_]) -> Program:
    """The program with some rows reversed: upper limits become lower limits."""
    return program.with_signs(np.where(chosen, -1.0, 1.0))


def contradiction(rows: Constraints, tolerances: Tolerances) -> Widest:
    """How far the rows exclude every safe slip at any load factor, and the multipliers that show it."""
    matrix = np.column_stack([rows.coefficients, rows.d])
    sizes = np.abs(matrix).max(axis=1)
    norms = np.where(sizes > 0, sizes, 1.0)
    return widest(matrix, norms, rows.g, cap=INF, signed=rows.n, tolerances=tolerances)
