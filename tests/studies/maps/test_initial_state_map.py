"""Maps of initial states, in the plane and in space: single runs, rows, what is known; files of interrupted runs."""

import numpy as np
import pytest
from command import run

import shakedown
from shakedown.files import pieces
from shakedown.joint.constraints import constraints
from shakedown.motion.checked_law import admissible

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
