"""Programs in the reactions of nodes: the same coefficients, the same normal equations, the same ends."""

from dataclasses import replace

import numpy as np
import pytest

from shakedown.ground.status import Status
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.self_dual import solve_self_dual


def program(rank: int, *, norm: bool, seed: int = 4) -> DiscProgram:
    """The largest w_1 over the discs of four nodes and two rows: safe at the origin."""
    rng = np.random.default_rng(seed)
    n, K = 4, 12
    right = rng.normal(size=(K, 3))
    right[:, 0] = np.hypot(right[:, 1], right[:, 2]) + rng.uniform(0.5, 1.0, K)
    extra = rng.normal(size=(K, 3, 2))
    extra[:, 0, 0], extra[:, 1:, 0] = 0.3, 0.0
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
@pytest.mark.parametrize("rank", [8, 5])
def test_ends_are_the_same(rank, norm):
    discs = program(rank, norm=norm)
    one, two = solve_self_dual(discs), solve_self_dual(replace(discs, reactions_from=1))
    assert one.status == two.status == Status.OPTIMAL
    np.testing.assert_allclose(one.x[-1], two.x[-1], rtol=1e-9)


def test_reactions_that_say_nearly_the_same_are_no_unknowns():
    discs = program(8, norm=False)
    blocks = discs.blocks.copy()
    blocks[0, 1] = blocks[1, 1] + 1e-9 * blocks[0, 1]
    assert not replace(discs, blocks=blocks, reactions_from=1).in_reactions


def test_a_program_that_differs_little_shares_the_way_to_its_end():
    discs = program(8, norm=True)
    other = replace(discs, blocks=discs.blocks * (1.0 + 1e-6))
    first, alone = solve_self_dual(discs), solve_self_dual(other)
    shared = solve_self_dual(other, begun=first.path)
    assert shared.path[0] is first.path[0]
    np.testing.assert_allclose(shared.x[-1], alone.x[-1], rtol=1e-9)


def test_a_program_that_differs_much_goes_its_own_way():
    discs = program(8, norm=True)
    other = program(8, norm=True, seed=6)
    shared, alone = solve_self_dual(other, begun=solve_self_dual(discs).path), solve_self_dual(other)
    assert shared.status == alone.status
    np.testing.assert_allclose(shared.x[-1], alone.x[-1], rtol=1e-9)
