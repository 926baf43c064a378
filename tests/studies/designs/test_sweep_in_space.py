"""Sweeps of joints with two tangential directions: the limits that there are, the others refused or missing."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import Problem, sweep
from shakedown.studies.design_point import with_parameter

JOINT = shakedown.example("one-node-3d")


@pytest.mark.slow
def test_every_point_is_the_joint_by_itself():
    found = sweep(JOINT, {"friction": [0.5]}, quick=True)
    assert found.bounds == ("universal", "energy", "accumulated", "transient", "upper")
    assert (found.energy <= found.transient).all()
    assert (found.transient <= found.upper).all()
    one = shakedown.assess(with_parameter(JOINT, "friction", 0.5), certify=False)
    assert found.upper[0] == one.impossible_above
    assert found.universal[0] == one.proved_from_every_state
    assert found.energy[0] == one.details.energy.load_factor
    assert found.contradictions == ()
    assert np.isnan(found.lower).all()


def of_friction(f: float) -> Problem:
    return replace(JOINT, f=np.array([f]))


def test_of_a_function_that_makes_joints_what_there_is_not_is_undecided_with_the_reason():
    found = sweep(of_friction, {"f": [0.4]}, bounds=["lower", "universal", "upper"])
    assert found.status("lower").tolist() == ["undecided"]
    assert "first collapse: expected one tangential direction" in found.points[0]["lower"]["remark"]
    assert 0 < found.universal[0] < found.upper[0]
    with pytest.raises(
        shakedown.UsageError, match="bounds with two directions: expected some of universal, energy"
    ):
        sweep(JOINT, {"f": [0.4, 0.5]}, bounds=["lower"])


def test_up_to_where_the_slips_of_every_point_are_small():
    found = sweep(JOINT, {"friction": [1.0]}, bounds=["upper"], slip_below=0.05)
    (point,), upper = found.points, found.upper[0]
    assert 0.9 * upper < point["slip_criterion"]["load_factor"] < 2.0 * upper
    assert 0 <= point["slip_criterion"]["largest"] < 0.05
