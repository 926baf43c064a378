"""λ_1 and λ_max against cited values and closed forms; safe slips, as far from every row as possible."""

from dataclasses import replace

import numpy as np
import pytest
from joints import creeping

import shakedown
from shakedown.joint.constraints import constraints


def test_two_node_system_has_the_thesis_bounds() -> None:
    bounds = shakedown.shakedown_bounds(shakedown.example("two-node"))
    assert bounds.lower.load_factor == pytest.approx(0.6573734697246544, rel=1e-12)
    assert bounds.upper.load_factor == pytest.approx(0.7391455673806329, rel=1e-12)
    np.testing.assert_allclose(bounds.lower.slip, [1.53656435, 1.59365716], atol=1e-8)
    np.testing.assert_allclose(bounds.upper.slip, [-0.15634934, 1.28772669], atol=1e-8)


@pytest.mark.parametrize(
    ("name", "f", "lower", "upper"),
    [
        ("block-9", 0.5, 0.0, 4.715032),
        ("block-9", 0.2, 1.219830, 1.730955),
        ("three-node", 0.5, 3.096, 10 / 3),
    ],
)
def test_known_systems(name: str, f: float, lower: float, upper: float) -> None:
    bounds = shakedown.shakedown_bounds(replace(shakedown.example(name), f=f))
    assert bounds.lower.load_factor == pytest.approx(lower, abs=5e-7)
    assert bounds.upper.load_factor == pytest.approx(upper, abs=5e-7)
    if lower == 0:
        assert f"some locked-in slip lifts node {bounds.lower.node} off" in bounds.lower.reason


def test_zero_amplitude_is_told_from_wedging() -> None:
    problem = shakedown.example("two-node")
    point = replace(problem, q_w=problem.q_w[:1], p_w=problem.p_w[:1])
    upper = shakedown.upper_bound(point)
    assert upper.status == "unbounded"
    assert upper.reason.startswith("zero-amplitude loop")
    uncoupled = shakedown.lower_bound(replace(point, B=np.zeros((2, 2))))
    assert (uncoupled.status, uncoupled.load_factor, uncoupled.node) == ("unbounded", np.inf, -1)
    A = problem.A
    assert uncoupled.coupling_ratio == pytest.approx(abs(A[0, 1]) / np.sqrt(A[0, 0] * A[1, 1]))
    assert uncoupled.guarantee == "proved"


def test_a_floating_body_without_coupling_shakes_down_below_the_upper_bound() -> None:
    """Its safe slips vanish all together: no single node collapses, and λ_1 is λ_max (Melan)."""
    bounds = shakedown.shakedown_bounds(creeping())
    assert bounds.upper.load_factor == pytest.approx(5 / 9, rel=1e-12)
    assert bounds.lower.load_factor == bounds.upper.load_factor
    assert (bounds.lower.node, bounds.lower.guarantee) == (-1, "proved")
    assert "vanish together" in bounds.lower.reason
    assert bounds.lower.coupling_ratio == pytest.approx(1.0)


def test_the_round_off_of_a_rigid_motion_is_no_answer() -> None:
    """The stored stiffness of a floating block resists rigid motion by 1e-15; no bound may build on that."""
    bounds = shakedown.shakedown_bounds(shakedown.example("receding-block"))
    assert bounds.upper.status == bounds.lower.status == "infeasible"
    assert bounds.upper.certified is None


def test_margin_is_the_distance_from_the_nearest_row() -> None:
    problem = shakedown.example("block-9")
    safe, rows = shakedown.safe_slip(problem, 2.0), constraints(problem)
    distance = -rows.excess(safe.slip, 2.0) / np.linalg.norm(rows.G, axis=1)
    assert safe.status == "optimal"
    assert distance.min() == pytest.approx(safe.margin, rel=1e-9)
    assert len(safe.active) == problem.n + 1


def test_margin_vanishes_at_the_upper_bound() -> None:
    problem = shakedown.example("two-node")
    upper = shakedown.upper_bound(problem)
    safe = shakedown.safe_slip(problem, upper.load_factor)
    assert safe.status == "optimal"
    assert abs(safe.margin) < 1e-12
    np.testing.assert_allclose(safe.slip, upper.slip, atol=1e-9)
    beyond = shakedown.safe_slip(problem, 1.01 * upper.load_factor)
    assert beyond.status == "infeasible"
    assert beyond.margin < 0
    assert np.all(np.isnan(beyond.slip))


def test_margin_without_limit_is_a_status() -> None:
    problem = replace(shakedown.example("two-node"), f=2.5)
    safe = shakedown.safe_slip(problem, 1.0)
    assert (safe.status, safe.margin) == ("unbounded", np.inf)
    assert constraints(problem).excess(safe.slip, 1.0).max() < 0
