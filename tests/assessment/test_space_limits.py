"""The limits of joints with two tangential directions: what there is none of, and which states λ_U is about."""

from functools import cache

import numpy as np
import pytest
from joints_in_space import random_joint

import shakedown
from shakedown.assessment.every_limit import admitted_up_to
from shakedown.ground.errors import Missing
from shakedown.joint.constraints import loading

JOINT = shakedown.example("two-node-3d")


@cache
def assessed(name):
    return shakedown.assess(shakedown.example(name))


def test_what_the_plane_alone_has_is_missing_with_the_reason():
    limits = assessed("two-node-3d").details
    for found in (limits.lower, limits.friction):
        assert isinstance(found, Missing)
        assert not found
        assert "expected one tangential direction, found two (" in found.reason
    assert set(limits.sensitivities) == {"upper", "energy"}
    with pytest.raises(shakedown.UsageError) as refused:
        shakedown.lower_bound(JOINT)
    assert str(refused.value) == limits.lower.reason


@pytest.mark.parametrize("seed", range(5))
def test_the_first_load_step_admits_a_slip_up_to_where_it_is_on_its_cone(seed):
    rng = np.random.default_rng(seed)
    problem = random_joint(rng, 3, pressure=3.0, m=int(rng.integers(1, 6)))
    slip, loop = 0.03 * rng.normal(size=6), loading(problem)

    def outside(load_factor):
        q = loop.q0 + load_factor * loop.q1[0] + problem.A @ slip
        p = loop.p0 + load_factor * loop.p1[0] + problem.B @ slip
        return (np.hypot(*q.reshape(-1, 2).T) - problem.f * p).max()

    limit = admitted_up_to(problem, slip)
    if limit == 0.0:
        assert outside(0.0) > 0
    elif np.isfinite(limit):
        assert outside(limit) == pytest.approx(0.0, abs=1e-9 * (1 + limit))
        assert outside(0.999 * limit) < 0 < outside(1.001 * limit)
    else:
        assert outside(1e6) <= 1e-6


def test_a_load_factor_within_the_enclosure_of_the_largest_is_not_said_to_be_impossible():
    """Node 1 has no friction, and its pressure 1 + λ cos t ends at λ = 1: λ_max is 1 but for round-off."""
    turn = 2 * np.pi * np.arange(8) / 8
    B = np.zeros((2, 4))
    B[[0, 1], [0, 2]] = 0.3
    joint = shakedown.Problem(
        A=2 * np.eye(4),
        B=B,
        C=2 * np.eye(2),
        f=[0.5, 0.0],
        q_w=np.outer(np.cos(turn), [0.04, 0.0, 0.0, 0.0]),
        p_w=np.column_stack([np.ones(8), 1.0 + np.cos(turn)]),
    )
    found = shakedown.assess(joint)
    low, high = found.details.upper.certified
    assert low <= 1.0 <= high
    assert found.impossible_above == max(high, found.details.upper.load_factor) >= 1.0
    assert found.verdict == "open"


def test_where_a_body_begins_to_slide_away_is_found_to_all_digits():
    one, t = np.eye(2), 2 * np.pi * np.arange(8) / 8
    q = np.zeros((8, 4))
    q[:, 0], q[:, 2] = 0.4 + 0.1 * np.cos(t), 0.3 + 0.2 * np.cos(t)
    free = np.block([[one, -one], [-one, one]])
    joint = shakedown.Problem(
        A=free, B=np.zeros((2, 4)), C=one, f=0.5, q_w=q, p_w=np.ones((8, 2))
    )  # friction 0.5 · 2 holds 0.7 + 0.3 λ
    limit = shakedown.transient_limit(joint)
    assert limit.at_high.slides_away
    assert limit.low <= 1.0 <= limit.high <= limit.low + 1e-8
