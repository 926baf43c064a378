"""A dovetail opens at the inner ends of its flanks; the bound of its zone is kept and is sharp."""

import numpy as np
import pytest
from dovetail import dovetail

import shakedown
from shakedown import UsageError


@pytest.fixture(scope="module")
def joint():
    return dovetail()


@pytest.fixture(scope="module")
def upper(joint):
    return shakedown.upper_bound(joint, open_nodes="auto")


def test_the_mean_pull_opens_nodes_and_no_slip_is_safe_with_all_closed(joint, upper):
    assert shakedown.upper_bound(joint).status == "infeasible"
    assert upper.status == "optimal"
    assert upper.open_nodes == tuple(range(7, 19))  # the inner halves of both flanks
    assert upper.residual < 1e-9


@pytest.mark.parametrize("share", [0.2, 0.9, 0.999])
def test_below_the_bound_of_the_zone_nothing_slips(joint, upper, share):
    state = shakedown.long_term_state(
        joint, share * upper.load_factor, upper.slip, open_nodes=upper.open_nodes
    )
    assert state.outcome == "shakedown"
    assert state.open_nodes == upper.open_nodes
    closed = [i for i in range(joint.n) if i not in upper.open_nodes]
    assert np.abs(state.final_slip - upper.slip)[closed].max() == 0.0


def test_above_it_a_gap_closes(joint, upper):
    """A gap limits this zone: at 1.02 of the bound the safe slip is no state with the node open."""
    assert any(side == 0 for _, side in upper.active)
    with pytest.raises(UsageError, match="would overlap"):
        shakedown.long_term_state(joint, 1.02 * upper.load_factor, upper.slip, open_nodes=upper.open_nodes)


def test_a_large_joint_is_bounded_with_its_open_nodes():
    """120 nodes in a chain, the first 48 of them pulled open."""
    n, t = 120, 2 * np.pi * np.arange(24) / 24
    apart = np.subtract.outer(np.arange(n), np.arange(n))
    A = 1000.0 * (2.2 * (apart == 0) - (np.abs(apart) == 1))
    p = np.where(np.arange(n) < 48, -80.0, 100.0)
    problem = shakedown.Problem(
        A=A,
        B=300.0 * ((apart == 1).astype(float) - (apart == -1)),
        C=1.4 * A,
        f=0.4,
        q_w=np.outer(np.sin(t), np.linspace(10, 20, n)),
        p_w=np.outer(1 + 0.2 * np.cos(t), p),
    )
    upper = shakedown.upper_bound(problem, open_nodes="auto")
    assert upper.status == "optimal"
    assert set(range(48)) <= set(upper.open_nodes) < set(range(58))
    assert upper.residual < 1e-9
