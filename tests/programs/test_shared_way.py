"""A program that begins on the way to the end of another one."""

from dataclasses import replace

import numpy as np

from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.self_dual import solve_self_dual


def program(seed: int = 4) -> DiscProgram:
    """The largest w_1 over the discs of four nodes and two rows: safe at the origin."""
    rng = np.random.default_rng(seed)
    n, K = 4, 12
    right = rng.normal(size=(K, 3))
    right[:, 0] = np.hypot(right[:, 1], right[:, 2]) + rng.uniform(0.5, 1.0, K)
    extra = rng.normal(size=(K, 3, 2))
    extra[:, 0, 0], extra[:, 1:, 0] = 0.3, 0.0
    return DiscProgram(
        blocks=rng.normal(size=(n, 3, 8)),
        node=rng.permutation(np.arange(K) % n),
        extra=extra,
        right=right,
        rows=np.vstack([rng.normal(size=(2, 8)), np.zeros((2, 8))]),
        rows_extra=np.array([[0.0, 0.1], [0.1, 0.0], [-1.0, 0.0], [0.0, 1.0]]),
        rows_right=np.array([1.0, 2.0, 0.0, 9.0]),
        cost=np.array([0.0, -1.0]),
        norm=np.array([1.0, 0.0]),
        offset=0.1,
    )


def test_a_program_that_differs_little_shares_the_way_to_its_end():
    discs = program()
    other = replace(discs, blocks=discs.blocks * (1.0 + 1e-6))
    first, alone = solve_self_dual(discs), solve_self_dual(other)
    shared = solve_self_dual(other, begun=first.path)
    assert shared.path[0] is first.path[0]
    np.testing.assert_allclose(shared.x[-1], alone.x[-1], rtol=1e-9)


def test_a_program_that_differs_much_goes_its_own_way():
    discs = program()
    other = program(seed=6)
    shared, alone = solve_self_dual(other, begun=solve_self_dual(discs).path), solve_self_dual(other)
    assert shared.status == alone.status
    np.testing.assert_allclose(shared.x[-1], alone.x[-1], rtol=1e-9)
