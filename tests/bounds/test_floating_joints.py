"""Joints that friction alone holds: rigid slips are pinned, and both bounds are those of the true joint."""

from dataclasses import replace

import numpy as np
import pytest
from difficult_joints import floating_block
from floating_joints import AGREES, by_highs, other_pins, rational_joint

import shakedown
from benchmarks.problems import in_units
from shakedown import Problem
from shakedown.bounds.independent_solver import conic_upper_bound
from shakedown.joint.rigid_slips import rigid_slips

SIZES = [(n, free) for n in (2, 5, 12) for free in (1, 2) if n > 2 * free - 1 and n > free]


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("n", "free"), SIZES)
def test_both_bounds_are_those_of_highs_whichever_nodes_are_pinned(n: int, free: int, seed: int) -> None:
    problem, Z = rational_joint(100 + seed, n, free)
    bounds = shakedown.shakedown_bounds(problem)
    lower, upper = bounds.lower, bounds.upper
    assert len(upper.pinned) == free
    peer = by_highs(problem, other_pins(Z, upper.pinned))
    assert upper.load_factor == pytest.approx(peer["upper"], rel=AGREES)
    assert lower.load_factor == pytest.approx(peer["lower"], rel=AGREES, abs=AGREES)
    for found in (upper, lower):
        if found.status == "optimal":
            low, high = found.certified
            assert low <= found.load_factor <= high
    for slip in (upper.slip, lower.slip):
        assert not np.any(slip[list(upper.pinned)][np.isfinite(slip[list(upper.pinned)])])
    if lower.node >= 0 and peer["witness"]:
        assert np.abs(lower.slip).max() < 100 * peer["witness"]


def test_a_block_on_friction_alone() -> None:
    """Without pins exact arithmetic gave 4.048403: it moved the block until round-off felt like a spring."""
    problem = floating_block(5, 0.5)
    bounds = shakedown.shakedown_bounds(problem)
    peer = by_highs(problem, [0])
    assert bounds.lower.pinned == bounds.upper.pinned == (2,)
    assert bounds.lower.load_factor == pytest.approx(3.8393831340, rel=1e-9)
    assert bounds.lower.load_factor == pytest.approx(peer["lower"], rel=1e-9)
    assert bounds.upper.load_factor == pytest.approx(peer["upper"], rel=1e-9)
    assert bounds.lower.certified is not None
    assert bounds.upper.certified is not None


def two_bodies(noise: float = 0.0, held: float = 0.0) -> Problem:
    """A double lap joint in small: two chains of three nodes each, one of them perhaps held by a spring."""
    chain = np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    A = np.kron(np.eye(2), 1e4 * chain / 3.0) + np.diag([held, 0, 0, 0, 0, 0])
    tilt = 0.1 * np.kron(np.array([[1.0, 0.4], [0.0, 1.0]]), 1e4 * (chain + np.triu(chain, 1)) / 3.0)
    tilt -= np.outer(tilt.sum(axis=1), np.ones(6) / 6)
    tilt[:, :3] -= tilt[:, :3].mean(axis=1, keepdims=True)
    tilt[:, 3:] -= tilt[:, 3:].mean(axis=1, keepdims=True)
    error = noise * np.random.default_rng(4).normal(size=(6, 6))
    steps = 2 * np.pi * np.arange(8) / 8
    q = np.cos(steps)[:, None] * np.array([3.0, 2.0, 4.0, -3.0, -4.0, -2.0]) + 0.4
    p = 20.0 + np.sin(steps)[:, None] * np.array([1.0, 2.0, 0.0, 2.0, 1.0, 1.0])
    return Problem(A=A * (1 + error + error.T), B=tilt * (1 + error), f=0.4, q_w=q, p_w=p)


