"""A vertex proved by exact residuals: the same as in exact arithmetic, or no answer."""

import numpy as np
import pytest

import shakedown
from benchmarks.problems import chain, random_problem
from shakedown.bounds import certificate
from shakedown.ground.size_limits import DENSE_FROM
from shakedown.programs.exact_program import ExactProgram, exact_vertex
from shakedown.programs.verified_vertex import verified_vertex


def program_with_known_vertex(seed: int, n: int = DENSE_FROM) -> ExactProgram:
    """Rows 0 … n − 1 meet in a point that the others leave alone, with positive multipliers, thirds."""
    rng = np.random.default_rng(seed)
    active = rng.integers(-(10**6), 10**6, (n, n)) + 10**7 * np.eye(n, dtype=int)
    others = rng.integers(-(10**6), 10**6, (n, n))
    point, weights = rng.integers(-50, 50, n), rng.integers(1, 9, n)
    more = rng.integers(1, 3, n)
    weights[0], more[0] = 1, (1 - weights[1:] @ more[1:]) % 3  # the optimum is a whole number and a third
    right = np.concatenate([3 * (active @ point) + more, others @ point + 10**8])
    matrix = np.vstack([3 * active, others])
    return ExactProgram(matrix.tolist(), right.tolist(), (weights @ active).tolist())


def fractions(numerators, scale):
    return [x / scale for x in numerators]


@pytest.mark.parametrize("seed", range(3))
def test_the_vertex_of_exact_arithmetic(seed):
    program, basis = program_with_known_vertex(seed), list(range(DENSE_FROM))
    verified, exact = (way(program, basis, basis) for way in (verified_vertex, exact_vertex))
    assert verified is not None
    assert exact is not None
    assert fractions(verified.x, verified.x_scale) == fractions(exact.x, exact.x_scale)
    weights = [fractions(end.y.values(), end.y_scale) for end in (verified, exact)]
    assert weights[0] == pytest.approx(weights[1], rel=1e-15)


def test_no_answer_where_the_optimum_is_a_float():
    program, n = program_with_known_vertex(0), DENSE_FROM
    whole = ExactProgram(program.matrix, [3 * b for b in program.right], program.cost)
    exact = exact_vertex(whole, list(range(n)), list(range(n)))
    value = sum(c * x for c, x in zip(whole.cost, exact.x, strict=True))
    assert value % exact.x_scale == 0
    assert verified_vertex(whole, list(range(n)), list(range(n))) is None


def test_no_answer_for_a_basis_that_is_not_the_best():
    program, n = program_with_known_vertex(0), DENSE_FROM
    assert verified_vertex(program, [*range(1, n), n], list(range(n))) is None
    beyond = ExactProgram(program.matrix, [*program.right[:n], *([-(10**9)] * n)], program.cost)
    assert verified_vertex(beyond, list(range(n)), list(range(n))) is None


def test_no_answer_where_one_more_row_meets_the_vertex():
    program, n = program_with_known_vertex(1), DENSE_FROM
    first, second = program.matrix[:2]
    both = [a + b for a, b in zip(first, second, strict=True)]
    met = ExactProgram([*program.matrix, both], [*program.right, sum(program.right[:2])], program.cost)
    assert verified_vertex(met, list(range(n)), list(range(n))) is None


def test_no_answer_beyond_the_range_of_floats():
    program, n = program_with_known_vertex(2), DENSE_FROM
    huge = ExactProgram([[x << 1200 for x in row] for row in program.matrix], program.right, program.cost)
    assert verified_vertex(huge, list(range(n)), list(range(n))) is None


@pytest.mark.parametrize("problem", [chain(64), random_problem(64, 2)], ids=["chain", "random"])
def test_certified_bounds_are_those_of_exact_arithmetic(problem, monkeypatch):
    verified = shakedown.upper_bound(problem)
    monkeypatch.setattr(certificate, "verified_vertex", lambda *_: None)
    exact = shakedown.upper_bound(problem)
    assert verified.certified == exact.certified
    assert verified.slip.tolist() == exact.slip.tolist()
    assert verified.multipliers.tolist() == exact.multipliers.tolist()
