"""Problem files: one array, and all of a problem, checked before they are read; the built-in ones."""

import io
import os
import warnings
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from functools import cache
from importlib import resources
from math import prod
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.files.atomic_write import atomic_write
from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import BLOCK, TIMES_A_FILE, FloatArray, memory
from shakedown.ground.errors import ProblemError, UsageError, found_in, wrong_key
from shakedown.ground.regular_file import open_regular
from shakedown.ground.shown_values import LONGEST_NAME, shortened
from shakedown.joint.fields import LOOP, NAMES, TEXTS, check_shapes, plain_text, real_numbers
from shakedown.joint.problem import AXES, Problem


class Header(NamedTuple):
    """The claims of a header: shape and type of the array, and the bytes of header and array."""

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    size: int


def read_header(file: IO[bytes]) -> Header:
    """The header of an NPY array at the start of ``file``; nothing of the array is read.

    Raises
    ------
    ProblemError
        If the bytes are not the header of an array of numbers or text.
    """
    stream = io.BytesIO(file.read(4096))  # bytes; headers of plain arrays have about 100
    readers = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    try:
        with warnings.catch_warnings(action="error"):  # where NumPy or Python doubts them, they are none
            shape, _, dtype = readers[np.lib.format.read_magic(stream)](stream)
        if min(shape, default=0) < 0:
            raise ValueError(f"the shape {shape}")
    except Exception as error:  # NumPy raises a dozen kinds of them where bytes are no header
        raise damaged(error) from None
    if dtype.hasobject:
        raise ProblemError("expected numbers, found Python objects (never unpickled)")
    return Header(shape, dtype, stream.tell() + prod(shape) * dtype.itemsize)


def read_array(file: IO[bytes], header: Header, found: int) -> NDArray[Any]:
    """The array at the start of ``file``, of which ``found`` bytes are there.

    Raises
    ------
    ProblemError
        If the bytes are more or fewer than the header claims, or damaged.
    """
    if header.size != found:
        raise ProblemError(
            f"the header claims shape {header.shape}, {header.size} bytes with it; the file holds {found}"
        )
    try:
        array = np.lib.format.read_array(file, allow_pickle=False)
        rest = file.read(1)  # reading to the end compares a compressed member's checksum
    except (ValueError, TypeError, OverflowError, EOFError, MemoryError) as error:
        raise damaged(error) from None
    if rest:
        raise ProblemError("expected the end of the array, found more bytes")
    return array


def damaged(error: Exception) -> ProblemError:
    """The message for bytes that are not an array."""
    reason = str(error) or type(error).__name__
    return ProblemError(f"expected an NPY array, found damaged data ({reason})")


SCHEMA = "shakedown/1"
KEYS = frozenset((*AXES, *TEXTS))
ASSUMED = 2**34  # bytes of memory where the system does not say


@checked
def load_problem(path: str | os.PathLike[str]) -> Problem:
    """Read a problem from an NPZ file (keys as the fields of :class:`Problem`).

    Parameters
    ----------
    path
        The file. Nothing in it is unpickled. Before any array is read, the headers of all
        are checked against each other and against the size of the file. All arrays together
        may take a quarter of the machine's memory at most, and 100 times the size of the file
        or 256 MiB, whichever is larger.

    Raises
    ------
    ProblemError
        If the file cannot be read, is not an NPZ archive of stored or deflated
        members, holds an unknown key or breaks a rule of :class:`Problem`; the
        message starts with the path.

    Examples
    --------
    >>> import tempfile, pathlib, shakedown
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "joint.npz"
    >>> save_problem(path, shakedown.example("two-node"))
    >>> load_problem(path) == shakedown.example("two-node")
    True
    """
    with found_in(path):
        return Problem(**_read_arrays(path))


@checked
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
    present = {d.name: getattr(problem, d.name) for d in fields(problem)}
    arrays = {key: value for key, value in present.items() if value is not None}
    for key, usual in (("source", ""), ("load_path", LOOP)):
        if arrays[key] == usual:  # left out for earlier versions
            del arrays[key]
    try:
        with atomic_write(path) as file:
            np.savez(file, schema=np.array(SCHEMA), **arrays)
    except UsageError as error:
        raise ProblemError(str(error)) from None


@checked
def load_initial_slip(path: str | os.PathLike[str]) -> FloatArray:
    """Read an initial slip, or any array of real numbers, from an NPY file.

    Parameters
    ----------
    path
        The file, read as carefully as a problem file.

    Returns
    -------
    (n,)
        The slip [length], in the shape that the file has.

    Raises
    ------
    ProblemError
        If the file is not an NPY file of real, finite numbers; the message starts
        with the path.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "slip.npy"
    >>> np.save(path, np.array([0.5, 0.25]))
    >>> load_initial_slip(path)
    array([0.5 , 0.25])
    """
    with found_in(path), open_regular(path, "an NPY file") as file:
        found, most = os.fstat(file.fileno()).st_size, int(memory(ASSUMED) / 4)
        if found > most:
            raise ProblemError(f"expected at most {most} bytes, found {found}")
        header = read_header(file)
        file.seek(0)
        return real_numbers("initial slip", read_array(file, header, found))


