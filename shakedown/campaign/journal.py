"""The journal of a campaign: one file, valid after a kill at any instant and after any damage.

The file begins with its format and with what the campaign is; then comes one record for each piece
of work, in the order in which they were done. Everything has its checksum, and that of a piece covers
its number and the campaign too: a record that does not match, or is cut off, is as good as not there,
and that piece is done again.
"""

import hashlib
import json
import mmap
import os
import struct
import tempfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, NamedTuple

from shakedown.files.atomic_write import check_target, created_part, is_at, locked, sync_folder
from shakedown.ground.errors import UsageError
from shakedown.ground.size_limits import READ_AT_ONCE
from shakedown.ground.visible_text import shortened

KIND = b"shakedown campaign, format "
FORMAT = KIND + b"2\n"
FORMER, FORMER_MARK = b"SQLite format 3\0", b"SHKD"  # how the databases of format 1 begin, and their mark
MARK = b"\x93piece\r\n"  # start of a record, to find the next one after a damaged one
NUMBER = struct.Struct("<Q")
HEAD = struct.Struct("<QQ32sI")  # number and length of a piece, its checksum, and a checksum of these three
HEAD_SIZE = len(MARK) + HEAD.size


class Place(NamedTuple):
    """The place of a piece in the file."""

    start: int
    length: int


class Journal:
    """The finished pieces of work, by number; each is on the disk before the next is added."""

    def __init__(self, file: IO[bytes], path: Path | None, header: bytes) -> None:
        """Continue after the last whole record of an open, locked file that begins with this header."""
        self._file = file
        self._path = path
        self._campaign = hashlib.sha256(header).digest()
        self._places: dict[int, Place] = {}
        self._begin = self._end = len(header)
        if path is not None:
            self._find_records()

    def done(self) -> set[int]:
        """The numbers of the pieces recorded."""
        return set(self._places)

    def add(self, number: int, piece: bytes) -> None:
        """Record a piece, in place of one of this number.

        Raises
        ------
        UsageError
            If the disk is full or fails.
        """
        claims = number, len(piece), self._checksum(number, piece)
        try:
            self._file.seek(self._end)
            self._file.write(MARK + HEAD.pack(*claims, _check_of(*claims)) + piece)
            self._file.flush()
            if self._path is not None:
                os.fsync(self._file.fileno())
        except OSError as error:
            raise UsageError(
                f"{self._path or 'the temporary record'}: cannot be written ({error.strerror or error})"
            ) from None
        self._places[number] = Place(self._end + HEAD_SIZE, len(piece))
        self._end += HEAD_SIZE + len(piece)

    def drop(self, number: int) -> None:
        """Drop a piece, which is to be done again."""
        del self._places[number]

    @property
    def waste(self) -> int:
        """Bytes of the file that no piece needs: of those that were dropped or replaced, or are damaged."""
        return self.size - sum(HEAD_SIZE + place.length for place in self._places.values())

    @property
    def size(self) -> int:
        """Bytes of the file behind what the campaign is."""
        return self._end - self._begin

    def compact(self) -> None:
        """Remove the waste: a new file replaces this one, unless it cannot be written."""
        if self._path is None:
            return
        temporary, handle = created_part(self._path, 0o666)
        fresh, places, end = os.fdopen(handle, "w+b"), {}, self._begin
        try:
            fresh.write(self._bytes(0, self._begin))
            for number, place in self._places.items():
                fresh.write(self._bytes(place.start - HEAD_SIZE, HEAD_SIZE + place.length))
                places[number] = Place(end + HEAD_SIZE, place.length)
                end += HEAD_SIZE + place.length
            fresh.flush()
            os.fsync(fresh.fileno())
            os.replace(temporary, self._path)
        except OSError:
            temporary.unlink(missing_ok=True)
            with suppress(OSError):
                fresh.close()
            return
        sync_folder(self._path.parent)
        self._file.close()
        self._file, self._places, self._end = fresh, places, end

    def _bytes(self, start: int, length: int) -> bytes:
        self._file.seek(start)
        return self._file.read(length)

    def piece(self, number: int) -> bytes:
        """One piece."""
        place = self._places[number]
        try:
            return self._bytes(place.start, place.length)
        except OSError as error:
            raise UsageError(f"{self._path}: cannot be read ({error.strerror or error})") from None

    def pieces(self) -> Iterator[bytes]:
        """All pieces in order of their numbers, one in memory at a time."""
        return (self.piece(number) for number in sorted(self._places))

    def remove(self) -> None:
        """Close the journal and delete its file: what it held is no longer needed."""
        if self._path is not None:
            self._path.unlink(missing_ok=True)
        self._file.close()

    def close(self) -> None:
        """Close the journal and keep its contents."""
        with suppress(OSError):  # a full disk has been reported already
            self._file.close()

    def _checksum(self, number: int, piece: bytes | memoryview) -> bytes:
        digest = hashlib.sha256(self._campaign + NUMBER.pack(number))
        digest.update(piece)
        return digest.digest()

    def _find_records(self) -> None:
        """Index the whole records, and cut off the rest after the last of them."""
        with self._content() as content, memoryview(content) as view:
            at = content.find(MARK, self._end)
            while at >= 0:
                start = at + HEAD_SIZE
                head = content[at + len(MARK) : start]
                *claims, check = HEAD.unpack(head) if len(head) == HEAD.size else (0, 0, b"", -1)
                number, length, checksum = claims
                if check != _check_of(*claims):
                    at = content.find(MARK, at + 1)
                    continue
                if self._checksum(number, view[start : start + length]) == checksum:
                    self._places[number] = Place(start, length)
                    self._end = start + length
                at = content.find(MARK, min(start + length, len(content)))
        with suppress(OSError):  # where files cannot be cut, the next records are written over the rest
            self._file.truncate(self._end)

    @contextmanager
    def _content(self) -> Iterator[mmap.mmap | bytes]:
        """All bytes of the file, mapped, or read where the file system does not map files."""
        try:
            content = mmap.mmap(self._file.fileno(), 0, access=mmap.ACCESS_READ)
        except OSError:
            self._file.seek(0)
            yield self._file.read()
            return
        with content:
            yield content


