"""Problem files: NPZ archives that are never unpickled and are written whole or not at all."""

import os
import tempfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import IO, Any

import numpy as np

from shakedown.errors import ProblemError
from shakedown.model.problem import SHAPES, TEXTS, Problem

SCHEMA = "shakedown/1"
KEYS = frozenset(SHAPES) | frozenset(TEXTS)


def load_problem(path: str | os.PathLike[str]) -> Problem:
    """Read a problem from an NPZ file (keys as the fields of :class:`Problem`).

    Parameters
    ----------
    path
        The file. Nothing in it is unpickled, and no array is read before its
        header has been checked against the size of the file.

    Raises
    ------
    ProblemError
        If the file cannot be read, is not an NPZ archive, holds an unknown key
        or breaks a rule of :class:`Problem`; the message starts with the path.

    Examples
    --------
    >>> import tempfile, pathlib, shakedown
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "joint.npz"
    >>> save_problem(path, shakedown.example("two-node"))
    >>> load_problem(path) == shakedown.example("two-node")
    True
    """
    try:
        return Problem(**_read_arrays(_path(path)))
    except ProblemError as error:
        raise ProblemError(f"{path}: {error}") from None


def save_problem(path: str | os.PathLike[str], problem: Problem) -> None:
    """Write a problem to an NPZ file; an existing file is replaced only by a complete one.

    Parameters
    ----------
    path
        Where to write; the name is used as it is, no suffix is added.
    problem
        What to write. The key ``schema`` = ``shakedown/1`` is added.

    Raises
    ------
    ProblemError
        If the file cannot be written.
    """
    target = _path(path)
    if not isinstance(problem, Problem):
        raise ProblemError(f"problem: expected a Problem, found {type(problem).__name__}")
    present = {d.name: getattr(problem, d.name) for d in fields(problem)}
    arrays = {key: value for key, value in present.items() if value is not None}
    try:
        with atomic_write(target) as file:
            np.savez(file, schema=np.array(SCHEMA), **arrays)
    except OSError as error:
        raise ProblemError(f"{os.fspath(path)}: cannot be written ({error.strerror})") from None


def _path(path: str | os.PathLike[str]) -> Path:
    if not isinstance(path, str | os.PathLike) or not os.fspath(path):
        raise ProblemError(f"expected the path of a file, found {path!r}")
    return Path(path)


@contextmanager
def atomic_write(path: Path) -> Iterator[IO[bytes]]:
    """Open a temporary file beside ``path`` that replaces it when the block ends without error."""
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            yield file
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _read_arrays(path: Path) -> dict[str, Any]:
    if path.is_dir():
        raise ProblemError("expected an NPZ file, found a directory")
    try:
        with zipfile.ZipFile(path) as archive:
            members = {_key(info): info for info in archive.infolist()}
            _check_keys(members, archive)
            return {key: _read_member(key, archive, info) for key, info in members.items() if key != "schema"}
    except FileNotFoundError:
        raise ProblemError("no such file") from None
    except (zipfile.BadZipFile, EOFError, NotImplementedError) as error:
        raise ProblemError(f"expected an NPZ file, found a damaged or different one ({error})") from None
    except OSError as error:
        raise ProblemError(f"cannot be read ({error.strerror or error})") from None


def _key(info: zipfile.ZipInfo) -> str:
    return info.filename.removesuffix(".npy")


def _check_keys(members: dict[str, zipfile.ZipInfo], archive: zipfile.ZipFile) -> None:
    if len(members) != len(archive.infolist()):
        raise ProblemError("expected every key once, found one twice")
    unknown = sorted(set(members) - KEYS - {"schema"})
    if unknown:
        names = ", ".join(f"'{key}'" for key in unknown)
        raise ProblemError(f"unknown key {names}; expected keys are {', '.join(sorted(KEYS))}")
    missing = [key for key in ("A", "B", "f", "q_w", "p_w") if key not in members]
    if missing:
        found = ", ".join(sorted(members)) or "an empty archive"
        raise ProblemError(f"missing key '{missing[0]}'; found {found}")
    if "schema" in members:
        schema = _read_member("schema", archive, members["schema"])
        if schema.dtype.kind != "U" or schema.ndim != 0 or str(schema) != SCHEMA:
            raise ProblemError(f"key 'schema': expected '{SCHEMA}', found '{schema}'")


def _read_member(key: str, archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> np.ndarray:
    """Read one array after its header has been found to agree with the size of the member."""
    if info.file_size > _memory() // 4:
        raise ProblemError(f"key '{key}': {info.file_size:.3g} bytes are more than this machine can hold")
    if info.flag_bits & 0x1:
        raise ProblemError(f"key '{key}': expected an open archive, found an encrypted member")
    try:
        with archive.open(info) as file:
            shape, dtype = _read_header(file)
            if dtype.hasobject:
                raise ProblemError(f"key '{key}': expected numbers, found Python objects (never unpickled)")
            claimed = int(np.prod([int(s) for s in shape], dtype=object)) * dtype.itemsize
            if claimed > info.file_size:
                raise ProblemError(
                    f"key '{key}': the header claims shape {shape}, {claimed} bytes; "
                    f"the file holds {info.file_size}"
                )
        with archive.open(info) as file:
            return np.lib.format.read_array(file, allow_pickle=False)
    except ProblemError:
        raise
    except (ValueError, SyntaxError, TypeError, EOFError, zipfile.BadZipFile, zipfile.zlib.error) as error:  # type: ignore[attr-defined]
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ProblemError(f"key '{key}': expected an NPY array, found damaged data ({reason})") from None


def _read_header(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype]:
    version = np.lib.format.read_magic(file)
    if version == (1, 0):
        shape, _, dtype = np.lib.format.read_array_header_1_0(file)
    elif version == (2, 0):
        shape, _, dtype = np.lib.format.read_array_header_2_0(file)
    else:
        raise ValueError(f"NPY format version {version}")
    if any(s < 0 for s in shape):
        raise ValueError(f"negative size in shape {shape}")
    return shape, dtype


def _memory() -> int:
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):  # not POSIX
        return 1 << 34
