"""The ways to the vertex of a linear program: the rows that meet, HiGHS, other options where it fails; hard joints."""

from dataclasses import replace

import joints
import numpy as np
import pytest

import shakedown
from benchmarks.problems import chain, joint
from shakedown.bounds.certificate import load_factor_program
from shakedown.ground.errors import Missing, SolverError, attempt
from shakedown.joint.constraints import constraints
from shakedown.programs.program import INF, Program, equilibration, polished
from shakedown.programs.simplex import Simplex, chebyshev_centre, solve


def square(cost, upper=(1.0, 1.0)):
    """x ≤ upper, x ≥ −1 as columns' bounds."""
    return Simplex(Program(np.eye(2), np.array(upper), cost=np.array(cost), lower=-np.ones(2)))


def residuals(found):
    """Violation of rows and bounds, of the balance and signs of multipliers, and the gap, in numbers near 1."""
    program, x, scales = found.solved, found.x / found.scales.x, found.scales
    y = found.multipliers * scales.cost / scales.row
    rest = program.cost + y @ program.matrix
    side = np.where(y > 0, program.right, program.left)
    bound = np.where(rest > 0, program.lower, program.upper)
    wrong = np.append(np.abs(y)[np.isinf(side)], np.abs(rest)[np.isinf(bound)])
    proved = -y @ np.where(np.isinf(side), 0, side) + rest @ np.where(np.isinf(bound), 0, bound)
    size = max(np.abs(program.cost) @ np.abs(x), 1e-300)
    return program.violation(x), wrong.max(initial=0.0), abs(program.cost @ x - proved) / size


def test_a_vertex_is_taken_only_where_it_is_optimal():
    both = np.arange(2)
    assert square((-1.0, -2.0)).at(both).x == pytest.approx([1.0, 1.0])
    assert square((-1.0, -2.0), upper=(1.0, 1e-17)).at(both).x == pytest.approx([1.0, 1e-17], abs=0.0)
    assert square((-1.0, 2.0)).at(both) is None  # a multiplier of the wrong sign
    assert square((-1.0, -2.0), upper=(1.0, -3.0)).at(both) is None  # below its bound
    assert square((-1.0, -2.0)).at(np.array([0, 0])) is None  # meets nowhere


def test_a_vertex_is_solved_for_with_other_columns_at_their_bounds():
    program = Program(np.array([[2.0, 0.5], [1.0, 0.0]]), np.array([3.0, 9.0]), np.array([-4.0, -2.0]),
                      np.full(2, -INF), np.array([-INF, -1.0]), np.array([INF, 2.0]))  # fmt: skip
    for y, x in ((2.0, 1.0), (-1.0, 1.75)):
        found = polished(program, np.array([x + 1e-7, y]), np.array([1.9, 0.0]), (np.arange(1), np.arange(1)))
        np.testing.assert_allclose(found[0], [x, y], rtol=1e-15)
        np.testing.assert_allclose(found[1], [2.0, 0.0], rtol=1e-15)


def test_a_row_without_entries_holds_or_does_not_whatever_its_unit():
    for right, status in ((-1e-15, "infeasible"), (0.0, "optimal"), (1e-15, "optimal")):
        program = Program(np.array([[1.0], [0.0]]), np.array([1.0, right]), cost=np.array([-1.0]))
        assert solve(program).status == status


def test_bounds_changed_before_the_solver_is_made_count():
    """x ≤ 1, y ≤ a and 1024 (x + y) ≤ 1024 b, and the mirror image of that."""
    right, free, rows = np.array([1.0, 1.0, 2048.0]), np.full(3, -INF), np.arange(1, 3)
    program = Program(np.vstack([np.eye(2), np.full(2, 1024.0)]), right, np.array([-1.0, -2.0]), free)
    above, below = Simplex(program), Simplex(replace(program, cost=-program.cost, left=-right, right=-free))
    for sides in ([0.5, 1.25], [0.75, 1.0]):
        new = np.array(sides) * [1.0, 1024.0]
        above.set_rows(rows, free[rows], new)
        below.set_rows(rows, -new, -free[rows])
        for end, sign in ((above.solve(), 1.0), (below.solve(), -1.0)):
            assert sign * end.x == pytest.approx([sides[1] - sides[0], sides[0]])


@pytest.mark.parametrize("problem", [joint(n=30, seed=1), joint(n=90), chain(90)], ids=["30", "90", "chain"])
def test_an_upper_bound_is_optimal_to_round_off(problem):
    end = solve(load_factor_program(constraints(problem), towards=-1.0))
    assert not end.reduced_accuracy
    assert max(residuals(end)) <= 1e-12


@pytest.mark.parametrize("seed", range(4))
def test_changed_rows_lead_where_a_new_program_ends(seed):
    rows = constraints(joint(n=12, seed=seed))
    held = Simplex(load_factor_program(rows, towards=-1.0))
    most, steep = held.solve().x[-1], np.flatnonzero(rows.d > 0)[:1]
    right = 0.5 * most * rows.d[steep] - 1e-3
    held.set_rows(steep, np.array([-INF]), right)
    sides = rows.g.copy()
    sides[steep] = right
    end, new = held.solve(), solve(load_factor_program(replace(rows, g=sides), towards=-1.0))
    assert max(residuals(end)) <= 1e-12
    np.testing.assert_allclose(end.x, new.x, rtol=1e-9)
    assert end.value == pytest.approx(new.value, rel=1e-9)


