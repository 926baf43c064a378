"""Slips of the pen in the data of a joint, in the plane and in space, as they are said to its user."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.joint.doubtful_data import doubtful_data

JOINTS = ["block-9", "block-3x3"]


def of(problem, **factors):
    """The joint with some of its arrays in other units."""
    return replace(problem, **{key: factor * getattr(problem, key) for key, factor in factors.items()})


@pytest.mark.parametrize("name", shakedown.example_names())
def test_nothing_is_said_of_built_in_joints(name):
    assert doubtful_data(shakedown.example(name)) == []


@pytest.mark.parametrize("name", JOINTS)
@pytest.mark.parametrize(
    ("factors", "said"),
    [
        ({"p_w": -1.0}, "The mean pressure is negative at every node"),
        ({"f": 100.0}, "is it in percent?"),
        ({"C": 1e3}, "The largest stiffness in C is "),
        ({"A": 1e3, "B": 1e-3}, "The largest stiffness in C is "),
        ({"A": 1e-3, "B": 1e-6, "C": 1e-3, "q_w": 1e3}, "The load is as large as the stiffness times "),
    ],
)
def test_likely_slips_of_the_pen_are_said(name, factors, said):
    problem = shakedown.example(name)
    place = np.arange(float(problem.n)) if problem.x is None else problem.x
    (hint,) = doubtful_data(of(replace(problem, x=place), **factors))
    assert said in hint


@pytest.mark.parametrize("name", JOINTS)
def test_without_normal_stiffness_a_coupling_in_other_units_is_said(name):
    (hint,) = doubtful_data(of(replace(shakedown.example(name), C=None), B=1e3))
    assert hint.startswith("The largest stiffness in B is ")


@pytest.mark.parametrize("name", JOINTS)
@pytest.mark.parametrize("factors", [{"B": 1e3}, {"A": 1e-3}, {"C": 1e-3}])
def test_blocks_in_different_units_make_no_stiffness(name, factors):
    with pytest.raises(shakedown.ProblemError, match="positive semi-definite, found the eigenvalue"):
        of(shakedown.example(name), **factors)


@pytest.mark.parametrize("scale", [1e-12, 1e12])
def test_hints_do_not_depend_on_units(scale):
    for name in JOINTS:
        problem = shakedown.example(name)
        loads = dict.fromkeys(("q_w", "p_w"), scale)
        assert doubtful_data(of(problem, A=scale, B=scale, C=scale, **loads)) == []
