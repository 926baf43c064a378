"""All states of a map in one NPZ file, written and read a piece at a time."""

import json
import os
import zipfile
from collections.abc import Iterator, Mapping
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from shakedown.campaign.journal import Journal
from shakedown.campaign.payload import unpacked, unpacked_array
from shakedown.files.atomic_write import atomic_write

Columns = dict[str, NDArray[Any]]

LONG_AGO = (1980, 1, 1, 0, 0, 0)  # the time stamp of every member: equal maps are equal files


def write_map(path: str | os.PathLike[str], journal: Journal, rows: int, settings: Mapping[str, Any]) -> None:
    """Write the columns of all pieces, one after the other, so that memory holds one piece at a time.

    Parameters
    ----------
    path
        Where to write, whole or not at all.
    journal
        The pieces; a column is all of them in order.
    rows
        Number of states in all.
    settings
        What the map is, as the JSON text of the key ``settings``. ``load_factor`` is one
        number where all states have the same.
    """
    first = unpacked(next(journal.pieces()))
    single = settings["load_factors"] if len(settings["load_factors"]) == 1 else None
    with atomic_write(path) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        for key, sample in first.items():
            if key == "load_factor" and single:
                _write(archive, key, np.array(single[0]))
            else:
                pieces = (unpacked_array(piece, key) for piece in journal.pieces())
                _write_column(archive, key, (rows, *sample.shape[1:]), sample.dtype, pieces)
        _write(archive, "settings", np.array(json.dumps(settings, ensure_ascii=False)))


def _write(archive: zipfile.ZipFile, key: str, array: NDArray[Any]) -> None:
    _write_column(archive, key, array.shape, array.dtype, iter([array]))


def _write_column(
    archive: zipfile.ZipFile,
    key: str,
    shape: tuple[int, ...],
    dtype: np.dtype[Any],
    pieces: Iterator[NDArray[Any]],
) -> None:
    """One member of the archive, as ``numpy.save`` would write it."""
    info = zipfile.ZipInfo(f"{key}.npy", LONG_AGO)
    with archive.open(info, "w", force_zip64=True) as member:
        head = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_1_0(member, head)
        for piece in pieces:
            member.write(np.ascontiguousarray(piece, dtype=dtype).tobytes())


def mapped_columns(path: str | os.PathLike[str]) -> Columns:
    """The arrays of a file that :func:`write_map` wrote, on the disk until they are looked at."""
    columns: Columns = {}
    with open(path, "rb") as file, zipfile.ZipFile(file) as archive:
        for info in archive.infolist():
            file.seek(info.header_offset + 26)
            lengths = int.from_bytes(file.read(2), "little"), int.from_bytes(file.read(2), "little")
            file.seek(info.header_offset + 30 + sum(lengths))
            columns[info.filename.removesuffix(".npy")] = _mapped(file)
    return columns


def _mapped(file: IO[bytes]) -> NDArray[Any]:
    """The array that begins at this place of a file."""
    np.lib.format.read_magic(file)
    shape, _, dtype = np.lib.format.read_array_header_1_0(file)
    if not shape or 0 in shape:
        return (
            np.frombuffer(file.read(dtype.itemsize), dtype=dtype).reshape(shape)
            if not shape
            else np.empty(shape, dtype)
        )
    return np.memmap(file, dtype=dtype, mode="r", offset=file.tell(), shape=shape)


def finished_map(path: str | os.PathLike[str], settings: Mapping[str, Any]) -> Columns | None:
    """The columns of a file that holds the map with these settings; None of any other or none."""
    try:
        columns = mapped_columns(path)
        found = json.loads(str(columns["settings"]))
    except (OSError, ValueError, KeyError, zipfile.BadZipFile):
        return None
    return columns if found == json.loads(json.dumps(settings)) else None


def joined_columns(journal: Journal) -> Columns:
    """The columns of all pieces in memory."""
    pieces = [unpacked(piece) for piece in journal.pieces()]
    return {key: np.concatenate([piece[key] for piece in pieces]) for key in pieces[0]}