def _check_of(number: int, length: int, checksum: bytes) -> int:
    """The checksum of a record's head, so that its length can be trusted."""
    return zlib.crc32(HEAD.pack(number, length, checksum, 0))


@contextmanager
def journal_at(
    path: str | os.PathLike[str] | None, header: Mapping[str, str], *, resume: bool = False
) -> Iterator[Journal]:
    """Open the journal of a campaign, new or to go on with; an empty one is deleted on error.

    Parameters
    ----------
    path
        Its file; None for a temporary one that nobody can resume.
    header
        What the campaign is, by name: everything that its results depend on.
    resume
        Whether to go on with the journal that stands there, if one does.

    Raises
    ------
    UsageError
        If a journal stands there and is not to be resumed, was kept by a campaign with
        another header or by another version of the toolkit, is in use by another process, or
        cannot be read or written; or if another file stands there.

    Examples
    --------
    >>> with journal_at(None, {"seed": "0"}) as journal:
    ...     journal.add(1, b"second")
    ...     journal.add(0, b"first")
    ...     list(journal.pieces()), sorted(journal.done())
    ([b'first', b'second'], [0, 1])
    """
    beginning = _beginning(header)
    if path is None:
        with _closed_in_the_end(tempfile.TemporaryFile()) as file:
            yield Journal(file, None, beginning)
        return
    target = check_target(path)
    if target.exists() and not resume:
        raise UsageError(f"{path}: an unfinished run is recorded there; resume it, or remove that file")
    with _closed_in_the_end(_opened(target)) as file:
        found = file.read(len(beginning))
        if found != beginning:
            if not beginning.startswith(found):  # nor cut off before there was a record
                raise UsageError(f"{path}: {_difference(found + file.read(READ_AT_ONCE), header)}")
            _begin(file, target, beginning, new=not found)
        journal = None
        try:
            journal = Journal(file, target, beginning)
            yield journal
        except BaseException:
            # nothing to resume from, or a start that failed
            if not (journal.done() if journal else found):
                target.unlink(missing_ok=True)
            raise
        finally:
            if journal is not None:
                journal.close()


@contextmanager
def _closed_in_the_end(file: IO[bytes]) -> Iterator[IO[bytes]]:
    """The file; what a full disk did not take is tried again when it is closed, and has been said."""
    try:
        yield file
    finally:
        with suppress(OSError):
            file.close()


def _beginning(header: Mapping[str, str]) -> bytes:
    """What the journal of a campaign begins with: three lines."""
    text = json.dumps(dict(header), sort_keys=True).encode()
    return b"%s%s\n%s\n" % (FORMAT, hashlib.sha256(text).hexdigest().encode(), text)


def _begin(file: IO[bytes], target: Path, beginning: bytes, *, new: bool) -> None:
    """Write what the journal begins with; where that fails no new file stays, which is no record."""
    try:
        file.seek(0)
        file.write(beginning)
        file.flush()
        os.fsync(file.fileno())
    except OSError as error:
        if new:
            target.unlink(missing_ok=True)
        raise UsageError(f"{target}: cannot be written ({error.strerror or error})") from None
    sync_folder(target.parent)


def _opened(target: Path) -> IO[bytes]:
    """The file, new or not, that no other process writes."""
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
    try:
        while True:  # ends, as only a run that removes its journal at this moment makes it try again
            file = os.fdopen(os.open(target, flags, 0o666), "r+b")
            if not locked(file.fileno()):
                file.close()
                raise UsageError(f"{target}: cannot be resumed (another run is writing it)")
            if is_at(file.fileno(), target):
                return file
            file.close()
    except OSError as error:
        raise UsageError(f"{target}: cannot be opened ({error.strerror or error})") from None


def _difference(found: bytes, header: Mapping[str, str]) -> str:
    """What a file holds that does not begin as the journal of this campaign does."""
    former = found.startswith(FORMER) and found[68:72] == FORMER_MARK
    if former or (found.startswith(KIND) and not found.startswith(FORMAT)):
        return (
            "expected the record of an unfinished run of this version, found one of another version; "
            "remove that file to begin again"
        )
    if not found.startswith(FORMAT):
        return "expected the record of an unfinished run, found another file"
    known = _recorded(found[len(FORMAT) :])
    differing = [key for key in [*header, *known] if known.get(key) != header.get(key)]
    if not known or not differing:
        return (
            "expected the record of an unfinished run, found a damaged one; remove that file to begin again"
        )
    was, asked = (shortened(str(said.get(differing[0])), 40) for said in (known, header))
    return f"expected the same run to resume, found it recorded with {differing[0]} = {was}, not {asked}"


def _recorded(lines: bytes) -> dict[str, str]:
    """The description of a campaign in its journal; empty where that is damaged."""
    checksum, _, rest = lines.partition(b"\n")
    text = rest.partition(b"\n")[0]
    if hashlib.sha256(text).hexdigest().encode() != checksum:
        return {}
    try:
        known = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return known if isinstance(known, dict) else {}
