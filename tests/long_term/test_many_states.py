"""Many long-term states at once: state by state those of ``long_term_state``, whatever else is in the batch."""

import gc
import signal
import time
from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.long_term.find_state import LongTermStates
from shakedown.motion.checked_law import scales
from tests.joints import joint_of_kind, slow_problem


def assert_agree(problem, load_factor, starts, **options):
    """State by state: equal verdicts and contact sequences; slips and dissipation to 1e-9 of the scales."""
    states = shakedown.long_term_states(problem, load_factor, starts, **options)
    scale = scales(problem, load_factor)
    for row, start in enumerate(starts):
        one = shakedown.long_term_state(problem, load_factor, start, **options)
        assert (states.outcome[row], states.period[row]) == (one.outcome, one.period)
        assert int(states.signature[row]) == one.signature
        near = 1e-9 * max(scale.length, float(np.abs(one.final_slip).max()))
        assert states.final_slip[row] == pytest.approx(one.final_slip, abs=near)
        assert states.slip_per_cycle[row] == pytest.approx(one.slip_per_cycle, abs=near, nan_ok=True)
        energy = near * scale.force
        assert states.dissipation[row] == pytest.approx(one.dissipation_per_cycle, abs=energy, nan_ok=True)
        assert states.contraction[row] == pytest.approx(one.contraction, abs=1e-3, nan_ok=True)
    return states


def identical(one: LongTermStates, other: LongTermStates, rows=slice(None)):
    for key in LongTermStates.__dataclass_fields__:
        if key != "load_factor":
            first, second = getattr(one, key)[rows], getattr(other, key)
            assert first.tobytes() == second.tobytes(), key


@pytest.mark.parametrize(
    ("kind", "outcomes"),
    [
        ("any", {"shakedown", "cyclic-slip", "separation"}),
        ("loosely coupled", {"shakedown", "cyclic-slip"}),
        ("above thresholds", {"shakedown", "cyclic-slip"}),
        ("floating", {"shakedown", "cyclic-slip", "ratchetting"}),
    ],
)
def test_agrees_with_the_single_state_on_random_joints(kind, outcomes):
    """Slips at the start far from admissible too, and transient load steps."""
    rng, found = np.random.default_rng(5), set()
    for _ in range({"floating": 12, "above thresholds": 4}.get(kind, 8)):
        problem = joint_of_kind(rng, kind)
        load_factor = float(rng.uniform(0.2, 1.6))
        starts = rng.normal(size=(3, problem.n)) * scales(problem, load_factor).length
        states = assert_agree(problem, load_factor, starts * rng.choice([0.1, 1.0, 5.0]), max_cycles=40)
        alone = shakedown.long_term_states(problem, load_factor, states.initial_slip[1:2], max_cycles=40)
        identical(states, alone, slice(1, 2))
        found |= set(states.outcome.tolist())
    assert outcomes <= found


def test_what_is_not_found_in_time_is_undecided():
    states = assert_agree(slow_problem(0.9999), 1.1, np.zeros((1, 2)), max_cycles=1)
    assert states.outcome.tolist() == ["undecided"]


def test_depends_neither_on_the_batch_nor_on_threads():
    problem, rng = shakedown.example("two-node"), np.random.default_rng(1)
    starts = rng.uniform(-1.0, 2.0, (31, 2))
    whole = shakedown.long_term_states(problem, 0.8, starts)
    identical(whole, shakedown.long_term_states(problem, 0.8, starts, threads=3))
    order = rng.permutation(31)
    identical(whole, shakedown.long_term_states(problem, 0.8, starts[order]), order)
    identical(whole, shakedown.long_term_states(problem, 0.8, starts[4:5]), slice(4, 5))


def test_the_signature_tells_limit_cycles_apart_and_not_where_they_are_cut():
    problem = shakedown.example("two-node")
    states = shakedown.long_term_states(problem, 0.9, [[0.0, 0.0], [2.0, 1.0], [-1.0, 3.0]])
    assert len(set(states.signature.tolist())) == 1
    later = replace(problem, q_w=np.roll(problem.q_w, -17, axis=0), p_w=np.roll(problem.p_w, -17, axis=0))
    state = shakedown.long_term_state(later, 0.9, states.final_slip[0])
    assert state.outcome == "cyclic-slip"
    assert state.signature == states.signature[0]
    assert shakedown.long_term_state(problem, 1.2).signature != states.signature[0]


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no interval timer on this system")
@pytest.mark.parametrize("threads", [1, 2])
def test_an_interrupt_ends_it_soon(threads):
    problem = shakedown.example("block-9")
    starts = np.random.default_rng(0).uniform(-1.0, 1.0, (200_000, 9))  # some minutes
    shakedown.long_term_states(problem, 5.0, starts[:1])
    began, before = time.process_time(), signal.signal(signal.SIGALRM, signal.default_int_handler)
    gc.disable()  # what is raised in a function that the collector calls is lost
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        with pytest.raises(KeyboardInterrupt):
            shakedown.long_term_states(problem, 5.0, starts, threads=threads)
    finally:
        gc.enable()
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert time.process_time() - began < 10.0


@pytest.mark.parametrize(
    ("starts", "options", "message"),
    [
        ([0.0, 0.0], {}, r"initial slips: expected shape \(s, 2\), found \(2,\)"),
        ([[0.0, 0.0, 0.0]], {}, r"initial slips: expected shape \(s, 2\), found \(1, 3\)"),
        ([[0.0, np.nan]], {}, "initial slips: expected finite numbers, found nan"),
        ([[0.0, 1e120]], {}, "expected slips with reactions up to 1e.100"),
        ([[0.0, 0.0]], {"threads": 0}, "threads: expected a whole number >= 1, found 0"),
        ([[0.0, 0.0]], {"longest_period": 0.5}, "longest period: expected a whole number, found 0.5"),
    ],
)
def test_what_is_wrong_is_named(starts, options, message):
    with pytest.raises(shakedown.UsageError, match=message):
        shakedown.long_term_states(shakedown.example("two-node"), 0.7, starts, **options)
