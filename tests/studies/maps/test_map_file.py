"""The file of a map: the same bytes whoever did the work and however often it was interrupted."""

import errno
import hashlib
import io
import os
import zipfile

import numpy as np
import pytest
from hostile.damaged_npz import HEADERS, npy, with_header

import shakedown
from shakedown.campaign.journal import Journal
from shakedown.campaign.stored_result import packed, unpacked
from shakedown.studies.map_file import finished_map

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
    assert isinstance(on_disk.final_slip, np.memmap)
    assert on_disk.to_dict()["limit_cycles"] == in_memory.to_dict()["limit_cycles"]
    assert [entry.name for entry in tmp_path.iterdir()] == ["map.npz"]


def test_a_map_that_is_whole_is_not_made_again(tmp_path, monkeypatch):
    path = tmp_path / "map.npz"
    before, bytes_before = mapped(path, 70), path.read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr("shakedown.studies.mapping.run_campaign", None)
        after = mapped(path, 70, resume=True)
        np.testing.assert_array_equal(after.final_slip, before.final_slip)
        with pytest.raises(TypeError):
            mapped(path, 70, resume=True, seed=1)
    assert not (tmp_path / "map.npz.partial").exists()  # it ended before its first piece
    assert mapped(path, 71, resume=True).initial_slip.shape == (73, 2)
    path.write_bytes(b"something else")
    mapped(path, 70, resume=True)
    assert path.read_bytes() == bytes_before


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The bytes of a small map, and what reading one again needs."""
    path, known = tmp_path_factory.mktemp("map") / "map.npz", []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("shakedown.studies.mapping.finished_map", lambda *words: known.extend(words))
        patch.setattr("shakedown.studies.mapping.LOGGER.disabled", True)
        path.touch()
        mapped(path, 4, resume=True)
    return path.read_bytes(), *known[1:]


def read_again(path, content, settings, kinds):
    path.write_bytes(content)
    return finished_map(path, settings, kinds)


def test_no_altered_byte_of_a_finished_map_is_accepted(tmp_path, finished):
    path, (whole, *known) = tmp_path / "map.npz", finished
    assert read_again(path, whole, *known) is not None
    for place in range(0, len(whole), 17):
        altered = bytearray(whole)
        altered[place] ^= 1 << place % 8
        assert read_again(path, altered, *known) is None, place
        assert read_again(path, whole[:place], *known) is None, place
    assert read_again(path, whole + b"0", *known) is None


def test_where_files_cannot_be_mapped_a_map_is_read(tmp_path, finished, monkeypatch):
    def refused(*_, **__):
        raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))

    path, (whole, *known) = tmp_path / "map.npz", finished
    mapped_columns = read_again(path, whole, *known)
    monkeypatch.setattr(np, "memmap", refused)
    columns = read_again(path, whole, *known)
    assert columns.keys() == mapped_columns.keys()
    for key, column in columns.items():
        np.testing.assert_array_equal(column, mapped_columns[key])


def sealed(content):
    return content + hashlib.sha256(content).hexdigest().encode()


def test_a_map_that_somebody_else_sealed_is_none(tmp_path, finished):
    """Its checksum is right; its columns claim other shapes and types, or what no file can hold."""
    path, (whole, *known) = tmp_path / "map.npz", finished
    with np.load(io.BytesIO(whole)) as file:
        members = {f"{key}.npy": npy(file[key]) for key in file.files}
    other = [with_header(header, members["period.npy"][128:]) for header in HEADERS]
    other += [npy(np.ones(4)), npy(np.ones((4, 2), dtype=np.int64)), b""]
    for method in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        for member in other:
            buffer = io.BytesIO()
            with zipfile.ZipFile(buffer, "w", method) as archive:
                for name, content in (members | {"period.npy": member}).items():
                    archive.writestr(name, content)
                archive.comment = bytes(64)
            assert read_again(path, sealed(buffer.getvalue()[:-64]), *known) is None


def test_what_is_made_again_is_said(tmp_path, caplog):
    path = tmp_path / "map.npz"
    mapped(path, 4)
    whole = path.read_bytes()
    path.write_bytes(whole.replace(np.float64(0.7).tobytes(), np.float64(0.8).tobytes()))
    assert path.read_bytes() != whole
    mapped(path, 4, resume=True)
    assert path.read_bytes() == whole
    assert "map.npz: not this map, or altered since; made again" in caplog.text


@pytest.mark.usefixtures("small_pieces")
def test_a_piece_of_another_shape_is_done_again(tmp_path, monkeypatch):
    path, add = tmp_path / "map.npz", Journal.add
    mapped(path, 48)
    whole = path.read_bytes()
    path.unlink()

    def wrong(journal, number, piece):
        arrays = unpacked(piece)
        column, values = [
            ("period", arrays["period"] * 1.0),
            ("final_slip", np.ones((15, 2))),
            ("x", np.ones(16)),
        ][number]
        add(journal, number, packed(arrays | {column: values}))
        if number == 2:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Journal, "add", wrong)
        with pytest.raises(KeyboardInterrupt):
            mapped(path, 48)
    mapped(path, 48, resume=True)
    assert path.read_bytes() == whole


def test_several_load_factors_are_rows_below_each_other(tmp_path):
    path = tmp_path / "map.npz"
    maps = shakedown.initial_state_map(JOINT, [0.7, 0.8], states=65, path=path)
    with np.load(path) as file:
        np.testing.assert_array_equal(file["load_factor"], np.repeat([0.7, 0.8], 67))
        np.testing.assert_array_equal(file["final_slip"][67:], maps.maps[1].final_slip)


@pytest.fixture
def small_pieces(monkeypatch):
    monkeypatch.setattr("shakedown.studies.map_pieces.MapPieces.size", 16)


class Stopped(Exception):
    """The run ends here."""


def stopped_after(patch, last):
    """A run ends as soon as its piece ``last`` is recorded."""
    add = Journal.add

    def stop(journal, number, piece):
        add(journal, number, piece)
        if number == last:
            raise Stopped

    patch.setattr(Journal, "add", stop)


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
def test_another_map_is_not_gone_on_with(tmp_path, monkeypatch):
    path, partial = tmp_path / "map.npz", tmp_path / "map.npz.partial"
    with monkeypatch.context() as patch:
        stopped_after(patch, 1)
        with pytest.raises(Stopped):
            mapped(path, 64)
    assert partial.exists()
    with pytest.raises(shakedown.UsageError, match="unfinished run is recorded there; resume it, or remove"):
        mapped(path, 64)
    with pytest.raises(shakedown.UsageError, match="recorded with seed = 0, not 1"):
        mapped(path, 64, seed=1, resume=True)
    with pytest.raises(shakedown.UsageError, match="recorded with states = 64, not 80"):
        mapped(path, 80, resume=True)
    assert not path.exists()


@pytest.mark.usefixtures("small_pieces")
def test_on_a_cluster_the_bytes_are_the_same(tmp_path):
    """Its worker is a thread of this process; those that die are in ``tests/campaign/test_cluster.py``."""
    distributed = pytest.importorskip("distributed")
    calls = []
    mapped(tmp_path / "whole.npz", 64)
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=":0", silence_logs=50
    ) as cluster:
        address = cluster.scheduler_address
        mapped(tmp_path / "cluster.npz", 64, scheduler=address, progress=lambda *done: calls.append(done))
    assert calls[-1] == (5, 5)  # the named states are one
    assert digest(tmp_path / "cluster.npz") == digest(tmp_path / "whole.npz")
