"""Arrays as bytes: what a journal holds."""

import struct
from collections.abc import Mapping
from io import BytesIO
from typing import Any
from zipfile import ZIP_STORED, BadZipFile, ZipFile, ZipInfo

import numpy as np
from numpy.typing import NDArray

from shakedown.files.npy import read_array, read_header
from shakedown.ground.errors import ProblemError


def packed(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Arrays by name as the bytes of an NPZ archive.

    Examples
    --------
    >>> unpacked(packed({"slip": np.array([0.5, 0.25])}))["slip"]
    array([0.5 , 0.25])
    """
    buffer = BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def unpacked(piece: bytes, *keys: str) -> dict[str, NDArray[Any]]:
    """The arrays that :func:`packed` put together, all of them or some.

    Raises
    ------
    ProblemError
        If the bytes are none of its: another archive, one that claims more than it holds, …
    """
    try:
        with ZipFile(BytesIO(piece)) as archive:
            members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
            return {key: _array(archive, members[key]) for key in keys or members}
    except (BadZipFile, KeyError, EOFError, RuntimeError, ValueError, OverflowError, struct.error) as error:
        raise ProblemError(f"expected arrays, found damaged ones ({error})") from None


def _array(archive: ZipFile, info: ZipInfo) -> NDArray[Any]:
    if info.compress_type != ZIP_STORED:  # it may be endless
        raise ProblemError("expected arrays as they are, found compressed ones")
    with archive.open(info) as file:
        header = read_header(file)
    with archive.open(info) as file:
        return read_array(file, header, info.file_size)
