"""The energy norm and γ."""

import numpy as np
import pytest
from bounds.energy.joints import strong_joint

from shakedown.bounds.energy.ball_limits import energy_metric, spreads


def gamma_by_subtraction(problem, i, c):
    """sqrt(B_i A⁻¹ B_iᵀ − 2c B_ii + c² A_ii)."""
    A, B = problem.A, problem.B
    return np.sqrt(B[i] @ np.linalg.inv(A) @ B[i] - 2 * c * B[i, i] + c * c * A[i, i])


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


def test_above_its_own_critical_friction_the_side_needs_the_distance_to_its_limit():
    """c = 1/f: the ball must not reach the plane of the limit at all."""
    A, B, f = np.array([[1.0]]), np.array([[3.0]]), np.array([0.5])
    found = spreads(A, B, f, energy_metric(A, B))[0]
    np.testing.assert_allclose(found, [0.5, 0.0], atol=1e-15)  # |f B − A| / √A; forward as before
