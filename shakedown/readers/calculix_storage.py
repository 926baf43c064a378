"""CalculiX ``*FREQUENCY, SOLVER=MATRIXSTORAGE``: ``job.sti`` with its map ``job.dof``."""

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.errors import ProblemError
from shakedown.readers.row_map import Rows, read_row_map, row_map
from shakedown.readers.stiffness import Stiffness, check_entries_once, checked, completed
from shakedown.readers.text import integers, number, quoted, read_lines

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
    indices, values = [], []
    for k, line in enumerate(read_lines(path), start=1):
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
    table = np.array(indices, dtype=np.intp) - 1
    dofs = _rows(rows, int(table.max()) + 1, name)
    N = len(dofs)
    if table.min() < 0 or table.max() >= N:
        raise ProblemError(f"{name}: expected row and column numbers 1 to {N}, found {table.max() + 1}")
    half = sparse.coo_array((np.array(values), (table[:, 0], table[:, 1])), shape=(N, N))
    check_entries_once(table[:, 0], table[:, 1], name)
    return checked(completed(half), dofs, NUMBERED)


def _rows(rows: Rows, most: int, name: str) -> NDArray[np.intp]:
    """The map; one that names its rows may be longer than the largest row that has an entry."""
    if rows is None or isinstance(rows, np.ndarray):
        return row_map(rows, most, name, NUMBERED) if rows is None else rows
    return read_row_map(rows, most)
