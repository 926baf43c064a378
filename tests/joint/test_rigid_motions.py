"""Rigid motions of joints that friction alone holds: found beside round-off and few digits, and free in all motions."""

from dataclasses import replace

import numpy as np
import pytest
from floating_joints import (
    floating_block,
    floating_joint,
    floating_solid,
    rational_joint,
    rounded,
    stiffened,
    without_places,
)

import shakedown
from benchmarks.problems import in_units
from shakedown import Problem
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
    for joint, size, error in (
        (problem, np.ones(n), 1e-11),
        (in_units(problem, 1.0 / sizes, sizes), sizes, 1e-11),
        *(
            (rounded(replace(problem, stiffness_accuracy=10.0**-d), d), np.ones(n), 5 * 10.0**-d)
            for d in (3, 5)
        ),
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
