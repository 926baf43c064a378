"""The two roads to the bounds, held against each other."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import Problem


def random_problem(seed: int, n: int) -> Problem:
    rng = np.random.default_rng(seed)
    root = 0.3 * rng.normal(size=(2 * n, 2 * n))
    kappa = 2e5 * (root @ root.T / np.sqrt(2 * n) + np.eye(2 * n))
    return Problem(
        A=kappa[:n, :n],
        B=kappa[n:, :n],
        f=rng.uniform(0.1, 0.5, n),
        q_w=500 * rng.normal(size=(6, n)),
        p_w=2000 + 500 * rng.normal(size=(6, n)),
    )


@pytest.mark.parametrize("seed", range(6))
def test_both_roads_lead_to_the_same_bounds(seed: int) -> None:
    problem = random_problem(seed, n=2 + seed % 5)
    bounds = shakedown.shakedown_bounds(problem)
    upper, lower = shakedown.conic_upper_bound(problem), shakedown.conic_lower_bound(problem)
    assert upper.load_factor == pytest.approx(bounds.upper.load_factor, rel=1e-9)
    assert lower.load_factor == pytest.approx(bounds.lower.load_factor, rel=1e-9)
    assert lower.node == bounds.lower.node


def test_real_units_block() -> None:
    problem = replace(shakedown.example("block-9"), f=0.2)
    bounds = shakedown.shakedown_bounds(problem)
    upper, lower = shakedown.conic_upper_bound(problem), shakedown.conic_lower_bound(problem)
    assert upper.load_factor == pytest.approx(bounds.upper.load_factor, rel=1e-9)
    assert lower.load_factor == pytest.approx(bounds.lower.load_factor, rel=1e-9)


def test_statuses_agree() -> None:
    problem = shakedown.example("two-node")
    for changed in (replace(problem, f=2.5), replace(problem, p_w=problem.p_w - 9000.0)):
        assert shakedown.conic_upper_bound(changed).status == shakedown.upper_bound(changed).status
