"""Programs over the discs of nodes: one block per node is the whole matrix, and its end keeps its conditions."""

from dataclasses import replace

import numpy as np
import pytest

from shakedown.bounds.independent_solver import solve_conic
from shakedown.bounds.scaled_solution import polished
from shakedown.ground.errors import SolverError
from shakedown.ground.status import Status
from shakedown.programs.disc_program import DiscProgram, _by_orthogonal_factor
from shakedown.programs.self_dual import solve_discs


def program(seed: int, *, norm: bool, rank: int = 4, n: int = 4) -> DiscProgram:
    """The largest w_1 over three discs of each of n nodes in no order and two rows of y: safe at the origin."""
    rng, K = np.random.default_rng(seed), 3 * n
    right = rng.normal(size=(K, 3))
    right[:, 0] = np.hypot(right[:, 1], right[:, 2]) + rng.uniform(0.5, 1.0, K)
    extra = rng.normal(size=(K, 3, 2))
    extra[:, 0, 0], extra[:, 1:, 0] = 0.3, 0.0  # w_0 is a radius
    return DiscProgram(
        blocks=rng.normal(size=(n, 3, rank)),
        node=rng.permutation(np.arange(K) % n),
        extra=extra,
        right=right,
        rows=np.vstack([rng.normal(size=(2, rank)), np.zeros((2, rank))]),
        rows_extra=np.array([[0.0, 0.1], [0.1, 0.0], [-1.0, 0.0], [0.0, 1.0]]),
        rows_right=np.array([1.0, 2.0, 0.0, 9.0]),
        cost=np.array([0.0, -1.0]),
        norm=np.array([1.0, 0.0]) if norm else None,
        offset=0.1 if norm else 0.0,
    )


@pytest.mark.parametrize("norm", [True, False])
@pytest.mark.parametrize("seed", [0, 1, 8])
def test_an_end_keeps_its_conditions(seed, norm):
    discs = program(seed, norm=norm)
    end = solve_discs(discs)
    assert end.status == Status.OPTIMAL
    for found, off in ((end, 1e-8), (polished(discs, end), 1e-13)):
        slack = discs.limits - discs.times(found.x)
        assert min(discs.cones.margin(slack), discs.cones.margin(found.multipliers)) > -0.1 * off
        np.testing.assert_allclose(discs.transposed(found.multipliers), -discs.costs, atol=off)
        assert abs(slack @ found.multipliers) < off
    wide = replace(discs, blocks=discs.blocks * np.logspace(0, 4, 4))
    better = polished(wide, solve_discs(wide))  # by as much as round-off leaves
    assert abs((wide.limits - wide.times(better.x)) @ better.multipliers) < 1e-11
    for solver in (None, "CLARABEL") if seed == 0 and not norm else ():  # Clarabel itself; through cvxpy
        status, x, _ = solve_conic(discs, solver)
        assert status == Status.OPTIMAL
        np.testing.assert_allclose(x, end.x, atol=1e-6)


def test_no_end_is_claimed_that_is_not_accurate_enough():
    with pytest.raises(SolverError, match="the program of 12 discs ended without an answer"):
        solve_discs(program(0, norm=True), usable=1e-17)


@pytest.mark.parametrize("little", [True, False])
def test_a_program_that_differs_little_shares_the_way_to_its_end(little):
    discs = program(4, norm=True, rank=8)
    other = replace(discs, blocks=discs.blocks * (1.0 + 1e-6)) if little else program(6, norm=True, rank=8)
    first, alone = solve_discs(discs), solve_discs(other)
    shared = solve_discs(other, earlier=first.path)
    assert shared.path[0] is first.path[0] or not little
    assert shared.status == alone.status
    np.testing.assert_allclose(shared.x[-1], alone.x[-1], rtol=1e-9)


@pytest.mark.parametrize("norm", [True, False])
@pytest.mark.parametrize(("n", "rank"), [(4, 4), (40, 80), (40, 77), (40, 90)])  # reactions: all, most, few
def test_either_factor_solves_the_normal_equations(n, rank, norm):
    discs = program(1, norm=norm, n=n, rank=rank)
    discs = replace(discs, node=np.minimum(discs.node, n - 1 - (rank != 80)))  # 3, …, 6 discs a node, or none
    rng, unit = np.random.default_rng(1), discs.cones.unit
    slack, multipliers = (unit + rng.uniform(-0.6, 0.6, len(unit)) / np.sqrt(rank) for _ in range(2))
    scaling, x = discs.cones.scaling(slack, multipliers), rng.normal(size=len(discs.costs))
    in_reactions, _, to_reactions = discs.in_reactions
    assert (in_reactions.tied > 0) == (4 < rank <= 2 * n)  # all columns at once where they are few
    z = to_reactions @ x
    ill = replace(discs, blocks=discs.blocks * np.append(1e-8, np.ones(rank - 1)))
    assert ill.in_reactions[0] is ill
    np.testing.assert_allclose(in_reactions.times(z), discs.times(x), rtol=1e-9, atol=1e-9)
    for given, expected in ((discs, x), (in_reactions, z)):
        right = given.transposed(scaling.divided(scaling.divided(given.times(expected))))
        for factor in (given.normal_equations, given.orthogonal_factor):
            np.testing.assert_allclose(factor(scaling)(right), expected, rtol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_rows_that_are_larger_by_many_orders_are_equations_to_the_others(seed):
    rng = np.random.default_rng(seed)
    small, large, right = (rng.normal(size=size) for size in ((9, 4), (2, 4), 4))
    with_multipliers = np.block([[small.T @ small, large.T], [large, np.zeros((2, 2))]])
    expected = np.linalg.solve(with_multipliers, np.append(right, [0.0, 0.0]))[:4]
    found = _by_orthogonal_factor(np.vstack([small, 2.0**30 * large]))(right)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
