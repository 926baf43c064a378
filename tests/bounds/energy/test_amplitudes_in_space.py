"""The energy bound of joints in space under periodic parts far smaller, or larger, than the constant one."""

import numpy as np
import pytest

import shakedown
from shakedown.studies.design_point import with_parameter

JOINT = shakedown.example("one-node-3d")


@pytest.mark.parametrize(("amplitude", "digits"), [(1e-12, 1e-3), (1e12, 1e-9)])
def test_a_factor_on_the_amplitude_divides_the_bound(amplitude, digits):
    """Of a small one the digits beside the constant part are lost in the data already."""
    one = shakedown.energy_bound(JOINT, certify=False)
    other = shakedown.energy_bound(with_parameter(JOINT, "amplitude", amplitude), certify=False)
    assert other.status == one.status
    assert amplitude * other.load_factor == pytest.approx(one.load_factor, rel=digits)


def test_a_node_without_stiffness_bears_what_its_friction_does():
    q_w = np.array([[0.3, 0.4], [-0.3, -0.4], [0.1, 0.0], [-0.1, 0.0]])
    joint = shakedown.Problem(
        A=np.zeros((2, 2)), B=np.zeros((1, 2)), f=0.4, q_w=q_w, p_w=np.full((4, 1), 2.0)
    )
    assert shakedown.energy_bound(joint).load_factor == pytest.approx(0.8 / 0.5, rel=1e-9)
