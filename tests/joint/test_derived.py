"""What a problem determines is built once, kept with it, and neither changed nor sent along."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.bounds.row_programs import exact_rows
from shakedown.joint.constraints import constraints, step_loads
from shakedown.joint.loading import loading


@pytest.mark.parametrize("build", [constraints, loading, exact_rows])
def test_what_a_problem_determines_is_built_once(build) -> None:
    problem = shakedown.example("two-node")
    assert build(problem) is build(problem)
    other = replace(problem, f=0.5)
    assert build(other) is not build(problem)


def test_what_is_kept_cannot_be_changed() -> None:
    problem = shakedown.example("two-node")
    rows, loop = constraints(problem), loading(problem)
    for array in (rows.G, rows.d, rows.g, rows.node, rows.side, rows.step, *vars(loop).values()):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_what_is_kept_is_not_sent_along() -> None:
    problem = shakedown.example("block-33")
    bare = len(pickle.dumps(problem))
    exact_rows(problem)
    assert len(pickle.dumps(problem)) < bare + 100
    sent = pickle.loads(pickle.dumps(problem))
    assert sent == problem
    np.testing.assert_array_equal(constraints(sent).G, constraints(problem).G)


def test_rows_are_the_largest_over_the_load_steps() -> None:
    problem = shakedown.example("block-9")
    rows, steps = constraints(problem), step_loads(problem)
    assert np.array_equal(rows.d, steps[rows.step, np.arange(2 * problem.n)])
    assert np.all(steps <= rows.d)
