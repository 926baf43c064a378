"""The file of a map: the same bytes whoever did the work and however often it was interrupted."""

import hashlib
import io
import zipfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hostile.damaged_npz import HEADERS, npy, with_header

import shakedown
from shakedown.campaign import pieces
from shakedown.studies import mapping
from shakedown.studies.mapping import MapPieces

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


def test_a_map_that_is_whole_is_not_made_again(tmp_path, monkeypatch):
    path = tmp_path / "map.npz"
    before, bytes_before = mapped(path, 70), path.read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr("shakedown.studies.mapping.run_pieces", None)
        after = mapped(path, 70, resume=True)
        np.testing.assert_array_equal(after.final_slip, before.final_slip)
        with pytest.raises(TypeError):
            mapped(path, 70, resume=True, seed=1)
    assert not (tmp_path / "map.npz.parts").exists()  # it ended before its first piece
    assert mapped(path, 71, resume=True).initial_slip.shape == (73, 2)
    path.write_bytes(b"something else")
    mapped(path, 70, resume=True)
    assert path.read_bytes() == bytes_before


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The bytes of a small map, and its work."""
    path = tmp_path_factory.mktemp("map") / "map.npz"
    return mapped(path, 4), path.read_bytes()


def read_again(path, content, finished):
    path.write_bytes(content)
    return mapping._finished(path, MapPieces((finished[0].sampling,)))


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_no_altered_byte_changes_a_finished_map(tmp_path, finished):
    path, (found, whole) = tmp_path / "map.npz", finished
    assert read_again(path, whole, finished) is not None
    for place in range(0, len(whole), 17):
        altered = bytearray(whole)
        altered[place] ^= 1 << place % 8
        columns = read_again(path, altered, finished) or vars(found)
        for key in KEYS[:-1]:
            np.testing.assert_array_equal(columns[key], getattr(found, key))
        assert read_again(path, whole[:place], finished) is None, place


def test_a_map_that_somebody_else_wrote_is_none(tmp_path, finished):
    """Its columns claim other shapes and types, or what no file can hold."""
    path, whole = tmp_path / "map.npz", finished[1]
    with np.load(io.BytesIO(whole)) as file:
        members = {f"{key}.npy": npy(file[key]) for key in file.files}
    other = [with_header(header, members["period.npy"][128:]) for header in HEADERS]
    other += [npy(np.ones(4)), npy(np.array(4)), b""]
    for method in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        for member in other:
            buffer = io.BytesIO()
            with zipfile.ZipFile(buffer, "w", method) as archive:
                for name, content in (members | {"period.npy": member}).items():
                    archive.writestr(name, content)
            assert read_again(path, buffer.getvalue(), finished) is None


def test_what_is_made_again_is_said(tmp_path, caplog):
    path = tmp_path / "map.npz"
    mapped(path, 4)
    whole = path.read_bytes()
    path.write_bytes(whole.replace(np.float64(0.7).tobytes(), np.float64(0.8).tobytes()))
    assert path.read_bytes() != whole
    mapped(path, 4, resume=True)
    assert path.read_bytes() == whole
    assert "map.npz: not this map, or altered since; made again" in caplog.text


def test_several_load_factors_are_rows_below_each_other(tmp_path):
    path = tmp_path / "map.npz"
    maps = shakedown.initial_state_map(JOINT, [0.7, 0.8], states=65, path=path)
    with np.load(path) as file:
        np.testing.assert_array_equal(file["load_factor"], np.repeat([0.7, 0.8], 67))
        np.testing.assert_array_equal(file["final_slip"][67:], maps.maps[1].final_slip)


@pytest.fixture
def small_pieces(monkeypatch):
    monkeypatch.setattr("shakedown.studies.mapping.MapPieces.size", 16)


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


@pytest.mark.usefixtures("small_pieces")
def test_interrupted_after_any_piece_the_bytes_are_the_same(tmp_path, monkeypatch):
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


@pytest.mark.usefixtures("small_pieces")
def test_another_map_is_not_gone_on_with(tmp_path, monkeypatch, caplog):
    path, parts = tmp_path / "map.npz", tmp_path / "map.npz.parts"
    mapped(path, 64, seed=1)
    expected = path.read_bytes()
    path.unlink()
    with monkeypatch.context() as patch:
        stopped_after(patch, 1)
        with pytest.raises(Stopped):
            mapped(path, 64)
    assert len(list(parts.iterdir())) == 2
    with pytest.raises(shakedown.UsageError, match="unfinished run is kept there; resume it, or remove"):
        mapped(path, 64)
    mapped(path, 64, seed=1, resume=True)
    assert path.read_bytes() == expected
    assert f"goes on from 0 of 5 pieces in {parts}; 2 others there do not fit" in caplog.messages
    assert not parts.exists()


def test_on_any_executor_the_bytes_are_the_same(tmp_path):
    calls = []
    mapped(tmp_path / "whole.npz", 8200)
    with ThreadPoolExecutor(2) as pool:
        mapped(tmp_path / "other.npz", 8200, executor=pool, progress=lambda *done: calls.append(done))
        assert pool.submit(int).result() == 0
    assert calls[-1] == (3, 3)  # the named states are one
    assert digest(tmp_path / "other.npz") == digest(tmp_path / "whole.npz")


@pytest.mark.usefixtures("small_pieces")
def test_pieces_that_stay_beside_a_whole_map_go(tmp_path):
    """As after a kill between the two."""
    path, parts = tmp_path / "map.npz", tmp_path / "map.npz.parts"
    mapped(path, 64)
    parts.mkdir()
    (parts / f"{'0' * 16}-3.npz").touch()
    mapped(path, 64, resume=True)
    assert not parts.exists()
