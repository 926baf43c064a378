"""Many long-term states at once, and those of joints in uncoupled parts: state by state and part by part the single ones."""

import gc
import signal
import time
from dataclasses import replace

import numpy as np
import pytest
from joints import FAMILY, member, walking
from joints_in_space import embedded
from uncoupled_parts import joined, pair, with_mean

import shakedown
from benchmarks.problems import in_units
from shakedown import Outcome, Problem
from shakedown.long_term import motion_start, proved_outcome
from shakedown.long_term.find_state import LongTermStates, long_term_states
from shakedown.long_term.node_results import node_results
from shakedown.motion.checked_law import scales
from shakedown.motion.evolution import Evolution
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


@pytest.mark.parametrize(("load_factor", "outcome"), [(1.1, "undecided"), (0.9, "shakedown")])
def test_what_is_not_found_in_time_is_undecided_unless_it_is_proved(load_factor, outcome):
    states = assert_agree(slow_problem(0.9999), load_factor, np.zeros((1, 2)), max_cycles=1)
    assert states.outcome.tolist() == [outcome]


def test_whatever_is_proved_of_one_state_is_proved_of_many(monkeypatch):
    """A drift too: if a proof said that it ends, no number would stand against it."""
    joint, starts = walking(), np.zeros((2, 2))
    assert set(assert_agree(joint, 1.0, starts).outcome) == {"ratchetting"}
    monkeypatch.setattr(motion_start, "above_lambda_max", lambda _: False)
    monkeypatch.setattr(proved_outcome, "proof_from_start", lambda _: "as is said here")
    assert set(assert_agree(joint, 1.0, starts).outcome) == {"shakedown"}


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


ORDER = ("shakedown", "separation", "cyclic-slip", "ratchetting", "undecided")


def cycling():
    """A node that slips to and fro."""
    return with_mean(Problem(A=[[1.0]], B=[[0.2]], f=0.3, q_w=[[2.0], [-2.0]], p_w=[[1.0], [1.0]]))


@pytest.mark.parametrize("in_space", [False, True])
@pytest.mark.parametrize("decades", [0, 10])
def test_a_slow_drift_beside_a_large_slip_is_ratchetting(in_space, decades):
    still, slow = cycling(), in_units(with_mean(walking()), 1.0, 10.0**-decades)
    parts = [with_mean(embedded(each)) if in_space else each for each in (still, slow)]
    whole, alone = shakedown.long_term_state(joined(parts), 1.0), shakedown.long_term_state(parts[1], 1.0)
    assert whole.outcome == alone.outcome == Outcome.RATCHETTING
    d = parts[0].directions
    assert whole.drift[d:] == pytest.approx(alone.drift, rel=1e-6)
    assert not whole.drift[:d].any()
    assert whole.slip_per_cycle[1:] == pytest.approx(alone.slip_per_cycle, rel=1e-6)
    assert node_results(whole).status == ("slip", "slip", "slip")
    assert long_term_states(joined(parts), 1.0, np.zeros((1, 3 * d))).outcome.tolist() == ["ratchetting"]


@pytest.mark.parametrize("lever", [1e-6, 1.0])
@pytest.mark.parametrize("seed", [16, 18])
def test_a_body_that_sticks_beside_one_that_walks_changes_nothing(seed, lever):
    """Two rigid slips of one part: the other body's slips, one of them ``lever`` of the other, would press on it."""
    joint = joint_of_kind(np.random.default_rng(seed), "floating")
    alone, right = Problem(A=joint.A, B=joint.B, f=joint.f, q_w=joint.q_w, p_w=joint.p_w), ((0, 0), (0, 2))
    A, B = np.zeros((2, joint.n + 2, joint.n + 2))
    A[:-2, :-2], A[-2:, -2:] = joint.A, np.outer([1.0, -lever], [1.0, -lever])
    B[:-2, :-2], B[:-2, -2:] = joint.B, [0.1, -0.1 * lever]
    q_w, p_w = np.pad(joint.q_w, right), np.pad(joint.p_w, right, constant_values=1.0)
    both = Problem(A=A, B=B, f=np.append(joint.f, [1.0, 1.0]), q_w=q_w, p_w=p_w)
    walks, beside = (shakedown.long_term_state(each, 1.0) for each in (alone, both))
    assert walks.outcome == beside.outcome == Outcome.RATCHETTING
    assert walks.cycles_simulated == beside.cycles_simulated < 20
    assert beside.drift == pytest.approx([*walks.drift, 0.0, 0.0], rel=1e-9, abs=1e-14)


