"""Laws over random joints with two tangential directions: floating, open, without friction, gaps, domains, …

What is proved never lies above what is impossible; the safe slip is safe at every load step; and the same
joint in other words (units, labels, tangents turned at every node) has the same answers.
"""

from itertools import pairwise

import numpy as np
from hostile.campaign import named, numbers
from hostile.random_joints import SPACE, space_joint

import shakedown
from shakedown import Problem
from shakedown.joint.constraints import loading

ROUND_OFF = 1e-6  # a joint whose κ is singular to rounding may have a condition of 1e8
SAFE = 1e-8
NUMBERS = ("proved_from_every_state", "proved_from_this_state", "impossible_above")


def excess(problem: Problem, slip: np.ndarray, load_factor: float) -> float:
    """By how much |q| exceeds f p anywhere in the loop, relative to the largest reaction of the node."""
    loop = loading(problem)
    q = (loop.q0 + load_factor * loop.q1 + problem.A @ slip).reshape(problem.m, -1, 2)
    p = loop.p0 + load_factor * loop.p1 + problem.B @ slip
    over = np.hypot(q[..., 0], q[..., 1]) - problem.f * p
    size = np.abs(problem.A) @ np.abs(slip) + np.abs(load_factor * loop.q1) + np.abs(loop.q0)
    return float((over / size.max()).max()) if size.any() else float(over.max())


def test_numbers_are_consistent_and_the_safe_slip_is_safe():
    for number in numbers(len(SPACE) // 4):
        kind = SPACE[2 * number % len(SPACE)]
        problem = space_joint(np.random.default_rng([31, number]), kind)
        with named(number, kind):
            found = shakedown.assess(problem, problem.initial_slip[0])
            found.to_dict()
            upper, energy = found.details.upper, found.details.energy
            for name in NUMBERS[:2]:
                proved = getattr(found, name)
                assert np.isnan(proved) or 0.0 <= proved <= found.impossible_above * (1 + ROUND_OFF)
            if not upper.open_nodes and upper.status == "optimal":
                assert excess(problem, upper.slip, upper.load_factor) <= SAFE
                chain = (upper.certified or (upper.load_factor,) * 2)[0], upper.load_factor
                assert all(low <= high * (1 + ROUND_OFF) for low, high in pairwise((*chain, chain[-1])))
                assert not energy.load_factor > upper.load_factor * (1 + ROUND_OFF)


def test_a_node_that_no_leaning_disc_holds_has_an_answer():
    steep = Problem(
        A=[[8.0, -2.0], [-2.0, 5.0]],
        B=[[0.0, 3.0]],
        f=50.0,
        q_w=[[0.1, -1.0], [0.2, 0.5]],
        p_w=[[3.0], [3.0]],
    )
    found = shakedown.universal_bound(steep)
    assert (found.load_factor, found.limited_by) == (0.0, "uniqueness")
