"""What motions may take is counted in operations: within a cycle and within a jump, and no pause changes a path."""

from dataclasses import replace

import numpy as np
import pytest
from joints_in_space import of_verdicts

import shakedown
from shakedown import Outcome
from shakedown.ground.work_limit import limited_work, work_is_left
from shakedown.motion.evolution import Evolution
from shakedown.motion.space import space_events

JUMPING = of_verdicts("floating", 35, 3)
LOAD_FACTOR = 0.93  # at which the joint jumps


def taken(problem, load_factor):
    """What the first cycle takes."""
    with limited_work(np.inf) as limit:
        assert Evolution(problem, load_factor).cycle() is not None
    return limit.taken


@pytest.mark.parametrize("record", [False, True])
def test_no_pause_changes_a_path(monkeypatch, record):
    joint = shakedown.example("four-node-3d")
    whole, paused = Evolution(joint, 1.5), Evolution(joint, 1.5)
    at_once = whole.cycle(record=record)
    monkeypatch.setattr(space_events, "CALL_OPERATIONS", 1)
    bit_by_bit = paused.cycle(record=record)
    np.testing.assert_array_equal(whole.state.u, paused.state.u)
    np.testing.assert_array_equal(at_once.slip, bit_by_bit.slip)
    assert (at_once.events, at_once.signature) == (bit_by_bit.events, bit_by_bit.signature)


def test_a_motion_stops_within_its_cycle_and_its_jump(monkeypatch):
    most = 0.3 * taken(JUMPING, LOAD_FACTOR)
    monkeypatch.setattr(space_events, "CALL_OPERATIONS", 1)
    with limited_work(most) as limit:
        motion = Evolution(JUMPING, LOAD_FACTOR)
        assert motion.cycle() is None
        assert not work_is_left()
        before = limit.taken
        assert Evolution(JUMPING, LOAD_FACTOR).cycle() is None  # what is spent is spent
        assert limit.taken == before
    assert before <= most + 1e4
    assert motion.stop.spent
    assert motion.stop.reason.startswith("the computation allowed for a run is spent")
    assert Evolution(JUMPING, LOAD_FACTOR).cycle() is not None  # outside nothing is limited


def test_limits_do_not_add_up():
    with limited_work(1.0) as outer:
        with limited_work(np.inf):
            assert Evolution(shakedown.example("four-node-3d"), 1.0).cycle() is not None
        assert (outer.taken, work_is_left()) == (0.0, True)


def test_a_state_is_undecided_where_its_work_is_spent():
    with limited_work(3.5 * taken(JUMPING, LOAD_FACTOR)):
        found = shakedown.long_term_state(JUMPING, LOAD_FACTOR)
    assert (found.outcome, found.stop.spent) == (Outcome.UNDECIDED, True)
    assert 1 <= found.cycles_simulated <= 20


def test_what_is_proved_needs_no_more_work():
    joint = shakedown.example("four-node-3d")
    load_factor = 1.02 * shakedown.upper_bound(joint).load_factor
    whole = shakedown.long_term_state(joint, load_factor)
    with limited_work(1.5 * taken(joint, load_factor)):
        found = shakedown.long_term_state(joint, load_factor)
    assert found.cycles_simulated < whole.cycles_simulated
    assert found.outcome == whole.outcome == Outcome.CYCLIC_SLIP
    assert found.reason.startswith("proved, above λ_max")


def test_what_holds_the_start_proves_nothing_before_the_transient():
    joint = shakedown.example("block-3x3")
    highest = shakedown.upper_bound(joint).load_factor
    before = {"q_transient": 3.0 * highest * joint.q_w[:1], "p_transient": joint.p_w[:1]}
    joint, start = replace(joint, **before), shakedown.safe_slip(joint, 0.9 * highest).slip
    with limited_work(0.0):
        found = shakedown.long_term_state(joint, 0.9 * highest, start)
    assert (found.outcome, found.stop.spent) == (Outcome.UNDECIDED, True)
    assert shakedown.long_term_state(joint, 0.9 * highest, start).outcome == Outcome.CYCLIC_SLIP
