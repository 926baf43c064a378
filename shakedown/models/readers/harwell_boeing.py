"""Harwell–Boeing files, as Ansys' ``HBMAT`` and ``*EXPORT, …, HBMAT`` write them, with a map file."""

import os
import re

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.row_map import Rows, row_map
from shakedown.models.readers.stiffness import Stiffness, check_entries_once, checked, completed
from shakedown.models.readers.text import integers, numbers, quoted, read_lines

_TYPE = re.compile(r"[RCP][SUHZR][AE]$", re.IGNORECASE)
_FORMAT = re.compile(
    r"\(?\s*(?:\d+P\s*,?\s*)?(\d{1,3})?\s*[IEDFG](\d{1,3})(?:\.\d+)?(?:E\d+)?\s*\)?$", re.IGNORECASE
)


def is_harwell_boeing(lines: list[str]) -> bool:
    """Whether the third line begins with a matrix type like ``RSA``, followed by three numbers."""
    if len(lines) < 4:
        return False
    fields = lines[2].split()
    return len(fields) >= 4 and bool(_TYPE.match(fields[0])) and all(f.isdigit() for f in fields[1:4])


def read_harwell_boeing(path: str | os.PathLike[str], rows: Rows = None) -> Stiffness:
    """Read a real assembled matrix; one stored as a triangle is completed by symmetry.

    The reader is the project's own because SciPy's leaves a symmetric matrix
    half, and splits the fixed fields at blanks, which may be missing. Ansys
    writes superelements as ``RSA`` and yet in full: both triangles are then
    taken as they are.

    Parameters
    ----------
    path
        The file; right-hand sides in it are passed over.
    rows
        The map, which the format does not hold (Ansys: the ``.mapping`` file).

    Raises
    ------
    ProblemError
        If the matrix is not real, square and assembled, a section is not of the
        length that the header says, or an index lies outside.
    """
    name, lines = os.fspath(path), read_lines(path)
    if not is_harwell_boeing(lines):
        raise ProblemError(f"{name}: line 3: expected a Harwell-Boeing matrix type, found {quoted(lines[0])}")
    kind, *sizes = lines[2].split()
    N, columns, count = integers(sizes[:3], f"{name}: line 3")
    if kind.upper() not in ("RSA", "RUA") or columns != N or N < 1:
        raise ProblemError(
            f"{name}: line 3: expected a real assembled square matrix (RSA or RUA), found {kind} "
            f"{N} x {columns}"
        )
    counts = integers([*lines[1].split(), "0"][:5], f"{name}: line 2")
    if len(counts) < 4:
        raise ProblemError(f"{name}: line 2: expected the lengths of four sections, found {quoted(lines[1])}")
    formats = re.findall(r"\([^()]*\)", lines[3])
    if len(formats) < 3:
        raise ProblemError(f"{name}: line 4: expected three Fortran formats, found {quoted(lines[3])}")
    at = 5 if len(counts) > 4 and counts[4] > 0 else 4
    sections = []
    for length, layout, size in zip(counts[1:4], formats, (N + 1, count, count), strict=False):
        sections.append(_section(lines, at, length, layout, size, name))
        at += length
    pointers, index = (np.array(integers(fields, name), dtype=np.intp) - 1 for fields in sections[:2])
    values = np.array(numbers(sections[2], name))
    if pointers[0] != 0 or pointers[-1] != count or (np.diff(pointers) < 0).any():
        down = np.flatnonzero(np.diff(pointers) < 0)
        found = f"{pointers[0] + 1} to {pointers[-1] + 1}"
        if down.size:
            found = f"{pointers[down[0] + 1] + 1} after {pointers[down[0]] + 1} at column {down[0] + 2}"
        raise ProblemError(f"{name}: expected column pointers from 1 to {count + 1} in order, found {found}")
    if count and (index.min() < 0 or index.max() >= N):
        raise ProblemError(f"{name}: expected rows 1 to {N}, found {index.max() + 1}")
    matrix = sparse.csc_array((values, index, pointers), shape=(N, N))
    if not matrix.has_canonical_format:
        check_entries_once(index, _columns(pointers), name)
    whole = matrix if kind.upper() == "RUA" else completed(matrix.tocoo())
    return checked(whole, row_map(rows, N, name, "Harwell-Boeing"), "Harwell-Boeing")


def _columns(pointers: NDArray[np.intp]) -> NDArray[np.intp]:
    return np.repeat(np.arange(len(pointers) - 1), np.diff(pointers))


def _section(lines: list[str], at: int, length: int, layout: str, size: int, name: str) -> list[str]:
    """The fields of one section, split at blanks, or sliced by its Fortran format where they touch."""
    match = _FORMAT.match(layout.replace(" ", ""))
    per_line, width = (int(match[1] or 1), int(match[2])) if match else (0, 0)
    if per_line < 1 or width < 1:
        raise ProblemError(f"{name}: line 4: expected a Fortran format like (8I10), found {quoted(layout)}")
    if length < 0 or at + length > len(lines):
        raise ProblemError(
            f"{name}: expected {length} lines from line {at + 1} on, found the end of the file"
        )
    fields = [field for line in lines[at : at + length] for field in line.split()]
    if len(fields) == size:
        return fields
    fields = []  # numbers touch each other, or there is text beside them
    for line in lines[at : at + length]:
        padded = line.rstrip()[: per_line * width]
        fields += [padded[k : k + width] for k in range(0, len(padded), width)]
    if len(fields) != size:
        raise ProblemError(f"{name}: expected {size} numbers from line {at + 1} on, found {len(fields)}")
    return fields
