"""Programs with many second-order cones, optima built backwards: through Clarabel and cvxpy."""

import sys
from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.bounds.independent_solver import conic_upper_bound
from shakedown.ground.errors import UsageError
from shakedown.programs.conic import by_clarabel, by_cvxpy
from shakedown.programs.program import INF, Program
from shakedown.programs.simplex import solve


def discs(seed, columns=6, cones=30, size=3, rows=5):
    """(program, x, y): every cone is met on its surface with a multiplier there, or left alone."""
    rng = np.random.default_rng(seed)
    x, count = rng.normal(size=columns), rows + cones * size
    matrix = rng.normal(size=(count, columns))
    slack, y = np.zeros(count), np.zeros(count)
    slack[:rows] = np.where(np.arange(rows) % 2, 0.0, 0.7)
    y[:rows] = np.where(np.arange(rows) % 2, 0.4, 0.0)
    for k in range(cones):
        ends, w = slice(rows + k * size, rows + (k + 1) * size), rng.normal(size=size - 1)
        length = np.linalg.norm(w)
        if k < 3:
            slack[ends], y[ends] = np.append(length, w), 0.5 * np.append(length, -w)
        else:
            slack[ends] = np.append(length + 1.0, w)
    return Program(matrix, matrix @ x + slack, cost=-y @ matrix, cones=(size,) * cones), x, y


def judged_by(found):
    """The largest residual of a solution, computed anew."""
    return np.abs(found.residuals).max()


def in_units(program, x, y, rows, columns):
    """The same in other units: of the rows (one for a whole cone) and of the columns."""
    scale = np.append(
        np.full(program.linear, rows[0]), np.repeat(rows[1], len(program.right) - program.linear)
    )
    other = Program(
        program.matrix * scale[:, None] / columns, program.right * scale,
        cost=program.cost / columns, cones=program.cones,
    )  # fmt: skip
    return other, x * columns, y / scale


def through_cvxpy(program):
    return by_cvxpy(program, "CLARABEL", 1e-9)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("by", "near", "limit"), [(solve, 1e-5, 1e-9), (through_cvxpy, 1e-4, 1e-8)])
def test_every_method_ends_where_the_program_was_built(seed, by, near, limit):
    program, x, y = discs(seed)
    found = by(program)
    assert found.status == "optimal"
    np.testing.assert_allclose(found.x, x, atol=near)
    np.testing.assert_allclose(found.multipliers, y, atol=near)
    assert judged_by(found) <= limit
    assert found.value == pytest.approx(program.cost @ x, rel=10 * limit)


@pytest.mark.parametrize("rows", [(1e6, 1e-6), (1e-5, 1e7)])
def test_units_of_cones_rows_and_columns_do_not_matter(rows):
    columns = 10.0 ** np.linspace(-6, 6, 6)
    program, x, y = in_units(*discs(7), rows, columns)
    found = by_clarabel(program)
    np.testing.assert_allclose(found.x / columns, x / columns, atol=1e-7)
    unit = found.scales.y
    np.testing.assert_allclose(found.multipliers / unit, y / unit, atol=1e-6)
    assert judged_by(found) <= 1e-8


def test_thousands_of_cones_of_different_sizes():
    rng = np.random.default_rng(0)
    sizes = tuple(rng.integers(2, 5, 2000).tolist())
    matrix, x = rng.normal(size=(sum(sizes), 12)), rng.normal(size=12)
    slack = rng.normal(size=sum(sizes))
    starts = np.cumsum([0, *sizes[:-1]])
    for start, size in zip(starts, sizes, strict=True):
        slack[start] = np.linalg.norm(slack[start + 1 : start + size]) + rng.uniform(0.0, 1.0)
    program = Program(matrix, matrix @ x + slack, cost=rng.normal(size=12), cones=sizes)
    found = solve(program)
    assert found.status == "optimal"
    assert judged_by(found) <= 1e-8
    assert found.value <= program.cost @ x


def test_equalities_and_bounds_stand_beside_cones():
    """The point of a disc about the origin, on a line, farthest along it: cut off by a bound, or not."""
    matrix = np.array([[1.0, 1.0], [0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]])
    for upper, expected in ((INF, (1 + np.sqrt(7)) / 2), (1.5, 1.5)):
        program = Program(
            matrix, np.array([1.0, 2.0, 0.0, 0.0]), cost=np.array([-1.0, 0.0]),
            cones=(3,), left=np.array(1.0), upper=np.array([upper, INF]),
        )  # fmt: skip
        for found in (solve(program), through_cvxpy(program)):
            assert found.x == pytest.approx([expected, 1 - expected], abs=1e-6)
            assert judged_by(found) <= 1e-6


def test_statuses_without_an_optimum():
    ball = np.array([[0.0], [-1.0]])  # |x| ≤ 1
    nothing = Program(np.vstack([[[-1.0]], ball]), np.array([-2.0, 1.0, 0.0]), cost=np.ones(1), cones=(2,))
    assert solve(nothing).status == "infeasible"
    ray = Program(np.array([[-1.0, 0.0], [0.0, -1.0]]), np.zeros(2), cost=np.array([-1.0, 0.0]), cones=(2,))
    assert solve(ray).status == "unbounded"
    assert solve(ray).x[0] > 0


def test_what_is_wrong_shows_in_the_residuals():
    program, x, y = discs(1)
    right = solve(program)
    solved, scales = right.solved, right.scales
    assert np.abs(solved.residuals(x / scales.x, y / scales.y)).max() <= 1e-12
    beyond = x + 1e-3 * np.linalg.lstsq(program.matrix, program.right, rcond=None)[0]
    assert solved.residuals(beyond / scales.x, y / scales.y).primal > 1e-6
    assert solved.residuals(x / scales.x, (y + 1e-3) / scales.y).dual > 1e-6
    assert abs(solved.residuals(x / scales.x, 1.001 * y / scales.y).gap) > 1e-7


@pytest.mark.parametrize("count", [2, 3, 8])
def test_right_sides_that_are_round_off_are_no_size(count):
    """Beside one cone with a right side of its own those of the others are 1e-17: as if they were zero."""
    rng = np.random.default_rng(0)
    matrix, right = rng.normal(size=(3 * count, 5)), 1e-17 * rng.normal(size=3 * count)
    matrix[::3, 4], matrix[1::3, 4], matrix[2::3, 4] = 1.0, 0.0, 0.0
    right[:3] = 1.0, 0.2, 0.1
    told = Program(
        matrix, right, np.array([0, 0, 0, 0, -1.0]), (3,) * count, upper=np.append(np.full(4, INF), 1)
    )
    still = replace(told, right=np.where(np.abs(right) < 1e-15, 0.0, right))
    found, other = solve(told), solve(still)
    assert found.optimal
    assert other.optimal
    assert found.x[-1] == pytest.approx(other.x[-1], abs=1e-9)


def test_without_cvxpy_its_solvers_are_refused_in_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "cvxpy", None)
    with pytest.raises(UsageError, match=r"^solver: 'SCS' needs cvxpy.*shakedown-bounds\[solvers\]'$"):
        conic_upper_bound(shakedown.example("two-node"), solver="SCS")
