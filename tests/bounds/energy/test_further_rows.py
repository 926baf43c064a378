"""The programs work on any limits: what another kind of condition adds."""

from dataclasses import replace

import numpy as np
import pytest
from bounds.energy.joints import strong_joint

from shakedown import Problem
from shakedown.bounds.energy.ball_limits import BallLimits, Rows, ball_limits
from shakedown.bounds.energy.ball_search import largest_ball, largest_load_factor
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.contact_zone import contact_zone


def limits_of(problem: Problem) -> BallLimits:
    return ball_limits(contact_zone(problem, ()))


def with_condition(limits: BallLimits, slope: np.ndarray, slack: float) -> BallLimits:
    """One more row: slope · v ≤ slack throughout the ball."""
    spread = limits.metric.relative_dual_norms(slope[None], np.zeros(1), DEFAULT)
    one = Rows(
        slope[None],
        (slope @ limits.metric.inverse)[None],
        np.zeros(1),
        np.array([slack]),
        spread,
        *np.zeros((2, 1), dtype=int),
    )
    return replace(limits, rows=limits.rows.followed_by(one))


@pytest.mark.parametrize("seed", range(3))
def test_a_further_row_keeps_its_distance_from_the_ball(seed):
    limits = limits_of(strong_joint(seed, 4))
    plain = largest_ball(limits, 0.5, split=True)
    slope = np.random.default_rng(seed).normal(size=4)
    slack = float(slope @ plain.slip)  # cuts through the centre
    cut = with_condition(limits, slope, slack)
    ball = largest_ball(cut, 0.5, split=True)
    assert 0 < ball.radius < plain.radius
    assert (0, 0) in cut.names(ball.carrying)
    towards = slope @ limits.metric.inverse
    touching = ball.slip + ball.radius * limits.metric.inverse @ towards / np.linalg.norm(towards)
    assert slope @ touching == pytest.approx(slack, rel=1e-9, abs=1e-9)


def test_a_further_row_lowers_the_load_factor():
    limits = limits_of(strong_joint(1, 4))
    start = largest_ball(limits, 0.5, split=True).slip
    plain = largest_load_factor(limits, start, 0.05, DEFAULT, split=True)
    slope = plain.slip - start
    cut = with_condition(limits, slope, float(slope @ start) + 0.5 * float(slope @ slope))
    bound = largest_load_factor(cut, start, 0.05, DEFAULT, split=True)
    assert bound.value < plain.value
    assert abs(bound.gap) <= 1e-9
    assert cut.residual(bound.slip, bound.value, bound.radius) <= 1e-12
