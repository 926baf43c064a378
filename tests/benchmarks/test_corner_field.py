"""Williams's corner: critical friction, and the power by which λ_max falls below it."""

import numpy as np
import pytest

from benchmarks.corner_field import corner_field
from shakedown.fem import Material

STEEL = Material(200e3, 0.3)
RIGHT = np.pi / 2


def softer(ratio):
    return Material(STEEL.young / ratio, 0.3)


def test_the_critical_friction_of_a_square_block_on_a_half_plane():
    """0.543 (Mugadu, Hills, Limmer 2002), with the singularity r^(-0.4555) of Bogy's corner."""
    found = corner_field(RIGHT, STEEL, 0.6, against=STEEL)
    assert found.shear_ratio == pytest.approx(0.543, abs=5e-4)
    assert found.exponent == pytest.approx(0.5445, abs=1e-4)
    assert found.slope == 0.0


def test_the_exponent_of_a_right_angle_on_a_rigid_plane():
    """0.7112 (Williams 1952)."""
    assert corner_field(RIGHT, STEEL, 0.3).exponent == pytest.approx(0.71117, abs=1e-5)


@pytest.mark.parametrize(
    ("f", "against"), [(0.1, None), (0.2, None), (0.2, STEEL), (0.4, STEEL), (0.3, softer(3))]
)
def test_friction_just_holds_the_slip_that_decides(f, against):
    """Below the critical friction the slope is above 0 and falls to 0 as friction gets there."""
    found = corner_field(RIGHT, STEEL, f, against=against)
    near = corner_field(RIGHT, STEEL, found.shear_ratio * (1 - 1e-6), against=against)
    more = corner_field(RIGHT, STEEL, f + 0.05, against=against)
    assert 0 < more.slope < found.slope < 0.5
    assert 0 < near.slope < 1e-5


def test_only_the_ratio_of_the_stiffnesses_counts():
    one = corner_field(1.3, STEEL, 0.2, against=softer(2))
    other = corner_field(1.3, Material(1.0, 0.3), 0.2, against=Material(0.5, 0.3))
    assert one == other


def test_two_wedges_may_change_their_places():
    one = corner_field(1.3, STEEL, 0.1, against=softer(2), against_angle=2.0)
    other = corner_field(2.0, softer(2), 0.1, against=STEEL, against_angle=1.3)
    assert (one.exponent, one.slope) == pytest.approx((other.exponent, other.slope), abs=1e-9)
