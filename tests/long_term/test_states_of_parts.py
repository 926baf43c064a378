"""Long-term states of joints in uncoupled parts: each part's verdict is its own, whatever the others do."""

import numpy as np
import pytest
from joints import FAMILY, member, walking
from joints_in_space import embedded
from uncoupled_parts import joined, pair

import shakedown
from benchmarks.problems import in_units
from shakedown import Outcome, Problem
from shakedown.long_term.find_state import long_term_states
from shakedown.long_term.node_results import node_results
from shakedown.motion.evolution import Evolution

ORDER = ("shakedown", "separation", "cyclic-slip", "ratchetting", "undecided")


def with_mean(problem):
    """The joint with its mean said."""
    return Problem(
        A=problem.A, B=problem.B, C=problem.C, f=problem.f, q_w=problem.q_w, p_w=problem.p_w,
        q_mean=problem.q_w.mean(axis=0), p_mean=problem.p_w.mean(axis=0),
    )  # fmt: skip


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
def test_many_states_are_single_ones(kind):
    problem, rng = joined(pair(kind, 3, 2)), np.random.default_rng(0)
    starts = 0.3 * rng.normal(size=(3, problem.layout.slip_size))
    starts[:, -2:] *= 100.0
    many = long_term_states(problem, 0.8, starts, max_cycles=60)
    for k, start in enumerate(starts):
        one = shakedown.long_term_state(problem, 0.8, start, max_cycles=60)
        found = (many.outcome[k], many.period[k], many.signature[k])
        assert found == (one.outcome, one.period, one.signature)
        assert many.final_slip[k] == pytest.approx(one.final_slip, nan_ok=True)
        assert many.slip_per_cycle[k] == pytest.approx(one.slip_per_cycle, nan_ok=True)
        assert many.dissipation[k] == pytest.approx(one.dissipation_per_cycle, nan_ok=True)


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
    for a, fB, impulses, load_factor, start in FAMILY:
        joint = member(a, fB, impulses)
        parts.append(Problem(
            A=joint.A, B=joint.B, f=joint.f, q_w=load_factor * joint.q_w, p_w=joint.p_w, q_mean=joint.q_mean,
            p_mean=joint.p_mean,
        ))  # fmt: skip
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
