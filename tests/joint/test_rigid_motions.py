"""Rigid motions of joints that friction alone holds: found beside round-off and few digits, and free in all motions.

Rigid slips are pinned, and both bounds are those of the true joint.
"""

import re
from dataclasses import replace

import difficult_joints
import numpy as np
import pytest
from floating_joints import (
    AGREES,
    by_highs,
    floating_block,
    floating_joint,
    floating_solid,
    other_pins,
    rational_joint,
    rounded,
    stiffened,
    without_places,
)

import shakedown
from benchmarks.problems import in_units
from shakedown import Problem
from shakedown.bounds.independent_solver import conic_upper_bound
from shakedown.joint.rigid_slips import can_drift, free_stiffness, rigid_slips, zero_modes

SHARES = [sign * 10.0**power for power in (-17, -15, -13, -11, -9) for sign in (1.0, -1.0)]


@pytest.mark.parametrize("share", SHARES)
def test_a_body_slides_away_whatever_round_off_resists_it(share: float) -> None:
    """With +1e-15 of the largest stiffness it was followed for 1e7 lengths of its slip, and then undecided."""
    block = floating_block(3)
    rough = stiffened(block, share)
    for load_factor in (0.9, 5.0):
        true, found = (shakedown.simulate(one, load_factor * 3.0) for one in (block, rough))
        assert (found.outcome, found.slides_away) == (true.outcome, true.slides_away)
        np.testing.assert_allclose(
            found.final_slip, true.final_slip, rtol=1e-6, atol=1e-6 * np.abs(true.final_slip).max()
        )
    assert bool(rigid_slips(without_places(rough)).doubt) == (abs(share) >= 1e-9)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("n", "free"), [(3, 1), (6, 2), (12, 3)])
def test_rigid_slips_are_those_that_changed_nothing_before_rounding(n: int, free: int, seed: int) -> None:
    """To round-off, in units of each node too; with few digits to about as many, by a clear gap or by none."""
    problem, Z = rational_joint(seed, n, free)
    sizes = 10.0 ** np.random.default_rng(seed).uniform(-3, 3, n)
    given = [(d, replace(problem, stiffness_accuracy=10.0**-d)) for d in (3, 5)]
    for joint, size, error in (
        (problem, np.ones(n), 1e-11),
        (in_units(problem, 1.0 / sizes, sizes), sizes, 1e-11),
        *((rounded(exact, d), np.ones(n), 5 * 10.0**-d) for d, exact in given),
    ):
        known, true = rigid_slips(joint), size[:, None] * Z
        pinned = list(known.pinned)
        assert pinned == sorted(pinned)
        assert np.array_equal(known.motions[pinned], np.eye(free))
        off = known.motions @ true[pinned] - true
        np.testing.assert_allclose(off / size[:, None], 0.0, atol=error * np.abs(Z).max())


@pytest.mark.parametrize("kind", ["block", "solid"])
@pytest.mark.parametrize("digits", [5, 7])
def test_with_places_few_digits_are_no_doubt(kind: str, digits: int) -> None:
    problem = floating_joint(kind, 1)
    rough, most = rounded(problem, digits), shakedown.upper_bound(problem).load_factor
    assert not rigid_slips(rough).doubt
    assert len(rigid_slips(rough).pinned) == len(rigid_slips(problem).pinned)
    assert shakedown.upper_bound(rough).load_factor == pytest.approx(most, rel=100 * 10.0**-digits)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("digits", [5, 7])
def test_few_digits_without_places_give_the_same_limits_in_doubt(seed: int, digits: int) -> None:
    """25 of 59 joints of five digits had another λ_max, certified, and some of seven had none at all."""
    joint = rational_joint(seed, 3 + seed % 5, 1)[0]
    rough, most = rounded(joint, digits), shakedown.upper_bound(joint)
    found = shakedown.upper_bound(rough, certify=True)
    assert found.load_factor == pytest.approx(most.load_factor, rel=1000 * 10.0**-digits)
    if rigid_slips(rough).doubt:
        assert (found.certified, found.exact) == (None, False)
        assert "taken for rigid" in found.uncertified
    known = shakedown.upper_bound(replace(rough, stiffness_accuracy=10.0**-digits))
    assert known.load_factor == pytest.approx(found.load_factor, rel=1e-9)


