"""The only way in which files are written, and tables as CSV or Parquet."""

import csv
import io
import os
import re
import secrets
import stat
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO

from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import UsageError
from shakedown.ground.regular_file import kind_of
from shakedown.ground.shown_values import shortened, visible
from shakedown.joint.result import frame

try:
    import fcntl
except ImportError:  # not POSIX: no locks
    fcntl = None  # type: ignore[assignment]

PART = ".shakedown-part"  # suffix of an unfinished file


@checked
def check_target(path: str | os.PathLike[str]) -> Path:
    """The file that a path leads to, symbolic links followed, after a check that it can be written.

    Raises
    ------
    UsageError
        If the name is empty, its folder is missing or closed to us, or something
        stands there that is not a regular file or is read-only.
    """
    if not isinstance(os.fspath(path), str) or not os.fspath(path):
        raise UsageError(f"expected the path of a file to write, found {path!r}")
    try:
        os.stat(os.path.dirname(path) or ".")  # as it is spelt: realpath takes "none/.." for "."
        target = Path(os.path.realpath(path))
        old = _status(target)
        if old is not None and not stat.S_ISREG(old.st_mode):
            raise OSError(0, f"expected a regular file, found {kind_of(old.st_mode)}")
        if old is not None and not os.access(target, os.W_OK):
            raise OSError(0, "the file there is read-only")
        if not stat.S_ISDIR(os.stat(target.parent).st_mode):
            raise OSError(0, f"no folder {target.parent}")
        if not os.access(target.parent, os.W_OK | os.X_OK):
            raise OSError(0, f"no permission to write in the folder {target.parent}")
    except (OSError, ValueError) as error:
        raise _refusal(path, error) from None
    return target


@checked
def pieces_beside(path: str | os.PathLike[str]) -> str:
    """The folder for the pieces of what will be written to ``path``: ``.parts`` after it, links followed.

    Examples
    --------
    >>> pieces_beside("runs/map.npz")
    'runs/map.npz.parts'
    """
    return f"{os.path.realpath(path) if os.path.islink(path) else os.fspath(path)}.parts"


@contextmanager
def atomic_write(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open a file that takes its place at ``path`` when the block ends without error.

    Until then an older file stands there unchanged; afterwards the new one does,
    with the older one's mode. A kill at any moment leaves one or the other, and at
    most an unfinished file named ``.NAME.….shakedown-part`` beside it.

    Parameters
    ----------
    path
        Where to write. A symbolic link stays one: the file that it points to is replaced.

    Raises
    ------
    UsageError
        As for :func:`check_target`, or if the disk is full or fails.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "slip.txt"
    >>> with atomic_write(path) as file:
    ...     _ = file.write(b"0.5")
    >>> path.read_text()
    '0.5'
    """
    with atomic_write_together([path]) as (file,):
        yield file


@contextmanager
def atomic_write_together(paths: Sequence[str | os.PathLike[str]]) -> Iterator[list[BinaryIO]]:
    """Open several files that take their places one right after the other when the block ends.

    All of them are complete and on the disk before the first takes its place, so
    that only a kill between two renamings leaves a new file beside an old one. See
    :func:`atomic_write`.
    """
    with ExitStack() as stack:
        parts = [stack.enter_context(_part(path)) for path in paths]
        with refusing(" and ".join(os.fspath(path) for path in paths)):
            yield [file for _, _, file in parts]
            for _, _, file in parts:
                file.flush()
                os.fsync(file.fileno())
                file.close()
            for temporary, target, _ in parts:
                os.replace(temporary, target)


@contextmanager
def refusing(name: str) -> Iterator[None]:
    """Turn errors of the system into a ``UsageError`` that names the file."""
    try:
        yield
    except OSError as error:
        raise _refusal(name, error) from None


@contextmanager
def _part(path: str | os.PathLike[str]) -> Iterator[tuple[Path, Path, BinaryIO]]:
    """The path of an unfinished file, its target, the open file; it is gone afterwards in any case."""
    target = check_target(path)
    temporary = target.with_name(f".{target.name[:40]}.{secrets.token_hex(8)}{PART}")  # of 255 bytes at most
    flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
    with refusing(os.fspath(path)):
        old = _status(target)
        handle = os.open(temporary, flags, 0o666 if old is None else 0o600)  # less the umask
    file = os.fdopen(handle, "w+b")
    try:
        if old is not None:
            temporary.chmod(stat.S_IMODE(old.st_mode) & 0o777)
        yield temporary, target, file
    finally:
        with suppress(OSError):  # on a full disk closing tries to write again
            file.close()
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def locked(handle: int) -> bool:
    """Lock a file until it is closed, where there are locks; False where somebody else holds it."""
    try:
        if fcntl is not None:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # no locks on this file system
        pass
    return True


def _status(path: Path) -> os.stat_result | None:
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None


def _refusal(path: str | os.PathLike[str], error: Exception) -> UsageError:
    reason = error.strerror if isinstance(error, OSError) and error.strerror else error
    return UsageError(f"{os.fspath(path)}: cannot be written ({reason})")


Columns = Mapping[str, Sequence[Any]]


def write_csv(path: str | PathLike[str], columns: Columns) -> None:
    """One row per entry under the headings, in UTF-8; numbers with all their digits, undefined ones empty.

    A text, headings too, that a spreadsheet would run as a formula (it begins with = + - @ and is no number)
    has an apostrophe before it. Quotation marks are as in RFC 4180.
    """
    text = io.StringIO(newline="")
    table = csv.writer(text, lineterminator="\n")
    table.writerow(map(cell, columns))
    table.writerows([cell(entry) for entry in row] for row in zip(*columns.values(), strict=True))
    with atomic_write(path) as file:
        file.write(text.getvalue().encode())


def write_table(path: str | PathLike[str], columns: Columns) -> None:
    """Write the table: CSV, or Parquet where the name ends in .parquet; refuses as :func:`check_table`."""
    check_table(path)
    if str(path).lower().endswith("csv"):
        write_csv(path, columns)
        return
    buffer = io.BytesIO()
    frame(columns).to_parquet(buffer, index=False)
    with atomic_write(path) as file:
        file.write(buffer.getvalue())


@checked
def check_table(path: str | PathLike[str]) -> None:
    """Raise ``UsageError`` unless a .csv, or with pandas and pyarrow a .parquet, can be written there."""
    ending = str(path).rpartition(".")[2].lower()
    if ending not in ("csv", "parquet"):
        found = shortened(str(path))
        raise UsageError(f"table: expected a file name that ends in .csv or .parquet, found {found}")
    check_target(path)
    missing = [name for name in ("pandas", "pyarrow") if ending == "parquet" and not find_spec(name)]
    if missing:
        raise UsageError(f"{path}: expected the packages pandas and pyarrow, found no {missing[0]}; use .csv")


def cell(entry: float | str) -> str:
    r"""An entry as it is written, before quotation marks.

    Examples
    --------
    >>> cell(0.1), cell(float("nan")), cell("=1+1"), cell("-12"), cell("PART-1.7")
    ('0.1', '', "'=1+1", '-12', 'PART-1.7')
    """
    if isinstance(entry, float):
        return "" if entry != entry else repr(float(entry))
    text = visible(str(entry))
    formula = text.startswith(tuple("=+-@＝＋－＠"))  # as a spreadsheet takes it
    return f"'{text}" if formula and not re.fullmatch(r"[+-]?\d+(\.\d*)?([eE][+-]?\d+)?", text) else text
