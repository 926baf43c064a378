"""λ_E and R(λ) in the plane: numbers, optimality, statuses, intervals, what the ball says of states and motions."""

import numpy as np
import pytest
from bounds.energy.joints import strong_joint

import shakedown
from benchmarks.plain_energy import plainly
from benchmarks.problems import chain, random_problem
from shakedown import Problem, energy_ball, energy_bound
from shakedown.motion.evolution import Evolution

NUMBERS = {  # λ_E, and R at half of λ_max in √energy units, to the digits of an independent computation
    "one-node": (0.9305239948, np.inf),
    "two-node": (0.6619611189, 63.31165567),
    "three-node": (1.4845583487, 3.263428741),
    "block-9": (4.6633908331, 0.0694897475),
    "block-33": (4.7067126363, 0.02193297344),
}


@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_of_the_examples(name):
    problem, (load_factor, radius) = shakedown.example(name), NUMBERS[name]
    bound = energy_bound(problem)
    assert bound.load_factor == pytest.approx(load_factor, rel=1e-9)
    assert bound.residual <= 1e-14
    assert abs(bound.gap) <= 1e-12
    assert bound.load_factor * (1 - 1e-12) <= bound.certified <= bound.load_factor
    assert bound.radius == pytest.approx(np.sqrt(bound.slip @ problem.A @ bound.slip), rel=1e-9, abs=1e-12)
    ball = energy_ball(problem, 0.5 * shakedown.upper_bound(problem, certify=False).load_factor)
    assert ball.radius == pytest.approx(radius, rel=1e-9)
    assert not ball.residual > 1e-14


@pytest.mark.parametrize("seed", [0, 3])
def test_never_above_the_largest_and_falling_with_the_distance(seed):
    problem = strong_joint(seed, 6, floating=seed == 3)
    upper = shakedown.upper_bound(problem, certify=False)
    factors = [energy_bound(problem, upper.slip, d, certify=False).load_factor for d in (0.0, 0.01, 0.1, 0.2)]
    assert factors[0] == pytest.approx(upper.load_factor, rel=1e-9)  # the safe slip itself
    assert factors == sorted(factors, reverse=True)
    assert factors[1] < factors[0]


@pytest.mark.parametrize("make", [random_problem, chain])
def test_many_nodes(make):
    problem = make(60, seed=0)
    bound = energy_bound(problem)
    assert bound.certificate is None  # more than 40 nodes
    assert abs(bound.gap) <= 1e-12
    assert bound.residual <= 1e-14


def test_a_finite_interval():
    problem = Problem(
        A=np.eye(2), B=[[0.0, 0.2], [0.1, 0.0]], C=np.eye(2), f=0.5, q_w=[[0.3, 0.9], [-0.3, -0.9]],
        p_w=[[2.0, 3.0], [2.0, 3.0]], q_mean=[0.0, 0.0], p_mean=[-1.0, 3.0],
    )  # fmt: skip
    bound = energy_bound(problem, [0.5, 0.0])
    least, most = bound.least_load_factor, bound.load_factor
    assert bound.status == "optimal"
    assert 0.4 < least < most
    assert least == pytest.approx(plainly(problem, start=[0.5, 0.0], least=True), rel=1e-6)
    for factor in (least, most):
        ball = shakedown.energy_ball(problem, factor)
        assert ball.status == "optimal"


def test_where_not_even_one_load_step_is_safe_nothing_is_proved():
    jump = shakedown.example("jump")
    for start in (None, jump.initial_slip[0]):
        assert energy_bound(jump, start).status == "infeasible"
    idle = {"q_w": [[1.0, 0.0], [-1.0, 0.0]], "p_w": [[3.0, 0.0], [3.0, 0.0]]}  # node 1 bears nothing
    assert energy_bound(Problem(A=np.eye(2), B=np.zeros((2, 2)), f=0.5, **idle)).status == "infeasible"


def test_a_node_above_its_own_critical_friction_has_its_number():
    """The plane of its limit must not enter the ball: R ≤ distance to the plane."""
    problem = Problem(
        A=[[1.0, 0.0], [0.0, 1.0]], B=[[3.0, 0.0], [0.0, 0.0]], C=20 * np.eye(2), f=0.5,
        q_w=[[0.1, 1.0], [-0.1, -1.0]], p_w=[[3.0, 3.0], [3.0, 3.0]],
    )  # fmt: skip
    bound = energy_bound(problem, [0.0, 0.0], 0.1)
    assert bound.status == "optimal"
    assert bound.load_factor == pytest.approx(1.5, rel=1e-12)  # node 1: Melan; node 0 has slack left
    assert bound.certified == pytest.approx(1.5, rel=1e-9)


