"""Maps of initial states: single runs, files of interrupted runs; whether all end in one state; where the states begin."""

import numpy as np
import pytest
from command import run
from joints import FAMILY, member

import shakedown
from shakedown.files import pieces
from shakedown.joint.constraints import constraints
from shakedown.motion.checked_law import admissible
from shakedown.motion.evolution import Evolution
from shakedown.studies.samplers import Sampler, Sampling

JOINT = shakedown.example("two-node")


@pytest.fixture(scope="module")
def found():
    return shakedown.initial_state_map(JOINT, 0.7, states=256, seed=1)


def agrees_with_single_states(found, numbers, digits):
    for k in numbers:
        state = shakedown.long_term_state(found.sampling.problem, found.load_factor, found.initial_slip[k])
        assert (found.outcome[k], found.period[k]) == (state.outcome, state.period)
        assert found.signature[k] == state.signature
        np.testing.assert_allclose(found.final_slip[k], state.final_slip, rtol=0, atol=digits)
        np.testing.assert_allclose(found.slip_per_cycle[k], state.slip_per_cycle, rtol=0, atol=digits)
        assert found.dissipation[k] == pytest.approx(state.dissipation_per_cycle, rel=1e-9, abs=1e-9)


def test_it_agrees_state_by_state_with_the_long_term_state(found):
    agrees_with_single_states(found, range(0, 256, 16), 1e-10)


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


SPACE = shakedown.example("two-node-3d")


@pytest.fixture(scope="module")
def in_space():
    return shakedown.initial_state_map(SPACE, 0.98 * shakedown.upper_bound(SPACE).load_factor, states=8)


def test_it_agrees_bit_by_bit_with_single_states(in_space):
    agrees_with_single_states(in_space, (0, 5), 0.0)
    assert in_space.initial_slip.shape == in_space.final_slip.shape == (len(in_space.sampling.named) + 8, 4)
    assert in_space.slip_per_cycle.shape == (len(in_space), 2)


@pytest.mark.parametrize("sampler", ["ball", "transients"])
def test_every_sampler_has_states(sampler):
    some = shakedown.initial_state_map(SPACE, 0.5, states=5, sampler=sampler, seed=3)
    np.testing.assert_array_equal(some.sampling.slips(4, 5), some.initial_slip[some.sampled][4:5])
    assert len(np.unique(some.initial_slip[:, 0])) > 1 or sampler == "transients"
    if sampler == "ball":
        assert (some.sampling.ball.distance(some.initial_slip) <= some.sampling.ball.radius).all()
        assert some.outcomes == {"shakedown": 5}


def test_the_command(tmp_path):
    words = ["map", "two-node-3d", "--load-factor", "0.5", "--states", "4", "-q"]
    code, text, err = run(*words, "--grid", "0:y", "1:x", "-o", "map.npz", cwd=tmp_path)
    assert (code, err) == (0, "")
    assert max(map(len, text.splitlines())) <= 80
    kept = np.load(tmp_path / "map.npz")["initial_slip"][-4:]
    assert [len(np.unique(column)) for column in kept.T] == [1, 2, 2, 1]


KEYS = ("initial_slip", "final_slip", "outcome", "period", "dissipation", "load_factor")


def mapped(path, states, **words):
    return shakedown.initial_state_map(JOINT, 0.7, states=states, path=path, **words)


def test_the_file_holds_every_state(tmp_path):
    path = tmp_path / "map.npz"
    on_disk = mapped(path, 70)
    in_memory = shakedown.initial_state_map(JOINT, 0.7, states=70)
    with np.load(path, allow_pickle=False) as file:
        shapes, names = {key: file[key].shape for key in KEYS}, file["named"].tolist()
        for key in KEYS[:-1]:
            np.testing.assert_array_equal(file[key], getattr(in_memory, key))
            np.testing.assert_array_equal(file[key], getattr(on_disk, key))
        assert file["load_factor"] == 0.7
    assert shapes == {
        "initial_slip": (72, 2), "final_slip": (72, 2), "outcome": (72,), "period": (72,),
        "dissipation": (72,), "load_factor": (),
    }  # fmt: skip
    assert names == ["zero", "critical"]
    assert on_disk.to_dict()["limit_cycles"] == in_memory.to_dict()["limit_cycles"]
    assert [entry.name for entry in tmp_path.iterdir()] == ["map.npz"]


def test_a_map_that_is_whole_comes_out_the_same_when_resumed(tmp_path):
    path = tmp_path / "map.npz"
    mapped(path, 70)
    whole = path.read_bytes()
    mapped(path, 70, resume=True)
    assert path.read_bytes() == whole
    assert not (tmp_path / "map.npz.parts").exists()
    assert mapped(path, 71, resume=True).initial_slip.shape == (73, 2)


class Stopped(Exception):
    """The run ends here."""


def stopped_after(patch, last):
    """A run ends as soon as its piece ``last`` is kept."""
    keep = pieces._keep

    def stop(folder, name, arrays):
        keep(folder, name, arrays)
        if name.endswith(f"-{last}.npz"):
            raise Stopped

    patch.setattr(pieces, "_keep", stop)


def test_interrupted_after_any_piece_the_bytes_are_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr("shakedown.studies.basin_map.piece_size", lambda problem: 16)
    mapped(tmp_path / "whole.npz", 64)
    expected = (tmp_path / "whole.npz").read_bytes()
    for last in range(4):
        path = tmp_path / f"{last}.npz"
        with monkeypatch.context() as patch:
            stopped_after(patch, last)
            with pytest.raises(Stopped):
                mapped(path, 64)
        assert not path.exists()
        mapped(path, 64, resume=True)
        assert path.read_bytes() == expected


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
def attracted():
    return shakedown.initial_state_map(ATTRACTED, 1.0, states=512, reach=2.0)


def test_both_are_there(attracted):
    assert attracted.outcomes == {"cyclic-slip": 512}
    cycles = sorted(attracted.limit_cycles, key=lambda cycle: cycle.dissipation)
    assert [cycle.period for cycle in cycles] == [1, 1]
    assert [cycle.slipping_nodes for cycle in cycles] == [(0, 1), (0, 1)]
    assert min(cycle.count for cycle in cycles) > 100
    for cycle, expected in zip(cycles, DISSIPATIONS, strict=True):
        low, high = cycle.dissipation
        assert high - low <= 1e-9 * high
        assert low == pytest.approx(expected, abs=5e-7)
    assert attracted.unique is False


@pytest.mark.parametrize("which", [0, 1])
def test_both_are_stable_and_a_disturbance_shrinks_by_the_contraction(attracted, which):
    """Second method for the contraction: the slips of two neighbours, cycle by cycle."""
    cycle = sorted(attracted.limit_cycles, key=lambda cycle: cycle.dissipation)[which]
    ends = []
    for away in (0.0, 1e-6):
        evolution = Evolution(ATTRACTED, 1.0, cycle.final_slip[0] + away)
        slips = []
        for _ in range(12):
            evolution.cycle()
            slips.append(evolution.method.u[:2].copy())
        ends.append(slips)
    apart = np.abs(np.subtract(*ends)).max(axis=1)
    assert apart[-1] / apart[-2] == pytest.approx(attracted.contraction[cycle.example], rel=1e-3)
    assert 0 < attracted.contraction[cycle.example] < 1


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
