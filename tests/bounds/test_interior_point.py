"""The two roads to the bounds, held against each other."""

from dataclasses import replace

import pytest

import shakedown
from benchmarks.problems import joint

UNITS = (500.0, 0.0025)  # newton and millimetre of a small steel joint


@pytest.mark.parametrize("seed", range(6))
def test_both_roads_lead_to_the_same_bounds(seed: int) -> None:
    problem = joint(seed, 2 + seed % 5, units=UNITS)
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
