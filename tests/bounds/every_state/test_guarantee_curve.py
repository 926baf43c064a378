"""Guarantee curve: its ends, known values, and the invariance of the boxes by simulation."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import Problem
from shakedown.joint.loading import loading


def step(problem: Problem, q: np.ndarray, p: np.ndarray, v: np.ndarray) -> np.ndarray:
    """One implicit load step with all nodes closed."""
    fB, before, v = problem.f[:, None] * problem.B, v.copy(), v.copy()
    for _ in range(120):
        for j in range(problem.n):
            q_rest = q[j] + problem.A[j] @ v - problem.A[j, j] * v[j]
            fp_rest = problem.f[j] * p[j] + fB[j] @ v - fB[j, j] * v[j]
            upper = (fp_rest - q_rest) / (problem.A[j, j] - fB[j, j])
            lower = -(fp_rest + q_rest) / (problem.A[j, j] + fB[j, j])
            v[j] = min(max(before[j], lower), upper)
    return v


def test_block_9_values() -> None:
    problem, radii = shakedown.example("block-9"), [0.25, 1.0, 4.0, 8.0]
    curve = shakedown.guarantee_curve(problem, radii, weights=np.ones(9))
    np.testing.assert_allclose(curve.load_factors, [4.663, 4.551, 4.109, 3.521], atol=6e-4)
    assert not curve.invariant
    assert shakedown.guarantee_curve(problem, radii).invariant  # in the weights of the coupling ratio


@pytest.mark.parametrize("name", ["two-node", "three-node", "block-9", "uncoupled"])
def test_falls_from_the_upper_to_the_lower_bound(name: str) -> None:
    problem = replace(shakedown.example(name), f=0.3)
    bounds = shakedown.shakedown_bounds(problem, certify=False)
    curve = shakedown.guarantee_curve(problem, [0.0, 0.1, 0.5, 1.0, 3.0, 1e5])
    assert curve.load_factors[0] == pytest.approx(bounds.upper.load_factor, rel=1e-9)
    assert curve.load_factors[-1] == pytest.approx(bounds.lower.load_factor, rel=1e-9)
    assert np.all(np.diff(curve.load_factors) <= 1e-12)


def test_witness_lies_in_the_box() -> None:
    problem = shakedown.example("block-9")
    curve = shakedown.guarantee_curve(problem, [0.5, 2.0])
    for radius, node, slip in zip(curve.radii, curve.nodes, curve.slips, strict=True):
        distance = np.abs(slip - curve.centre) / (curve.unit * curve.weights)
        assert np.all(np.delete(distance, node) <= radius * (1 + 1e-9))


@pytest.mark.parametrize("seed", [0])
def test_boxes_are_invariant_below_coupling_ratio_one(seed: int) -> None:
    problem = replace(shakedown.example("block-9"), f=0.2)
    curve = shakedown.guarantee_curve(problem, [1.0])
    assert curve.invariant
    load_factor = 0.95 * shakedown.upper_bound(problem).load_factor
    q, p = loading(problem).at(load_factor)
    rng = np.random.default_rng(seed)
    box = curve.unit * curve.weights
    v = curve.centre + rng.uniform(-1, 1, 9) * box
    size = np.abs((v - curve.centre) / box).max()
    for k in range(2 * problem.m):
        v = step(problem, q[k % problem.m], p[k % problem.m], v)
        now = np.abs((v - curve.centre) / box).max()
        assert now <= size * (1 + 1e-9)
        size = now


def test_a_box_about_an_unsafe_slip_is_not_invariant() -> None:
    curve = shakedown.guarantee_curve(shakedown.example("two-node"), [0.0, 1.0], centre=[50.0, -70.0])
    assert not curve.invariant  # every limit of both nodes is far from there


def test_a_slip_that_is_safe_only_under_load_makes_no_invariant_box() -> None:
    """One node whose mean lies outside the loop: the middle at λ_max is beyond the limits of the mean."""
    loop = {"q_w": [[3.0], [4.0]], "p_w": [[1.0], [1.0]], "q_mean": [0.0], "p_mean": [1.0]}
    problem = Problem(A=[[1.0]], B=[[0.1]], f=0.5, **loop)
    curve = shakedown.guarantee_curve(problem, [0.0])
    assert curve.centre[0] < -0.6
    assert not curve.invariant


def test_boxes_of_a_floating_body_are_not_invariant() -> None:
    """ρ* = 1 exactly, whatever the weights: nothing bounds the rigid slip."""
    A, B = [[1.0, -1.0], [-1.0, 1.0]], [[0.3, -0.3], [0.2, -0.2]]
    problem = Problem(A=A, B=B, f=0.5, q_w=[[0.3, -0.2], [-0.3, 0.1]], p_w=[[3.0, 3.2], [3.0, 2.9]])
    assert not shakedown.guarantee_curve(problem, [0.0, 1.0], weights=[1.0, 1.0]).invariant


def test_no_safe_slip_is_a_status() -> None:
    problem = shakedown.example("two-node")
    curve = shakedown.guarantee_curve(replace(problem, p_w=problem.p_w - 9000.0), [1.0])
    assert curve.status == "infeasible"
    assert np.isnan(curve.load_factors[0])


@pytest.mark.parametrize(
    "arguments",
    [
        {"radii": [-1.0]},
        {"radii": [np.nan]},
        {"radii": [1.0], "weights": [1.0, -1.0]},
        {"radii": [1.0], "centre": [1.0]},
    ],
)
def test_misuse_is_refused(arguments: dict) -> None:
    with pytest.raises(shakedown.UsageError):
        shakedown.guarantee_curve(shakedown.example("two-node"), **arguments)
