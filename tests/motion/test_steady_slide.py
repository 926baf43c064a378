"""Rigid slides that nothing ends: told after few steps, and right by the law for ever."""

import numpy as np
import pytest
from bounds.energy.joints import space_joint

import shakedown
from benchmarks.implicit_steps import ImplicitSteps
from shakedown.motion.checked_law import Scales, law_violation
from shakedown.motion.evolution import Evolution
from shakedown.motion.viscous_jump import Relaxation, ViscousJoint, steady_slide
from tests.joints_in_space import random_joint


def viscous_slide(problem, load):
    """The joint under a constant load, and a slide that is near the one it tends to, by small implicit steps."""
    n, D = problem.n, np.diag(problem.kappa)
    law, scale = problem.law, Scales(float(np.abs(load).max()), 1.0)
    joint = ViscousJoint(problem.kappa, law, load, D, scale)
    u, velocity, dt = np.zeros(3 * n), np.zeros(3 * n), 0.1
    steps = ImplicitSteps(problem.kappa + np.diag(D / dt), problem.f, 2, scale.force)
    for _ in range(600):
        q, p = (np.tile(part, (2, 1)) for part in problem.layout.split(load - D / dt * u))
        found = steps.follow(*problem.layout.split(u), q, p)
        after = problem.layout.joined(found.v[-1], found.w[-1])
        u, velocity = after, (after - u) / dt
    return joint, u, velocity


@pytest.mark.parametrize("seed", range(4))
def test_the_slide_is_the_one_that_small_steps_tend_to_and_the_law_holds_for_ever(seed):
    problem = space_joint(seed, 4, floating=True)
    load = problem.layout.joined(np.tile([6.0, 2.0], 4) * problem.p_w[0].max(), problem.p_w[0])
    joint, u, velocity = viscous_slide(problem, load)
    contact = np.where(u[problem.layout.gaps] > 0.0, 2, 1)
    slide = steady_slide(joint, u, velocity, contact)
    assert slide is not None
    begun, speed = slide
    np.testing.assert_allclose(speed, velocity, atol=1e-5 * np.abs(velocity).max())
    for later in (0.0, 1e3):
        state = begun + later * speed
        q, p = problem.layout.split(load + problem.kappa @ state + joint.damping * speed)
        slip, gap = speed[problem.layout.slips], state[problem.layout.gaps]
        assert law_violation(problem.f, q, p, gap, slip, joint.scale).max() <= 1e-9


def test_a_joint_that_is_held_has_no_slide():
    problem = random_joint(np.random.default_rng(1), 3)
    load = 9.0 * problem.p_w[0].max() * np.ones(9)
    joint = ViscousJoint(problem.kappa, problem.law, load, np.ones(9), Scales(1.0, 1.0))
    assert steady_slide(joint, np.zeros(9), np.ones(9), np.ones(3, dtype=int)) is None


@pytest.mark.parametrize("unit", [1.0, 2.0**30])
def test_a_jump_that_slides_for_ever_ends_in_few_steps(monkeypatch, unit):
    steps, step = [], Relaxation._step
    monkeypatch.setattr(Relaxation, "_step", lambda *at: steps.append(at) or step(*at))
    problem = space_joint(3, 3, floating=True)
    scaled = {key: unit * getattr(problem, key) for key in "ABC"}
    push = problem.q_w.copy()
    push[1:] += 8.0 * problem.p_w.max()
    motion = Evolution(shakedown.Problem(f=problem.f, q_w=push, p_w=problem.p_w, **scaled), 1.0)
    while motion.stop is None:
        motion.cycle()
    assert motion.stop.slides_away
    assert 0 < len(steps) < 300
