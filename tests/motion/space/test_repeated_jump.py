"""A joint that jumps in every cycle jumps in the same way: its steps do not depend on how it was put out of balance."""

import numpy as np
import pytest

import shakedown
from benchmarks.space_verdicts import KINDS, random_joint
from shakedown import Outcome
from shakedown.motion import viscous_jump
from shakedown.motion.evolution import Evolution

LOAD_FACTOR = 0.93  # above λ_max


@pytest.fixture(scope="module")
def drifting():
    """A floating joint of three nodes that jumps once a cycle and drifts."""
    return random_joint(np.random.default_rng([35, KINDS.index("floating"), 3]), "floating", 4)


def first_jump(problem):
    record = Evolution(problem, LOAD_FACTOR).cycle()
    assert record is not None
    return record.jumps[0]


def way_of(jump):
    return np.abs(jump.v_after - jump.v_before).max()


def test_cycles_with_a_jump_repeat(drifting):
    motion = Evolution(drifting, LOAD_FACTOR)
    motion.advance(30)
    states = [motion.state.u]
    for _ in range(3):
        record = motion.cycle()
        assert record is not None
        assert len(record.jumps) == 1
        states.append(motion.state.u)
    drifts = np.diff(states, axis=0)
    assert np.ptp(drifts, axis=0).max() <= 1e-7 * np.abs(drifts).max()


def test_their_drift_is_ratchetting(drifting):
    found = shakedown.long_term_state(drifting, LOAD_FACTOR)
    assert found.outcome == Outcome.RATCHETTING
    motion = Evolution(drifting, LOAD_FACTOR)
    motion.advance(30)
    before = motion.state.u[drifting.layout.slips]
    motion.advance(1)
    drift = motion.state.u[drifting.layout.slips] - before
    np.testing.assert_allclose(found.drift / found.period, drift, rtol=0.0, atol=1e-5 * np.abs(drift).max())


def test_shorter_steps_lead_to_the_same_end(monkeypatch, drifting):
    jump = first_jump(drifting)
    monkeypatch.setattr(viscous_jump, "ACCURACY", 0.03 * viscous_jump.ACCURACY)
    monkeypatch.setattr(viscous_jump, "DISTANCE_RATIO", 1.1)
    finer = first_jump(drifting)
    assert finer.steps > 2 * jump.steps
    np.testing.assert_allclose(finer.v_after, jump.v_after, rtol=0.0, atol=1e-2 * way_of(jump))
    np.testing.assert_allclose(finer.work, jump.work, rtol=0.0, atol=1e-2 * jump.work.max())


@pytest.mark.parametrize(("seed", "number", "load_factor"), [(10, 0, 2.1069736009012625)])
def test_a_jump_that_stands_still_is_tried_from_farther_away(seed, number, load_factor):
    """Within 1e-9 of where it began it stood, next to an apex, and was called one that does not come to rest."""
    problem = random_joint(
        np.random.default_rng([seed, KINDS.index("stiff and soft"), number]), "stiff and soft", 4
    )
    found = shakedown.long_term_state(problem, load_factor)
    assert found.outcome == Outcome.CYCLIC_SLIP
    assert found.jumps
