"""Many pieces of work: here, on processes or on an executor, each kept in a file as soon as it is done."""

import json
import logging
import os
import re
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import ExitStack, contextmanager, suppress
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol
from zipfile import ZIP_STORED, ZipFile, ZipInfo

import numpy as np
from numpy.typing import NDArray

from shakedown.campaign.executors import finished, processes_asked
from shakedown.files.atomic_write import PART, locked, pieces_beside
from shakedown.files.npy import read_array, read_header
from shakedown.ground.errors import ProblemError, ShakedownError, UsageError
from shakedown.ground.regular_file import open_regular
from shakedown.ground.size_limits import BLOCK
from shakedown.ground.visible_text import visible
from shakedown.joint.problem import Problem

Arrays = dict[str, NDArray[Any]]
Progress = Callable[[int, int], None]

TEXT_BYTES = 4 * BLOCK  # the largest size of a piece that is a text
NAME = re.compile(r"[0-9a-f]{16}-[0-9]+\.npz")  # of a piece: what its run is, and its number


class Task(Protocol):
    """A picklable function from the number of a piece to its arrays: the same ones whenever and wherever."""

    def __call__(self, number: int) -> Arrays:
        """The arrays of a piece."""

    @property
    def most_bytes(self) -> int:
        """The largest size of the file of a piece [bytes]."""

    def told(self, number: int, arrays: Arrays) -> Any:
        """What the arrays of a piece tell; nothing, or an error, where they cannot be those of this piece."""

    def settings(self) -> object:
        """Everything that the arrays depend on, but for the version: what it looks like tells runs apart."""


class Pieces:
    """The pieces that are done, by number: in memory, or in the files of a folder."""

    def __init__(self, work: Task, folder: Path | None) -> None:
        self._work, self.folder, self._here = work, folder, dict[int, Arrays]()
        settings = None if folder is None else (version("shakedown-bounds"), work.settings())
        self.run = sha256(repr(settings).encode()).hexdigest()[:16]

    def keep(self, number: int, arrays: Arrays) -> None:
        """Keep a piece; its file is there whole or not at all, but after a crash of the system."""
        if self.folder is None or "text" in arrays:  # a short one
            self._here[number] = arrays
        if self.folder is None:
            return
        unfinished = self.folder / f".{number}{PART}"
        try:
            unfinished.unlink(missing_ok=True)
            with open(unfinished, "xb") as file:
                np.savez(file, allow_pickle=False, **arrays)
            os.replace(unfinished, self._path(number))
        except OSError as error:
            raise _unwritable(self.folder, error) from None

    def read(self, number: int, *keys: str) -> Arrays:
        """The arrays of a piece, all of them or some."""
        if number in self._here:
            return self._here[number]
        return read_arrays(self._path(number), self._work.most_bytes, *keys)

    def told(self, number: int) -> Any:
        """What a piece tells."""
        return self._work.told(number, self.read(number))

    def kept(self, count: int) -> set[int]:
        """The numbers below ``count`` whose files are whole and fit; says how many, and where."""
        there = [] if self.folder is None else _names(self.folder)
        if not there:
            return set()
        found = {number for number in range(count) if self._fits(number)}
        others = f"; {n} others there do not fit" if (n := len(there) - len(found)) else ""
        where = visible(str(self.folder))
        logging.getLogger("shakedown").warning(
            f"goes on from {len(found)} of {count} pieces in {where}{others}"
        )
        return found

    def _fits(self, number: int) -> bool:
        try:
            return bool(self.told(number))
        except Exception:  # whatever damaged bytes, and texts that tell something else, raise
            return False

    def _path(self, number: int) -> Path:
        return Path(f"{self.folder}/{self.run}-{number}.npz")


@contextmanager
def run_pieces(
    work: Task,
    count: int,
    *,
    output: str | os.PathLike[str] | None = None,
    resume: bool = False,
    executor: Executor | None = None,
    workers: int | None = 1,
    progress: Progress | None = None,
) -> Iterator[Pieces]:
    """Do the pieces 0 … count − 1, and hand them over.

    Parameters
    ----------
    work
        What to do.
    count
        How many pieces there are.
    output
        The file that will be made of them: until the block ends well, they are files in ``OUTPUT.parts``.
    resume
        Whether to go on with those that an earlier run left there.
    executor
        Who works (any of ``concurrent.futures``); it is not shut down.
    workers
        Without one: the number of processes, None one for each core; 1 is this process.
    progress
        Called as ``progress(done, count)`` at the start and after each piece.

    Raises
    ------
    UsageError
        If an unfinished run is there and is not to be resumed, another run is writing it, a file cannot be
        written, or processes cannot begin to work.
    SolverError
        If a worker dies.
    """
    workers = processes_asked(workers if executor is None else 1)
    report = progress or (lambda done, count: None)
    with _folder(output, resume) as folder:
        pieces = Pieces(work, folder)
        done = pieces.kept(count)
        todo = [number for number in range(count) if number not in done]
        report(len(done), count)
        for place, (number, arrays) in enumerate(finished(work, todo, executor, workers), len(done) + 1):
            pieces.keep(number, arrays)
            report(place, count)
        yield pieces


