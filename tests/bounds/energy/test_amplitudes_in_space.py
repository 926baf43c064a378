"""The energy bound of joints in space under periodic parts far smaller, or larger, than the constant one."""

import pytest

import shakedown
from shakedown.studies.designs.parameters import with_parameter

JOINT = shakedown.example("one-node-3d")


@pytest.mark.parametrize(("amplitude", "digits"), [(1e-12, 1e-3), (1e-6, 1e-8), (1e9, 1e-9), (1e12, 1e-9)])
def test_a_factor_on_the_amplitude_divides_the_bound(amplitude, digits):
    """Of a small one the digits beside the constant part are lost in the data already."""
    one = shakedown.energy_bound(JOINT, certify=False)
    other = shakedown.energy_bound(with_parameter(JOINT, "amplitude", amplitude), certify=False)
    assert other.status == one.status
    assert amplitude * other.load_factor == pytest.approx(one.load_factor, rel=digits)
