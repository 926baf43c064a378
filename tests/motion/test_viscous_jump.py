"""Jumps of chapter VI: the published one, its end for several dampings, its energy; slides that nothing ends."""

import numpy as np
import pytest
from bounds.energy.joints import space_joint
from joints import free_pair, joint_of_kind

import shakedown
from benchmarks.implicit_steps import ImplicitSteps
from shakedown.ground.status import OPEN
from shakedown.ground.work_limit import limited_work
from shakedown.motion.checked_law import Scales, law_violation, scales
from shakedown.motion.course import EventKind
from shakedown.motion.event_history import path_violation
from shakedown.motion.evolution import Evolution, evolve
from shakedown.motion.viscous_jump import Relaxation, ViscousJoint, steady_slide
from tests.joints_in_space import random_joint

FORCE, LENGTH = 1e9, 1e-6


def work_not_stored(kappa, history):
    """What the load puts in on a path, but for what the joint stores."""
    u, r_w = np.hstack([history.v, history.w]), np.hstack([history.q_w, history.p_w])
    begin, end = (u[k] @ (0.5 * (kappa @ u[k]) + r_w[k]) for k in (0, -1))
    return ((u[1:] + u[:-1]) / 2 * np.diff(r_w, axis=0)).sum() - (end - begin)


def test_jump_ends_in_the_published_state_and_balances_the_load_whatever_the_damping(monkeypatch):
    problem, step = shakedown.example("jump"), Relaxation._step
    released, accepted = [], []
    monkeypatch.setattr(Relaxation, "_step", lambda *at: accepted.append(step(*at)) or accepted[-1])
    for damping in (None, [1.0, 1.0, 1.0, 1.0], [1.0, 10.0, 3.0, 0.2], [5.0, 0.3, 0.3, 5.0]):
        run = evolve(problem, 1.0, problem.initial_slip[0], damping=damping)
        assert run.stop is None
        (jump,) = run.cycles[0].jumps
        assert np.hypot(*(jump.v_before - [-20.7269, 30.9051])) < 0.12  # from slightly inside the corner
        assert run.history.v[-1] == pytest.approx([3.5639831, -24.56392242], abs=1e-7)
        assert run.history.w[-1] == pytest.approx([0.0, 3.34427293], abs=1e-7)
        assert list(run.history.state[-1]) == [-1, 2]
        assert 0 < jump.friction_work < jump.energy_released
        released.append(jump.energy_released)
        assert jump.steps == sum(accepted)
        accepted.clear()
    assert released == pytest.approx([released[0]] * len(released), rel=1e-9)
    assert run.cycles[0].dissipation == pytest.approx(work_not_stored(problem.kappa, run.history), rel=1e-6)


def test_cycles_with_jumps_are_periodic():
    """Back and forth across the jump: a limit cycle that jumps in every cycle."""
    jump = shakedown.example("jump")
    load, p_w = np.array([[2.6, 2.0], [2.2, 2.0], [60.0, 2.0]]), np.tile(jump.p_w, (3, 1))
    problem = shakedown.Problem(A=jump.A, B=jump.B, C=jump.C, f=jump.f, q_w=load, p_w=p_w)
    state = shakedown.long_term_state(problem, 1.0, jump.initial_slip[0])
    assert state.outcome != "undecided"
    again = Evolution(problem, 1.0, jump.initial_slip[0])
    assert again.advance(40) == 40
    assert again.method.u[:2] == pytest.approx(state.final_slip, abs=1e-8)


def copies(problem, count, *, one_after_another):
    """Joints beside each other in other units that do not feel each other; the load of copy k falls in step k."""
    beside, n = FORCE / LENGTH * np.eye(count), problem.n
    first, last = FORCE * problem.q_transient[0], FORCE * problem.q_w[0]
    steps = count if one_after_another else 1
    q_w = np.tile(first, (steps + 1, count))
    for k in range(count):
        q_w[k + 1 if one_after_another else 1 :, n * k : n * (k + 1)] = last
    p_w = FORCE * np.tile(problem.p_w[0], (steps + 1, count))
    return shakedown.Problem(
        A=np.kron(beside, problem.A), B=np.kron(beside, problem.B), C=np.kron(beside, problem.C),
        f=np.tile(problem.f, count), q_w=q_w, p_w=p_w, q_mean=q_w[0], p_mean=p_w[0],
        initial_slip=LENGTH * np.tile(problem.initial_slip[0], count),
    )  # fmt: skip


