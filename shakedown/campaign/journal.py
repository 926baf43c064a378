"""What a campaign has done so far: one SQLite file, valid after a kill at any instant."""

import os
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from shakedown.errors import UsageError
from shakedown.visible_text import shortened

APPLICATION = 0x53484B44  # marks our files among SQLite's: "SHKD"


class Journal:
    """The pieces of work that are done, by number; each is on the disk before the next is added."""

    def __init__(self, connection: sqlite3.Connection, path: Path | None) -> None:
        self._connection = connection
        self._path = path

    def done(self) -> set[int]:
        """Numbers of the pieces that are there."""
        return {number for (number,) in self._connection.execute("SELECT number FROM pieces")}

    def add(self, number: int, piece: bytes) -> None:
        """Record a piece.

        Raises
        ------
        UsageError
            If the disk is full or fails.
        """
        try:
            self._connection.execute("INSERT OR REPLACE INTO pieces VALUES (?, ?)", (number, piece))
        except sqlite3.Error as error:
            raise UsageError(f"{self._path}: cannot be written ({error})") from None

    def pieces(self) -> Iterator[bytes]:
        """All pieces in order of their numbers, one in memory at a time."""
        for (piece,) in self._connection.execute("SELECT piece FROM pieces ORDER BY number"):
            yield piece

    def remove(self) -> None:
        """Close the journal and delete its file: what it held is no longer needed."""
        self._connection.close()
        if self._path is not None:
            self._path.unlink(missing_ok=True)


@contextmanager
def journal_at(
    path: str | os.PathLike[str] | None, header: Mapping[str, str], *, resume: bool = False
) -> Iterator[Journal]:
    """Open the journal of a campaign, new or to go on with.

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
        another header, is in use by another process, or cannot be read or written.

    Examples
    --------
    >>> with journal_at(None, {"seed": "0"}) as journal:
    ...     journal.add(1, b"second")
    ...     journal.add(0, b"first")
    ...     list(journal.pieces()), sorted(journal.done())
    ([b'first', b'second'], [0, 1])
    """
    file = None if path is None else Path(path)
    if file is not None and file.exists() and not resume:
        raise UsageError(f"{file}: an unfinished run is recorded there; resume it, or remove that file")
    try:
        connection = sqlite3.connect("" if file is None else file, isolation_level=None, timeout=0.5)
    except sqlite3.Error as error:
        raise UsageError(f"{file}: cannot be opened ({error})") from None
    try:
        _prepare(connection, file, dict(header))
        yield Journal(connection, file)
    finally:
        connection.close()


def _prepare(connection: sqlite3.Connection, file: Path | None, header: dict[str, str]) -> None:
    """Lock the journal for this process; lay it out where it is new, else compare its header."""
    try:
        connection.execute("PRAGMA locking_mode = EXCLUSIVE")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("BEGIN EXCLUSIVE")
        _check_kind(connection, file)
        connection.execute(f"PRAGMA application_id = {APPLICATION}")
        connection.execute("CREATE TABLE IF NOT EXISTS header (key TEXT PRIMARY KEY, value TEXT)")
        connection.execute("CREATE TABLE IF NOT EXISTS pieces (number INTEGER PRIMARY KEY, piece BLOB)")
        known = dict(connection.execute("SELECT key, value FROM header"))
        if not known:
            connection.executemany("INSERT INTO header VALUES (?, ?)", header.items())
        connection.execute("COMMIT")
    except sqlite3.OperationalError as error:
        reason = "another run is writing it" if "locked" in str(error) else error
        raise UsageError(f"{file}: cannot be resumed ({reason})") from None
    except sqlite3.DatabaseError:
        raise UsageError(f"{file}: expected the record of an unfinished run, found another file") from None
    for key in header if known else ():
        if known.get(key) != header[key]:
            found, asked = shortened(str(known.get(key)), 40), shortened(header[key], 40)
            raise UsageError(
                f"{file}: expected the same run to resume, found it recorded with {key} = {found}, "
                f"not {asked}"
            )


def _check_kind(connection: sqlite3.Connection, file: Path | None) -> None:
    """Refuse somebody else's database."""
    ((mark,),) = connection.execute("PRAGMA application_id")
    ((tables,),) = connection.execute("SELECT count(*) FROM sqlite_master")
    if tables and mark != APPLICATION:
        raise UsageError(f"{file}: expected the record of an unfinished run, found another database")
