"""Whether all states end in one and the same state: by what they ended in."""

import numpy as np
import pytest

import shakedown
from tests.joints import FAMILY, member

JOINT = shakedown.example("two-node")


def apart(p_w, q_w=0.0, stiffness=1.0):
    """Nodes that do not feel each other, under these normal and tangential loads (m, n)."""
    p_w = np.asarray(p_w, dtype=float)
    n, one = p_w.shape[1], np.eye(p_w.shape[1])
    return shakedown.Problem(
        A=one * stiffness, B=np.zeros((n, n)), C=one, f=0.5, q_w=np.broadcast_to(q_w, p_w.shape), p_w=p_w
    )


def test_locked_in_slips_that_differ_are_no_unique_state():
    found = shakedown.initial_state_map(JOINT, 0.6, states=64)
    assert found.outcomes == {"shakedown": 64}
    assert found.same_outcome is True
    assert found.unique is False
    assert found.scatter.spread == pytest.approx(np.ptp(found.final_slip, axis=0).max())
    assert found.scatter.spread > 0.1
    assert found.scatter.largest == np.abs(found.final_slip).max()
    document = found.to_dict()
    assert document["same_outcome"] is True
    assert document["slip_spread"] == found.scatter.spread


def test_where_every_start_is_forgotten_the_state_is_unique():
    """A node whose two limits meet at the same slip: whatever it starts from, it ends there."""
    problem = apart([[1.0]] * 4, np.array([[0.0], [0.5], [0.0], [-0.5]]))
    (limit,) = shakedown.initial_state_map(problem, 1.0, states=64, reach=3.0).final_slip.T
    assert np.ptp(limit) <= 1e-12
    found = shakedown.initial_state_map(problem, 1.0, states=64, reach=3.0)
    assert (found.same_outcome, found.unique) == (True, True)


def of_three(q_1):
    """Node 0 slips to and fro, node 1 is stuck under these loads (m,)."""
    q_w = np.column_stack([[0.0, 2.0, 0.0, -2.0], q_1])
    return apart(np.ones((4, 2)), q_w)


def test_a_node_that_sticks_makes_no_continuum_by_itself():
    """Node 1 is driven to one slip by its loads, and stuck there at the start of every period."""
    driven = shakedown.initial_state_map(of_three([0.0, 0.5, 0.0, -0.5]), 1.0, states=64, reach=3.0)
    (cycle,) = driven.limit_cycles
    assert cycle.spread <= 1e-12
    assert cycle.coincide
    assert (driven.same_outcome, driven.unique) == (True, True)


def test_the_same_dissipation_does_not_make_one_limit_cycle():
    """Node 1 is free between its limits: it stays where it was put, and dissipates nothing."""
    found = shakedown.initial_state_map(of_three([0.0, 0.1, 0.0, -0.1]), 1.0, states=64, reach=3.0)
    (cycle,) = found.limit_cycles
    low, high = cycle.dissipation
    assert high - low <= 1e-12 * high
    assert cycle.spread == pytest.approx(np.ptp(found.final_slip[:, 1]))
    assert not cycle.coincide
    assert (found.same_outcome, found.unique) == (True, False)


def test_states_at_different_cycles_of_one_period_are_compared_in_phase():
    *data, load_factor, _ = FAMILY[0]
    found = shakedown.initial_state_map(member(*data), load_factor, states=64)
    twos = [cycle for cycle in found.limit_cycles if cycle.period == 2]
    assert twos
    assert all(cycle.coincide for cycle in twos)