@pytest.mark.parametrize("one_after_another", [True, False])
def test_copies_jump_as_each_would_alone(one_after_another):
    """A jump has nothing to do with those before it in the cycle."""
    problem, count = shakedown.example("jump"), 3
    many = copies(problem, count, one_after_another=one_after_another)
    with limited_work(np.inf) as work:
        alone = evolve(problem, 1.0, problem.initial_slip[0]).cycles[0]
    with limited_work(np.inf) as more:
        run = evolve(many, 1.0, many.initial_slip[0])
    assert run.stop is None
    (cycle,) = run.cycles
    assert len(cycle.jumps) == (count if one_after_another else 1)
    times = [jump.cycle for jump in cycle.jumps]  # as the load pulls them away one after another
    share = alone.jumps[0].cycle * problem.m % 1.0
    assert times == pytest.approx((share + np.arange(len(times))) / many.m, rel=1e-6)
    assert more.taken == pytest.approx(len(cycle.jumps) * count**3 * work.taken, rel=0.02)  # of equations
    released, energy = sum(jump.energy_released for jump in cycle.jumps), count * FORCE * LENGTH
    assert released == pytest.approx(energy * alone.jumps[0].energy_released, rel=1e-9)
    assert cycle.dissipation == pytest.approx(energy * alone.dissipation, rel=1e-9)
    slip = cycle.slip.reshape(count, 2) / LENGTH
    assert slip == pytest.approx(np.tile(alone.slip, (count, 1)), rel=1e-7, abs=1e-9)


def test_eight_nodes_may_jump_one_after_another_within_a_load_step():
    blocks = {key: getattr(shakedown.example("one-node-separation"), key) * np.eye(8) for key in "ABC"}
    q_w = np.repeat([[1.0], [4.0]], 8, axis=1)
    problem = shakedown.Problem(**blocks, f=0.8 - 1e-3 * np.arange(8), q_w=q_w, p_w=np.full((2, 8), 4.0))
    (cycle,) = evolve(problem, 1.0).cycles
    np.testing.assert_allclose([1 + 6 * jump.cycle for jump in cycle.jumps], 4 * problem.f[::-1], rtol=1e-6)


def test_a_body_that_friction_does_not_hold_slides_away():
    """No stiffness against a rigid shift, and more load than friction: there is no equilibrium to jump to."""
    problem = free_pair([0.0, 2.0], C=np.eye(2))
    run = evolve(problem, 1.0)
    assert run.stop.slides_away
    assert "the body slides away" in run.stop.reason
    state = shakedown.long_term_state(problem, 1.0)
    assert (state.outcome, state.slides_away) == ("undecided", True)
    assert shakedown.simulate(problem, 1.0).to_dict()["slides_away"] is True
    lifted = shakedown.Problem(A=[[1.0]], B=[[0.0]], f=0.5, q_w=[[0.0], [0.0]], p_w=[[1.0], [-1.0]])
    other = shakedown.long_term_state(lifted, 1.0)
    assert (other.outcome, other.slides_away) == ("undecided", False)
    assert not evolve(lifted, 1.0).stop.slides_away
    loose = shakedown.Problem(A=[[0.0]], B=[[0.0]], f=0.5, q_w=[[0.0], [2.0]], p_w=[[1.0], [1.0]])
    assert evolve(loose, 1.0).stop.slides_away


def test_random_joints_far_above_their_thresholds():
    """The law at every event, and the energy balance of load, friction and jumps."""
    rng, jumps = np.random.default_rng(0), 0
    for _ in range(80):
        problem = joint_of_kind(rng, "above thresholds")
        run = evolve(problem, 1.0, cycles=3)
        assert run.stop is None
        h, scale = run.history, scales(problem, 1.0)
        assert law_violation(problem.f, h.q, h.p, h.w, np.zeros_like(h.v), scale).max() <= 1e-12
        assert path_violation(problem, 1.0, shakedown.Tolerances(), h) <= 1e-9
        found = [jump for cycle in run.cycles for jump in cycle.jumps]
        assert [jump.cycle for jump in found] == pytest.approx(h.cycle[h.kind == EventKind.JUMPS], rel=1e-12)
        jump = (h.kind[1:] == EventKind.JUMPS)[:, None]
        closed = (h.state[:-1] != OPEN) & (~jump | (h.state[1:] != OPEN))
        way = np.where(closed, np.diff(h.v, axis=0), 0.0)
        slip, exact = sum(cycle.slip for cycle in run.cycles), 1e-12 * scale.length
        np.testing.assert_allclose(slip, np.abs(way).sum(axis=0), rtol=0.0, atol=exact)
        work = sum(cycle.work for cycle in run.cycles) - sum(jump.work for jump in found)
        rubbed = -(way * (h.q[1:] + h.q[:-1]) / 2).sum(axis=0, where=~jump)
        np.testing.assert_allclose(work, rubbed, rtol=0.0, atol=exact * scale.force)
        lost, near = sum(cycle.dissipation for cycle in run.cycles), 1e-7 * scale.force * scale.length
        assert lost == pytest.approx(work_not_stored(problem.kappa, h), abs=near)
        assert all(jump.energy_released > 0 for jump in found)
        jumps += len(found)
    assert jumps > 3


def test_a_body_that_is_not_held_leaves():
    """Two floating nodes lifted by the load: no equilibrium, the evolution says so."""
    problem = free_pair([0.0, 0.0], np.array([[1.0], [-1.0]]), C=np.array([[1.0, -1.0], [-1.0, 1.0]]))
    state = shakedown.long_term_state(problem, 1.0)
    assert (state.outcome, state.period) == ("separation", 0)
    assert "leaves" in state.reason


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
    assert steady_slide(joint, u, -velocity, contact) is None
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
