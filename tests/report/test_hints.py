"""Slips of the pen in the data of a joint, in the plane and in space, as they are said to its user."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.fem import ElasticBody, Material, Pressure, block_mesh, brick_mesh, contact_problem
from shakedown.joint.units import doubtful_data, without_loads

JOINTS = ["block-9", "block-3x3"]


def of(problem, **factors):
    """The joint with some of its arrays in other units."""
    return replace(without_loads(problem), **{key: x * getattr(problem, key) for key, x in factors.items()})


@pytest.mark.parametrize("name", shakedown.example_names())
def test_nothing_is_said_of_built_in_joints(name):
    assert doubtful_data(shakedown.example(name)) == []
    problem = of(shakedown.example(name), B=0.0)
    rigid = replace(problem, C=np.zeros((problem.n, problem.n)))  # as in as few nodes as hold a body
    hints = [hint for hint in doubtful_data(rigid) if "stiffness in C is 0 times" in hint]
    assert len(hints) == (problem.n > problem.directions + 1)


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


def ordered(problem, steps):
    """The joint with these of its load steps, in this order."""
    history = problem.load_history
    history = None if history is None else history[steps]
    return replace(problem, q_w=problem.q_w[steps], p_w=problem.p_w[steps], load_history=history)


@pytest.mark.parametrize("name", JOINTS)
def test_load_steps_out_of_order_are_said(name):
    problem = shakedown.example(name)
    steps = list(range(problem.m))
    third = problem.m // 3
    swapped = [third if k == 1 else 1 if k == third else k for k in steps]
    for wrong in (swapped, sorted(steps, key=str), [*steps[:third], 2 * third, *steps[third:]]):
        (hint,) = doubtful_data(ordered(problem, wrong))
        assert "are the load steps in their order, and each there once?" in hint
    assert doubtful_data(ordered(problem, steps[::-1])) == []  # the other way round is an order, too
    assert doubtful_data(ordered(problem, steps[5:] + steps[:5])) == []
    assert doubtful_data(replace(ordered(problem, swapped), load_path="domain")) == []  # any order is as good


@pytest.mark.parametrize("name", JOINTS)
def test_a_last_load_step_that_repeats_the_first_is_said_where_it_counts(name):
    """It moves the sample mean, and with it the periodic part."""
    problem = shakedown.example(name)
    twice = ordered(problem, [*range(problem.m), 0])
    (hint,) = doubtful_data(twice)
    assert hint.startswith("The last load step repeats the first.")
    mean = {"q_mean": problem.q_w.mean(axis=0), "p_mean": problem.p_w.mean(axis=0)}
    assert doubtful_data(replace(twice, **mean)) == []


@pytest.mark.parametrize("solid", [False, True])
def test_a_modulus_in_pascals_beside_millimetres_and_newtons_is_said(solid):
    """Slips are then too small by a million, which no ratio of stiffnesses shows."""
    for young, stress, hints in ((200e3, 10.0, 0), (200e9, 10.0, 1), (200e9, 500.0, 1), (1.0, 0.005, 0)):
        loads = [Pressure("top", stress, history=1.0)]
        mesh = brick_mesh((2.0, 2.0, 1.0), (4, 4, 2)) if solid else block_mesh(2.0, 1.0, 8, 4)
        joint = contact_problem(ElasticBody(mesh, Material(young, 0.3), loads=loads), "bottom", f=0.5)
        found, end = doubtful_data(joint), "are forces, stiffnesses and positions in the same units?"
        assert [hint.endswith(end) for hint in found] == [True] * hints, (young, stress)


@pytest.mark.parametrize("scale", [1e-12, 1e12])
def test_hints_do_not_depend_on_units(scale):
    for name in JOINTS:
        problem = shakedown.example(name)
        loads = dict.fromkeys(("q_w", "p_w"), scale)
        assert doubtful_data(of(problem, A=scale, B=scale, C=scale, **loads)) == []
