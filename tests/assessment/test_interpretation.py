"""What docs/interpretation.md proves of ranges of friction and load is tried; its blocks run in tests/docs."""

from dataclasses import replace

import numpy as np
import pytest
from joints import joint_of_kind

import shakedown
from shakedown.joint.constraints import loading


def loaded(problem, factors):
    """Of each node the constant and the periodic load by factors, (2, n)."""
    loop, (mean, part) = loading(problem), factors
    q0, p0 = mean * loop.q0, mean * loop.p0
    return replace(problem, q_mean=q0, p_mean=p0, q_w=q0 + part * loop.q1, p_w=p0 + part * loop.p1)


@pytest.mark.parametrize("bound", [shakedown.upper_bound, shakedown.energy_bound])
def test_corners_of_the_loads_at_the_lower_friction_are_the_worst_case(bound):
    rng, tried = np.random.default_rng(4), 0
    for _ in range(12):
        problem = replace(joint_of_kind(rng, "loose"), q_transient=None, p_transient=None)
        if problem.n > 2 or np.any(1.3 * problem.f * np.abs(np.diag(problem.B)) > np.diag(problem.A)):
            continue
        corners = np.stack(np.meshgrid(*[[0.8, 1.2]] * (2 * problem.n)), axis=-1).reshape(-1, 2, problem.n)
        found = [bound(loaded(problem, corner), certify=False) for corner in corners]
        if any(each.status != "optimal" or each.least_load_factor > 0 for each in found):
            continue
        least, tried = min(each.load_factor for each in found), tried + 1
        for _ in range(6):
            inside = loaded(problem, rng.uniform(0.8, 1.2, (2, problem.n)))
            rougher = replace(inside, f=problem.f * rng.uniform(1.0, 1.3, problem.n))
            assert bound(rougher, certify=False).load_factor >= least * (1 - 1e-9)
    assert tried > 1
