"""Paths through a load domain in random order: the bounds are the same, and from the safe slip nothing slips."""

from itertools import product

import numpy as np
import pytest

import shakedown
from shakedown import Problem, safe_slip, upper_bound
from shakedown.motion.evolution import evolve
from tests.joints import random_paths
from tests.partly_open import SOME, partly_open

SIZES = (0.3, 0.2, 0.4)


def domain(seed, opens=False):
    """A random joint under three loads that vary independently: the samples are the corners."""
    joint, rng = partly_open(seed, n=5), np.random.default_rng(seed)
    p_mean = joint.p_w.mean(axis=0) if opens else 2.0 + np.abs(rng.normal(size=5))
    q, p = 0.5 * rng.normal(size=(2, 3, 5))
    corners = np.array(list(product((-1.0, 1.0), repeat=3))) * SIZES
    return Problem(A=joint.A, B=joint.B, C=joint.C, f=0.3, q_w=corners @ q, p_w=p_mean + corners @ p)


def slips(problem, load_factor, upper, count=6):
    """Largest slip of closed nodes on random paths from the safe slip."""
    safe = safe_slip(problem, load_factor, open_nodes=upper.open_nodes)
    closed = np.delete(np.arange(problem.n), upper.open_nodes)
    for path in random_paths(problem, count):
        run = evolve(path, load_factor, safe.slip, open_nodes=upper.open_nodes, cycles=2)
        assert run.stop is None
        yield max(float(cycle.slip[closed].max()) for cycle in run.cycles)


@pytest.mark.parametrize("opens", [False, True])
@pytest.mark.parametrize("seed", SOME[1:4])
def test_below_the_upper_bound_nothing_slips_on_any_path(seed, opens):
    problem = domain(seed, opens)
    upper = upper_bound(problem, open_nodes="auto")
    if upper.status != "optimal":
        return
    least = upper.least_load_factor
    for share in (0.5, 0.999):
        load_factor = least + share * (upper.load_factor - least)
        assert max(slips(problem, load_factor, upper)) < 1e-9 * np.abs(upper.slip).max()


def test_bounds_do_not_depend_on_the_path():
    problem = domain(SOME[0])
    plain = shakedown.shakedown_bounds(problem)
    for path in random_paths(problem, 4, seed=3):
        other = shakedown.shakedown_bounds(path)
        assert other.upper.load_factor == pytest.approx(plain.upper.load_factor, rel=1e-12)
        assert other.lower.load_factor == pytest.approx(plain.lower.load_factor, rel=1e-9)
        assert np.array_equal(np.sort(path.q_w, axis=0), np.sort(problem.q_w, axis=0))
