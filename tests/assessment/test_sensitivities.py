"""Sensitivities against finite differences, at regular and at degenerate optima, and what scaling demands."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from joints import joint_of_kind

import shakedown
from benchmarks.problems import in_units
from shakedown.assessment.sensitivities import KINDS, sensitivities
from shakedown.joint.constraints import loading

STEP = 1e-3
upper, energy = (partial(bound, certify=False) for bound in (shakedown.upper_bound, shakedown.energy_bound))


def changed(problem, kind, node, change):
    """The joint with one quantity of one node changed by a share of it."""
    loop, at = loading(problem), 1.0 + change
    parts = [np.array(part) for part in (loop.q0, loop.p0, loop.q1, loop.p1)]
    before = [None if part is None else np.array(part) for part in (problem.q_transient, problem.p_transient)]
    f = np.array(problem.f)
    if kind == "friction":
        f[node] *= at
    scaled = {"constant": [*parts[:2], *before], "amplitude": parts[2:]}.get(kind, [])
    for part in scaled:
        if part is not None:
            part[..., node] *= at
    q0, p0, q1, p1 = parts
    return replace(
        problem, f=f, q_w=q0 + q1, p_w=p0 + p1, q_mean=q0, p_mean=p0, q_transient=before[0], p_transient=before[1]
    )  # fmt: skip


def by_differences(problem, bound, here, kind, node):
    """The elasticity by central differences of order four; ``here`` is the load factor of the joint."""
    at = [bound(changed(problem, kind, node, k * STEP)).load_factor for k in (-2, -1, 1, 2)]
    return (at[0] - 8 * at[1] + 8 * at[2] - at[3]) / (12 * STEP) / here


def on_each_side(problem, bound, here, kind, node, step=1e-6):
    fallen, grown = (bound(changed(problem, kind, node, sign * step)).load_factor for sign in (-1, 1))
    return np.array([here - fallen, grown - here]) / step / here


def largest_error(problem, bound):
    """Of every elasticity against differences; NaN where there is no bound or the optimum changes nearby."""
    found = bound(problem)
    if found.status != "optimal" or not found.load_factor > 1e-3:
        return np.nan
    known, errors = sensitivities(problem, found), []
    sizes = max(np.abs(getattr(known, kind).elasticity).max() for kind in KINDS)
    for kind in KINDS:
        for node in range(problem.n):
            asked = problem, bound, found.load_factor, kind, node
            near = [by_differences(*asked), *on_each_side(*asked)]
            if np.ptp(near) > 1e-4 * max(sizes, 1.0):
                return np.nan
            errors.append(near[0] - getattr(known, kind).elasticity[node])
    return np.abs(errors).max() / max(sizes, 1.0)


@pytest.mark.parametrize("name", ["one-node", "two-node"])
@pytest.mark.parametrize("bound", [upper, energy])
def test_built_in_joints_agree_with_differences(name, bound):
    assert largest_error(shakedown.example(name), bound) < 1e-6


@pytest.mark.parametrize("distance", [0.0, 0.3])
def test_a_node_above_its_own_critical_friction_agrees_with_differences(distance):
    """Also of a state that is known to a distance."""
    rng = np.random.default_rng(2)
    given = {"A": [[2.0, 0.5], [0.5, 3.0]], "B": 3.0 * rng.normal(size=(2, 2)), "f": 0.7}
    loads = {"q_w": rng.normal(size=(4, 2)), "p_w": 5.0 + 0.3 * rng.normal(size=(4, 2))}
    assert largest_error(shakedown.Problem(**given, **loads), partial(energy, distance=distance)) < 1e-6


def test_with_open_nodes_the_loads_of_all_nodes_count():
    """Where they stay clear of the other body, and where one is about to touch it at λ_max."""
    rng, errors, touching = np.random.default_rng(3), [], 0
    for _ in range(12):
        problem = joint_of_kind(rng, "loose")
        if problem.n not in (2, 3):  # of more every derivative takes long
            continue
        node = int(rng.integers(problem.n))
        lifted, zone = np.array(problem.p_w), {"open_nodes": (node,)}
        lifted[:, node] -= 2.0
        problem = replace(problem, p_w=lifted, p_transient=None, q_transient=None)
        errors += [largest_error(problem, partial(bound, **zone)) for bound in (upper, energy)]
        touching += np.isfinite(errors[-2]) and node in dict(upper(problem, **zone).active)
    errors = np.array(errors)
    assert np.sum(np.isfinite(errors)) - touching >= 3
    assert touching >= 1
    assert np.nanmax(errors) < 1e-6


def twice(problem):
    """Two copies of a joint that know nothing of each other: both limit, and the multipliers are anyone's."""
    pair = {key: np.kron(np.eye(2), getattr(problem, key)) for key in "ABC"}
    loads = ("q_w", "p_w", "q_transient", "p_transient", "q_mean", "p_mean")
    both = {k: np.concatenate([v, v], axis=-1) for k in loads if (v := getattr(problem, k)) is not None}
    return shakedown.Problem(**pair, **both, f=np.tile(problem.f, 2))


