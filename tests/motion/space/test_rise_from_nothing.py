"""A load that rises from nothing at many nodes, all of them at the apex of their cones."""

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

import shakedown
from benchmarks.implicit_steps import ImplicitSteps
from shakedown.motion.course import EventKind
from shakedown.motion.evolution import evolve
from tests.joints_in_space import random_joint


def rising(rng, n):
    """A joint whose load rises from nothing; pressure pulls some of its nodes apart."""
    problem = random_joint(rng, n)
    transient = np.stack([np.zeros(n), problem.p_w[0] - 3.6 * problem.p_w.min() * rng.integers(0, 2, n)])
    return replace(problem, q_transient=np.stack([np.zeros(2 * n), problem.q_w[0]]), p_transient=transient)


def beside(one, other):
    """Two joints that know nothing of each other as one."""
    joined = {key: block_diag(getattr(one, key), getattr(other, key)) for key in "ABC"}
    for key in ("q_w", "p_w", "q_transient", "p_transient"):
        joined[key] = np.hstack([getattr(one, key), getattr(other, key)])
    return shakedown.Problem(f=np.append(one.f, other.f), **joined)


def test_loads_in_proportion_are_one_implicit_step():
    """No reaction turns on the way, of few nodes or of many."""
    rng = np.random.default_rng(3)
    one, other = rising(rng, 6), rising(rng, 6)
    for joint in (one, other, beside(one, other)):
        path = evolve(joint, 1.0, cycles=1).history
        risen = path.rows(path.kind == EventKind.LOAD_STEP).rows(
            [2]
        )  # after the start and the first of two rows
        step = ImplicitSteps(joint.kappa, joint.f, 2, np.abs(joint.q_transient).max())
        slip = step.follow(np.zeros(2 * joint.n), np.zeros(joint.n), joint.q_transient, joint.p_transient).v[
            -1
        ]
        np.testing.assert_allclose(risen.v[0], slip, rtol=0.0, atol=1e-8 * np.abs(slip).max())
        assert len(set(risen.state[0])) > 1
