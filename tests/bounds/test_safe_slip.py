"""Safe slips: as far from every row as possible."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.joint.constraints import constraints


def test_margin_is_the_distance_from_the_nearest_row() -> None:
    problem = shakedown.example("block-9")
    safe, rows = shakedown.safe_slip(problem, 2.0), constraints(problem)
    distance = -rows.excess(safe.slip, 2.0) / np.linalg.norm(rows.G, axis=1)
    assert safe.status == "optimal"
    assert distance.min() == pytest.approx(safe.margin, rel=1e-9)
    assert len(safe.active) == problem.n + 1


def test_no_neighbour_has_a_larger_margin() -> None:
    problem = shakedown.example("two-node")
    safe, rows = shakedown.safe_slip(problem, 0.3), constraints(problem)
    norms = np.linalg.norm(rows.G, axis=1)
    rng = np.random.default_rng(0)
    for step in rng.normal(size=(200, 2)):
        margin = (-rows.excess(safe.slip + 0.1 * step, 0.3) / norms).min()
        assert margin <= safe.margin * (1 + 1e-12)


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
