"""The two roads to the bounds, held against each other."""

import subprocess
import sys
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


@pytest.mark.parametrize("solver", ["CLARABEL", "HIGHS"])
def test_any_solver_of_the_modelling_road(solver: str) -> None:
    problem = shakedown.example("two-node")
    upper = shakedown.conic_upper_bound(problem, solver=solver)
    lower = shakedown.conic_lower_bound(problem, solver=solver)
    assert upper.solver == lower.solver == solver
    assert upper.load_factor == pytest.approx(0.7391455673806329, rel=1e-8)
    assert lower.load_factor == pytest.approx(0.6573734697246544, rel=1e-8)


def test_the_default_road_does_without_cvxpy() -> None:
    code = (
        "import sys, shakedown; shakedown.conic_lower_bound(shakedown.example('two-node'));"
        "assert 'cvxpy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
