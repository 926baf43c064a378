"""Pieces that a disk, another program or an attacker altered: they are done again, and nothing else happens."""

import io
import os
import zipfile

import numpy as np
import pytest
from hostile.damaged_npz import BYTES, HEADERS, npy, with_header
from pieces_works import Squares, squares

from shakedown.files.pieces import read_arrays, run_pieces
from shakedown.ground.errors import ProblemError

WORK = Squares()
LIES = [each for each in HEADERS if "'a'" not in each and not each.startswith(" ")]  # NumPy reads the others


def kept(tmp_path):
    """The path of one piece of a run that has ended, and its bytes."""
    with pytest.raises(KeyError), run_pieces(WORK, 1, output=tmp_path / "map.npz"):
        raise KeyError
    (path,) = (tmp_path / "map.npz.parts").iterdir()
    return path, path.read_bytes()


def resumed(tmp_path):
    """Whether the piece was done again."""
    calls = []
    with run_pieces(
        WORK, 1, output=tmp_path / "map.npz", resume=True, progress=lambda *at: calls.append(at)
    ) as pieces:
        assert squares(pieces).tolist() == [k**2 for k in range(10)]
    return len(calls) == 2


def archive(*members):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as file:
        for member in members:
            file.writestr("square.npy", member)
    return buffer.getvalue()


def test_a_flipped_byte_a_cut_or_bytes_put_in_cost_the_piece_at_most(tmp_path):
    path, whole = kept(tmp_path)
    for place in range(0, len(whole), 11):
        for damaged in (
            whole[:place] + bytes([whole[place] ^ 1 << place % 8]) + whole[place + 1 :],
            whole[:place],
            whole[:place] + BYTES[place % len(BYTES)] + whole[place:],
        ):
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(damaged)
            resumed(tmp_path)


@pytest.mark.parametrize(
    "content",
    [
        b"", b"PK", b"text", npy(np.arange(10)), *(archive(with_header(header, bytes(80))) for header in LIES),
        bytes(1 << 20),
    ],
    ids=lambda content: content[:4].hex(),
)  # fmt: skip
def test_a_piece_that_cannot_be_is_done_again(tmp_path, content):
    path, _ = kept(tmp_path)
    path.write_bytes(content)
    assert resumed(tmp_path)


@pytest.mark.parametrize("make", [os.mkdir, os.mkfifo, lambda path: os.symlink("/dev/zero", path)])
def test_what_is_no_file_is_one_line_or_done_again(tmp_path, make):
    path, _ = kept(tmp_path)
    path.unlink()
    make(path)
    with pytest.raises(ProblemError):
        read_arrays(path)


def test_pickles_are_not_read(tmp_path):
    path = tmp_path / "0.npz"
    np.savez(path, square=np.array([print], dtype=object))
    with pytest.raises(ProblemError, match="allow_pickle=False"):
        read_arrays(path)
