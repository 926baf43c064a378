"""A load that rises from nothing at many nodes, all of them at the apex of their cones."""

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

import shakedown
from shakedown.motion.evolution import Evolution
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


def test_many_nodes_reach_what_few_nodes_reach_one_after_the_other():
    rng = np.random.default_rng(3)
    one, other = rising(rng, 6), rising(rng, 6)
    found = [Evolution(joint, 1.0) for joint in (one, other, beside(one, other))]
    assert [motion.advance(1) for motion in found] == [1, 1, 1]
    alone = np.concatenate([motion.state.contact for motion in found[:2]])
    np.testing.assert_array_equal(found[2].state.contact, alone)
    slips = np.concatenate([motion.state.u[motion.problem.layout.slips] for motion in found[:2]])
    together = found[2].state.u[found[2].problem.layout.slips]
    np.testing.assert_allclose(together, slips, rtol=0.0, atol=1e-7 * np.abs(slips).max())
    assert len(set(alone)) > 1
