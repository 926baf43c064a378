"""Nastran OUTPUT4 files, text and binary, read by pyYeti (the extra ``nastran``)."""

import os
import re
import warnings
from typing import Any, Literal

import numpy as np
from scipy import sparse

from shakedown.ground.constants import TIMES_A_FILE, FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.models.readers.formats import Format, begins
from shakedown.models.readers.nastran_bulk import chosen_matrix, pyyeti_module
from shakedown.models.readers.row_map import Rows, row_map
from shakedown.models.readers.stiffness import Stiffness, checked
from shakedown.models.readers.text import UNREADABLE, quoted, read_bytes

_HEADER = re.compile(
    rb"^([ \d-]{8}|[ \d-]{16})([ \d-]{8}|[ \d-]{16})([ \d]{8})([ \d]{8})([A-Za-z_]\S{0,7}) *(\S*)\r?$",
    re.MULTILINE,
)
_HEADS = {24: 4, 48: 8}  # bytes of a binary header record: width of its integers
_REAL = (1, 2)  # types: single and double precision


def is_op4(text: str) -> bool:
    """Whether the first characters of a file, a byte each, are those of an OUTPUT4 file, binary or text."""
    raw = text.encode("latin-1")
    if b"\0" in raw[:4]:
        return bool({int.from_bytes(raw[:4], order) for order in ("little", "big")} & set(_HEADS))
    return _HEADER.match(raw) is not None


def read_nastran_op4(path: str | os.PathLike[str], rows: Rows = None, matrix: str | None = None) -> Stiffness:
    """Read one real square matrix of an OUTPUT4 file.

    Parameters
    ----------
    path
        The file.
    rows
        The map: the order of the analysis set is not in the file, but on the
        EXTRN or ASET cards of the punch file beside it.
    matrix
        Its name; by default the only one larger than 1 × 1 whose name begins
        with K, or the only one at all. ``"KXX(2)"`` is the second of a name that
        occurs several times, as of several superelements.

    Raises
    ------
    ProblemError
        If there is no such matrix, it is complex or not square, pyYeti is not
        installed, or the file is damaged.
    """
    name = os.fspath(path)
    values = _matrix(path, matrix)
    size, columns = values.shape
    if size != columns:
        raise ProblemError(f"{name}: expected a square matrix, found {size} x {columns}")
    table = row_map(rows, size, name, "Nastran OUTPUT4")
    return checked(sparse.csr_array(values), table, "Nastran OUTPUT4")


def read_op4_columns(path: str | os.PathLike[str], matrix: str) -> FloatArray:
    """One real matrix of an OUTPUT4 file as a dense array, for load vectors; see :func:`read_nastran_op4`."""
    found = _matrix(path, matrix)
    if 8 * found.shape[0] * found.shape[1] > _most(path):
        raise ProblemError(
            f"{os.fspath(path)}: expected at most {TIMES_A_FILE} times the size of the file in loads, found "
            f"a header that claims {found.shape[0]} x {found.shape[1]}"
        )
    return np.asarray(found.toarray() if sparse.issparse(found) else found, dtype=float)


def _most(path: str | os.PathLike[str]) -> int:
    """The largest size of a dense matrix of a file [bytes]."""
    return TIMES_A_FILE * max(os.stat(path).st_size, 1 << 16)


def _matrix(path: str | os.PathLike[str], matrix: str | None) -> Any:
    """The matrix of a name as pyYeti reads it; sparse where a header claims far more than the file holds."""
    name, raw = os.fspath(path), read_bytes(path)
    if not is_op4(raw[:256].decode("latin-1")):
        raise ProblemError(f"{name}: expected an OUTPUT4 file, found no header of one")
    large = 8 * _largest(raw, name) > _most(path)
    reader = pyyeti_module("op4", name).OP4()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            names, values, _, types = reader.load(name, into="list", sparse=large)
    except UNREADABLE as error:
        raise ProblemError(f"{name}: expected whole matrices, found {quoted(str(error))}") from None
    finally:
        reader._op4close()
    scalars = [k for k, own in enumerate(values) if own.shape == (1, 1)]
    k = chosen_matrix([own.upper() for own in names], matrix, name, scalars)
    if types[k] not in _REAL:
        raise ProblemError(f"{name}: expected {names[k]} to be real (type 1 or 2), found type {types[k]}")
    data = values[k].data if sparse.issparse(values[k]) else values[k]
    if not np.isfinite(data).all():
        found = data[~np.isfinite(data)][0]
        raise ProblemError(f"{name}: expected finite numbers in {names[k]}, found {found}")
    return values[k]


def _largest(raw: bytes, name: str) -> int:
    """The most numbers that a header claims; ``ProblemError`` if a binary record is not whole."""
    if b"\0" not in raw[:4]:
        sizes = (b"%b %b" % (found[1].strip(), found[2].strip()) for found in _HEADER.finditer(raw))
        whole = (size.split() for size in sizes if re.fullmatch(rb"-?\d+ -?\d+", size))
        return max((abs(int(columns) * int(rows)) for columns, rows in whole), default=0)
    order: Literal["little", "big"] = "little" if int.from_bytes(raw[:4], "little") in _HEADS else "big"
    width, at, claimed = _HEADS[int.from_bytes(raw[:4], order)], 0, 0
    while at < len(raw):  # a length, the content, the length again
        length = int.from_bytes(raw[at : at + 4], order)
        end = at + 4 + length
        if length < 3 * width or raw[end : end + 4] != raw[at : at + 4]:
            raise ProblemError(f"{name}: byte {at}: expected a whole record, found it cut off or damaged")
        if length == 6 * width:
            size = (int.from_bytes(raw[k : k + width], order, signed=True) for k in (at + 4, at + 4 + width))
            columns, rows = map(abs, size)
            claimed = max(claimed, columns * rows)
        at = end + 4
    return claimed


_READS = {"stiffness": read_nastran_op4}
FORMATS = (Format("op4", "Nastran OUTPUT4", begins(is_op4), _READS, ("rows", "matrix")),)
