"""A solver that fails is asked again with other options; joints on which solvers have failed."""

import joints
import numpy as np
import pytest

import shakedown
from shakedown.ground.errors import Missing, SolverError, attempt
from shakedown.programs.program import Program, equilibration
from shakedown.programs.simplex import Simplex


def linear(seed=0):
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(12, 4))
    cost = matrix.T @ rng.uniform(-1, 0, 12)
    return Simplex(Program(matrix, rng.uniform(1, 2, 12), cost=cost))


def test_units_of_columns_that_are_powers_of_two_change_no_bit():
    matrix, units = np.random.default_rng(0).normal(size=(6, 3)), 2.0 ** np.array([40, -30, 0])
    (rows, columns), (others, scaled) = equilibration(matrix), equilibration(matrix * units)
    np.testing.assert_array_equal(others, rows)
    np.testing.assert_array_equal(scaled * units, columns)


def test_where_a_start_fails_loosened_tolerances_lead_to_the_same_vertex(monkeypatch):
    program, expected = linear(), linear().solve()
    run, failures = Simplex._warm, 3 * [None]
    monkeypatch.setattr(Simplex, "_warm", lambda self: failures.pop() if failures else run(self))
    with pytest.raises(SolverError, match=r"the linear program of shape \(12, 4\) ended as"):
        program.solve()
    for reduced in (True, False):  # the first start fails, then all options are as before
        found = program.solve()
        assert found.reduced_accuracy == reduced
        assert found.x == pytest.approx(expected.x, rel=1e-12)
        assert found.multipliers == pytest.approx(expected.multipliers, abs=1e-12)


def test_only_the_failure_of_a_solver_is_missing_evidence():
    def broken():
        raise TypeError("an error in the program")

    def fails():
        raise SolverError("ended as 'Unknown'")

    assert attempt(fails) == Missing("ended as 'Unknown'")
    with pytest.raises(TypeError):
        attempt(broken)


@pytest.mark.parametrize("seed", [1420, 2249, 2557, 2607])
def test_joints_on_which_the_cone_solver_gives_up_have_their_energy_bound(seed):
    problem, start = joints.wild_joint(np.random.default_rng(seed))
    bound = shakedown.energy_bound(problem, start)
    assert bound.status == "optimal"
    assert bound.residual <= 1e-9
    assert abs(bound.gap) < 1e-4


def test_one_node_at_its_own_critical_friction_has_the_bound_of_melan():
    """Slip of the node shifts its pressure in proportion to its shear: nothing is lost to the ball."""
    for seed in range(15):
        rng = np.random.default_rng(seed)
        stiffness, f = 10.0 ** rng.uniform(-2, 2), rng.uniform(0.1, 2)
        coupling = stiffness / f * rng.choice([-1, 1])  # f |B| = A to round-off
        m = int(rng.integers(2, 8))
        problem = shakedown.Problem(
            A=[[f * abs(coupling)]], B=[[coupling]], C=[[2 * coupling**2 / stiffness]], f=f,
            q_w=rng.normal(size=(m, 1)), p_w=rng.uniform(0.2, 3, (m, 1)),
            q_mean=rng.normal(size=1), p_mean=1 + rng.uniform(size=1),
        )  # fmt: skip
        energy, upper = shakedown.energy_bound(problem), shakedown.upper_bound(problem, certify=False)
        assert energy.status == upper.status
        if energy.status == "optimal":
            assert energy.residual <= 1e-9
            assert energy.load_factor == pytest.approx(upper.load_factor, rel=1e-9)
