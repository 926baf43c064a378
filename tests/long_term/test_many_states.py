"""Many long-term states at once: state by state those of ``long_term_state``, whatever else is in the batch."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.long_term.many_states import LongTermStates


def one_by_one(problem, load_factor, starts, **options):
    return [shakedown.long_term_state(problem, load_factor, start, **options) for start in starts]


def assert_agree(states, singles, problem, load_factor):
    """Outcome, period and contact sequence are equal; slips and dissipation to 1e-9 of the scales."""
    scale = shakedown.scales(problem, load_factor)
    for row, one in enumerate(singles):
        assert (states.outcome[row], states.period[row]) == (one.outcome, one.period)
        assert int(states.signature[row]) == one.signature
        near = 1e-9 * max(scale.length, float(np.abs(one.final_slip).max()))
        assert states.final_slip[row] == pytest.approx(one.final_slip, abs=near)
        assert states.slip_per_cycle[row] == pytest.approx(one.slip_per_cycle, abs=near, nan_ok=True)
        assert states.dissipation[row] == pytest.approx(
            one.dissipation_per_cycle, abs=near * scale.force, nan_ok=True
        )
        assert states.contraction[row] == pytest.approx(one.contraction, abs=1e-6, nan_ok=True)


def identical(one: LongTermStates, other: LongTermStates, rows=slice(None)):
    for key in LongTermStates.__dataclass_fields__:
        if key != "load_factor":
            first, second = getattr(one, key)[rows], getattr(other, key)
            assert first.tobytes() == second.tobytes(), key


@pytest.mark.parametrize(("name", "load_factor"), [("two-node", 0.7), ("two-node", 0.9), ("block-9", 2.0)])
def test_agrees_with_the_single_state(name, load_factor):
    problem, rng = shakedown.example(name), np.random.default_rng(0)
    starts = rng.uniform(-1.5, 1.5, (12, problem.n)) * shakedown.scales(problem, load_factor).length
    states = shakedown.long_term_states(problem, load_factor, starts)
    assert len(states) == 12
    assert states.load_factor == load_factor
    assert_agree(states, one_by_one(problem, load_factor, starts), problem, load_factor)


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


def test_no_initial_slip_gives_no_state():
    assert len(shakedown.long_term_states(shakedown.example("two-node"), 0.7, np.zeros((0, 2)))) == 0


@pytest.mark.parametrize(
    ("starts", "options", "message"),
    [
        ([0.0, 0.0], {}, r"initial slips: expected shape \(s, 2\), found \(2,\)"),
        ([[0.0, 0.0, 0.0]], {}, r"initial slips: expected shape \(s, 2\), found \(1, 3\)"),
        ([[0.0, np.nan]], {}, "initial slips: expected finite numbers, found nan"),
        ([[0.0, 1e120]], {}, "expected slips with reactions up to 1e.100"),
        ([[0.0, 0.0]], {"threads": 0}, "threads: expected at least 1, found 0"),
        ([[0.0, 0.0]], {"longest_period": 0.5}, "longest_period: expected a whole number, found 0.5"),
    ],
)
def test_what_is_wrong_is_named(starts, options, message):
    with pytest.raises(shakedown.UsageError, match=message):
        shakedown.long_term_states(shakedown.example("two-node"), 0.7, starts, **options)
