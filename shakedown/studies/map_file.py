"""All states of a map in one NPZ file, written and read a piece at a time."""

import hashlib
import json
import os
import zipfile
from collections.abc import Iterator, Mapping
from math import prod
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from shakedown.campaign.pieces import Pieces
from shakedown.files.atomic_write import atomic_write
from shakedown.files.npy import read_header
from shakedown.ground.errors import ProblemError
from shakedown.ground.regular_file import open_regular
from shakedown.ground.size_limits import BLOCK

Columns = dict[str, NDArray[Any]]
Kinds = dict[str, tuple[np.dtype[Any], tuple[int, ...]]]

SEAL = b"sha256 of all that is before it: "  # comment of the archive, followed by the checksum
DIGITS = 2 * hashlib.sha256().digest_size  # of the checksum
LONG_AGO = (1980, 1, 1, 0, 0, 0)  # fixed time stamp of every member, so that equal maps are equal files


def write_map(
    path: str | os.PathLike[str], pieces: Pieces, count: int, kinds: Kinds, settings: Mapping[str, Any]
) -> None:
    """Write the columns of all pieces, one after the other, so that memory holds one piece at a time.

    Parameters
    ----------
    path
        Where to write, whole or not at all.
    pieces, count
        The pieces; a column is all of them in order.
    kinds
        Type and shape of each column.
    settings
        What the map is, as the JSON text of the key ``settings``. ``load_factor`` is one
        number where all states have the same, ``named`` the names of the first states at each load factor.
    """
    with atomic_write(path) as file:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
            for key, (dtype, shape) in kinds.items():
                column = (pieces.read(number, key)[key] for number in range(count))
                _write(archive, key, dtype, shape, column if shape else iter([settings["load_factors"][0]]))
            for key, value in (
                ("named", np.array(settings["named"])),
                ("settings", np.array(json.dumps(settings, ensure_ascii=False))),
            ):
                _write(archive, key, value.dtype, value.shape, iter([value]))
            archive.comment = SEAL + bytes(DIGITS)
        checksum = _checksum(file)
        file.seek(-DIGITS, os.SEEK_END)
        file.write(checksum)


def _write(
    archive: zipfile.ZipFile, key: str, dtype: np.dtype[Any], shape: tuple[int, ...], parts: Iterator[Any]
) -> None:
    """One member of the archive, as ``numpy.save`` would write it."""
    info = zipfile.ZipInfo(f"{key}.npy", LONG_AGO)
    with archive.open(info, "w", force_zip64=True) as member:
        head = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_1_0(member, head)
        for part in parts:
            member.write(np.ascontiguousarray(part, dtype=dtype).tobytes())


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
    """The arrays of a file that :func:`write_map` wrote, on the disk until they are looked at."""
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
    if not header.shape:
        file.seek(start)
        return np.lib.format.read_array(file, allow_pickle=False)
    content = start + header.size - prod(header.shape) * header.dtype.itemsize
    try:
        return np.memmap(file, dtype=header.dtype, mode="r", offset=content, shape=header.shape)
    except OSError:  # a file system that does not map files
        file.seek(content)
        return np.fromfile(file, header.dtype, prod(header.shape)).reshape(header.shape)


def kinds_of(columns: Columns) -> Kinds:
    """Type and shape of each column."""
    return {key: (column.dtype, column.shape) for key, column in columns.items()}


def finished_map(path: str | os.PathLike[str], settings: Mapping[str, Any], kinds: Kinds) -> Columns | None:
    """The columns of a file that holds the map with these settings, no byte altered; None of any other."""
    try:
        with open_regular(path) as file:
            whole = _checksum(file) == file.read(DIGITS)
        columns = mapped_columns(path) if whole else {}
        found = json.loads(str(columns.pop("settings")))
        del columns["named"]
    except (OSError, ValueError, KeyError, OverflowError, RecursionError, zipfile.BadZipFile):
        return None
    fits = found == json.loads(json.dumps(settings)) and kinds_of(columns) == kinds
    return columns if fits else None
