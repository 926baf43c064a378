"""The exact check against fractions put down by hand, and against the floats."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from bounds.energy.joints import one_node, strong_joint

import shakedown
from shakedown import Problem
from shakedown.bounds.energy.energy_bound import ExactBall

NONE = np.zeros((0, 2))  # shares are given with two directions only
LOADS = {"q_w": [[1.0, 0.0], [-1.0, 0.0]], "p_w": [[4.0, 4], [4, 4]]}
# A⁻¹ = I / 2: B_0 A⁻¹ B_0ᵀ = 1/2 + 1/8, less B_00²/A_00 = 1/2: γ_0² = 1/8; γ_1 = 0
TWO = Problem(A=2 * np.eye(2), B=[[1.0, 0.5], [0.0, 0.0]], f=[0.5, 0.25], **LOADS)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("radius", "holds"), [(Fraction(56, 10), True), (Fraction(57, 10), False)])
def test_a_radius_by_hand(radius, holds, side):
    """Node 0 at λ = 1 and zero slip: margin f p − |q| = 1; f γ R < 1 for R < 2√8 = 5.657."""
    for problem in (TWO, replace(TWO, q_w=[[side, 0.0], [0.0, 0.0]])):  # at both limits, at one
        assert ExactBall(problem, NONE).holds(1.0, np.zeros(2), radius) is holds


def test_strictly():
    exact = ExactBall(one_node(), NONE)  # γ = 0: all that counts is a margin > 0
    assert exact.holds(np.nextafter(1.5, 0), np.zeros(1), 1e300)
    assert not exact.holds(1.5, np.zeros(1), 0.0)
    space = Problem(A=np.eye(2), B=[[2.0, 0.0]], f=0.5, q_w=[[3.0, 4.0]], p_w=[[12.0]])  # f p = |q| + f γ
    within, touching = (ExactBall(space, np.zeros((1, 2))).holds(1.0, np.zeros(2), R) for R in (0.999, 1))
    assert (within, touching) == (True, False)
    near = 1.0 - 2.0**-50  # eigenvalues of A: 2⁻⁵⁰, of the size of round-off, and 2
    assert not ExactBall(replace(TWO, A=[[1.0, near], [near, 1.0]]), NONE).regular


@pytest.mark.parametrize("size", [1.0, 2.0**60, 2.0**-60])
def test_distance_is_rounded_up(size):
    exact = ExactBall(TWO, NONE)
    found = exact.radius_to(np.array([size, 0.0]), np.zeros(2), 0.25 * size) / Fraction(size)
    assert 0 < (found - Fraction(1, 4)) ** 2 - 2 < Fraction(1, 2**70)


@pytest.mark.parametrize(
    ("problem", "split"),
    [
        (strong_joint(0, 5, friction=0.3), True),
        (strong_joint(1, 5, friction=3.0), True),
        (shakedown.example("four-node-3d"), False),
        *((shakedown.example(name), True) for name in ("one-node-3d", "four-node-3d")),
    ],
)
def test_certificates_are_next_to_the_optimum(problem, split):
    start, distance = np.zeros(problem.layout.slip_size), 0.0
    if problem.directions == 1:
        start, distance = np.nan_to_num(shakedown.upper_bound(problem, certify=False).slip), 0.02
    bound = shakedown.energy_bound(problem, start, distance, split=split)
    assert bound.status == "optimal"
    assert bound.load_factor * (1 - 1e-9) < bound.certified <= bound.load_factor
    assert bound.share.shape == ((problem.n if problem.directions == 2 else 0), 2)
    found, exact = bound.certificate, ExactBall(problem, bound.share)
    assert exact.holds(found.load_factor, found.slip, found.radius)
    assert exact.radius_to(found.slip, start, distance) <= Fraction(found.radius)
    assert not exact.holds(bound.load_factor * (1 + 1e-9), bound.slip, bound.radius * (1 + 1e-9))
    assert not exact.holds(1.002 * found.load_factor, found.slip, found.radius)
    assert not shakedown.energy_bound(problem, certify=False).uncertified


def test_a_body_that_only_friction_holds_is_certified_where_that_is_clear():
    A = np.array([[1.0, -1.0], [-1.0, 1.0]])
    floating = Problem(A=A, B=0.25 * A[::-1], f=0.5, q_w=A, p_w=np.full((2, 2), 3.0))
    bound = shakedown.energy_bound(floating)
    assert bound.load_factor * (1 - 1e-12) <= bound.certified <= bound.load_factor
    for error, clear in ((-1e-14, True), (1e-14, True), (1e-8, False)):
        rough = replace(floating, A=A + np.diag([0.0, error]))
        again = shakedown.energy_bound(rough)
        assert again.load_factor == pytest.approx(bound.load_factor, rel=1e-7)
        assert (again.certified is not None, again.pinned) == (clear, (0,))


def test_transient_load_steps_are_checked():
    pulled = replace(TWO, q_transient=[[1.8, 0.0]], p_transient=[[4.0, 4.0]])
    assert ExactBall(TWO, NONE).holds(1.0, np.zeros(2), 5.0)
    assert not ExactBall(pulled, NONE).holds(1.0, np.zeros(2), 5.0)
    assert ExactBall(pulled, NONE).holds(1.0, np.zeros(2), 1.0)
