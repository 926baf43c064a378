"""Whether all states end in one: by what they ended in, also two attractors; and where a map's states begin."""

import numpy as np
import pytest

import shakedown
from shakedown.motion.checked_law import admissible
from shakedown.motion.evolution import Evolution
from shakedown.studies.samplers import Sampler, Sampling
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


ATTRACTED = shakedown.example("two-attractors")
DISSIPATIONS = (1.876905, 2.135192)


@pytest.fixture(scope="module")
def found():
    return shakedown.initial_state_map(ATTRACTED, 1.0, states=512, reach=2.0)


def test_both_are_there(found):
    assert found.outcomes == {"cyclic-slip": 512}
    cycles = sorted(found.limit_cycles, key=lambda cycle: cycle.dissipation)
    assert [cycle.period for cycle in cycles] == [1, 1]
    assert [cycle.slipping_nodes for cycle in cycles] == [(0, 1), (0, 1)]
    assert min(cycle.count for cycle in cycles) > 100
    for cycle, expected in zip(cycles, DISSIPATIONS, strict=True):
        low, high = cycle.dissipation
        assert high - low <= 1e-9 * high
        assert low == pytest.approx(expected, abs=5e-7)
    assert found.unique is False


@pytest.mark.parametrize("which", [0, 1])
def test_both_are_stable_and_a_disturbance_shrinks_by_the_contraction(found, which):
    """Second method for the contraction: the slips of two neighbours, cycle by cycle."""
    cycle = sorted(found.limit_cycles, key=lambda cycle: cycle.dissipation)[which]
    ends = []
    for away in (0.0, 1e-6):
        evolution = Evolution(ATTRACTED, 1.0, cycle.final_slip[0] + away)
        slips = []
        for _ in range(12):
            evolution.cycle()
            slips.append(evolution.method.u[:2].copy())
        ends.append(slips)
    apart = np.abs(np.subtract(*ends)).max(axis=1)
    assert apart[-1] / apart[-2] == pytest.approx(found.contraction[cycle.example], rel=1e-3)
    assert 0 < found.contraction[cycle.example] < 1


@pytest.mark.slow
@pytest.mark.parametrize("sampler", Sampler)
def test_a_state_follows_from_its_number_alone(sampler):
    count = 81 if sampler == Sampler.TRANSIENTS else 144  # the first of them are simulated
    chosen = Sampling(JOINT, 0.7, sampler, states=count, seed=3)
    every = chosen.slips(0, count)
    assert every.shape == (chosen.states, 2)
    for start, stop in ((0, 1), (63, 65), (70, count)):
        np.testing.assert_array_equal(chosen.slips(start, stop), every[start:stop])
    more = Sampling(JOINT, 0.7, sampler, states=169, seed=3)
    if sampler != Sampler.GRID:
        np.testing.assert_array_equal(more.slips(0, count), every)
        assert (Sampling(JOINT, 0.7, sampler, states=count, seed=4).slips(0, 9) != every[:9]).any()


@pytest.mark.parametrize("sampler", [Sampler.GRID, Sampler.SOBOL])
def test_a_box_is_about_the_safe_slip_and_filled(sampler):
    chosen = Sampling(JOINT, 0.7, sampler, states=1024, reach=2.0)
    place = (chosen.slips(0, 1024) - shakedown.safe_slip(JOINT, 0.7).slip) / chosen.half_width
    assert np.abs(place).max() <= 1.0 + 1e-12
    assert np.abs(place.mean(axis=0)).max() < 0.01
    np.testing.assert_allclose((place**2).mean(axis=0), 1.0 / 3.0, atol=0.03)


@pytest.mark.parametrize("name", ["two-attractors", "two-node-3d"])
@pytest.mark.parametrize("sampler", [Sampler.GRID, Sampler.SOBOL])
def test_a_box_contains_the_named_states_and_what_loads_leave_behind(name, sampler):
    joint = shakedown.example(name)
    chosen = Sampling(joint, 1.1, sampler, states=16)
    left = Sampling(joint, 1.1, Sampler.TRANSIENTS, states=4).slips(0, 4)
    for slip in chosen.named.values():
        assert (np.abs(slip - chosen.centre) <= chosen.half_width * (1 + 1e-12)).all()
    assert (np.abs(left - chosen.centre) <= 1.5 * chosen.half_width).all()


def test_states_of_a_ball_are_uniform_in_it():
    chosen = Sampling(JOINT, 0.7, Sampler.BALL, states=4000, reach=1.5)
    share = chosen.ball.distance(chosen.slips(0, 4000)) / chosen.ball.radius
    assert share.max() <= 1.5 * (1 + 1e-12)
    assert (share < 0.75).mean() == pytest.approx(0.25, abs=0.03)


def test_what_a_transient_leaves_is_admissible_at_the_first_load():
    slips = Sampling(JOINT, 0.7, Sampler.TRANSIENTS, states=64).slips(0, 64)
    assert admissible(JOINT, 0.7, slips).all()
    assert len(np.unique(slips.round(9), axis=0)) > 30


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"sampler": "monte-carlo"}, "sampler: expected one of grid, sobol, ball, transients"),
        ({"states": 0}, "states: expected a whole number from 1"),
        ({"seed": -1}, "seed: expected a whole number >= 0"),
        ({"reach": 0.0}, "reach: expected a number > 0"),
        ({"coordinates": (0, 0)}, "two different nodes from 0 to 1"),
        ({"coordinates": (0, 2)}, "two different nodes from 0 to 1"),
    ],
)
def test_what_cannot_be_sampled_is_said_in_one_line(words, said):
    with pytest.raises(shakedown.UsageError, match=said):
        Sampling(JOINT, 0.7, **words)
