"""The gauge of differences: by a second road, what it implies, and bodies that friction alone holds."""

from itertools import combinations, permutations, product

import numpy as np
import pytest
from scipy.optimize import linprog

import shakedown
from benchmarks.adversary import scaled_to
from benchmarks.collapse_adversary import stiffness
from benchmarks.problems import in_units
from benchmarks.universal_adversary import loaded
from shakedown.planar.collapse.proof_status import Evidence
from shakedown.planar.uniqueness.coupling import coupling
from shakedown.planar.uniqueness.difference_gauge import difference_gauge


def beyond_one(seed: int) -> shakedown.Problem:
    """A joint with ρ* just above 1 and a gauge of differences."""
    rng = np.random.default_rng(seed)
    for _ in range(200):
        A, B = scaled_to(*stiffness(rng, 4, ("dense", "chain")[seed % 2]), rng.uniform(1.0, 1.03))
        problem = loaded(rng, A, B, "impulses")
        if coupling(problem).bound >= 1.0 and difference_gauge(problem) is not None:
            return problem
    raise AssertionError


def floating(seed: int, n: int = 4) -> shakedown.Problem:
    rng = np.random.default_rng(seed)
    for _ in range(200):
        problem = loaded(rng, *stiffness(rng, n, "floating"), "smooth")
        if difference_gauge(problem) is not None and shakedown.lower_bound(problem).load_factor > 0:
            return problem
    raise AssertionError


def largest_after_relaxing(problem: shakedown.Problem, scales: np.ndarray) -> float:
    """Largest difference to another node, in its scale, that one relaxed node comes to: one program each."""
    n, nodes = problem.n, len(scales)
    fB, pairs = problem.f[:, None] * problem.B, list(permutations(range(nodes), 2))
    apart = np.array([np.eye(nodes)[k] - np.eye(nodes)[other] for k, other in pairs])
    limits = np.array([scales[pair] for pair in pairs])
    largest = 0.0
    for i, side, j in product(range(n), (-1, 1), range(nodes)):
        if i == j:
            continue
        row = problem.A[i] + side * fB[i]
        relaxed = np.append(-row / row[i], np.zeros(nodes - n))
        relaxed[i] = 0.0
        gap = relaxed - np.eye(nodes)[j]
        held = [(0, 0) if k == (n if nodes > n else j) else (None, None) for k in range(nodes)]
        for sign, scale in ((1, scales[i, j]), (-1, scales[j, i])):
            found = linprog(-sign * gap, apart, limits, bounds=held)
            assert found.status == 0
            largest = max(largest, -found.fun / scale)
    return largest


@pytest.mark.parametrize("seed", range(3))
def test_relaxing_a_node_raises_no_difference(seed: int) -> None:
    for problem in (beyond_one(seed), floating(seed)):
        gauge = difference_gauge(problem)
        assert largest_after_relaxing(problem, gauge.scales) <= gauge.ratio < 1


@pytest.mark.parametrize("seed", range(3))
def test_every_principal_minor_is_positive(seed: int) -> None:
    """Of a floating joint all but the determinant itself."""
    for problem, most in ((beyond_one(seed), 4), (floating(seed), 3)):
        fB = problem.f[:, None] * problem.B
        for k in range(1, most + 1):
            for chosen, signs in product(combinations(range(4), k), product((-1, 1), repeat=k)):
                part = (
                    problem.A[np.ix_(chosen, chosen)] + np.array(signs)[:, None] * fB[np.ix_(chosen, chosen)]
                )
                assert np.linalg.det(part) > 0


@pytest.mark.parametrize("seed", range(4))
def test_below_the_first_collapse_every_state_shakes_down(seed: int) -> None:
    problem, rng = floating(seed), np.random.default_rng(seed)
    bound = shakedown.universal_bound(problem)
    assert bound.argument == "differences"
    assert bound.load_factor <= bound.first_collapse
    slips = rng.normal(size=(60, 4))
    size = np.abs(problem.q_w).max() / np.abs(problem.A).max()
    found = shakedown.long_term_states(problem, 0.999 * bound.load_factor, size * slips)
    assert set(found.outcome) <= {"shakedown", "separation"}  # large slips may open a node at first
    assert np.mean(found.outcome == "shakedown") > 0.5


def test_the_drift_bound_is_never_below_the_upper_bound() -> None:
    for seed in range(4):
        problem = floating(seed)
        drift = Evidence(problem, 1.0).argument.drift_bound
        assert shakedown.upper_bound(problem).load_factor <= drift * (1 + 1e-9) < np.inf


def test_units_and_directions_do_not_matter() -> None:
    for problem in (beyond_one(1), floating(1)):
        here = difference_gauge(problem)
        there = difference_gauge(in_units(problem, 2.0**20, 2.0**-15))
        np.testing.assert_allclose(there.scales, here.scales, rtol=1e-9)
    problem, signs = floating(1), np.array([1.0, -1.0, 1.0, -1.0])
    turned = shakedown.Problem(
        A=problem.A * signs * signs[:, None],
        B=problem.B * signs,
        f=problem.f,
        q_w=problem.q_w * signs,
        p_w=problem.p_w,
    )
    assert difference_gauge(turned).ratio == pytest.approx(difference_gauge(problem).ratio, rel=1e-9)
    here, there = (Evidence(joint, 1.0).argument.drift_bound for joint in (problem, turned))
    assert there == pytest.approx(here, rel=1e-9)
    here, there = (shakedown.universal_bound(joint) for joint in (problem, turned))
    assert there.load_factor == pytest.approx(here.load_factor, rel=1e-9)


def test_a_weakly_coupled_joint_has_one_and_the_counter_examples_none() -> None:
    assert difference_gauge(shakedown.example("block-33")) is not None
    for name in ("three-node", "pair-cycle"):
        assert difference_gauge(shakedown.example(name)) is None
