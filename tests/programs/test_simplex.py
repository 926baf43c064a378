"""The ways to the vertex of a linear program: the rows that meet, HiGHS."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from benchmarks.problems import chain, joint
from shakedown.bounds.certificate import load_factor_program
from shakedown.joint.constraints import constraints
from shakedown.programs.program import INF, Program
from shakedown.programs.simplex import Simplex, solve


def square(cost, upper=(1.0, 1.0)):
    """x ≤ upper, x ≥ −1 as columns' bounds."""
    return Simplex(Program(np.eye(2), np.array(upper), cost=np.array(cost), lower=-np.ones(2)))


def residuals(found):
    """Violation of rows and bounds, of the balance and signs of multipliers, and the gap, in numbers near 1."""
    program, x, y = (
        found.solved,
        found.x / found.scales.x,
        found.multipliers * found.scales.cost / found.scales.row,
    )
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
    assert square((-1.0, 2.0)).at(both) is None  # a multiplier of the wrong sign
    assert square((-1.0, -2.0), upper=(1.0, -3.0)).at(both) is None  # below its bound
    assert square((-1.0, -2.0)).at(np.array([0, 0])) is None  # meets nowhere


def test_a_row_is_met_at_either_side():
    program = Program(np.eye(2), np.ones(2), cost=np.array([1.0, -1.0]), left=-2.0 * np.ones(2))
    assert solve(program).x == pytest.approx([-2.0, 1.0])


def test_bounds_changed_before_the_solver_is_made_count():
    program = square((-1.0, -2.0))
    program.set_rows(np.array([1]), np.array([-INF]), np.array([0.25]))
    assert program.solve().x == pytest.approx([1.0, 0.25])
    program.set_rows(np.array([1]), np.array([-INF]), np.array([0.75]))
    assert program.solve().x == pytest.approx([1.0, 0.75])


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
    program = Simplex(Program(matrix, np.ones(3), cost=np.array([-3e-11, 0.0, -1.0])))
    assert program.solve().x[0] == pytest.approx(2e7, rel=1e-8)
    assert program.solve().value == pytest.approx(-1.0006, rel=1e-12)


def test_a_load_factor_from_zero_on_is_not_unbounded_below():
    """HiGHS says so of the first collapse just above the friction threshold: no pivot is large enough."""
    loads = {"q_w": [[1.0], [-1.3]], "p_w": [[3.0], [3.5]]}
    above = shakedown.Problem(A=[[1.0]], B=[[0.5]], f=2.0 * (1 + 1e-9), **loads)
    assert shakedown.lower_bound(above).status == "optimal"
    assert shakedown.lower_bound(above, certify=True).load_factor == 0.0


def test_a_column_in_no_row_is_at_the_bound_where_its_cost_wants_it():
    """It was taken for what round-off leaves of a zero: x = 0 with the value of x = 2."""
    program = Program(
        np.array([[0.0, 1.0, 0.0]]), np.ones(1), cost=np.array([-1.0, -1.0, 0.0]), upper=np.array([2.0, 5, 3])
    )
    found = solve(program)
    assert found.x == pytest.approx([2.0, 1.0, 0.0])
    assert found.value == pytest.approx(-3.0)
    assert max(residuals(found)) <= 1e-15