def _read_arrays(path: str | os.PathLike[str]) -> dict[str, Any]:
    with open_regular(path, "an NPZ file") as file:
        if (head := file.peek(4)) and head[:2] != b"PK":
            raise ProblemError(
                "expected an NPZ file, found another one (of a finite-element model, `shakedown-bounds "
                "import CONFIG.toml -o FILE.npz` makes one)"
            )
        try:
            with zipfile.ZipFile(file) as archive:
                members = _members(archive)
                headers = {key: _read_header(archive, key, info) for key, info in members.items()}
                _check_sizes(headers, os.fstat(file.fileno()).st_size)
                check_shapes({key: header.shape for key, header in headers.items() if key in AXES}, AXES)
                arrays = {}
                for key, info in members.items():
                    with _member(archive, key, info) as data:
                        arrays[key] = read_array(data, headers[key], info.file_size)
        except ProblemError:
            raise
        except OSError as error:
            raise ProblemError(f"cannot be read ({error.strerror or error})") from None
        except Exception as error:  # zipfile raises many kinds of them for damaged bytes
            raise ProblemError(f"expected an NPZ file, found a damaged or different one ({error})") from None
    if "schema" in arrays and (schema := plain_text("schema", arrays.pop("schema"))) != SCHEMA:
        raise wrong_key("schema", f"'{SCHEMA}'", f"'{shortened(schema)}'")
    return arrays


def _meant(key: str) -> str:
    """What an unknown key probably stands for, or which keys there are."""
    from difflib import get_close_matches  # where a key is wrong only

    if key == "directions":
        return ": it follows from the shape of B"
    near = ["f"] if key in ("mu", "friction") else get_close_matches(key, sorted(KEYS), 1)
    return f": did you mean '{near[0]}'?" if near else f"; expected keys are {', '.join(sorted(KEYS))}"


def _members(archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    """The members of an archive by key, each known, there once and of a plain kind."""
    listed = archive.infolist()
    members = {info.filename.removesuffix(".npy"): info for info in listed}
    for key in sorted(set(members) - KEYS - {"schema"}):
        raise ProblemError(f"unknown key '{shortened(key, 40)}'{_meant(key)}")
    if len(members) != len(listed):
        raise ProblemError("expected every key once, found one twice")
    for key, info in members.items():
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            found = f"compression type {info.compress_type}"
            raise wrong_key(key, "a stored or deflated member (numpy.savez)", found)
    return members


def _read_header(archive: zipfile.ZipFile, key: str, info: zipfile.ZipInfo) -> Header:
    with _member(archive, key, info) as file:
        header = read_header(file)
    longest = BLOCK if key in (*TEXTS, "schema") else LONGEST_NAME
    if key in (*TEXTS, *NAMES, "schema") and header.dtype.itemsize > 4 * longest:
        raise wrong_key(key, f"at most {longest} characters", "more")
    return header


def _check_sizes(headers: Mapping[str, Header], file_size: int) -> None:
    """Refuse arrays that are too large together, or implausibly large for the size of the file."""
    total = sum(header.size for header in headers.values())
    if total > memory(ASSUMED) / 4:
        raise ProblemError(f"its arrays, {total:.3g} bytes, are more than this machine can hold")
    harmless = 2**28  # bytes, whatever the file's size
    if total > max(harmless, TIMES_A_FILE * file_size):
        raise ProblemError(
            f"expected arrays of at most {TIMES_A_FILE} times the file's size, found {total:.3g} bytes in "
            f"{file_size} bytes"
        )


@contextmanager
def _member(archive: zipfile.ZipFile, key: str, info: zipfile.ZipInfo) -> Iterator[IO[bytes]]:
    """The bytes of a member; errors name its key."""
    with found_in(f"key '{key}'"):
        try:
            with archive.open(info) as file:
                yield file
        except (zipfile.BadZipFile, zlib.error, EOFError) as error:
            raise ProblemError(f"expected an NPY array, found damaged data ({error})") from None


@checked
@cache
def example(name: str) -> Problem:
    """A built-in problem by name, kept from call to call: nobody can change it.

    Raises
    ------
    UsageError
        If there is no problem of that name.

    Examples
    --------
    >>> example("two-node").n
    2
    """
    if name not in (known := example_names()):
        raise UsageError(f"no built-in problem '{name}'; there are {', '.join(known)}")
    with resources.as_file(resources.files("shakedown.files") / "data" / f"{name}.npz") as path:
        return load_problem(path)


def example_names() -> tuple[str, ...]:
    """Names of the built-in problems.

    Examples
    --------
    >>> "two-node" in example_names()
    True
    """
    return (
        # One node below its critical friction 2 (thesis, appendix A).
        "one-node",
        # One node above its critical friction: separation and stick in turn (A.6), cyclic slip (A.7).
        "one-node-separation",
        "one-node-cyclic",
        # The two-node system of thesis 5.3.1, and without coupling.
        "two-node",
        "uncoupled",
        # Cyclic slip below the first collapse: of one node, of two together.
        "three-node",
        "pair-cycle",
        # Two limit cycles, both stable: the initial state decides.
        "two-attractors",
        # The two-node system of thesis 6.4, whose state jumps.
        "jump",
        # Elastic block, plane strain, 9 or 33 contact nodes on a rigid plane, top face moved (CalculiX 2.20).
        "block-9",
        "block-33",
        # The receding contact of chapter III, 33 contact nodes; its outer nodes separate.
        "receding-block",
        # The slanted, cantilevered block of chapter V, nine contact nodes; λ_1 = 0 by lift-off.
        "cantilevered-block",
        # A hollow shaft pressed into a hub (Lamé), pulled oval to and fro; nine contact nodes.
        "press-fit",
        # A cylinder pressed onto a flat (Hertz), moved along it to and fro; thirteen nodes, the outer open.
        "cylinder-on-flat",
        # Two tangential directions, loaded out of phase in space: one, two, four nodes, an elastic block.
        "one-node-3d",
        "two-node-3d",
        "four-node-3d",
        "block-3x3",
        # A sector of a bolted flange, and the dovetail root of a blade after its spin; 24 pairs each.
        "bolted-flange",
        "blade-root",
        # The outer ring of a rolling bearing in a rigid housing: it creeps under eight balls; 64 nodes.
        "bearing-ring",
    )