def test_a_floating_body_knows_no_position():
    problem = strong_joint(6, 5, floating=True)
    start = np.array([0.1, -0.2, 0.0, 0.3, 0.2])
    here, there = energy_bound(problem, start), energy_bound(problem, start + 5.0)
    assert there.load_factor == pytest.approx(here.load_factor, rel=1e-10)
    np.testing.assert_allclose(there.slip, here.slip, atol=1e-9)  # relative to the pinned node
    assert (there.pinned, here.slip[list(here.pinned)]) == (here.pinned, [0.0])
    np.testing.assert_array_equal(there.initial_slip, start + 5.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1.0],), r"initial slip: expected shape \(2,\), found \(1,\)"),
        (([1.0, np.nan],), "initial slip: expected finite numbers, found nan"),
        ((None, -1.0), r"distance: expected a number >= 0, found -1.0"),
        ((None, 1e300), r"distance: expected reactions below .*, found"),
        (([1e90, 1.0],), r"initial slip: expected reactions below .*, found"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(shakedown.UsageError, match=message):
        energy_bound(shakedown.example("two-node"), *arguments)
    with pytest.raises(shakedown.UsageError, match="problem: expected a Problem"):
        energy_bound(None)


def test_what_the_ball_says_of_a_state():
    problem = strong_joint(1, 3)
    ball = energy_ball(problem, 0.5 * shakedown.upper_bound(problem, certify=False).load_factor)
    rng = np.random.default_rng(0)
    surface = ball.at(rng.normal(size=(40, 3)))
    np.testing.assert_allclose(ball.distance(surface), ball.radius, rtol=1e-12)
    assert not ball.contains(surface).any()  # less than round-off inside
    inside = ball.at(rng.normal(size=(40, 3)), 0.5)
    np.testing.assert_allclose(ball.margin(inside), 0.5 * ball.radius, rtol=1e-12)
    assert ball.contains(inside).all()
    reach = ball.single_node_margin(inside)
    for j in range(3):
        moved = inside + reach[:, None] * np.eye(3)[j]
        assert (ball.distance(moved) <= ball.radius * (1 + 1e-12)).all()
    assert ball.contains(ball.slip)
    assert ball.distance([1e300, 1e300, -1e300]) == np.inf
    assert ball.active


def test_the_radius_falls_to_nothing_at_the_largest_load_factor():
    problem = shakedown.example("two-node")
    most = shakedown.upper_bound(problem).load_factor
    radii = [energy_ball(problem, share * most).radius for share in (0.0, 0.5, 0.9, 0.999)]
    assert radii == sorted(radii, reverse=True)
    assert 0 < radii[-1] < 0.01 * radii[0]
    above = energy_ball(problem, 1.001 * most)
    assert (above.status, above.radius) == ("infeasible", 0.0)
    assert not above.contains(np.zeros(2))
    assert above.margin(np.zeros((4, 2))).tolist() == [-np.inf] * 4
    assert "friction limits" in above.reason


@pytest.mark.parametrize(
    ("seed", "n", "friction", "floating"),
    [(0, 1, 3.0, False), (1, 2, 0.5, False), (2, 3, 1.5, False), (3, 4, 3.0, False), (4, 4, 0.8, True)],
)
def test_no_motion_from_the_surface_leaves_the_ball(seed, n, friction, floating):
    """Also above single-node friction, floating, and from states that the first load does not admit."""
    problem = strong_joint(seed, n, friction=friction, floating=floating)
    load_factor = min(0.9 * shakedown.upper_bound(problem, certify=False).load_factor, 5.0)
    ball = energy_ball(problem, load_factor)
    assert ball.status == ("unbounded" if n == 1 else "optimal")  # one node above its friction wedges
    assert 0 < ball.radius < np.inf
    for start in ball.at(np.random.default_rng(seed).normal(size=(12, ball.metric.root.shape[0])), 1 - 1e-9):
        evolution, distance = Evolution(problem, load_factor, start), ball.distance(start)
        for _ in range(5):
            record = evolution.cycle()
            assert record is not None
            assert not record.opened.any()
            now = ball.distance(evolution.state.u[:n])
            assert now <= distance * (1 + 1e-9)
            distance = now
        assert shakedown.long_term_state(problem, load_factor, start).outcome == "shakedown"


@pytest.mark.parametrize("seed", [0, 3])
def test_the_ball_around_a_state_gives_it_the_largest_margin(seed):
    problem = strong_joint(seed, 5, floating=seed == 3)
    load_factor = 0.95 * shakedown.upper_bound(problem, certify=False).load_factor
    largest = energy_ball(problem, load_factor)
    rank = largest.metric.root.shape[0]
    state = largest.at(np.random.default_rng(seed).normal(size=rank), 0.9)
    ball = energy_ball(problem, load_factor, around=state)
    margin = float(ball.margin(state))
    assert ball.contains(state)
    assert 0.1 * largest.radius <= margin * (1 + 1e-9)
    assert ball.radius <= largest.radius * (1 + 1e-9)
    assert ball.residual <= 1e-13
    there = shakedown.energy_bound(problem, state, margin, certify=False)
    assert there.load_factor == pytest.approx(load_factor, rel=1e-7)  # no larger margin at this load factor


def test_no_ball_around_a_state_too_far_away():
    problem = shakedown.example("three-node")
    ball = energy_ball(problem, 2.6, around=problem.initial_slip[0])  # from here it cycles
    assert (ball.status, ball.radius) == ("infeasible", 0.0)
    assert not ball.contains(problem.initial_slip[0])
    with pytest.raises(shakedown.UsageError, match=r"initial slip: expected shape \(3,\), found \(2,\)"):
        energy_ball(problem, 2.6, around=[0.0, 1.0])
