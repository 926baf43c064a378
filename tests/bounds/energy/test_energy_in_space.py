"""λ_E and R(λ) with two tangential directions: numbers, conditions, shares, zones, transients, statuses."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from bounds.energy.joints import gammas, space_joint
from joints_in_space import embedded

import shakedown
from benchmarks.refinement import brick
from shakedown import Problem, energy_ball, energy_bound
from shakedown.bounds.energy.ball_limits import ball_limits, pressed_limits
from shakedown.bounds.energy.energy_ball import closed_radius, no_ball_holds
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.constraints import loading
from shakedown.joint.contact_zone import contact_zone

# λ_max, then λ_E from slip zero and R at half λ_max with c = 0, and λ_E with half of A_ii⁻¹ B_ii, from an
# independent computation.
NUMBERS = {
    "one-node-3d": (1.251732445097, 1.227253988458, 2.337451324026, 1.236273694265),
    "two-node-3d": (0.881085157837, 0.822301119853, 1.976757365817, 0.829089420041),
    "four-node-3d": (1.224961698973, 1.029447314668, 2.082820066996, 1.045380415637),
    "block-3x3": (2.784608340022, 1.895402011930, 1.113627187483, 2.190426015885),
}


@cache
def bound_of(name):
    return energy_bound(shakedown.example(name), certify=False)


@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_of_the_examples(name):
    problem, (most, zero, radius, half) = shakedown.example(name), NUMBERS[name]
    bound = energy_bound(problem, split=False, certify=False)
    assert bound.load_factor == pytest.approx(zero, rel=1e-9)
    assert bound.residual <= 1e-14
    assert abs(bound.gap) <= 1e-12
    assert bound.radius == pytest.approx(np.sqrt(bound.slip @ problem.A @ bound.slip), rel=1e-12)
    np.testing.assert_array_equal(bound.share, 0.0)
    ball = energy_ball(problem, 0.5 * most, split=False)
    assert ball.radius == pytest.approx(radius, rel=1e-9)
    assert ball.residual <= 1e-14
    split = bound_of(name)
    assert half < split.load_factor < most
    assert split.residual <= 1e-14
    assert abs(split.gap) <= 1e-12
    assert energy_ball(problem, 0.5 * most).radius > radius


@pytest.mark.parametrize("coupling", [1.0, 1e-8])
def test_a_ball_holds_a_state_below_its_load_factor_however_large_it_may_be(coupling):
    """Slip next to no pressure: balls many orders larger than what friction holds."""
    joint = space_joint(1, 3)
    problem = replace(joint, B=coupling * joint.B)
    start, proved = np.zeros(6), energy_bound(problem, certify=False).load_factor
    for share in (0.5, 0.99):
        assert energy_ball(problem, share * proved, around=start).contains(start)
    assert not energy_ball(problem, 1.01 * proved, around=start).contains(start)


def least_slack(problem: Problem, bound) -> float:
    """The least of f p − a |q| − f γ R over all nodes and load steps, from the matrices."""
    loop, f = loading(problem), problem.f
    q = loop.q0 + bound.load_factor * loop.q1 + problem.A @ bound.slip
    p = loop.p0 + bound.load_factor * loop.p1 + problem.B @ bound.slip
    stretch = np.sqrt(1 + f**2 * (bound.share**2).sum(axis=1))
    size = np.hypot(q[:, ::2], q[:, 1::2])
    return float((f * p - stretch * size - f * gammas(problem, bound.share) * bound.radius).min())


def test_the_conditions_hold_at_what_is_reported():
    problem = space_joint(0, 3)
    start = energy_ball(problem, 0.0).slip + 0.05 * np.random.default_rng(0).normal(size=6)
    bound = energy_bound(problem, start, 0.02, certify=False)
    assert bound.status == "optimal"
    assert np.all(problem.f * np.hypot(*bound.share.T) < 1)
    assert least_slack(problem, bound) >= -1e-13 * np.abs(problem.p_w).max()
    e = bound.slip - start
    assert bound.radius == pytest.approx(np.sqrt(e @ problem.A @ e) + 0.02, rel=1e-12)
    ball = energy_ball(problem, 0.5 * bound.load_factor, around=start)
    assert ball.contains(start)
    assert least_slack(problem, ball) >= -1e-13 * np.abs(problem.p_w).max()
    assert ball.margin(start) >= energy_ball(
        problem, 0.5 * bound.load_factor, around=start, split=False
    ).margin(start)


def test_load_in_one_direction():
    """The split of the plane takes no toll from the tangential reaction: c = 0 is below it, and here is a bound."""
    plane = shakedown.example("block-9")
    space = embedded(plane)
    zero, split = energy_bound(space, split=False, certify=False), energy_bound(space, certify=False)
    np.testing.assert_allclose(split.slip[1::2], 0.0, atol=1e-9 * np.abs(split.slip).max())
    assert zero.load_factor < split.load_factor < energy_bound(plane).load_factor


def test_the_example_of_a_jump_in_a_ball():
    """Inside a ball with a share the rates of slip may have no solution (docs/energy.md, Theorem 5)."""
    still = {"q_w": np.zeros((3, 2)), "p_w": np.ones((3, 1))}
    node = Problem(A=np.diag([1.0, 10.0]), B=[[0.0, 9.0]], C=[[9.0]], f=1.0, **still)
    ball = energy_ball(node, 0.0)
    np.testing.assert_allclose(ball.share, [[0.0, 0.9]])
    assert ball.inner_radius < ball.radius == pytest.approx(1 / np.sqrt(8.1))  # so far all pressures last


def test_a_ball_with_shares_is_so_small_that_no_jump_opens_a_node():
    joint = brick(4, 0.3)
    bound, plain = energy_bound(joint), energy_bound(joint, split=False)
    assert bound.load_factor > 2.5 * plain.load_factor
    loads = {"q_w": [[0.1, -0.13], [0.1, 0.0], [-0.2, 0.13]], "p_w": [[1.45], [1.55], [1.7]], "p_mean": [1.0]}
    node = Problem(A=np.diag([1.0, 10.0]), B=[[-0.4, -2.0]], C=[[9.0]], f=0.3, q_mean=[0.0, 0.0], **loads)
    small = energy_bound(node, [-0.3, -0.25], 0.6)  # the mean load presses the node least
    for each, ball in ((node, small), (joint, bound), (joint, bound.certificate)):
        metric = ball_limits(contact_zone(each, ())).metric
        assert ball.radius < closed_radius(each, metric, ball.slip, (0.0, ball.load_factor))
    assert closed_radius(replace(joint, B=0.0 * joint.B), metric, bound.slip, (0.0,)) == np.inf
    state = shakedown.long_term_state(joint, 0.999 * bound.load_factor)
    assert (state.outcome, state.open_nodes) == ("shakedown", ())


@pytest.mark.parametrize("size", [0.4, 0.5])
def test_a_ball_around_a_state_holds_it_or_there_is_none(size):
    joint, state = space_joint(2, 1, m=4, friction=1.2), size * np.array([-0.41, -2.44])
    ball = energy_ball(replace(joint, B=4.0 * joint.B, C=16.0 * joint.C), 0.3, around=state)
    assert (ball.status == "optimal", ball.contains(state)) == (size < 0.45, size < 0.45)


@pytest.mark.parametrize("seed", range(2))
def test_no_ball_is_refuted_that_the_energy_bound_finds(seed):
    """Where λ_E proves a state a ball holds it; above λ_E one program tells that none does."""
    problem = space_joint(seed, 2 + seed % 2)
    generator = np.random.default_rng(seed)
    base = energy_bound(problem, certify=False)
    for size in (0.0, 0.3, 1.0):
        state = base.slip + size * generator.normal(size=2 * problem.n)
        bound = energy_bound(problem, state, certify=False)
        assert bound.status == "optimal"
        assert not no_ball_holds(problem, bound.load_factor * (1 - 1e-9), state, (), DEFAULT)
        for times in (1.1, 2.0):
            assert no_ball_holds(problem, times * bound.load_factor, state, (), DEFAULT)


def test_open_nodes_keep_their_gap():
    """Every state of the ball of a zone leaves the open node open: the gap row, checked in the whole joint."""
    problem = space_joint(7, 4)
    opened = replace(problem, p_w=problem.p_w - 9.0 * (np.arange(4) == 2))
    zone = contact_zone(opened, [2])
    ball = energy_ball(opened, 0.3, open_nodes=[2])
    assert (ball.open_nodes, ball.status) == ((2,), "optimal")
    rng, loads = np.random.default_rng(0), loading(opened).at(0.3)
    for _ in range(200):
        state = ball.at(rng.normal(size=6), 1 - 1e-9)
        u = zone.displacements(state[opened.layout.slips_of(zone.closed_nodes)], *loads)
        assert np.all(u[:, opened.layout.gaps][:, 2] > 0)
    bound = energy_bound(opened, ball.slip, open_nodes=[2])
    assert bound.load_factor > 0.3
    assert bound.residual <= 1e-13
    assert np.all(np.isin([node for node, _ in bound.active], range(4)))
    assert energy_bound(opened, ball.slip).status == "infeasible"


def test_transient_steps_are_further_ones_without_load_factor():
    problem = space_joint(2, 3)
    middle, loop = energy_ball(problem, 0.0).slip, loading(problem)

    def bound(q, p):
        before = replace(problem, q_transient=q, p_transient=p)
        return energy_bound(before, middle, split=False, certify=False)

    plain = bound(None, None).load_factor
    for q, p in ((loop.q0[None], loop.p0[None]), loop.at(0.9 * plain)):
        assert bound(q, p).load_factor == pytest.approx(plain, rel=1e-9)
    q, p = loop.at(1.1 * plain)
    harder = bound(q, p)
    assert harder.status == "infeasible" or harder.load_factor < plain
    ball = energy_ball(replace(problem, q_transient=q, p_transient=p), 0.1, transient=False, split=False)
    assert ball.radius == pytest.approx(energy_ball(problem, 0.1, split=False).radius, rel=1e-9)


def test_limits_that_hold_below_a_load_factor_do_so_with_their_shares():
    """With p = f p = 1 − λ and q = 0.9 (λ − 1): at λ = 1 both vanish, and a |q| > f p below where a > 1 / 0.9."""
    loads = {"q_w": [[0.9, 0.0]], "p_w": [[0.0]], "q_mean": [0.0, 0.0], "p_mean": [1.0]}
    joint = Problem(A=2.0 * np.eye(2), B=[[0.0, 0.0]], f=1.0, **loads)
    limits, slip, found = ball_limits(contact_zone(joint, ())), np.array([-0.45, 0.0]), []
    for share in (0.0, 0.9):
        shared = limits.shared(np.array([[share, 0.0]]))
        assert shared.slack(slip, 1.0) == pytest.approx(0.0, abs=1e-15)
        found.append(bool((shared.slack(slip, 0.0) >= 0).all()))
        assert shared.hold_below == found[-1]
    assert found == [True, False]


@pytest.mark.parametrize("varying", [1.0, 0.0])
def test_the_rows_of_pressures_are_the_least_ones_of_the_loop_and_of_the_constant_load(varying):
    joint, slip = space_joint(1, 3), np.random.default_rng(0).normal(size=6)
    mean = joint.p_w.mean(axis=0)
    problem = replace(
        joint, p_w=mean + varying * (joint.p_w - mean), q_transient=[[0.0] * 6], p_transient=[mean - 1.0]
    )
    limits = ball_limits(contact_zone(problem, ()))
    rows = pressed_limits(limits, problem).rows
    for load_factor in (0.0, 0.7):
        found = (rows.g - rows.G @ slip - load_factor * rows.d)[: len(rows.g) - len(limits.rows.g)]
        of_loop = loading(problem).at(load_factor)[1].min(axis=0)
        constant = np.minimum(loading(problem).p0, problem.p_transient[0])
        assert found == pytest.approx(np.append(of_loop, constant) + np.tile(problem.B @ slip, 2))
