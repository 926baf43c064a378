"""The gauge of differences: by a second method, what it implies, and bodies that friction alone holds."""

from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest
from difficult_joints import loaded, scaled_to, stiffness

import shakedown
from shakedown.bounds.coupling import coupling, difference_gauge


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


@pytest.mark.parametrize("seed", [1, 5])
def test_which_way_the_tangents_of_the_nodes_point_does_not_matter(seed: int) -> None:
    problem = beyond_one(seed)
    for signs in product([1.0], *[(1.0, -1.0)] * 3):
        turned = replace(problem, A=problem.A * signs * np.array(signs)[:, None], B=problem.B * signs)
        assert difference_gauge(turned) == pytest.approx(difference_gauge(problem), rel=1e-9)


def test_a_weakly_coupled_joint_has_one_and_the_counter_examples_none() -> None:
    assert difference_gauge(shakedown.example("block-33")) is not None
    for name in ("three-node", "pair-cycle"):
        assert difference_gauge(shakedown.example(name)) is None


def test_where_the_gauge_does_not_exist_two_nodes_cycle_together_far_below_the_first_collapse() -> None:
    """The built-in counter-example: λ_1 = 3.096, and from 1.699024 on neither of its movers waits for it."""
    problem, slip = shakedown.example("pair-cycle"), [2.12293, 2.12293, -1.12424, -0.32851]
    below, above = (shakedown.long_term_state(problem, λ, slip) for λ in (1.69902, 1.69903))
    assert (below.outcome, above.outcome) == ("shakedown", "cyclic-slip")
    assert (above.slip_per_cycle > 0).tolist() == [True, True, False, False]
    assert shakedown.lower_bound(problem).load_factor == pytest.approx(3.096, rel=1e-12)
