"""A load that rises from nothing at many nodes, all of them at the apex of their cones."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.implicit_steps import ImplicitSteps
from shakedown.motion.course import EventKind
from shakedown.motion.evolution import evolve
from tests.joints_in_space import random_joint


def rising(rng, n):
    """A joint whose load rises from nothing; pressure pulls some of its nodes apart."""
    problem = random_joint(rng, n)
    transient = np.stack([np.zeros(n), problem.p_w[0] - 3.6 * problem.p_w.min() * rng.integers(0, 2, n)])
    return replace(problem, q_transient=np.stack([np.zeros(2 * n), problem.q_w[0]]), p_transient=transient)


@pytest.mark.parametrize("n", [3, 6, 12])
def test_loads_in_proportion_are_one_implicit_step(n):
    """No reaction turns on the way, of few nodes or of many."""
    joint = rising(np.random.default_rng(0), n)
    path = evolve(joint, 1.0, cycles=1).history
    risen = path.rows(path.kind == EventKind.LOAD_STEP).rows([2])  # after the start and the first of two rows
    step = ImplicitSteps(joint.kappa, joint.f, 2, np.abs(joint.q_transient).max())
    slip = step.follow(np.zeros(2 * n), np.zeros(n), joint.q_transient, joint.p_transient).v[-1]
    np.testing.assert_allclose(risen.v[0], slip, rtol=0.0, atol=1e-8 * np.abs(slip).max())
    assert len(set(risen.state[0])) > 1
