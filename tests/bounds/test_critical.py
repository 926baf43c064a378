"""Critical load factors: cited values, counts, degenerate subsets, budget; the compiled tree against plain solves."""

import numpy as np
import pytest

import shakedown
from benchmarks.problems import joint
from shakedown import Problem
from shakedown.bounds import critical as module
from shakedown.bounds import walk_kernel


def test_two_node_system_has_the_thesis_values() -> None:
    critical = shakedown.critical_load_factors(shakedown.example("two-node"), values=True, budget=4)
    assert (critical.total, critical.regular, critical.degenerate) == (4, 4, 0)
    np.testing.assert_allclose(
        critical.load_factors,
        [0.6573734697246544, 0.7391455673806329, 1.05252030036052, 2.9348503882950054],
        rtol=1e-12,
    )
    np.testing.assert_allclose(critical.smallest_positive.slip, [1.53656435, 1.59365716], atol=1e-8)
    assert critical.smallest_positive.rows == shakedown.lower_bound(shakedown.example("two-node")).active


def test_degenerate_subsets_are_counted_not_solved() -> None:
    """Two nodes that do not feel each other, with a loop that leaves node 1 alone."""
    loop = {"q_w": [[1.0, 0.0], [-1.0, 0.0]], "p_w": np.full((2, 2), 4.0)}
    problem = Problem(A=np.eye(2), B=np.zeros((2, 2)), f=0.5, **loop)
    critical = shakedown.critical_load_factors(problem, values=True)
    assert (critical.total, critical.regular, critical.degenerate) == (4, 2, 2)
    np.testing.assert_allclose(critical.load_factors, [2.0, 2.0])


def test_nearly_singular_is_degenerate() -> None:
    """Two nodes with the same backward limit, exactly or but for 1e-14."""
    loop = {"f": 0.5, "q_w": [[1.0, 1.0], [-1.0, -1.0]], "p_w": np.full((2, 2), 4.0)}
    coupled = (np.diag([2.0, 2.0 - 2 * tilt]) for tilt in (0.0, 1e-14))
    joints = [Problem(A=[[2.0, 1.0], [1.0, 2.0]], B=B, **loop) for B in coupled]
    same, nearly = (shakedown.critical_load_factors(each).degenerate for each in joints)
    assert same == nearly > 0


def test_progress_ends_at_the_total() -> None:
    calls = []
    shakedown.critical_load_factors(
        shakedown.example("block-9"), progress=lambda done, total: calls.append((done, total))
    )
    assert calls[-1] == (43758, 43758)
    assert calls == sorted(calls)


@pytest.mark.parametrize(
    ("n", "count", "time"),
    [
        (20, "131,282,408,400", "about 1.5 hours"),
        (18, "8,597,496,600", "about 3.4e+02 seconds"),
        (600, "about 10^359", "more than 1.1e+10 hours"),
    ],
)
def test_any_size_is_refused_with_an_estimate(n: int, count: str, time: str) -> None:
    loop = np.array([[1.0], [-1.0]]) * np.ones(n)
    problem = Problem(A=np.eye(n), B=0.1 * np.eye(n), f=0.3, q_w=loop, p_w=np.full((2, n), 5.0))
    with pytest.raises(shakedown.BudgetExceeded) as refusal:
        shakedown.critical_load_factors(problem)
    most = f"{n + 1} rows are more than the budget of 200,000,000"
    assert str(refusal.value) == f"{count} subsets of {most}; they would take {time} on one core"


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


def apex(seed: int, n: int) -> Problem:
    """A far slip under which the mean load leaves no reaction: every subset meets there, at load factor 0."""
    problem = joint(seed, n)
    slip, q, p = 1e4 * np.random.default_rng(seed).normal(size=n), problem.q_w, problem.p_w
    q0, p0 = -problem.A @ slip, -problem.B @ slip
    loop = {"q_w": q - q.mean(axis=0) + q0, "p_w": p - p.mean(axis=0) + p0}
    return Problem(A=problem.A, B=problem.B, f=problem.f, q_mean=q0, p_mean=p0, **loop)


@pytest.fixture
def by_tree(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SMALL", 0)
    monkeypatch.setattr(walk_kernel, "BLOCK", 300)


@pytest.mark.parametrize("make", [joint, half_coupled, twins, apex])
@pytest.mark.parametrize("n", [1, 4])
def test_tree_and_batches_agree(make, n: int, request: pytest.FixtureRequest) -> None:
    problem = make(n, max(n, 2) if make is half_coupled else n)
    plain = shakedown.critical_load_factors(problem, values=True)
    request.getfixturevalue("by_tree")
    tree = shakedown.critical_load_factors(problem, values=True)
    assert (tree.total, tree.regular, tree.degenerate) == (plain.total, plain.regular, plain.degenerate)
    assert tree.regular + tree.degenerate == plain.regular + plain.degenerate == tree.total
    np.testing.assert_allclose(tree.load_factors, plain.load_factors, rtol=1e-8, atol=1e-11)
    for which in ("smallest_positive", "smallest_feasible"):
        expected = getattr(plain, which).load_factor
        assert getattr(tree, which).load_factor == pytest.approx(expected, rel=1e-10, nan_ok=True)


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
