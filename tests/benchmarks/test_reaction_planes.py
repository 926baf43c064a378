"""What the pictures of chapters IV and V are drawn from (``benchmarks.reaction_planes``)."""

import numpy as np
import pytest

import shakedown
from benchmarks import reaction_planes
from shakedown.joint.constraints import constraints

TWO_NODE = shakedown.example("two-node")


def test_reactions_of_the_second_node_follow_from_those_of_the_first():
    """(4.14)–(4.17), at every slip with both nodes closed."""
    slips = np.random.default_rng(1).normal(size=(5, 2))
    q, p = slips @ TWO_NODE.A.T, slips @ TWO_NODE.B.T
    first, second = (np.stack([q[:, j], p[:, j]]) for j in (0, 1))
    assert reaction_planes.reaction_map(TWO_NODE) @ first == pytest.approx(second)


def test_three_limits_meet_at_the_critical_load_factors():
    found = reaction_planes.meeting_points(constraints(TWO_NODE))
    factors = shakedown.critical_load_factors(TWO_NODE, values=True).load_factors
    assert [load_factor for load_factor, _ in found] == pytest.approx(factors)
    assert found[0][1] == pytest.approx(shakedown.lower_bound(TWO_NODE).slip)
    assert found[1][1] == pytest.approx(shakedown.upper_bound(TWO_NODE).slip)


def test_the_wedged_witness_holds_itself_and_needs_that_friction():
    wedged = shakedown.friction_thresholds(TWO_NODE).wedging
    q, p = TWO_NODE.A @ wedged.slip, TWO_NODE.B @ wedged.slip
    assert (p > 0).all()
    assert np.abs(q) / p == pytest.approx(wedged.value)


def test_in_the_tenth_cycle_the_initial_state_decides():
    """Like fig. 5.8: nothing slips from the safe slip, and something does from another start."""
    block = shakedown.example("cantilevered-block")
    slips = reaction_planes.tenth_cycle(block)
    assert slips["safe slip"].max() == 0
    assert slips["critical slip state"].max() > 1e-4 * np.abs(shakedown.upper_bound(block).slip).max()