def test_two_floating_bodies_have_a_pin_each() -> None:
    problem = two_bodies()
    bounds, energy = shakedown.shakedown_bounds(problem), shakedown.energy_bound(problem)
    assert len(bounds.upper.pinned) == 2
    assert {node // 3 for node in bounds.upper.pinned} == {0, 1}
    assert energy.pinned == bounds.lower.pinned == bounds.upper.pinned
    for pins in ([0, 3], [2, 5]):
        peer = by_highs(problem, pins)
        assert bounds.upper.load_factor == pytest.approx(peer["upper"], rel=1e-12)
        assert bounds.lower.load_factor == pytest.approx(peer["lower"], rel=1e-9)
    assert energy.load_factor <= bounds.upper.load_factor
    half_held = shakedown.upper_bound(two_bodies(held=1e3))
    assert [node // 3 for node in half_held.pinned] == [1]


@pytest.mark.parametrize("noise", [1e-15, 1e-7])
def test_every_bound_answers_for_the_true_joint(noise: float) -> None:
    """Round-off up to what condensing leaves is found; of seven printed digits the file says so."""
    true = two_bodies()
    rough = replace(two_bodies(noise), stiffness_accuracy=noise if noise > 1e-9 else None)
    near = {"rel": max(100 * noise, 1e-11)}
    pairs = [(shakedown.shakedown_bounds(one), shakedown.energy_bound(one)) for one in (true, rough)]
    (bounds, energy), (others, again) = pairs
    assert others.upper.pinned == bounds.upper.pinned
    for one, other in (
        (bounds.upper.load_factor, others.upper.load_factor),
        (bounds.lower.load_factor, others.lower.load_factor),
        (energy.load_factor, again.load_factor),
        *zip(energy.slip, again.slip, strict=True),
    ):
        assert other == pytest.approx(one, **near, abs=near["rel"] * 1e-3)
    assert others.upper.certified is not None
    assert again.certified is not None
    half = 0.5 * bounds.upper.load_factor
    for function in (shakedown.safe_slip, shakedown.energy_ball):
        one, other = (function(joint_, half) for joint_ in (true, rough))
        assert other.pinned == one.pinned == bounds.upper.pinned
        np.testing.assert_allclose(other.slip, one.slip, rtol=1e3 * near["rel"], atol=near["rel"])
    methods = [conic_upper_bound(one).load_factor for one in (true, rough)]
    assert methods == pytest.approx([bounds.upper.load_factor] * 2, rel=max(1e-6, near["rel"]))


def test_a_doubtful_gap_is_said_and_nothing_is_certified() -> None:
    unclear = two_bodies(noise=1e-8)
    bounds = shakedown.shakedown_bounds(unclear, certify=True)
    energy = shakedown.energy_bound(unclear)
    assert bounds.upper.certified is None
    assert bounds.lower.certified is None
    assert energy.certified is None
    assert "stiffness_accuracy" in bounds.upper.uncertified
    assert shakedown.upper_bound(replace(unclear, stiffness_accuracy=1e-8)).certified is not None


def test_a_soft_spring_is_a_spring_where_the_data_are_sharp() -> None:
    soft = replace(two_bodies(held=1e-7), stiffness_accuracy=1e-15)
    known = rigid_slips(soft)
    assert (len(known.pinned), known.doubt) == (1, "")
    assert len(rigid_slips(replace(soft, stiffness_accuracy=None)).pinned) == 2


@pytest.mark.parametrize("d", [1, 2])
@pytest.mark.parametrize("soft", [1e-3, 1e-9, 1e-13])
def test_a_body_on_soft_springs_bears_what_melan_says_of_each_node(d, soft) -> None:
    """Slip takes up every constant load, far as it may have to go; no slip changes a pressure."""
    A = np.kron([[1.0 + soft, -1.0], [-1.0, 1.0 + soft]], np.eye(d))
    q_w = np.zeros((4, 2 * d)) + 0.1 * soft
    q_w[:, 0], q_w[:, d] = [1.0, 0.0, -1.0, 0.0], [0.0, 0.3, 0.0, -0.3]
    joint = Problem(
        A=A, B=np.zeros((2, 2 * d)), f=0.5, q_w=q_w, p_w=np.ones((4, 2)), stiffness_accuracy=1e-15
    )
    joint = in_units(joint, np.array([0.25, 4.0]), np.array([4.0, 0.25]))
    bounds = shakedown.upper_bound(joint), shakedown.energy_bound(joint)
    assert [bound.load_factor for bound in bounds] == pytest.approx([0.5, 0.5], rel=1e-6)
    assert bounds[0].pinned == ()


@pytest.mark.parametrize("wrong", [0.0, 0.01, np.nan, "seven", True])
def test_an_accuracy_is_a_number_of_three_digits_at_least(wrong) -> None:
    """With fewer every resistance would be round-off, and a joint that is held would have all nodes pinned."""
    with pytest.raises(shakedown.ProblemError, match="key 'stiffness_accuracy': expected"):
        replace(two_bodies(), stiffness_accuracy=wrong)


def test_a_body_that_can_move_only_rigidly_in_a_zone_keeps_its_gap() -> None:
    """With its middle open the receding block has the same pin, and λ_max whichever node is pinned."""
    block = shakedown.example("receding-block")
    zone = shakedown.upper_bound(block, open_nodes="auto")
    assert (len(zone.pinned), zone.slip[list(zone.pinned)].tolist()) == (1, [0.0])
    other = conic_upper_bound(block, open_nodes=zone.open_nodes)
    assert other.load_factor == pytest.approx(zone.load_factor, rel=1e-7)
