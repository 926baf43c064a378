"""Slips that loads of a joint can leave behind."""

from dataclasses import replace

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.conjugate_loads import without_loads
from shakedown.joint.loading import first_load, loop_path
from shakedown.joint.problem import Problem
from shakedown.motion.evolve import evolve

LONGEST_TRANSIENT = 12  # random load steps


def slip_after_transient(
    problem: Problem,
    load_factor: float,
    generator: np.random.Generator,
    *,
    overload: float = 1.0,
    tolerances: Tolerances = DEFAULT,
) -> FloatArray:
    """Slip after a random transient from slip zero, and then the first load of the motion, (dn,) [length].

    The transient has 1 to 12 load steps, each anywhere between two load steps of the loop. A node that is
    open in the end has its displacement; of a body that slides away it is the slip up to there, and none of
    one that nothing holds.

    Parameters
    ----------
    problem, load_factor
        The joint and λ.
    generator
        Of the random numbers.
    overload
        How many times λ the load factor of the transient is.
    tolerances
        Those of the motion.

    Examples
    --------
    >>> import shakedown
    >>> joint, generator = shakedown.example("two-node"), np.random.default_rng(0)
    >>> slip_after_transient(joint, 0.7, generator, overload=2.0).shape
    (2,)
    """
    split, loop = problem.layout.split, loop_path(problem, overload * load_factor)
    ends = loop[generator.integers(problem.m, size=(2, generator.integers(1, LONGEST_TRANSIENT + 1)))]
    share = generator.random((ends.shape[1], 1))
    before_q, before_p = split(ends[0] + share * (ends[1] - ends[0]))
    q, p = split(first_load(problem, load_factor))
    passed = replace(
        without_loads(problem),
        q_w=q[None],
        p_w=p[None],
        q_mean=q,
        p_mean=p,
        initial_slip=None,
        q_transient=before_q,
        p_transient=before_p,
    )
    slips = evolve(passed, 0.0, tolerances=tolerances).history.v
    return np.asarray(slips[-1]) if len(slips) else np.zeros(problem.layout.slip_size)
