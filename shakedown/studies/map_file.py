"""All states of a map in one NPZ file, written a piece at a time and read where it lies."""

import hashlib
import json
import os
import zipfile
from collections.abc import Iterable, Mapping
from math import prod
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from shakedown.files.atomic_write import atomic_write
from shakedown.files.npy import read_header
from shakedown.ground.errors import ProblemError
from shakedown.ground.regular_file import open_regular
from shakedown.ground.size_limits import BLOCK
from shakedown.studies.limit_cycles import Columns

SEAL = b"sha256 of all that is before it: "  # comment of the archive, followed by the checksum
DIGITS = 2 * hashlib.sha256().digest_size  # of the checksum
Kinds = dict[str, tuple[np.dtype[Any], tuple[int, ...]]]  # type and shape of columns
LONG_AGO = (1980, 1, 1, 0, 0, 0)  # fixed time stamp of every member, so that equal maps are equal files


def kinds_of(columns: Columns) -> Kinds:
    """Type and shape of each column."""
    return {key: (column.dtype, column.shape) for key, column in columns.items()}


def write_columns(
    path: str | os.PathLike[str], kinds: Kinds, parts: Mapping[str, Iterable[NDArray[Any]]]
) -> None:
    """Write an NPZ file of columns whose parts follow each other, so that memory holds one part at a time.

    Parameters
    ----------
    path
        Where to write, whole or not at all.
    kinds
        Type and shape of each column.
    parts
        Its rows.
    """
    with atomic_write(path) as file:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
            for key, (dtype, shape) in kinds.items():
                info = zipfile.ZipInfo(f"{key}.npy", LONG_AGO)
                head = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
                with archive.open(info, "w", force_zip64=True) as member:
                    np.lib.format.write_array_header_1_0(member, head)
                    for part in parts[key]:
                        member.write(np.ascontiguousarray(part, dtype=dtype).tobytes())
            archive.comment = SEAL + bytes(DIGITS)
        checksum = _checksum(file)
        file.seek(-DIGITS, os.SEEK_END)
        file.write(checksum)


def _checksum(file: BinaryIO) -> bytes:
    """SHA-256 of a file without its last digits, which are this checksum."""
    digest = hashlib.sha256()
    left = file.seek(0, os.SEEK_END) - DIGITS
    file.seek(0)
    while left > 0 and (block := file.read(min(left, BLOCK))):
        digest.update(block)
        left -= len(block)
    return digest.hexdigest().encode()


def mapped_columns(path: str | os.PathLike[str]) -> Columns:
    """The arrays of a file that :func:`write_columns` wrote, on the disk until they are looked at."""
    with open(path, "rb") as file, zipfile.ZipFile(file) as archive:
        return {info.filename.removesuffix(".npy"): _mapped(file, info) for info in archive.infolist()}


def _mapped(file: BinaryIO, info: zipfile.ZipInfo) -> NDArray[Any]:
    """The array of one member of an archive."""
    file.seek(info.header_offset + 26)
    lengths = int.from_bytes(file.read(2), "little"), int.from_bytes(file.read(2), "little")
    start = info.header_offset + 30 + sum(lengths)
    file.seek(start)
    header = read_header(file)
    if info.compress_type != zipfile.ZIP_STORED or header.size != info.file_size:
        raise ProblemError(f"key '{info.filename}': expected an array as it is, found another member")
    content = start + header.size - prod(header.shape) * header.dtype.itemsize
    try:
        return np.memmap(file, dtype=header.dtype, mode="r", offset=content, shape=header.shape)
    except OSError:  # a file system that does not map files
        file.seek(content)
        return np.fromfile(file, header.dtype, prod(header.shape)).reshape(header.shape)


def finished_map(path: str | os.PathLike[str], settings: Mapping[str, Any], kinds: Kinds) -> Columns | None:
    """The columns of a file that holds the map with these settings, no byte altered; None of any other."""
    try:
        with open_regular(path) as file:
            whole = _checksum(file) == file.read(DIGITS)
        columns = mapped_columns(path) if whole else {}
        fits = json.loads(str(columns["settings"])) == json.loads(json.dumps(settings))
    except (OSError, ValueError, KeyError, OverflowError, RecursionError, zipfile.BadZipFile):
        return None
    rest = {key: column for key, column in columns.items() if key in kinds}
    return columns if fits and kinds_of(rest) == kinds else None
