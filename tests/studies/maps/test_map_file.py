"""The file of a map: the same bytes whoever did the work and however often it was interrupted."""

import hashlib

import numpy as np
import pytest

import shakedown
from shakedown.files import pieces

JOINT = shakedown.example("two-node")
KEYS = ("initial_slip", "final_slip", "outcome", "period", "dissipation", "load_factor")


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


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
    monkeypatch.setattr("shakedown.studies.basin_map.MapPieces.size", 16)
    mapped(tmp_path / "whole.npz", 64)
    expected = digest(tmp_path / "whole.npz")
    for last in range(4):
        path = tmp_path / f"{last}.npz"
        with monkeypatch.context() as patch:
            stopped_after(patch, last)
            with pytest.raises(Stopped):
                mapped(path, 64)
        assert not path.exists()
        mapped(path, 64, resume=True)
        assert digest(path) == expected
