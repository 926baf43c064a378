"""The rows of a joint in exact arithmetic are those of the floats, but for round-off."""

import numpy as np
import pytest
from joints import any_joint

from shakedown import Problem
from shakedown.bounds.row_programs import exact_rows
from shakedown.joint.constraints import constraints


def agree(problem: Problem) -> None:
    rows, exact = constraints(problem), exact_rows(problem)
    stored = [
        [float(x / factor) for x in (*row, right)]
        for row, right, factor in zip(exact.matrix, exact.right, exact.factors, strict=True)
    ]
    floats = np.column_stack([rows.coefficients, rows.d, rows.g])
    np.testing.assert_allclose(stored, floats, atol=1e-13 * np.abs(floats).max())


@pytest.mark.parametrize("seed", range(12))
def test_of_any_joint(seed):
    agree(any_joint(np.random.default_rng(seed)))


@pytest.mark.parametrize("still", [("q_w",), ("p_w",), ("q_w", "p_w")])
def test_where_loads_of_a_node_stand_still(still):
    loads = {"q_w": [[0.3, 0.1], [0.5, -0.2], [0.1, 0.4]], "p_w": [[3.0, 2.0], [2.5, 2.2], [2.9, 1.7]]}
    for key in still:
        for load_step in loads[key]:
            load_step[1] = 0.7
    agree(Problem(A=[[2.0, 0.1], [0.1, 3.0]], B=[[0.5, 0.2], [0.0, 0.4]], f=[0.3, 0.5], **loads))
