"""What a verification follows: load factors in every region, states in balls; and what it predicts of them."""

from math import inf, nan

import numpy as np
import pytest
from stated_limits import stated

import shakedown
from shakedown.assessment import plan
from shakedown.assessment.plan import (
    ABOVE,
    BELOW,
    BETWEEN,
    IN_ZONE,
    NO_ZONE,
    OUTSIDE,
    PROVED,
    UNSAFE,
    region_of,
)

UNBOUNDED = {"load_factor": inf, "status": "unbounded"}
LATER = {"load_factor": 2.0, "least_load_factor": 0.5}
ZONE = {"load_factor": 2.0, "least_load_factor": 0.4, "open_nodes": (1,)}
AT_HALF = {"load_factor": 0.5}


@pytest.mark.parametrize(
    ("bounds", "followed"),
    [
        ({"lower": AT_HALF, "upper": {"load_factor": 2.0}}, {0.475: BELOW, 0.95: BETWEEN, 2.1: ABOVE}),
        ({"lower": AT_HALF, "upper": {"load_factor": 0.500045}}, {0.475: BELOW, 0.52504725: ABOVE}),  # alike
        ({"lower": AT_HALF, "upper": {"load_factor": 0.50006}}, {0.475: BELOW, 0.500018: BETWEEN, 0.525063: ABOVE}),
        ({"lower": AT_HALF, "upper": UNBOUNDED}, {0.475: BELOW, 0.75: BETWEEN}),
        ({"lower": {"load_factor": inf}, "upper": UNBOUNDED}, {1.0: BELOW, 10.0: BELOW}),
        ({"lower": {"load_factor": 0.0}, "upper": {"load_factor": 0.0}}, {1.0: ABOVE}),
        ({"lower": {"load_factor": nan}, "upper": LATER}, {0.475: UNSAFE, 0.95: BETWEEN, 2.1: ABOVE}),
        ({"lower": {"load_factor": nan}, "upper": LATER | UNBOUNDED}, {0.475: UNSAFE, 0.75: BETWEEN}),
        ({"lower": {"load_factor": nan}, "upper": {"status": "infeasible"}}, {1.0: NO_ZONE}),
        ({"lower": {"load_factor": nan}, "upper": {"status": "infeasible"}, "zone": ()}, {1.0: ABOVE}),
        ({"lower": {"load_factor": nan}, "upper": {"status": "undecided"}}, {1.0: OUTSIDE}),
        ({"lower": AT_HALF, "upper": ZONE}, {0.475: BELOW, 1.2: IN_ZONE, 1.9984: IN_ZONE, 2.1: OUTSIDE}),
        ({"lower": AT_HALF, "upper": ZONE | UNBOUNDED}, {0.475: BELOW, 0.6: IN_ZONE}),
        ({"lower": {"load_factor": nan}, "upper": ZONE | UNBOUNDED | {"least_load_factor": 0.0}}, {1.0: IN_ZONE}),
        ({"name": "two-node-3d", "universal": {"load_factor": 0.0}, "energy": AT_HALF, "upper": {"load_factor": 2.0}},
         {0.475: BETWEEN, 0.95: BETWEEN, 2.1: ABOVE}),
        ({"name": "two-node-3d", "universal": AT_HALF, "upper": {"load_factor": 2.0}},
         {0.475: PROVED, 0.95: BETWEEN, 2.1: ABOVE}),
    ],
)  # fmt: skip
def test_one_load_factor_is_followed_a_little_inside_of_every_region(bounds, followed):
    limits = stated(**bounds)
    factors = plan.default_load_factors(limits)
    assert factors == pytest.approx([*followed], rel=1e-12)
    assert [region_of(factor, limits) for factor in factors] == [*followed.values()]


@pytest.mark.parametrize("open_nodes", [(0,), (1,)])
def test_below_the_first_collapse_a_zone_that_is_none_contradicts_nothing(open_nodes):
    """Whatever nodes are said to stay open: from closed states shakedown is predicted, and found."""
    two = shakedown.example("two-node")
    report = shakedown.verify(two, open_nodes=open_nodes, load_factors=[0.3], random_states=0)
    assert not report.disagreements
    assert {run.predicted for run in report.runs[1:]} == {"shakedown"}


@pytest.mark.parametrize("name", ["two-node", "two-node-3d"])
def test_states_in_a_ball_are_just_inside_its_surface_or_as_far_away_as_other_states(name):
    limits = shakedown.assess(shakedown.example(name)).details
    (step,) = plan.plan_steps(limits, [0.3], 1, 0)
    starts = {case.initial: case.start for case in step()}
    ball = limits.ball_at(0.3)
    drawn = [starts.pop(name) for name in list(starts) if name.startswith("ball")]
    assert len(drawn) == 2
    reach = max(np.abs(start - ball.slip).max() for start in starts.values())
    for start in drawn:
        assert ball.contains(start)
        outwards = ball.slip + 1.001 * (start - ball.slip)
        assert not ball.contains(outwards) or np.abs(start - ball.slip).max() == pytest.approx(reach)