@pytest.mark.parametrize("decades", [-3, 0])
@pytest.mark.parametrize("kind", ["plane", "space"])
def test_the_outcome_is_the_worst_of_the_parts(kind, decades):
    for number in range(6 if kind == "plane" else 3):
        parts, load_factor = pair(kind, number, decades), 0.6 + 0.15 * number
        alone = [shakedown.long_term_state(part, load_factor, max_cycles=100) for part in parts]
        whole = shakedown.long_term_state(joined(parts), load_factor, max_cycles=100)
        assert whole.outcome == max((state.outcome for state in alone), key=ORDER.index)
        assert whole.proved == all(state.proved for state in alone)


@pytest.mark.parametrize("kind", ["plane", "space"])
def test_states_of_parts_agree_with_the_single_state(kind):
    problem, rng = joined(pair(kind, 3, 2)), np.random.default_rng(0)
    starts = 0.3 * rng.normal(size=(3, problem.layout.slip_size))
    starts[:, -2:] *= 100.0
    assert_agree(problem, 0.8, starts, max_cycles=60)


@pytest.mark.parametrize("kind", ["plane", "space"])
def test_the_whole_joint_does_in_a_period_what_its_parts_do(kind):
    """Followed in one motion from the state that was put together."""
    for number in (1, 12, 3, 8):
        problem = joined(pair(kind, number, 0))
        state = shakedown.long_term_state(problem, 0.9, max_cycles=100)
        if not state.period:
            continue
        path = state.history
        assert path.v[-1] == pytest.approx(state.final_slip, abs=1e-6 * np.abs(state.final_slip).max())
        moved = problem.law.size(np.diff(path.v, axis=0)).sum(axis=0)
        if not state.opened.any():
            none = 1e-6 * np.abs(state.final_slip).max()
            assert moved == pytest.approx(state.slip_per_cycle, rel=1e-3, abs=none)


@pytest.mark.parametrize("ahead", [0, 1])
def test_periods_of_parts_are_brought_in_step(ahead):
    """Two joints that repeat every other cycle: which of the two cycles each is in, plain cycles tell."""
    parts, starts = [], []
    for *data, load_factor, start in FAMILY:
        joint = member(*data)
        parts.append(replace(joint, q_w=load_factor * joint.q_w))
        starts.append(start)
    second = Evolution(parts[1], 1.0, starts[1])
    second.advance(ahead)
    whole, start = joined(parts), np.concatenate([starts[0], second.state.u[:2]])
    state = shakedown.long_term_state(whole, 1.0, start)
    assert (state.outcome, state.period) == (Outcome.CYCLIC_SLIP, 2)
    motion = Evolution(whole, 1.0, start)
    motion.advance(400 + state.cycles_simulated % 2)
    assert motion.state.u[:4] == pytest.approx(state.final_slip, abs=1e-9)
    assert [motion.cycle().dissipation for _ in range(2)] == pytest.approx(state.dissipations, rel=1e-6)
    many = long_term_states(whole, 1.0, [start])
    assert many.final_slip[0] == pytest.approx(state.final_slip)
    assert many.signature[0] == state.signature


def test_rest_is_proved_part_by_part():
    """Without a ball for both at once, as that of one part would have to be as large as that of the other."""
    joint = with_mean(shakedown.example("two-node"))
    whole = joined([joint, in_units(joint, 1e-5, 1e-5)])
    alone, both = (shakedown.long_term_state(each, 0.6) for each in (joint, whole))
    assert alone.proved
    assert both.proved
    assert both.energy_margin == pytest.approx(1e-5 * alone.energy_margin, rel=1e-6)


def test_an_undecided_part_leaves_the_joint_undecided_and_is_named():
    lifted = with_mean(Problem(A=[[1.0]], B=[[0.0]], f=0.5, q_w=[[0.1], [-0.1]], p_w=[[1.0], [-0.5]]))
    state = shakedown.long_term_state(joined([cycling(), lifted]), 1.0)
    assert state.outcome == Outcome.UNDECIDED
    assert "node 1 lifts off" in state.reason
    assert "cyclic-slip" in state.reason
    assert np.isnan(state.slip_per_cycle).all()
    assert state.stop is not None
