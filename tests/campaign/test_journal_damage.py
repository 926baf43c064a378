"""A journal that a disk, another program or an attacker altered: the same result or one line, at once."""

import errno
import hashlib
import io
import json
import mmap
import os
import sqlite3
import zipfile
import zlib

import numpy as np
import pytest
from campaign_works import Squares, squares
from hostile.damaged_npz import HEADERS, npy, with_header

from shakedown.campaign.journal import FORMAT, HEAD, MARK, Journal, journal_at
from shakedown.campaign.pieces import run_campaign
from shakedown.campaign.stored_result import packed, unpacked
from shakedown.ground.errors import ProblemError, UsageError

HEADER = {"what": "squares", "seed": "0"}
COUNT = 3


def small(number):
    return bytes([number]) * (number + 2)


@pytest.fixture(autouse=True)
def quick_disk(monkeypatch):
    monkeypatch.setattr(os, "fsync", lambda _: None)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "journal"


def recorded(path):
    with journal_at(path, HEADER) as journal:
        run_campaign(small, COUNT, journal)
    return path.read_bytes()


def resumed(path):
    """The pieces of a resumed run and how many were done again; or the line with which it is refused."""
    done = []
    try:
        with journal_at(path, HEADER, resume=True) as journal:
            run_campaign(lambda number: done.append(number) or small(number), COUNT, journal)
            return list(journal.pieces()), done
    except UsageError as error:
        line = str(error)
    assert "\n" not in line
    return line, done


WHOLE = [small(number) for number in range(COUNT)]


def test_any_flipped_byte_costs_a_piece_at_most(path):
    whole = recorded(path)
    beginning = whole.index(MARK)
    for place in range(len(whole)):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << place % 8
        path.write_bytes(damaged)
        found, done = resumed(path)
        if place < beginning:
            assert "expected the record of an unfinished run" in found, place
            assert path.read_bytes() == damaged
        else:
            assert (found, len(done)) == (WHOLE, 1), place
            assert resumed(path) == (WHOLE, [])


def test_cut_off_anywhere_the_rest_is_done_again(path):
    whole = recorded(path)
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        found, done = resumed(path)
        assert found == WHOLE, length
        assert done == list(range(COUNT - len(done), COUNT))
        assert path.read_bytes() == whole


def test_bytes_put_in_or_taken_out_anywhere(path):
    whole, generator = recorded(path), np.random.default_rng(0)
    for place in generator.integers(whole.index(MARK), len(whole), 60):
        for damaged in (
            whole[:place] + generator.bytes(7) + whole[place:],
            whole[:place] + MARK + whole[place:],
            whole[:place] + whole[place + 5 :],
        ):
            path.write_bytes(damaged)
            assert resumed(path)[0] == WHOLE


def test_pieces_of_another_number_or_campaign_are_not_taken(path):
    whole = recorded(path)
    _, second, third = whole.split(MARK)[1:]
    record = bytearray(second)
    record[0] = 0  # the piece 1 as the piece 0, with the check of its head made to match
    number, length, checksum, _ = HEAD.unpack(record[: HEAD.size])
    check = zlib.crc32(HEAD.pack(number, length, checksum, 0))
    forged = HEAD.pack(number, length, checksum, check) + second[HEAD.size :]
    path.write_bytes(whole[: whole.index(MARK)] + MARK + forged + MARK + third)
    assert resumed(path) == (WHOLE, [0, 1])
    with journal_at(path.with_name("other"), HEADER | {"seed": "1"}) as journal:
        run_campaign(lambda number: b"wrong", COUNT, journal)
    other = path.with_name("other").read_bytes()
    path.write_bytes(whole[: whole.index(MARK)] + other[other.index(MARK) :])
    assert resumed(path) == (WHOLE, [0, 1, 2])


def test_claims_of_endless_pieces_take_no_time(path):
    """Thirty thousand heads, each of which claims the rest of the file."""
    whole = recorded(path)
    head = HEAD.pack(0, 1 << 60, bytes(32), zlib.crc32(HEAD.pack(0, 1 << 60, bytes(32), 0)))
    path.write_bytes(whole[: whole.index(MARK)] + (MARK + head) * 30_000)
    assert resumed(path) == (WHOLE, [0, 1, 2])
    path.write_bytes(whole[: whole.index(MARK)] + MARK * 150_000)
    assert resumed(path) == (WHOLE, [0, 1, 2])


def former(path, *, mark=0x53484B44, statements=()):
    """A journal as version 0.1 kept it: a database."""
    with sqlite3.connect(path) as connection:
        connection.execute(f"PRAGMA application_id = {mark}")
        for statement in statements:
            connection.execute(statement)
    connection.close()
    return path.read_bytes()