def test_a_slip_that_meets_little_resistance_is_followed_as_far_as_it_gains():
    """A reduced cost of 3e-11 is none for HiGHS; where slips of 2e7 are possible it is 6e-4 of the optimum."""
    matrix = np.array([[1.0, -1.0, 0.0], [1e-7 - 1.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    program = Program(matrix, np.ones(3), np.array([-3e-11, 0.0, -1.0]), np.full(3, -INF))
    for given in (program, replace(program, matrix=-matrix, left=-program.right, right=-program.left)):
        found = solve(given)
        assert found.x[0] == pytest.approx(2e7, rel=1e-8)
        assert found.value == pytest.approx(-1.0006, rel=1e-12)


def test_a_load_factor_from_zero_on_is_not_unbounded_below():
    """HiGHS says so of the first collapse just above the friction threshold: no pivot is large enough."""
    loads = {"q_w": [[1.0], [-1.3]], "p_w": [[3.0], [3.5]]}
    above = shakedown.Problem(A=[[1.0]], B=[[0.5]], f=2.0 * (1 + 1e-9), **loads)
    assert shakedown.lower_bound(above).status == "optimal"
    assert shakedown.lower_bound(above, certify=True).load_factor == 0.0


def test_a_column_in_no_row_is_at_the_bound_where_its_cost_wants_it():
    """It was taken for what round-off leaves of a zero: x = 0 with the value of x = 2."""
    program = Program(
        np.array([[0.0, 1.0, 0.0, 0.0]]), np.ones(1), cost=np.array([-1.0, -1.0, 0.0, 1.0]),
        lower=np.array([-1.0, -1, -1, -4]), upper=np.array([2.0, 5, 3, 5]),
    )  # fmt: skip
    found = solve(program)
    assert found.x == pytest.approx([2.0, 1.0, 0.0, -4.0])
    assert found.value == pytest.approx(-7.0)
    idle = Program(
        np.eye(1, 4), np.ones(1), cost=np.array([-1.0, 1.0, 0.0, -1.0]),
        lower=np.array([-1.0, -4.0, -INF, -INF]), upper=np.array([INF, INF, INF, 3.0]),
    )  # fmt: skip
    assert Simplex(idle).at(np.arange(1)).x == pytest.approx([1.0, -4.0, 0.0, 3.0])
    for wrong in ([-1.0, -1.0, 0.0, -1.0], [-1.0, 1.0, 0.1, -1.0], [-1.0, 1.0, 0.0, 1.0]):
        assert Simplex(replace(idle, cost=np.array(wrong))).at(np.arange(1)) is None
    assert max(residuals(found)) <= 1e-15


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
    more = equilibration(np.vstack([matrix, [0.0, 1e6, 0.0]]))  # one entry says nothing of its column's unit
    np.testing.assert_array_equal(more[0][:-1], rows)
    np.testing.assert_array_equal(more[1], columns)
    assert [scale[-1] for scale in equilibration(np.pad(matrix, (0, 1)))] == [1.0, 1.0]


def test_the_unit_of_the_cost_changes_no_bit_of_what_is_solved():
    program = linear().program
    for unit in (2.0**-40, 2.0**40):
        other = replace(program, cost=unit * program.cost)
        np.testing.assert_array_equal(other.scaled()[0].cost, program.scaled()[0].cost)
        larger = solve(replace(other, right=unit * program.right))
        assert larger.value == unit**2 * solve(program).value == pytest.approx(larger.x @ other.cost)


def test_the_centre_of_a_polyhedron_stays_where_one_column_is_not_negative():
    """−3 ≤ x ≤ 1/2 has the centre −5/4; of x ≥ 0, from which no distance is kept, 0 is the farthest inside."""
    between = np.array([[1.0], [-1.0]]), np.ones(2), np.array([0.5, 3.0])
    for signed, x, margin in ((None, -1.25, 1.75), (0, 0.0, 0.5)):
        found = chebyshev_centre(*between, cap=INF, signed=signed)
        assert (found.x, found.margin) == (pytest.approx([x]), pytest.approx(margin))
        assert found.multipliers @ np.transpose(between[1:]) == pytest.approx([1.0, margin])
    assert chebyshev_centre(np.zeros((1, 1)), np.zeros(1), -np.ones(1), cap=INF).margin == -INF


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


def test_where_rows_meet_in_no_point_the_values_of_the_solver_stand(monkeypatch):
    def singular(_):
        raise np.linalg.LinAlgError

    monkeypatch.setattr(np.linalg, "inv", singular)
    assert max(residuals(linear().solve())) <= 1e-9


def test_only_the_failure_of_a_solver_is_missing_evidence():
    def fails(error):
        raise error

    assert attempt(fails, SolverError("ended as 'Unknown'")) == Missing("ended as 'Unknown'")
    with pytest.raises(TypeError):
        attempt(fails, TypeError("an error in the program"))


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
