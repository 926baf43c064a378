"""Critical load factors: cited values, counts, degenerate subsets, budget."""

import numpy as np
import pytest

import shakedown
from shakedown import Problem
from shakedown.joint.constraints import constraints


def test_two_node_system_has_the_thesis_values() -> None:
    critical = shakedown.critical_load_factors(shakedown.example("two-node"), values=True)
    assert (critical.total, critical.regular, critical.degenerate) == (4, 4, 0)
    np.testing.assert_allclose(
        critical.load_factors,
        [0.6573734697246544, 0.7391455673806329, 1.05252030036052, 2.9348503882950054],
        rtol=1e-12,
    )
    np.testing.assert_allclose(critical.smallest_positive.slip, [1.53656435, 1.59365716], atol=1e-8)
    assert critical.smallest_positive.rows == shakedown.lower_bound(shakedown.example("two-node")).active


@pytest.mark.slow
def test_intersection_satisfies_its_rows() -> None:
    problem = shakedown.example("block-9")
    critical, rows = shakedown.critical_load_factors(problem), constraints(problem)
    assert critical.total == 43758
    point = critical.smallest_positive
    index = [2 * node + (side < 0) for node, side in point.rows]
    assert np.abs(rows.relative_excess(point.slip, point.load_factor)[index]).max() < 1e-12
    assert point.excess > 0.01
    assert critical.smallest_feasible.load_factor > point.load_factor


def test_degenerate_subsets_are_counted_not_solved() -> None:
    """Two nodes that do not feel each other, with a loop that leaves node 1 alone."""
    problem = Problem(
        A=np.eye(2), B=np.zeros((2, 2)), f=0.5, q_w=[[1.0, 0.0], [-1.0, 0.0]], p_w=np.full((2, 2), 4.0)
    )
    critical = shakedown.critical_load_factors(problem, values=True)
    assert (critical.total, critical.regular, critical.degenerate) == (4, 2, 2)
    np.testing.assert_allclose(critical.load_factors, [2.0, 2.0])


def test_nearly_singular_is_degenerate() -> None:
    """Two nodes with the same backward limit, exactly or but for 1e-14."""
    same, nearly = (
        shakedown.critical_load_factors(
            Problem(
                A=[[2.0, 1.0], [1.0, 2.0]],
                B=np.diag([2.0, 2.0 - 2 * tilt]),
                f=0.5,
                q_w=[[1.0, 1.0], [-1.0, -1.0]],
                p_w=np.full((2, 2), 4.0),
            )
        )
        for tilt in (0.0, 1e-14)
    )
    assert same.degenerate == nearly.degenerate > 0


def test_budget_is_checked_before_the_work() -> None:
    calls = []
    with pytest.raises(shakedown.BudgetExceeded, match=r"43,758 subsets .* would take about"):
        shakedown.critical_load_factors(
            shakedown.example("block-9"), budget=1000, progress=lambda done, total: calls.append(done)
        )
    assert not calls


def test_progress_ends_at_the_total() -> None:
    calls = []
    shakedown.critical_load_factors(
        shakedown.example("block-9"), progress=lambda done, total: calls.append((done, total))
    )
    assert calls[-1] == (43758, 43758)
    assert calls == sorted(calls)


@pytest.mark.parametrize(
    ("n", "count"), [(20, "131,282,408,400"), (40, "about 10^23"), (600, "about 10^359")]
)
def test_any_size_is_refused_with_an_estimate(n: int, count: str) -> None:
    loop = np.array([[1.0], [-1.0]]) * np.ones(n)
    problem = Problem(A=np.eye(n), B=0.1 * np.eye(n), f=0.3, q_w=loop, p_w=np.full((2, n), 5.0))
    with pytest.raises(shakedown.BudgetExceeded) as refusal:
        shakedown.critical_load_factors(problem)
    assert str(refusal.value).startswith(f"{count} subsets of {n + 1} rows")
    assert "would take" in str(refusal.value)
