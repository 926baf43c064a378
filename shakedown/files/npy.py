"""NPY arrays, checked before they are read: the header, its claims, then the numbers."""

import io
import os
import re
from math import prod
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.regular_file import open_regular

LONGEST_HEADER = 4096  # bytes; those of plain arrays have about 100
# A header is a Python literal. Only one that looks like that of a plain array is passed to NumPy.
_DESCR = r"'descr' *: *'[<>|=]?[?biufcmMOSUV][0-9]{0,10}(?:\[[0-9a-zA-Z]*\])?'"
_ORDER = r"'fortran_order' *: *(?:True|False)"
_SHAPE = r"'shape' *: *\( *(?:(?:0|[1-9][0-9]{0,19}) *, *)*(?:(?:0|[1-9][0-9]{0,19}) *)?\)"
_ITEM = rf" *(?:{_DESCR}|{_ORDER}|{_SHAPE}) *"
_DICT = rf"\{{{_ITEM},{_ITEM},{_ITEM},? *\}} *\n?"
_HEADER = re.compile("|".join((_DICT, _DICT.replace("'", '"'))).encode())


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
    head = file.read(LONGEST_HEADER)
    stream = io.BytesIO(head)
    try:
        version = np.lib.format.read_magic(stream)
        start = {(1, 0): 10, (2, 0): 12}.get(version)
        if start is None:
            raise ValueError(f"NPY format version {version[0]}.{version[1]}")
        length = int.from_bytes(head[8:start], "little")
        if start + length > len(head):
            raise ValueError(f"a header of {length} bytes")
        if not _HEADER.fullmatch(head[start : start + length]):
            raise ValueError("a header that is not one of a plain array")
        read = np.lib.format.read_array_header_1_0 if start == 10 else np.lib.format.read_array_header_2_0
        shape, _, dtype = read(stream)
    except (ValueError, TypeError, OverflowError, SyntaxError) as error:
        raise damaged(error) from None
    if dtype.hasobject:
        raise ProblemError("expected numbers, found Python objects (never unpickled)")
    return Header(shape, dtype, start + length + prod(shape) * dtype.itemsize)


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


def load_array(path: str | os.PathLike[str], most_bytes: int) -> NDArray[Any]:
    """The array of an NPY file of at most ``most_bytes`` bytes; the message of an error lacks the path.

    Raises
    ------
    ProblemError
        If the file is none, is too large, or does not hold one array of numbers.
    """
    with open_regular(path, "an NPY file") as file:
        found = os.fstat(file.fileno()).st_size
        if found > most_bytes:
            raise ProblemError(f"expected at most {most_bytes} bytes, found {found}")
        header = read_header(file)
        file.seek(0)
        return read_array(file, header, found)


def damaged(error: Exception) -> ProblemError:
    """The message for bytes that are not an array."""
    reason = str(error) or type(error).__name__
    return ProblemError(f"expected an NPY array, found damaged data ({reason})")
