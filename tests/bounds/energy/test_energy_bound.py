"""λ_E: numbers, optimality, a second method, statuses, intervals, certificates, bad arguments."""

from dataclasses import replace

import numpy as np
import pytest
from bounds.energy.joints import one_node, strong_joint

import shakedown
from benchmarks.plain_energy import plainly
from benchmarks.problems import chain, random_problem
from shakedown import Problem, energy_bound

NUMBERS = {  # to the digits of an independent computation
    "one-node": 0.9305239948,
    "two-node": 0.6619611189,
    "three-node": 1.4845583487,
    "block-9": 4.6633908331,
    "block-33": 4.7067126363,
}


@pytest.mark.parametrize("name", NUMBERS)
def test_load_factor_of_the_examples(name):
    problem = shakedown.example(name)
    bound = energy_bound(problem)
    assert bound.load_factor == pytest.approx(NUMBERS[name], rel=1e-9)
    assert bound.residual <= 1e-14
    assert abs(bound.gap) <= 1e-12
    assert bound.load_factor * (1 - 1e-12) <= bound.certified <= bound.load_factor
    assert bound.radius == pytest.approx(np.sqrt(bound.slip @ problem.A @ bound.slip), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("seed", [0, 3])
def test_never_above_the_largest_and_falling_with_the_distance(seed):
    problem = strong_joint(seed, 6, floating=seed == 3)
    upper = shakedown.upper_bound(problem, certify=False)
    factors = [energy_bound(problem, upper.slip, d, certify=False).load_factor for d in (0.0, 0.01, 0.1, 0.2)]
    assert factors[0] == pytest.approx(upper.load_factor, rel=1e-9)  # the safe slip itself
    assert factors == sorted(factors, reverse=True)
    assert factors[1] < factors[0]


@pytest.mark.parametrize("make", [random_problem, chain])
def test_many_nodes(make):
    problem = make(60, seed=0)
    bound = energy_bound(problem)
    assert bound.certificate is None  # more than 40 nodes
    assert abs(bound.gap) <= 1e-12
    assert bound.residual <= 1e-14


def test_a_finite_interval():
    problem = Problem(
        A=np.eye(2), B=[[0.0, 0.2], [0.1, 0.0]], C=np.eye(2), f=0.5, q_w=[[0.3, 0.9], [-0.3, -0.9]],
        p_w=[[2.0, 3.0], [2.0, 3.0]], q_mean=[0.0, 0.0], p_mean=[-1.0, 3.0],
    )  # fmt: skip
    bound = energy_bound(problem, [0.5, 0.0])
    least, most = bound.least_load_factor, bound.load_factor
    assert bound.status == "optimal"
    assert 0.4 < least < most
    assert least == pytest.approx(plainly(problem, start=[0.5, 0.0], least=True), rel=1e-6)
    for factor in (least, most):
        ball = shakedown.energy_ball(problem, factor)
        assert ball.status == "optimal"


def test_statuses():
    still = replace(one_node(), q_w=[[0.5], [0.5]])
    assert energy_bound(still).status == "unbounded"  # nothing changes over the period
    assert energy_bound(still).least_load_factor == 0.0
    jump = shakedown.example("jump")  # not even the only load step is safe: the joint opens
    assert energy_bound(jump).status == "infeasible"
    assert energy_bound(jump, jump.initial_slip[0]).status == "infeasible"
    apart = energy_bound(one_node(p_w=[[-3.0], [-3.0]]))
    assert (apart.status, apart.certified) == ("infeasible", None)
    assert np.isnan([apart.load_factor, apart.least_load_factor, apart.radius, *apart.slip]).all()
    far = energy_bound(shakedown.example("two-node"), [1e4, -1e4])
    assert far.status == "infeasible"
    assert far.residual <= 1e-9
    assert far.active
    assert energy_bound(one_node(f=0.0)).reason.startswith("node 0 has no friction")
    loose = Problem(
        A=np.eye(2), B=np.zeros((2, 2)), f=0.5, q_w=[[1.0, 0.0], [-1.0, 0.0]], p_w=[[3.0, 0.0], [3.0, 0.0]]
    )
    assert energy_bound(loose).status == "infeasible"


def test_a_node_above_its_own_critical_friction_has_its_number():
    """The plane of its limit must not enter the ball: R ≤ distance to the plane."""
    problem = Problem(
        A=[[1.0, 0.0], [0.0, 1.0]], B=[[3.0, 0.0], [0.0, 0.0]], C=20 * np.eye(2), f=0.5,
        q_w=[[0.1, 1.0], [-0.1, -1.0]], p_w=[[3.0, 3.0], [3.0, 3.0]],
    )  # fmt: skip
    bound = energy_bound(problem, [0.0, 0.0], 0.1)
    assert bound.status == "optimal"
    assert bound.load_factor == pytest.approx(1.5, rel=1e-12)  # node 1: Melan; node 0 has slack left
    assert bound.certified == pytest.approx(1.5, rel=1e-9)


def test_a_floating_body_knows_no_position():
    problem = strong_joint(6, 5, floating=True)
    start = np.array([0.1, -0.2, 0.0, 0.3, 0.2])
    here, there = energy_bound(problem, start), energy_bound(problem, start + 5.0)
    assert there.load_factor == pytest.approx(here.load_factor, rel=1e-10)
    np.testing.assert_allclose(there.slip, here.slip, atol=1e-9)  # relative to the pinned node
    assert (there.pinned, here.slip[list(here.pinned)]) == (here.pinned, [0.0])
    np.testing.assert_array_equal(there.initial_slip, start + 5.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1.0],), r"initial slip: expected shape \(2,\), found \(1,\)"),
        (([1.0, np.nan],), "initial slip: expected finite numbers, found nan"),
        ((None, -1.0), r"distance: expected a number >= 0, found -1.0"),
        ((None, 1e300), r"distance: expected reactions below .*, found"),
        (([1e90, 1.0],), r"initial slip: expected reactions below .*, found"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(shakedown.UsageError, match=message):
        energy_bound(shakedown.example("two-node"), *arguments)
    with pytest.raises(shakedown.UsageError, match="problem: expected a Problem"):
        energy_bound(None)
