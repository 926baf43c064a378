"""Of a load domain only what holds for every path inside it is said: no order of its corners counts."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

import shakedown
from shakedown.bounds.proof_status import lift_off_bound
from shakedown.joint.constraints import loading


def corners(seed: int, n: int = 2, m: int = 4) -> shakedown.Problem:
    """A weakly coupled joint under loads that lift nodes off somewhere inside their hull."""
    rng = np.random.default_rng(seed)
    B = 0.3 * rng.normal(size=(n, n))
    q, p = rng.normal(size=(2, m, n))
    return shakedown.Problem(A=np.eye(n), B=B, f=0.5, q_w=q, p_w=2.0 + 1.2 * p, load_path="domain")


@pytest.mark.parametrize("n", [2, 3])
def test_no_order_of_the_corners_changes_what_is_proved(n):
    """As loops the same joints have larger bounds: more is proved where each corner returns in its turn."""
    gained = []
    for seed in range(6):
        problem = corners(seed, n)
        orders = [[0, *order] for order in permutations(range(1, 4))][:3]  # all cyclic ones but for direction
        domains = [replace(problem, q_w=problem.q_w[order], p_w=problem.p_w[order]) for order in orders]
        found = [shakedown.universal_bound(x).load_factor for x in domains]
        assert found == pytest.approx([found[0]] * len(orders), rel=1e-8)
        loops = [shakedown.universal_bound(replace(x, load_path="loop")).load_factor for x in domains]
        assert min(loops) >= found[0] * (1 - 1e-9)  # a loop is one of the paths
        gained.append(max(loops) - found[0])
        assert {shakedown.lower_bound(x).guarantee for x in domains} == {"evidence"}
    assert max(gained) > 1e-3


def test_the_lift_off_bound_is_that_of_the_hull():
    for seed in range(3):
        problem = corners(seed)
        loop = replace(problem, load_path="loop")
        hull = lift_off_bound(problem)
        assert lift_off_bound(loop) == pytest.approx(hull, rel=1e-9)
        inside = np.random.default_rng(seed).dirichlet(np.ones(4), size=60)
        path = replace(loop, q_w=inside @ problem.q_w, p_w=inside @ problem.p_w,
                       q_mean=problem.q_w.mean(axis=0), p_mean=problem.p_w.mean(axis=0))  # fmt: skip
        assert lift_off_bound(path) >= hull * (1 - 1e-9)


def test_what_is_proved_of_a_domain_holds_on_random_paths_inside_it():
    """Paths between corners and through the inside, none of which returns to all corners."""
    tried = 0
    for seed in range(4):
        problem = corners(seed, 3)
        bound = shakedown.universal_bound(problem).load_factor
        if not bound > 0:
            continue
        rng, loop = np.random.default_rng(seed), loading(problem)
        for _ in range(4):
            share = rng.dirichlet(np.full(4, 0.3), size=7)
            path = replace(problem, q_w=share @ problem.q_w, p_w=share @ problem.p_w,
                           q_mean=loop.q0, p_mean=loop.p0, load_path="loop")  # fmt: skip
            state = shakedown.long_term_state(path, 0.999 * bound, rng.normal(size=3))
            assert state.outcome == "shakedown"
            tried += 1
    assert tried