def test_no_load_factor_is_said_to_be_without_limit_in_doubt() -> None:
    """Slip of both nodes wedges the joint, if what resists it, 0.0005, is more than an error."""
    A, loads = np.array([[1.0005, -1.0], [-1.0, 1.0005]]), {"q_w": np.eye(2), "p_w": np.full((2, 2), 3.0)}
    clear = Problem(A=A, B=0.5 * A, f=4.0, **loads)
    assert shakedown.upper_bound(clear).status == "unbounded"
    assert not rigid_slips(clear).doubt
    doubtful = replace(clear, stiffness_accuracy=1e-5)
    assert rigid_slips(doubtful).doubt
    upper = shakedown.upper_bound(doubtful)
    assert (upper.status, np.isnan(upper.load_factor)) == ("undecided", True)
    assert "give stiffness_accuracy" in upper.reason
    lifted = replace(doubtful, A=np.eye(2), B=np.zeros((2, 2)), C=A)  # in doubt once nodes open
    assert [can_drift(each) for each in (lifted, replace(lifted, stiffness_accuracy=None))] == [True, False]


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("kind", ["matrices", "block", "matrices in space", "solid"])
def test_free_stiffness_is_that_of_the_joint_but_for_rigid_motions(kind: str, seed: int) -> None:
    problem = floating_joint(kind, seed)
    layout, kappa = problem.layout, free_stiffness(problem)
    Z = rigid_slips(problem).motions
    moved = np.vstack([Z, np.zeros((problem.n, Z.shape[1]))])
    np.testing.assert_allclose(kappa, problem.kappa, atol=1e-12 * np.abs(kappa).max())
    assert np.abs(kappa @ moved).max() < 1e-14 * np.abs(kappa).max() * np.abs(moved).max() * layout.size
    assert can_drift(problem)
    away = zero_modes(problem.kappa)
    assert zero_modes(kappa) == away >= Z.shape[1]


def test_a_joint_that_is_held_keeps_every_bit() -> None:
    for name in ("two-node", "block-9", "four-node-3d", "press-fit"):
        joint = shakedown.example(name)
        assert (free_stiffness(joint) == joint.kappa).all()


def test_the_motions_of_a_body_are_those_of_its_stiffness() -> None:
    """Of a brick on a plane: two translations and a turn keep it closed, a translation and two turns do not."""
    brick = floating_solid(0)
    assert (len(rigid_slips(brick).pinned), zero_modes(brick.kappa)) == (3, 6)
    rough = rounded(brick, 5)
    assert np.linalg.matrix_rank(free_stiffness(rough), tol=1e-9 * rough.kappa.max()) == len(rough.kappa) - 6


def test_a_diagonal_that_round_off_makes_negative_is_followed():
    loop = {"f": 0.5, "q_w": [[1.0, 0.0], [-1.0, 0.0]], "p_w": [[3.0, 3.0], [3.0, 3.0]]}
    problem = Problem(A=[[-1e-17, 0.0], [0.0, 1.0]], B=np.zeros((2, 2)), **loop)
    assert np.isfinite(free_stiffness(problem)).all()
    assert rigid_slips(replace(problem, A=np.diag([0.0, 1.0]))).motions.T.tolist() == [[1.0, 0.0]]


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
    problem = difficult_joints.floating_block(5, 0.5)
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
    """Where a certificate is there, or was not asked for, no reason is said."""
    unclear = two_bodies(noise=1e-8)
    bounds = shakedown.shakedown_bounds(unclear, certify=True)
    energy = shakedown.energy_bound(unclear)
    assert (bounds.upper.certified, bounds.upper.exact) == (None, False)
    assert bounds.lower.certified is None
    assert energy.certified is None
    assert re.search(
        r"meets \de-\d+ of the stiffness and is taken for rigid: give stiffness_accuracy",
        bounds.upper.uncertified,
    )
    sharp = replace(unclear, stiffness_accuracy=1e-8)
    assert shakedown.upper_bound(sharp).certified is not None
    assert shakedown.upper_bound(sharp).uncertified == ""
    assert shakedown.upper_bound(unclear, certify=False).uncertified == ""


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
