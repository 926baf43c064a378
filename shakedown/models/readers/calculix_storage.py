"""CalculiX ``*FREQUENCY, SOLVER=MATRIXSTORAGE``: ``job.sti`` with its map ``job.dof``."""

import os
import re
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.models.readers.formats import Format, register
from shakedown.models.readers.nastran_bulk import is_bulk_data
from shakedown.models.readers.row_map import Rows, read_row_map, row_map
from shakedown.models.readers.stiffness import Stiffness, check_entries_once, checked, completed
from shakedown.models.readers.text import REAL, integers, number, quoted, read_lines

_LINE = re.compile(rf"^\s*\d+\s+\d+\s+{REAL}\s*$")
NUMBERED = "numbered (CalculiX .sti, Abaqus COORDINATE)"


def read_calculix_storage(path: str | os.PathLike[str], rows: Rows = None) -> Stiffness:
    """Read ``i j value`` lines (one triangle or both, numbered from 1), with the map beside them.

    Abaqus' ``FORMAT=COORDINATE`` has the same layout and no map of its own.

    Parameters
    ----------
    path
        The ``.sti`` file.
    rows
        The map; by default the ``.dof`` file of the same name. For Abaqus, the
        ``.inp`` serves: the rows follow its nodes.

    Raises
    ------
    ProblemError
        If a line is malformed, an index lies outside the map, or there is no map.
    """
    name = os.fspath(path)
    beside = Path(path).with_suffix(".dof")
    rows = beside if rows is None and beside.exists() else rows
    lines = read_lines(path)
    entries = _at_once(lines)
    table, values = _one_by_one(lines, name) if entries is None else entries
    dofs = _rows(rows, max(int(table.max()) + 1, 1), name)
    N = len(dofs)
    _check_numbers(table, N, lines, name)
    half = sparse.coo_array((values, (table[:, 0], table[:, 1])), shape=(N, N))
    check_entries_once(table[:, 0], table[:, 1], name)
    return checked(completed(half), dofs, NUMBERED)


def _at_once(lines: list[str]) -> tuple[NDArray[np.intp], FloatArray] | None:
    """(row, column) from 0 and values; None where a line is not two whole numbers and a finite one."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # of whole numbers written as real ones, or no lines
            found = np.loadtxt(lines, dtype="i8,i8,f8", comments=None, ndmin=1)
    except (ValueError, Warning):
        return None
    values = np.ascontiguousarray(found["f2"])
    if not np.isfinite(values).all():
        return None
    return np.column_stack([found["f0"], found["f1"]]).astype(np.intp) - 1, values


def _one_by_one(lines: list[str], name: str) -> tuple[NDArray[np.intp], FloatArray]:
    """The same line by line, which says what is wrong where."""
    indices, values = [], []
    for k, line in enumerate(lines, start=1):
        fields = line.split()
        if not fields:
            continue
        where = f"{name}: line {k}"
        if len(fields) != 3:
            raise ProblemError(
                f"{where}: expected 'row column value', found {quoted(line)} (of Abaqus' formats, "
                "write *MATRIX OUTPUT, FORMAT=MATRIX INPUT)"
            )
        indices.append(integers(fields[:2], where))
        values.append(number(fields[2], where))
    return np.array(indices, dtype=np.intp) - 1, np.array(values)


def _check_numbers(table: NDArray[np.intp], most: int, lines: list[str], name: str) -> None:
    """Refuse the first line with a row or column that the map does not have."""
    wrong = (table < 0) | (table >= most)
    if wrong.any():
        entry = int(np.flatnonzero(wrong.any(axis=1))[0])
        line = [k for k, text in enumerate(lines, start=1) if text.strip()][entry]
        found = table[entry][wrong[entry]][0] + 1
        raise ProblemError(f"{name}: line {line}: expected row and column numbers 1 to {most}, found {found}")


def _rows(rows: Rows, most: int, name: str) -> NDArray[np.intp]:
    """The map; one that names its rows may be longer than the largest row that has an entry."""
    if rows is None or isinstance(rows, np.ndarray):
        return row_map(rows, most, name, NUMBERED) if rows is None else rows
    return read_row_map(rows, most)


register(
    Format(
        "numbered",
        "Abaqus COORDINATE, CalculiX .sti",
        read_calculix_storage,
        ("rows",),
        line=_LINE,
        unless=is_bulk_data,
    )
)
