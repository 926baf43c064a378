"""The cheap method for λ_1, what is asked for on top of it, and what cannot be had."""

from dataclasses import replace

import numpy as np
import pytest
from joints import safe_between, safe_later

import shakedown
from benchmarks.problems import joint
from shakedown import Problem
from shakedown.bounds.independent_solver import conic_lower_bound, conic_upper_bound
from shakedown.bounds.proof_status import GuaranteeEvidence, guarantee_status


@pytest.mark.parametrize("n", [1, 2, 5, 12])
def test_both_methods_for_the_lower_bound_agree(n: int) -> None:
    for seed in range(2):
        problem = joint(seed, n)
        cheap, full = shakedown.lower_bound(problem), shakedown.lower_bound(problem, guarantee=True)
        assert cheap.certified is None
        assert cheap.uncertified == ""
        low, high = full.certified
        assert low <= full.load_factor <= high
        assert cheap.node == full.node
        assert cheap.load_factor == pytest.approx(full.load_factor, rel=1e-12)
        assert cheap.per_node[cheap.node] == cheap.load_factor == cheap.per_node.min()
        np.testing.assert_allclose(cheap.per_node, full.per_node, rtol=1e-8)


def test_no_certificate_comes_with_its_reason() -> None:
    block = shakedown.example("receding-block")
    unclear = replace(block, A=block.A + 1e-7 * np.diag(np.diag(block.A)))
    floating = shakedown.upper_bound(unclear, certify=True)
    assert (floating.certified, floating.exact) == (None, False)
    assert (
        "meets 5e-08 of the stiffness and is taken for rigid: give stiffness_accuracy" in floating.uncertified
    )
    assert shakedown.upper_bound(shakedown.example("two-node")).uncertified == ""
    assert shakedown.upper_bound(shakedown.example("receding-block"), certify=False).uncertified == ""


def test_loads_safe_from_some_load_factor_on() -> None:
    """One node that the mean load opens: safe exactly from λ = 1/2.4 on."""
    problem = safe_later()
    upper, lower = shakedown.upper_bound(problem), shakedown.lower_bound(problem)
    assert upper.least_load_factor == pytest.approx(1 / 2.4, rel=1e-12)
    assert shakedown.safe_slip(problem, 0.4167).status == "optimal"
    assert shakedown.safe_slip(problem, 0.4166).status == "infeasible"
    assert (lower.status, lower.guarantee) == ("infeasible", "evidence")


def test_a_safe_interval_that_ends() -> None:
    problem = safe_between()
    upper = shakedown.upper_bound(problem)
    assert (upper.status, upper.load_factor) == ("optimal", pytest.approx(1.5))
    assert upper.least_load_factor == pytest.approx(1 / 2.4)
    second = conic_upper_bound(problem), conic_lower_bound(problem)
    assert second[0].load_factor == pytest.approx(1.5, rel=1e-9)
    assert second[1].status == "infeasible"


def test_the_guarantee_does_not_hang_on_the_last_bit() -> None:
    """λ_1 and the lift-off bound are the same number here, computed by two methods."""
    base = Problem(
        A=np.eye(2),
        B=[[0.0, 0.05], [0.05, 0.0]],
        f=0.3,
        q_w=[[0.9, 0.0], [-0.9, 0.0]],
        p_w=[[2.0, 4.0], [4.0, 4.0]],
    )
    lower = shakedown.lower_bound(base)
    status = {
        guarantee_status(GuaranteeEvidence(base, lower.load_factor * (1 + k * np.finfo(float).eps))).guarantee
        for k in range(-8, 9)
    }
    assert len(status) == 1