ENDLESS = (
    "CREATE VIEW pieces AS WITH RECURSIVE r(n) AS (SELECT 0 UNION ALL SELECT n + 1 FROM r) SELECT n FROM r"
)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda path: former(path, statements=["CREATE TABLE header (key, value)", ENDLESS]), "another version"),
        (lambda path: former(path, mark=7, statements=["CREATE TABLE theirs (a)"]), "found another file"),
        (lambda path: path.write_bytes(FORMAT.replace(b"2", b"3") + b"whatever"), "another version"),
        (lambda path: path.write_bytes(b"\x00" * 5000), "found another file"),
        (lambda path: path.write_bytes(npy(np.ones(3))), "found another file"),
        (lambda path: path.write_bytes(FORMAT + b"\n\n"), "found a damaged one"),
        (lambda path: path.mkdir(), "found a directory"),
        (os.mkfifo, "found a pipe"),
    ],
)  # fmt: skip
def test_other_files_are_refused_and_left_alone(path, make, said):
    make(path)
    before = path.read_bytes() if path.is_file() else None
    line, _ = resumed(path)
    assert said in line
    assert (path.read_bytes() if path.is_file() else None) == before


@pytest.mark.parametrize("text", ["[]", "1", "{", "[" * 5000, json.dumps(HEADER)])
def test_a_beginning_that_says_nothing_is_a_damaged_one(path, text):
    path.write_bytes(
        FORMAT + hashlib.sha256(text.encode()).hexdigest().encode() + b"\n" + text.encode() + b"\n"
    )
    assert "found a damaged one; remove that file to begin again" in resumed(path)[0]


def archive(header, method=zipfile.ZIP_STORED):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as file:
        file.writestr("square.npy", with_header(header, bytes(80)))
    return buffer.getvalue()


def test_a_piece_that_cannot_be_is_done_again(path):
    """Its checksum is right, but it is no piece of this campaign: no arrays, other ones, endless ones."""

    def fits(number, piece):
        try:
            found = unpacked(piece)
        except ProblemError:
            return False
        return set(found) == {"square"} and found["square"].shape == (10,)

    wrong = [b"", b"PK", *map(archive, HEADERS), archive(HEADERS[0], zipfile.ZIP_DEFLATED)]
    wrong += [packed({"square": np.ones(9)}), packed({"cube": np.ones(10)}), npy(np.ones(10))]
    with journal_at(path, HEADER) as journal:
        for number, piece in enumerate(wrong):
            journal.add(number, piece)
        run_campaign(Squares(), len(wrong) - 1, journal, fits=fits)  # the last one is none of the campaign
        assert squares(journal).tolist() == [k**2 for k in range(10 * (len(wrong) - 1))]


def test_a_disk_that_fails_is_said_in_one_line(path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    with journal_at(path, HEADER) as journal:
        monkeypatch.setattr(os, "fsync", full)
        with pytest.raises(UsageError, match=r"cannot be written \(No space left on device\)"):
            journal.add(0, b"x")


def full_disk(path):
    with journal_at(path, HEADER) as journal:
        handle = os.open("/dev/full", os.O_RDWR)
        os.dup2(handle, journal._file.fileno())
        os.close(handle)
        journal.add(0, b"small")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device of Linux")
def test_a_full_disk_is_said_also_where_closing_the_file_fails_again(path):
    with pytest.raises(UsageError, match="journal: cannot be written"):
        full_disk(path)


def test_a_record_that_could_not_begin_is_none(path, monkeypatch):
    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(UsageError, match="journal: cannot be written"), journal_at(path, HEADER):
        pass
    assert not path.exists()


def test_where_files_cannot_be_mapped_or_cut_a_journal_is_read(path, monkeypatch):
    """As on some network and user-space file systems; here the last record is cut off."""
    path.write_bytes(recorded(path)[:-1])

    def refused(*_, **__):
        raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))

    class Uncut(io.BufferedRandom):
        truncate = refused

    monkeypatch.setattr(mmap, "mmap", refused)
    monkeypatch.setattr(os, "fdopen", lambda handle, mode: Uncut(io.FileIO(handle, mode.replace("b", ""))))
    assert resumed(path) == (WHOLE, [COUNT - 1])
    assert resumed(path) == (WHOLE, [])


def test_a_start_that_failed_is_no_unfinished_run(path, monkeypatch):
    def fails(*_):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    with monkeypatch.context() as patched:
        patched.setattr(Journal, "_find_records", fails)
        with pytest.raises(OSError, match="Input/output"), journal_at(path, HEADER):
            pass
    assert not path.exists()
    assert recorded(path) == path.read_bytes()


def test_what_ends_before_the_first_piece_leaves_no_record(path):
    def fails(number):
        raise UsageError("state: expected another one")

    with pytest.raises(UsageError, match="another one"), journal_at(path, HEADER) as journal:
        run_campaign(fails, COUNT, journal)
    assert not path.exists()
    with pytest.raises(UsageError, match="another one"), journal_at(path, HEADER) as journal:
        run_campaign(lambda number: small(number) if number < 2 else fails(number), COUNT, journal)
    assert path.exists()
    assert resumed(path) == (WHOLE, [2])