@pytest.mark.parametrize("bound", [upper, energy])
def test_where_several_nodes_limit_alike_there_is_no_derivative(bound):
    pair = twice(joint_of_kind(np.random.default_rng(5), "loose"))
    found = bound(pair)
    known = sensitivities(pair, found)
    assert (known.status, known.load_factor) == ("optimal", found.load_factor)
    assert ("uncoupled parts" if bound is energy else "not unique") in known.reason
    assert all(np.isnan(getattr(known, kind).elasticity).all() for kind in KINDS)


def test_where_load_steps_with_unlike_pressures_limit_alike_friction_has_no_derivative():
    loads = {"q_w": [[1.0], [2.0], [-1.0]], "p_w": [[10.0], [12.0], [10.0]]}
    problem = shakedown.Problem(A=[[1.0]], B=[[0.0]], f=0.5, q_mean=[0.0], p_mean=[10.0], **loads)
    found = upper(problem)
    known = sensitivities(problem, found)
    fallen, grown = on_each_side(problem, upper, found.load_factor, "friction", 0)
    assert fallen > 1.01 * grown
    assert np.isnan(known.friction.elasticity).all()
    assert "several load steps" in known.reason
    assert not known.smooth
    assert known.amplitude.elasticity == pytest.approx([-1.0], rel=1e-9)


@pytest.mark.parametrize("name", ["two-node", "block-9", "cantilevered-block"])
def test_all_constant_loads_together_count_as_one_and_all_amplitudes_as_minus_one(name):
    problem = in_units(shakedown.example(name), 2.0**40, 2.0**-20)
    for bound in (upper(problem), energy(problem)):
        if bound.status != "optimal":
            continue
        known = sensitivities(problem, bound)
        assert known.constant.together == pytest.approx(1.0, rel=1e-9)
        assert known.amplitude.together == pytest.approx(-1.0, rel=1e-9)
        assert known.amplitude.elasticity.sum() == pytest.approx(-1.0, rel=1e-9)


def test_there_are_none_without_a_load_factor():
    floating = shakedown.example("one-node-separation")
    known = sensitivities(floating, upper(floating))
    assert known.status != "optimal"
    assert known.reason
    assert np.isnan(known.friction.derivative).all()


def test_a_bound_of_another_joint_or_kind_is_refused():
    joint = shakedown.example("two-node")
    with pytest.raises(shakedown.UsageError, match="expected one of a joint with 2 nodes, found 3"):
        sensitivities(joint, upper(shakedown.example("three-node")))
    with pytest.raises(shakedown.UsageError, match="expected λ_max or λ_E, found λ_1"):
        sensitivities(joint, shakedown.lower_bound(joint))
