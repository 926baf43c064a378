"""The energy norm and γ."""

from dataclasses import replace

import numpy as np
import pytest
from bounds.energy.joints import one_node, strong_joint

import shakedown
from shakedown.bounds.energy.ball_limits import ball_limits, energy_metric, spreads
from shakedown.joint.contact_zone import contact_zone


def gamma_by_subtraction(problem, i, c):
    """sqrt(B_i A⁻¹ B_iᵀ − 2c B_ii + c² A_ii)."""
    A, B = problem.A, problem.B
    return np.sqrt(B[i] @ np.linalg.inv(A) @ B[i] - 2 * c * B[i, i] + c * c * A[i, i])


@pytest.mark.parametrize("seed", range(4))
def test_norm_is_the_square_root_of_twice_the_energy(seed):
    problem = strong_joint(seed, 5)
    e = np.random.default_rng(seed).normal(size=(3, 5))
    expected = np.sqrt(np.einsum("ki,ij,kj->k", e, problem.A, e))
    np.testing.assert_allclose(energy_metric(problem.A, problem.B).norm(e), expected, rtol=1e-12)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("friction", [0.3, 3.0])
def test_gamma_is_least_over_the_splits_that_a_side_admits(seed, friction):
    problem = strong_joint(seed, 4, friction=friction)
    metric = energy_metric(problem.A, problem.B)
    found = spreads(problem.A, problem.B, problem.f, metric) / metric.unit
    for i in range(problem.n):
        f, splits = problem.f[i], np.linspace(-20, 20, 8001)
        values = gamma_by_subtraction(problem, i, splits)
        for column, admitted in enumerate((splits <= 1 / f, splits >= -1 / f)):
            assert found[i, column] <= f * values[admitted].min() * (1 + 1e-12)
            assert found[i, column] == pytest.approx(f * values[admitted].min(), rel=2e-2)


def test_gamma_is_exactly_zero_where_pressure_depends_on_the_own_slip_only():
    for problem in (
        one_node(),
        one_node(B=[[0.7]], C=[[3.0]]),
        shakedown.example("one-node"),
        shakedown.Problem(
            A=np.diag([2.0, 3.0]), B=np.diag([0.3, -1.1]), f=0.4, q_w=[[1.0, 0]], p_w=[[3.0, 3]]
        ),
    ):
        assert not spreads(problem.A, problem.B, problem.f, energy_metric(problem.A, problem.B)).any()


def test_above_its_own_critical_friction_the_side_needs_the_distance_to_its_limit():
    """c = 1/f: the ball must not reach the plane of the limit at all."""
    A, B, f = np.array([[1.0]]), np.array([[3.0]]), np.array([0.5])
    found = spreads(A, B, f, energy_metric(A, B))[0]
    np.testing.assert_allclose(found, [0.5, 0.0], atol=1e-15)  # |f B − A| / √A; forward as before


def test_rigid_motions_have_no_length():
    problem = strong_joint(3, 6, floating=True)
    metric = energy_metric(problem.A, problem.B)
    assert metric.root.shape == (5, 6)
    assert metric.norm(np.ones(6)) <= 1e-12
    np.testing.assert_allclose(metric.root @ metric.inverse, np.eye(5), atol=1e-12)
    e = np.random.default_rng(0).normal(size=6)
    assert metric.norm(e) == pytest.approx(metric.norm(e + 7.0), rel=1e-12)
    assert metric.norm(e) == pytest.approx(np.sqrt(e @ problem.A @ e), rel=1e-9)


def test_a_singular_stiffness_gives_the_limit_of_regular_ones():
    problem = strong_joint(5, 4, floating=True)
    supported = problem.A + 1e-7 * np.ones((4, 4))
    floating, held = (
        spreads(A, problem.B, problem.f, metric) / metric.unit
        for A in (problem.A, supported)
        for metric in (energy_metric(A, problem.B),)
    )
    np.testing.assert_allclose(floating, held, rtol=1e-5)


def test_a_pressure_that_a_free_slip_changes_has_no_bound():
    A, B = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([[1.0, 0.0], [0.5, -0.5]])
    found = spreads(A, B, np.array([0.3, 0.3]), energy_metric(A, B))
    assert np.isinf(found[0]).all()
    assert np.isfinite(found[1]).all()


def test_limits_of_a_problem_are_built_once_for_each_set_of_tolerances():
    problem = strong_joint(0, 4)
    limits = ball_limits(contact_zone(problem, ()))
    assert ball_limits(contact_zone(problem, ())) is limits
    other = ball_limits(contact_zone(problem, ()), tolerances=replace(shakedown.Tolerances(), zero_mode=1e-7))
    assert other is not limits
    assert np.array_equal(other.spread, limits.spread)
    stiffer = ball_limits(contact_zone(replace(problem, A=2.0 * problem.A), ()))
    assert stiffer.metric.norm(np.ones(4)) == pytest.approx(np.sqrt(2.0) * limits.metric.norm(np.ones(4)))
