"""A joint that jumps in every cycle jumps in the same way: its steps do not depend on how it was put out of balance."""

import numpy as np
import pytest

import shakedown
from benchmarks.space_verdicts import KINDS, random_joint
from shakedown import Outcome
from shakedown.motion import evolution, viscous_jump
from shakedown.motion.evolution import Evolution
from shakedown.motion.viscous_jump import LONGER, StepLengths, Stride

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


def test_where_a_jump_ends_does_not_depend_on_what_puts_it_out_of_balance(monkeypatch, drifting):
    jump, share = first_jump(drifting), evolution.NEGLIGIBLE
    for factor in (1.3, 1.9):
        monkeypatch.setattr(evolution, "NEGLIGIBLE", factor * share)
        np.testing.assert_allclose(
            first_jump(drifting).v_after, jump.v_after, rtol=0.0, atol=1e-6 * way_of(jump)
        )


def test_shorter_steps_lead_to_the_same_end(monkeypatch, drifting):
    jump = first_jump(drifting)
    monkeypatch.setattr(viscous_jump, "ACCURACY", 0.03 * viscous_jump.ACCURACY)
    monkeypatch.setattr(viscous_jump, "RUNG", 1.1)
    finer = first_jump(drifting)
    assert finer.steps > 2 * jump.steps
    np.testing.assert_allclose(finer.v_after, jump.v_after, rtol=0.0, atol=1e-2 * way_of(jump))
    np.testing.assert_allclose(finer.work, jump.work, rtol=0.0, atol=1e-2 * jump.work.max())


@pytest.mark.parametrize("power", [1, 2])
def test_a_motion_that_grows_takes_few_steps(power):
    """Implicit steps Δx = Δt v(x + Δx), v = b + xᵖ with b = 1e-9, of a motion from 0 to 1; few have no end."""
    offset, at, steps, failed = 1e-9, 0.0, 0, 0
    lengths = StepLengths(1.0, 0.05, 1.0)
    while at < 1.0:
        duration = lengths.duration
        parabola = [1.0, 2.0 * at - 1.0 / duration, at**2 + offset]
        ways = np.roots(parabola if power == 2 else [1.0 - 1.0 / duration, at + offset])
        ends = ways.real[(ways.imag == 0.0) & (ways.real > 0.0)]
        if not len(ends):
            lengths.shorten()
            failed += 1
            continue
        way = float(ends.min())
        at, steps = at + way, steps + 1
        assert lengths.accepts(Stride(way, way / duration, max(at, offset), 0.0, False))
    assert steps <= 60
    assert failed <= 5


def test_a_step_that_turns_is_taken_shorter():
    lengths = StepLengths(1.0, 1.0, 1.0)
    assert lengths.accepts(Stride(1.0, 1.0, 1.0, 0.0, False))
    duration = lengths.duration
    assert not lengths.accepts(Stride(1.0, 1.0, 2.0, 0.5, False))
    assert 0.1 * duration <= lengths.duration <= 0.5 * duration


def test_a_motion_within_round_off_takes_longer_steps_whatever_its_speeds_seem_to_do():
    lengths = StepLengths(1.0, 1.0, 1.0)
    for speed in (1e-6, 1e-17, 1e-16, 1e-18):
        before = lengths.duration
        assert lengths.accepts(Stride(speed * before, speed, 1e-6, 0.0, False))
    assert lengths.duration == LONGER * before


@pytest.mark.parametrize(
    ("seed", "number", "load_factor"), [(10, 0, 2.1069736009012625), (32, 1, 2.371089086131227)]
)
def test_a_jump_that_stands_still_is_tried_from_farther_away(seed, number, load_factor):
    """Within 1e-9 of where it began it stood, next to an apex, and was called one that does not come to rest."""
    problem = random_joint(
        np.random.default_rng([seed, KINDS.index("stiff and soft"), number]), "stiff and soft", 4
    )
    found = shakedown.long_term_state(problem, load_factor)
    assert found.outcome == Outcome.CYCLIC_SLIP
    assert found.jumps
