"""Maps of initial states: what they say agrees with single runs, with the rows, and with what is known."""

import numpy as np
import pytest

import shakedown
from shakedown.joint.constraints import constraints
from shakedown.motion.checked_law import admissible

JOINT = shakedown.example("two-node")


@pytest.fixture(scope="module")
def found():
    return shakedown.initial_state_map(JOINT, 0.7, states=256, seed=1)


def test_it_agrees_state_by_state_with_the_long_term_state(found):
    for k in range(0, 256, 16):
        state = shakedown.long_term_state(JOINT, 0.7, found.initial_slip[k])
        assert (found.outcome[k], found.period[k]) == (state.outcome, state.period)
        assert found.signature[k] == state.signature
        np.testing.assert_allclose(found.final_slip[k], state.final_slip, rtol=0, atol=1e-10)
        np.testing.assert_allclose(found.slip_per_cycle[k], state.slip_per_cycle, rtol=0, atol=1e-10)
        assert found.dissipation[k] == pytest.approx(state.dissipation_per_cycle, rel=1e-9, abs=1e-9)


def test_admissible_states_cycle_beyond_the_apex_line(found):
    """Theory and 562 of 562 runs: shakedown exactly where the slip of node 0 is below 0.65407."""
    rows, own = constraints(JOINT), constraints(JOINT).limits_of(1)
    apex = np.linalg.solve(rows.G[own], (rows.g - 0.7 * rows.d)[own])[0]
    assert apex == pytest.approx(0.65407, abs=1e-5)
    inside = admissible(JOINT, 0.7, found.initial_slip)
    assert 40 < inside.sum() < 256
    shaken = found.outcome[inside] == "shakedown"
    np.testing.assert_array_equal(shaken, found.initial_slip[inside, 0] < apex)
    assert 0 < shaken.sum() < len(shaken)


@pytest.mark.parametrize("name", ["three-node", "block-9", "two-node-3d", "one-node"])
def test_named_states_are_those_of_a_single_run_each(name):
    joint, load_factor = shakedown.example(name), 0.9
    found = shakedown.initial_state_map(joint, load_factor, states=2)
    words = {"zero": "zero", "given": "given", "critical": "witness"}
    assert list(found.named) == list(words)
    for k, (word, outcome) in enumerate((w, o) for w, o in found.named.items() if o is not None):
        slip = shakedown.bounds.named_start.named_start(joint, load_factor, words[word])
        np.testing.assert_array_equal(found.initial_slip[k], slip)
        assert outcome == shakedown.long_term_state(joint, load_factor, slip).outcome
    assert (found.named["given"] is None) == (joint.initial_slip is None)
    assert (found.named["critical"] is None) == (joint.directions == 2)


def test_numbers_over_all_states(found):
    shaken = (found.outcome[found.sampled] == "shakedown").sum()
    assert found.shakedown_fraction == shaken / 256
    p, z, n = shaken / 256, 1.959963984540054, 256
    middle, half = p + z**2 / (2 * n), z * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    expected = np.array([middle - half, middle + half]) / (1 + z**2 / n)
    np.testing.assert_allclose(found.interval, expected, rtol=1e-9)
    np.testing.assert_allclose(
        found.dissipation_quartiles, np.percentile(found.dissipation[2:], [0, 25, 50, 75, 100])
    )
    document = found.to_dict()
    assert document["states"] == 256
    assert document["limit_cycles"][0]["slipping_nodes"] == [1]
    assert repr(found).startswith("InitialStateMap(load_factor=0.7, states=256, shakedown_fraction=0.")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"load_factor": -1.0}, "load factor: expected a finite number >= 0"),
        ({"load_factor": []}, "load factor: expected a number, found"),
        ({"workers": 0}, "workers: expected a whole number >= 1"),
        ({"max_cycles": 0}, "max_cycles: expected a whole number >= 1"),
    ],
)
def test_misuse_is_said_in_one_line(words, said):
    with pytest.raises(shakedown.UsageError, match=said):
        shakedown.initial_state_map(JOINT, **{"load_factor": 0.7, **words})
