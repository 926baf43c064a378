"""Harwell–Boeing files, as Ansys' ``HBMAT`` and ``*EXPORT, …, HBMAT`` write them, with a map file."""

import os
import re

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.models.readers.formats import Format, begins
from shakedown.models.readers.row_map import Rows, row_map
from shakedown.models.readers.stiffness import Stiffness, check_entries_once, checked, completed
from shakedown.models.readers.text import integers, numbers, quoted, read_lines

_TYPE = re.compile(r"[RCP][SUHZR][AE](\s+\d+){3}(\s|$)", re.IGNORECASE)
_FORMAT = re.compile(r"\((?:\d+P,?)?(\d{0,3})[IEDFG](\d{1,3})(?:\.\d+)?(?:E\d+)?\)", re.IGNORECASE)


def is_harwell_boeing(text: str) -> bool:
    """Whether the third line begins with a matrix type like ``RSA``, followed by three numbers."""
    lines = text.splitlines()
    return len(lines) > 3 and _TYPE.match(lines[2].lstrip()) is not None


def read_harwell_boeing(path: str | os.PathLike[str], rows: Rows = None) -> Stiffness:
    """Read a real assembled matrix; one stored as a triangle is completed by symmetry.

    The reader is the project's own because SciPy's refuses symmetric matrices and right-hand sides. Ansys
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
    if not is_harwell_boeing("\n".join(lines[:4])):
        raise ProblemError(f"{name}: line 3: expected a Harwell-Boeing matrix type, found {quoted(lines[0])}")
    kind, *sizes = lines[2].split()
    N, columns, count = integers(sizes[:3], f"{name}: line 3")
    if kind.upper() not in ("RSA", "RUA") or columns != N or N < 1:
        raise ProblemError(
            f"{name}: line 3: expected a real assembled square matrix (RSA or RUA), found {kind} "
            f"{N} x {columns}"
        )
    lengths = integers([*lines[1].split(), "0"][1:5], f"{name}: line 2")
    layouts = [(int(n or 1), int(width)) for n, width in _FORMAT.findall(lines[3].replace(" ", ""))]
    if len(lengths) < 4 or len(layouts) < 3 or any(n * width < 1 for n, width in layouts):
        raise ProblemError(
            f"{name}: lines 2, 4: expected the lengths and Fortran formats, like (8I10), of three sections, "
            f"found {quoted(lines[1])} and {quoted(lines[3])}"
        )
    begins = np.cumsum([5 if lengths[3] > 0 else 4, *lengths[:2]])
    parts = zip(begins.tolist(), lengths, layouts, (N + 1, count, count), strict=False)
    sections = [_section(lines, *part, name) for part in parts]
    pointers, index = (found.astype(np.intp) - 1 for found in sections[:2])
    if pointers[0] != 0 or pointers[-1] != count or (np.diff(pointers) < 0).any():
        found = f"{pointers.min() + 1} to {pointers.max() + 1}"
        raise ProblemError(f"{name}: expected column pointers from 1 to {count + 1} in order, found {found}")
    if count and (index.min() < 0 or index.max() >= N):
        raise ProblemError(f"{name}: expected rows 1 to {N}, found {index.max() + 1}")
    column: NDArray[np.intp] = np.repeat(np.arange(N), np.diff(pointers))
    check_entries_once(index, column, name)
    matrix = sparse.coo_array((sections[2], (index, column)), shape=(N, N))
    whole = matrix if kind.upper() == "RUA" else completed(matrix)
    return checked(whole, row_map(rows, N, name, "Harwell-Boeing"), "Harwell-Boeing")


def _section(
    lines: list[str], at: int, length: int, layout: tuple[int, int], size: int, name: str
) -> FloatArray:
    """The numbers of one section, split at blanks, or sliced by its Fortran format where they touch."""
    if length < 0 or at + length > len(lines):
        raise ProblemError(
            f"{name}: expected {length} lines from line {at + 1} on, found the end of the file"
        )
    own, (repeat, width) = lines[at : at + length], layout
    fields = [field for line in own for field in line.split()]
    if len(fields) != size:  # numbers touch each other, or there is text beside them
        padded = (line.rstrip()[: repeat * width] for line in own)
        fields = [line[k : k + width] for line in padded for k in range(0, len(line), width)]
    if len(fields) != size:
        raise ProblemError(f"{name}: expected {size} numbers from line {at + 1} on, found {len(fields)}")
    return np.array(numbers(fields, f"{name}: from line {at + 1} on"))


_READS = {"stiffness": read_harwell_boeing}
FORMATS = (Format("harwell-boeing", "Harwell-Boeing", begins(is_harwell_boeing), _READS, ("rows",)),)