@contextmanager
def _folder(output: str | os.PathLike[str] | None, resume: bool) -> Iterator[Path | None]:
    """The folder of the pieces, which no other run writes; it goes at a good end, or where it is empty."""
    if output is None:
        yield None
        return
    path = Path(pieces_beside(output))
    with ExitStack() as stack:
        try:
            if not resume and path.is_dir() and _names(path):
                raise UsageError(f"{path}: an unfinished run is kept there; resume it, or remove that folder")
            path.mkdir(exist_ok=True)
            if os.name == "posix":  # others open no folders
                handle = os.open(path, os.O_RDONLY)
                stack.callback(os.close, handle)
                if not locked(handle):
                    raise UsageError(f"{path}: another run is writing there")
        except OSError as error:
            raise _unwritable(path, error) from None
        try:
            yield path
            remove_pieces(path)
        finally:
            with suppress(OSError):
                path.rmdir()


def _unwritable(path: Path, error: OSError) -> UsageError:
    return UsageError(f"{path}: cannot be written ({error.strerror or error})")


def _names(folder: Path) -> list[str]:
    """The names of all pieces in a folder."""
    return [name for name in os.listdir(folder) if NAME.fullmatch(name)]


def remove_pieces(folder: Path) -> None:
    """Remove all pieces in a folder, and the folder where nothing else is in it."""
    with suppress(OSError):
        for name in (*_names(folder), *(path.name for path in folder.glob(f".*{PART}"))):
            (folder / name).unlink(missing_ok=True)
        folder.rmdir()


def read_arrays(path: Path, most_bytes: int, *keys: str) -> Arrays:
    """The arrays of an NPZ file of ``numpy.savez``, all or some; their size is known before memory is taken.

    Raises
    ------
    ProblemError
        If it is none, or too large.
    """
    try:
        with open_regular(path) as file:
            if (size := os.fstat(file.fileno()).st_size) > most_bytes:
                raise ProblemError(f"expected at most {most_bytes} bytes, found {size}")
            with ZipFile(file) as archive:
                members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
                stored = all(info.compress_type == ZIP_STORED for info in members.values())
                if not stored or sum(info.file_size for info in members.values()) > size:
                    raise ProblemError("expected arrays as they are, found compressed ones")
                return {key: _array(archive, members[key]) for key in keys or members}
    except Exception as error:  # whatever damaged bytes raise
        raise ProblemError(f"{path}: expected a piece of this run, found a damaged one ({error})") from None


def _array(archive: ZipFile, info: ZipInfo) -> NDArray[Any]:
    with archive.open(info) as head, archive.open(info) as member:
        return read_array(member, read_header(head), info.file_size)


def text_of(arrays: Arrays) -> Any:
    """What :func:`as_text` made a piece of; of other arrays raises ``ValueError``."""
    if set(arrays) != {"text"} or arrays["text"].dtype.kind != "U" or arrays["text"].shape:
        raise ValueError("expected one text")
    return json.loads(str(arrays["text"]))


def as_text(said: Any) -> Arrays:
    """A piece of what JSON can say, NaN and infinities too; floats come back to the last bit."""
    return {"text": np.array(json.dumps(said, default=int))}  # whole numbers of NumPy


def function_stamp(make: Callable[..., Problem], *first: object) -> str:
    """Its name, and the fingerprint of what it makes of its first arguments: it may have been changed.

    Examples
    --------
    >>> import shakedown
    >>> function_stamp(shakedown.example, "two-node")[:45]
    'shakedown.files.examples.example 3053854690ce'
    """
    try:
        made = make(*first)
        found = made.fingerprint if isinstance(made, Problem) else type(made).__name__
    except ShakedownError as error:  # no such joint is an answer, too
        found = str(error)
    return f"{getattr(make, '__module__', '')}.{getattr(make, '__qualname__', repr(make))} {found}"
