"""Named parameters: each is what its line says, whatever the joint."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from benchmarks.problems import joint, random_problem
from shakedown import Problem
from shakedown.ground.errors import ProblemError, UsageError
from shakedown.joint.constraints import loading
from shakedown.studies.design_point import with_parameter

TWO = shakedown.example("two-node")
TRANSIENT = replace(joint(3), q_transient=np.full((2, 4), 0.1), p_transient=np.full((2, 4), 3.0))


def limits(problem):
    return (
        shakedown.lower_bound(problem, certify=False).load_factor,
        shakedown.universal_bound(problem).load_factor,
        shakedown.energy_bound(problem, certify=False).load_factor,
        shakedown.upper_bound(problem, certify=False).load_factor,
    )


@pytest.mark.parametrize("problem", [TWO, joint(1), random_problem(5, 2)], ids=["two", "joint", "random"])
def test_every_load_factor_is_inverse_to_the_amplitude_and_homogeneous_in_the_mean(problem):
    as_given = np.array(limits(problem))
    assert limits(with_parameter(problem, "amplitude", 2.0)) == pytest.approx(as_given / 2, rel=1e-7)
    assert limits(with_parameter(problem, "mean", 3.0)) == pytest.approx(as_given * 3, rel=1e-7)


def test_a_phase_there_and_back_changes_no_limit_and_whole_periods_nothing():
    there_and_back = with_parameter(with_parameter(TWO, "phase", 0.3), "phase", -0.3)
    assert limits(there_and_back) == pytest.approx(limits(TWO), rel=1e-9)
    for phase in (0.0, 1.0, -2.0):
        assert np.array_equal(loading(with_parameter(TWO, "phase", phase)).q1, loading(TWO).q1)


def test_without_coupling_both_bounds_are_melans():
    lower, universal, _, upper = limits(replace(TWO, B=0.0 * TWO.B))
    assert lower == universal == pytest.approx(upper, rel=1e-9)


@pytest.mark.parametrize(
    "problem", [TWO, joint(2), shakedown.example("two-node-3d")], ids=["two", "joint", "space"]
)
def test_more_friction_never_lowers_the_largest_load_factor(problem):
    found = [
        shakedown.upper_bound(with_parameter(problem, "friction", factor), certify=False).load_factor
        for factor in (0.3, 0.6, 0.9, 1.0)
    ]
    assert found == sorted(found)
    assert found[0] < found[-1]


def test_friction_factor_and_friction_coefficient_agree():
    assert np.array_equal(with_parameter(TWO, "f", 0.7).f, with_parameter(TWO, "friction", 2.0).f)
    with pytest.raises(UsageError, match=r"same friction coefficient at every node, found .* 'friction'"):
        with_parameter(joint(1), "f", 0.3)


def test_the_mean_takes_transient_load_steps_along_and_the_amplitude_does_not():
    assert np.array_equal(with_parameter(TRANSIENT, "mean", 2.0).p_transient, 2.0 * TRANSIENT.p_transient)
    assert np.array_equal(with_parameter(TRANSIENT, "amplitude", 2.0).p_transient, TRANSIENT.p_transient)


@pytest.mark.parametrize("name", ["mean", "amplitude"])
def test_the_units_of_a_load_are_scaled_with_it(name):
    joint = {"A": [[2.0]], "B": [[0.0]], "f": 0.5, "q_w": [[1.0], [0.0]], "p_w": [[3.0], [3.0]]}
    load = {"load_reactions": [[1.0, 0.0]], "load_history": [[1.0], [0.0]]}
    changed = with_parameter(Problem(**joint, **load), name, 3.0)
    assert np.array_equal(changed.load_history, changed.q_w)


@pytest.mark.parametrize("phase", [0.25, 1.137])
def test_a_phase_moves_the_tangential_part_along_the_period_and_nothing_else(phase):
    changed = with_parameter(TWO, "phase", phase)
    before, after = loading(TWO), loading(changed)
    assert np.array_equal(after.q0, before.q0)
    assert np.array_equal(after.p0, before.p0)
    for periodic in ("q1", "p1"):
        old, new = getattr(before, periodic), getattr(after, periodic)
        assert new.max(axis=0) == pytest.approx(old.max(axis=0), rel=1e-12)  # no corner is cut off
        assert new.min(axis=0) == pytest.approx(old.min(axis=0), rel=1e-12)
    # the same path as that of a loop refined so far that the phase is a whole number of its steps
    fine = 1000 if phase > 1 else 20
    t = np.arange(TWO.m * fine) / (TWO.m * fine)

    def at(samples, times):
        closed = np.vstack([samples, samples[:1]])
        return np.stack([np.interp(times % 1, np.arange(TWO.m + 1) / TWO.m, c) for c in closed.T], axis=1)

    refined = replace(
        TWO,
        q_w=before.q0 + at(before.q1, t - phase),
        p_w=before.p0 + at(before.p1, t),
        q_mean=before.q0,
        p_mean=before.p0,
    )
    assert limits(changed) == pytest.approx(limits(refined), rel=1e-9)


@pytest.mark.parametrize(
    ("name", "value", "error", "message"),
    [
        ("friktion", 1.0, UsageError, "expected one of f, friction, amplitude, .* found 'friktion'"),
        ("f", np.nan, UsageError, "parameter f: expected a finite number, found nan"),
        ("amplitude", -1.0, UsageError, "parameter amplitude: expected a number >= 0"),
        ("f", -0.1, ProblemError, "expected friction coefficients >= 0"),
        ("mean", 1e200, ProblemError, "between 1e-100 and 1e"),
        ("amplitude", 1e308, ProblemError, "expected finite numbers, found"),
    ],
)
def test_what_makes_no_joint_is_said_in_one_line(name, value, error, message):
    with pytest.raises(error, match=message) as caught:
        with_parameter(TWO, name, value)
    assert "\n" not in str(caught.value)


def test_the_corners_of_a_load_domain_have_no_phase():
    domain = replace(shakedown.example("two-node"), load_path="domain")
    with pytest.raises(UsageError, match="phase: expected load steps in their order"):
        with_parameter(domain, "phase", 0.25)
    assert with_parameter(domain, "amplitude", 2.0).is_domain
