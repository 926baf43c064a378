"""Atomic writing: files are written whole or not at all, and only over regular files."""

import errno
import hashlib
import os
import secrets
import stat
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, NamedTuple

from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import ProblemError, UsageError
from shakedown.ground.regular_file import kind_of, open_regular

try:
    import fcntl
except ImportError:  # not POSIX: no locks, so unfinished files are not swept
    fcntl = None  # type: ignore[assignment]

PART = ".shakedown-part"  # suffix of an unfinished file
_PARTS = ".*." + "[0-9a-f]" * 16 + PART
_STEM = 40  # characters of the target's name in that of its unfinished file, as names have at most 255 bytes
PIECES = ".parts"  # what the name of a file is followed by in that of the folder with its pieces
_TRIES = 16  # to make a file that no sweep finds between two system calls
_LONGEST = 255  # bytes of a name, where the file system does not tell


class _Part(NamedTuple):
    """An unfinished file: the caller's name for it, its path, its target, the open file."""

    name: str
    temporary: Path
    target: Path
    file: BinaryIO


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
            raise UsageError(
                f"{path}: cannot be written (expected a regular file, found {kind_of(old.st_mode)})"
            )
        if old is not None and not os.access(target, os.W_OK):
            raise UsageError(f"{path}: cannot be written (the file there is read-only)")
        if not stat.S_ISDIR(os.stat(target.parent).st_mode):
            raise NotADirectoryError(0, f"no folder {target.parent}")
        if not os.access(target.parent, os.W_OK | os.X_OK):
            raise PermissionError(0, f"no permission to write in the folder {target.parent}")
    except (OSError, ValueError) as error:
        if isinstance(error, UsageError):
            raise
        raise _refusal(path, error) from None
    return target


@checked
def pieces_beside(path: str | os.PathLike[str]) -> str:
    """The folder for the pieces of what will be written to ``path``: ``.parts`` after it, links followed.

    A name that becomes too long for its folder is cut short and told apart by a checksum.

    Examples
    --------
    >>> pieces_beside("runs/map.npz"), len(os.path.basename(pieces_beside("x" * 250)))
    ('runs/map.npz.parts', 255)
    """
    folder, name = os.path.split(os.path.realpath(path) if os.path.islink(path) else os.fspath(path))
    try:
        longest = os.pathconf(folder or ".", "PC_NAME_MAX")
    except (AttributeError, OSError, ValueError):  # no such question there, or no such folder
        longest = _LONGEST
    spelt, end = os.fsencode(name), PIECES
    if len(spelt) + len(end) > longest:
        end = f".{hashlib.sha256(spelt).hexdigest()[:16]}{end}"
        name = spelt[: longest - len(end)].decode(errors="ignore")  # without half a character
    return os.path.join(folder, name + end)


@contextmanager
def atomic_write(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open a file that takes its place at ``path`` when the block ends without error.

    Until then an older file stands there unchanged; afterwards the new one does,
    with the older one's mode. A kill at any moment leaves one or the other, and at
    most an unfinished file named ``.NAME.….shakedown-part`` beside it, which the
    next write into that folder sweeps away.

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
        with _refusing(" and ".join(part.name for part in parts)):
            yield [part.file for part in parts]
        for part in parts:
            with _refusing(part.name):
                part.file.flush()
                os.fsync(part.file.fileno())
        for part in parts:
            if fcntl is None:  # an open file cannot be renamed there
                part.file.close()
            with _refusing(part.name):
                os.replace(part.temporary, part.target)
        for folder in {part.target.parent for part in parts}:
            sync_folder(folder)


@contextmanager
def _refusing(name: str) -> Iterator[None]:
    """Turn errors of the system into a ``UsageError`` that names the file."""
    try:
        yield
    except OSError as error:
        raise _refusal(name, error) from None


@contextmanager
def _part(path: str | os.PathLike[str]) -> Iterator[_Part]:
    """An unfinished file beside its target, locked while we write, gone afterwards in any case."""
    target, name = check_target(path), os.fspath(path)
    if fcntl is not None:
        _sweep(target.parent)
    with _refusing(name):
        old = _status(target)
        temporary, handle = _created_part(target, 0o666 if old is None else 0o600)
    file = os.fdopen(handle, "w+b")
    try:
        if old is not None:
            temporary.chmod(stat.S_IMODE(old.st_mode) & 0o777)
        yield _Part(name, temporary, target, file)
    finally:
        with suppress(OSError):  # on a full disk closing tries to write again
            file.close()
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _created_part(target: Path, mode: int) -> tuple[Path, int]:
    """A new, locked file beside ``target``; the kernel applies the umask to its mode."""
    flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
    for left in reversed(range(_TRIES)):
        temporary = target.with_name(f".{target.name[:_STEM]}.{secrets.token_hex(8)}{PART}")
        handle = os.open(temporary, flags, mode)
        # where even a new file cannot be locked, no sweep locks it either
        if (locked(handle) or not left) and _is_at(handle, temporary):
            return temporary, handle
        os.close(handle)
        temporary.unlink(missing_ok=True)
    raise BlockingIOError(errno.EAGAIN, "new files are swept away as soon as they are made")


def _sweep(folder: Path) -> None:
    """Remove the unfinished files of killed writers, which nobody locks."""
    for path in folder.glob(_PARTS):
        with suppress(OSError, ProblemError), open_regular(path) as left:
            fcntl.flock(left, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_at(left.fileno(), path):
                path.unlink()


def locked(handle: int) -> bool:
    """Lock a file until it is closed, where there are locks; False where somebody else holds it."""
    try:
        if fcntl is not None:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # no locks on this file system, so nothing is swept
        pass
    return True


def _is_at(handle: int, path: Path) -> bool:
    """Whether an open file is still the one at that path."""
    try:
        return os.path.samestat(os.fstat(handle), os.stat(path))
    except FileNotFoundError:
        return False


def sync_folder(folder: Path) -> None:
    """Flush new names to the disk, where the system can."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _status(path: Path) -> os.stat_result | None:
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None


def _refusal(path: str | os.PathLike[str], error: Exception) -> UsageError:
    reason = error.strerror if isinstance(error, OSError) and error.strerror else error
    return UsageError(f"{os.fspath(path)}: cannot be written ({reason})")
