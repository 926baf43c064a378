"""What a verification follows: load factors in every region, states in balls; and what it predicts of them."""

from dataclasses import replace
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


def test_limits_belong_to_the_region_of_which_nothing_else_is_known():
    limits = stated(lower=AT_HALF, upper={"load_factor": 2.0})
    assert (region_of(0.5, limits), region_of(2.0, limits)) == (BETWEEN, BETWEEN)
    zone = stated(lower={"load_factor": 0.3}, upper=ZONE)
    assert [region_of(x, zone) for x in (0.3, 0.4, 2.0)] == [OUTSIDE, IN_ZONE, IN_ZONE]
    assert region_of(0.5, stated(lower={"load_factor": nan}, upper=LATER)) == BETWEEN


@pytest.mark.parametrize("open_nodes", [(0,), (1,)])
def test_below_the_first_collapse_a_zone_that_is_none_contradicts_nothing(open_nodes):
    """Whatever nodes are said to stay open: from closed states shakedown is predicted, and found."""
    two = shakedown.example("two-node")
    report = shakedown.verify(two, open_nodes=open_nodes, load_factors=[0.3], random_states=0)
    assert not report.disagreements
    assert {run.predicted for run in report.runs[1:]} == {"shakedown"}


@pytest.mark.parametrize("region", [UNSAFE, BELOW, PROVED, BETWEEN, ABOVE, IN_ZONE, OUTSIDE, NO_ZONE])
@pytest.mark.parametrize(
    ("about", "proved"),
    [({}, False), ({"initial": "safe"}, True), ({"in_ball": True}, True), ({"bounded": True}, True)],
)
def test_shakedown_is_predicted_of_closed_states_below_and_of_those_that_it_is_proved_of(
    region, about, proved
):
    case = plan.Case(
        **{"region": region, "load_factor": 0.7, "initial": "zero", "start": np.zeros(2)} | about
    )
    moves, rests, either = "slips or opens", "shakedown", "either"
    below = {UNSAFE: moves, ABOVE: moves, NO_ZONE: moves, BELOW: rests, PROVED: rests}
    assert case.predicted == below.get(region, rests if proved else either)
    lifted = replace(case, arrives_closed=False)
    if region in (BELOW, PROVED):
        assert lifted.predicted == (rests if proved else either)
    assert case.only_slips == (region == ABOVE)
    assert not replace(case, load_factor=1.0).only_slips


@pytest.mark.parametrize("name", ["two-node", "two-node-3d"])
def test_states_in_a_ball_are_just_inside_its_surface_or_as_far_away_as_other_states(name):
    limits = shakedown.assess(shakedown.example(name)).details
    (step,) = plan.plan_steps(limits, [0.3], 1, 0)
    starts = {case.initial: case.start for case in step()}
    ball = limits.ball_at(0.3)
    drawn = [starts.pop(name) for name in ("ball 0", "ball 1")]
    reach = max(np.abs(start - ball.slip).max() for start in starts.values())
    for start in drawn:
        assert ball.contains(start)
        outwards = ball.slip + 1.001 * (start - ball.slip)
        assert not ball.contains(outwards) or np.abs(start - ball.slip).max() == pytest.approx(reach)
