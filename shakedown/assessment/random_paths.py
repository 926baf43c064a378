"""Other paths through the same loads; statements on a load domain hold for each of them."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from shakedown.ground.argument_kinds import check_count, check_seed, checked
from shakedown.ground.size_limits import MANY
from shakedown.joint.arguments import require_problem
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.texts import LOOP


@checked
def random_paths(problem: Problem, count: int, seed: int = 0) -> Iterator[Problem]:
    """The joint with the samples of its loop in random order, and so on straight ways between any two.

    Where the samples are the corners of a load domain, paths through it. The constant
    part of the loading is kept. λ_1 and λ_max ask for every sample alone: they are the
    same for all of these paths, and below λ_max nothing slips on any of them from the safe
    slip. What becomes of another initial state may depend on the path.

    Parameters
    ----------
    problem
        The joint and its loading; its transient load steps are left out.
    count
        How many paths.
    seed
        Of the random orders.

    Raises
    ------
    UsageError
        If the number of paths or the seed is out of range.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> [round(shakedown.upper_bound(path).load_factor, 6) for path in random_paths(joint, 3)]
    [0.739146, 0.739146, 0.739146]
    """
    require_problem(problem)
    check_count("paths", count, MANY)
    seed = check_seed(seed)
    return _paths(problem, count, seed)


def _paths(problem: Problem, count: int, seed: int) -> Iterator[Problem]:
    generator, loop = np.random.default_rng(seed), loading(problem)
    for _ in range(count):
        order = generator.permutation(problem.m)
        yield replace(
            problem,
            q_w=problem.q_w[order],
            p_w=problem.p_w[order],
            load_history=None if problem.load_history is None else problem.load_history[order],
            q_mean=loop.q0,
            p_mean=loop.p0,
            q_transient=None,
            p_transient=None,
            load_path=LOOP,
        )
