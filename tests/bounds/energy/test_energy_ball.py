"""R(λ): numbers, optimality, what the ball says of a state, and motions from its surface."""

import numpy as np
import pytest
from bounds.energy.joints import strong_joint

import shakedown
from shakedown import energy_ball
from shakedown.motion.evolution import Evolution

RADII = {  # at half of λ_max, in √energy units of the file
    "two-node": 63.31165567,
    "three-node": 3.263428741,
    "block-9": 0.0694897475,
    "block-33": 0.02193297344,
}


@pytest.mark.parametrize("name", RADII)
def test_radius_of_the_examples(name):
    problem = shakedown.example(name)
    ball = energy_ball(problem, 0.5 * shakedown.upper_bound(problem, certify=False).load_factor)
    assert ball.radius == pytest.approx(RADII[name], rel=1e-9)
    assert ball.residual <= 1e-14


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
