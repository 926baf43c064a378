"""Dense interior points: optima built backwards, degenerate ones, programs without one."""

import numpy as np
import pytest

from shakedown.programs.dense_programs import cone_optimum, meeting_rows


def built_backwards(n: int, spare: int, seed: int):
    """max cᵀx with ``n + spare`` rows meeting at x*, n of them pushing, and the rows that push."""
    rng = np.random.default_rng(seed)
    count = 3 * n
    matrix, x = rng.normal(size=(count, n)), rng.normal(size=n)
    pushing = np.sort(rng.choice(count, n, replace=False))
    slack = rng.uniform(0.5, 2.0, count)
    slack[pushing] = 0.0
    others = np.setdiff1d(np.arange(count), pushing)
    slack[others[:spare]] = 0.0
    y = np.zeros(count)
    y[pushing] = rng.uniform(0.5, 2.0, n)
    return matrix, matrix @ x + slack, -(y @ matrix), x, pushing


@pytest.mark.parametrize("n", [1, 7, 40])
@pytest.mark.parametrize("units", [(1e9, 1e-7)])
def test_the_rows_that_push_are_found(n, units):
    for seed in range(5):
        matrix, right, cost, _, pushing = built_backwards(n, 0, seed)
        rows = meeting_rows(matrix * units[0], right * units[0] * units[1], cost)
        np.testing.assert_array_equal(rows, pushing)


@pytest.mark.parametrize("spare", [1, 3])
def test_where_more_rows_meet_those_left_have_a_vertex_and_multipliers(spare):
    for seed in range(5):
        matrix, right, cost, x, _ = built_backwards(10, spare, seed)
        rows = meeting_rows(matrix, right, cost)
        np.testing.assert_allclose(np.linalg.solve(matrix[rows], right[rows]), x, atol=1e-8)
        assert np.linalg.solve(matrix[rows].T, -cost).min() >= -1e-8


def test_columns_without_an_entry_are_left_out():
    matrix, right, cost, _, pushing = built_backwards(6, 0, 3)
    wider = np.insert(matrix, 2, 0.0, axis=1)
    np.testing.assert_array_equal(meeting_rows(wider, right, np.insert(cost, 2, 0.0)), pushing)


def test_no_optimum_is_claimed_where_there_is_none():
    box = np.vstack([np.eye(3), -np.eye(3)])
    assert meeting_rows(box, np.append(np.ones(3), -2 * np.ones(3)), np.ones(3)) is None  # x ≤ 1 and x ≥ 2
    assert meeting_rows(box[:3], np.ones(3), np.ones(3)) is None  # x as small as one likes
    assert meeting_rows(np.zeros((2, 1)), np.ones(2), np.ones(1)) is None


@pytest.mark.parametrize("size", [1, 5, 30])
def test_optimum_over_a_cone_has_its_conditions(size):
    """The farthest of rows that leave the ball its slack: primal and dual values agree, nothing is broken."""
    for seed in range(6):
        rng, count = np.random.default_rng(seed), 3 * size + 2
        rows, slack, slope = (
            rng.normal(size=(count, size)),
            rng.uniform(0.1, 0.4, count),
            rng.normal(size=count),
        )
        rows[0], slack[0], slope[0], slope[1] = 0.0, 1.0, 0.0, 1.0  # a largest radius, and a row that limits
        matrix, right = np.column_stack([rows, slack, slope]), rng.uniform(0.5, 1.0, count)
        cost, offset = np.append(np.zeros(size + 1), -1.0), 0.25
        x, y = cone_optimum(matrix, right, cost, size, offset)
        assert np.linalg.norm(x[:size]) + offset <= x[size] + 1e-9
        assert np.max(matrix @ x - right) <= 1e-9
        assert y.min() >= 0
        pull = cost + matrix.T @ y  # what the cone takes up
        assert np.linalg.norm(pull[:size]) <= pull[size] + 1e-6
        assert pull[-1] == pytest.approx(0.0, abs=1e-6)
        assert cost @ x == pytest.approx(-(right @ y) + offset * pull[size], rel=1e-6)
