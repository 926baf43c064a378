"""The compiled tree of subsets against batches of plain solves, also where subsets are degenerate."""

import numpy as np
import pytest

import shakedown
from benchmarks.problems import joint
from shakedown import Problem
from shakedown.bounds import critical, walk_kernel


def half_coupled(seed: int, n: int) -> Problem:
    """Nodes 0 and 1 coupled, the others on their own, node n − 1 without load: many singular subsets."""
    problem = joint(seed, n)
    A, B, q, p = np.diag(np.diag(problem.A)), np.zeros((n, n)), problem.q_w.copy(), problem.p_w.copy()
    A[:2, :2], B[:2, :2] = problem.A[:2, :2], problem.B[:2, :2]
    q[:, -1], p[:, -1] = 0.0, 4.0
    return Problem(A=A, B=B, f=problem.f, q_w=q, p_w=p)


def twins(seed: int, n: int) -> Problem:
    """Neighbouring nodes load and couple alike: parallel planes in slip space, ties everywhere."""
    problem = joint(seed, n)
    A = np.eye(n) + 0.2 * (np.eye(n, k=1) + np.eye(n, k=-1))
    same = np.ones((1, n))
    return Problem(A=A, B=0.3 * A, f=0.3, q_w=problem.q_w[:, :1] * same, p_w=problem.p_w[:, :1] * same)


@pytest.fixture
def by_tree(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(critical, "SMALL", 0)
    monkeypatch.setattr(walk_kernel, "BLOCK", 300)


def both_ways(problem: Problem, monkeypatch: pytest.MonkeyPatch) -> tuple:
    plain = shakedown.critical_load_factors(problem, values=True)
    monkeypatch.setattr(critical, "SMALL", 0)
    monkeypatch.setattr(walk_kernel, "BLOCK", 300)
    return plain, shakedown.critical_load_factors(problem, values=True)


@pytest.mark.parametrize("make", [joint, half_coupled, twins])
@pytest.mark.parametrize("n", [1, 4])
def test_tree_and_batches_agree(make, n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = make(n, max(n, 2) if make is half_coupled else n)
    plain, tree = both_ways(problem, monkeypatch)
    assert (tree.total, tree.regular, tree.degenerate) == (plain.total, plain.regular, plain.degenerate)
    assert tree.regular + tree.degenerate == plain.regular + plain.degenerate == tree.total
    np.testing.assert_allclose(tree.load_factors, plain.load_factors, rtol=1e-8, atol=1e-11)
    for a, b in (
        (tree.smallest_positive, plain.smallest_positive),
        (tree.smallest_feasible, plain.smallest_feasible),
    ):
        assert a.load_factor == pytest.approx(b.load_factor, rel=1e-10, nan_ok=True)


@pytest.mark.usefixtures("by_tree")
@pytest.mark.parametrize("n", [2, 5, 9])
def test_the_smallest_feasible_one_is_the_first_collapse(n: int) -> None:
    problem = joint(n, n)
    found, lower = shakedown.critical_load_factors(problem).smallest_feasible, shakedown.lower_bound(problem)
    assert found.load_factor == pytest.approx(lower.load_factor, rel=1e-11)
    assert found.excess <= 1e-12
    np.testing.assert_allclose(found.slip, lower.slip, rtol=1e-8, atol=1e-8)


@pytest.mark.usefixtures("by_tree")
def test_threads_do_not_change_the_answer() -> None:
    problem = joint(8, 7)
    one, two = (shakedown.critical_load_factors(problem, threads=k, values=True) for k in (1, 2))
    np.testing.assert_array_equal(one.load_factors, two.load_factors)
    assert one.smallest_positive.rows == two.smallest_positive.rows
