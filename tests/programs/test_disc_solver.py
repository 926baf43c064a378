"""Programs over the discs of nodes: one block per node is the whole matrix, and its end keeps its conditions."""

import numpy as np
import pytest

from shakedown.ground.errors import SolverError
from shakedown.ground.status import Status
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.self_dual import solve_discs


def program(seed: int, *, norm: bool) -> DiscProgram:
    """The largest w_1 over discs about the origin, their nodes in no order, and a half-space of y."""
    rng = np.random.default_rng(seed)
    n, r, K = 3, 4, 9
    node = rng.permutation(np.arange(K) % n)
    right = rng.normal(size=(K, 3))
    right[:, 0] = np.hypot(right[:, 1], right[:, 2]) + rng.uniform(0.5, 1.0, K)
    extra = rng.normal(size=(K, 3, 2))
    extra[:, 0, 0], extra[:, 1:, 0] = 0.3, 0.0  # w_0 is a radius
    return DiscProgram(
        blocks=rng.normal(size=(n, 3, r)),
        node=node,
        extra=extra,
        right=right,
        rows=np.vstack([rng.normal(size=(1, r)), np.zeros((2, r))]),
        rows_extra=np.array([[0.0, 0.1], [-1.0, 0.0], [0.0, 1.0]]),
        rows_right=np.array([1.0, 0.0, 9.0]),
        cost=np.array([0.0, -1.0]),
        norm=np.array([1.0, 0.0]) if norm else None,
        offset=0.1 if norm else 0.0,
    )


def matrix(discs: DiscProgram) -> np.ndarray:
    """All of its coefficients, column by column."""
    return np.column_stack([discs.times(column) for column in np.eye(len(discs.costs))])


@pytest.mark.parametrize("norm", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_an_end_keeps_its_conditions(seed, norm):
    discs = program(seed, norm=norm)
    end = solve_discs(discs)
    assert end.status == Status.OPTIMAL
    slack = discs.limits - discs.times(end.x)
    assert discs.cones.margin(slack) > -1e-9
    assert discs.cones.margin(end.multipliers) > -1e-9
    np.testing.assert_allclose(discs.transposed(end.multipliers), -discs.costs, atol=1e-8)
    assert abs(slack @ end.multipliers) < 1e-8


def test_no_end_is_claimed_that_is_not_accurate_enough():
    with pytest.raises(SolverError, match="the program of 9 discs ended without an answer"):
        solve_discs(program(0, norm=True), usable=1e-17)
