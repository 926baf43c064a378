"""A node that closes has no pressure yet: where round-off decides in which direction it slips, the motion goes on."""

import numpy as np
import pytest

from benchmarks.implicit_steps import ImplicitSteps
from benchmarks.space_verdicts import KINDS, random_joint
from shakedown.motion.checked_law import law_resolution, law_violation, scales
from shakedown.motion.course import EventKind
from shakedown.motion.evolution import Evolution

LOAD_FACTOR = 0.9776574724999321


def stiff_and_soft(seed, number):
    kind = "stiff and soft"
    return random_joint(np.random.default_rng([seed, KINDS.index(kind), number]), kind, 4)


@pytest.fixture(scope="module")
def passed():
    """A cycle in which a soft node closes while all slip."""
    motion = Evolution(stiff_and_soft(18, 1), LOAD_FACTOR)
    assert motion.cycle(record=True) is not None
    return motion


def test_the_law_holds_on_the_way(passed):
    problem, h = passed.problem, passed.history
    violation = law_violation(
        problem.f, h.q, h.p, h.w, np.zeros_like(h.v), scales(problem, passed.load_factor)
    )
    assert violation.max() <= law_resolution(problem, passed.tolerances)


def test_small_implicit_steps_reach_the_same_state(passed):
    problem, h = passed.problem, passed.history
    first = int(np.flatnonzero(h.kind == EventKind.CLOSES)[-1])
    last = first + int(np.flatnonzero(h.kind[first:] == EventKind.LOAD_STEP)[0])
    joint = ImplicitSteps(problem.kappa, problem.f, 2, passed.scale.force)
    ends = [first, last]
    steps = joint.follow(h.v[first], h.w[first], h.q_w[ends], h.p_w[ends], parts=400)
    way = np.abs(h.v[last] - h.v[first]).max()
    np.testing.assert_allclose(h.v[last], steps.v[-1], rtol=0.0, atol=1e-3 * way)


def test_a_node_that_sticks_does_not_leave_its_cone():
    """Step by step it was allowed to be a little further outside: 9e-6 in the end, of a pressure of 2e-6."""
    motion = Evolution(stiff_and_soft(22, 2), 1.8901743697598445)
    assert motion.advance(544) == 544
    for _ in range(4):
        assert motion.cycle(record=True) is not None
    problem, h = motion.problem, motion.history
    violation = law_violation(
        problem.f, h.q, h.p, h.w, np.zeros_like(h.v), scales(problem, motion.load_factor)
    )
    assert violation.max() <= 1e-8
