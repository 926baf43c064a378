"""Programs over the discs of nodes: one block per node is the whole matrix, and its end keeps its conditions."""

from dataclasses import replace

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
def test_one_block_per_node_is_the_whole_matrix(norm):
    discs, rng = program(1, norm=norm), np.random.default_rng(2)
    M, unit = matrix(discs), discs.cones.unit
    z = rng.normal(size=len(M))
    np.testing.assert_allclose(discs.transposed(z), M.T @ z, atol=1e-13)
    s, y = (unit + 0.3 * rng.uniform(-1, 1, len(M)) / np.sqrt(len(M)) for _ in range(2))
    scaling = discs.cones.scaling(s, y)
    divided = np.column_stack([scaling.divided(column) for column in M.T])
    right = rng.normal(size=M.shape[1])
    for solution in (discs.normal_equations, discs.orthogonal_factor):
        found = solution(scaling)(right)
        np.testing.assert_allclose(divided.T @ (divided @ found), right, atol=1e-11)


def test_columns_may_depend_on_each_other():
    discs = program(3, norm=False)
    blocks, rows = discs.blocks.copy(), discs.rows.copy()
    for part in (blocks, rows):
        part[..., 3] = part[..., 0] + part[..., 1]
    discs = replace(discs, blocks=blocks, rows=rows)
    unit = discs.cones.unit
    right = discs.transposed(np.random.default_rng(3).normal(size=len(unit)))
    found = discs.orthogonal_factor(discs.cones.scaling(unit, unit))(right)
    np.testing.assert_allclose(discs.transposed(discs.times(found)), right, rtol=1e-11)


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


def test_an_edge_bends_as_its_excess_does():
    """Slopes and curvature are those of differences."""
    discs, which, step = program(5, norm=False), np.array([0, 4, 7]), 1e-5
    rng = np.random.default_rng(3)
    x, way, weights = 0.1 * rng.normal(size=6), rng.normal(size=6), np.array([0.5, 1.0, 2.0])
    at = discs.edges(which, x, weights)
    ahead, behind = (discs.edges(which, x + sign * step * way, weights).excess for sign in (1, -1))
    np.testing.assert_allclose((ahead - behind) / (2 * step), at.slopes @ way, rtol=1e-7, atol=1e-8)
    bent = weights @ (ahead - 2 * at.excess + behind) / step**2
    np.testing.assert_allclose(np.sum((at.bends @ way) ** 2), bent, rtol=1e-4)
