"""CalculiX ``*FREQUENCY, SOLVER=MATRIXSTORAGE``: ``job.sti`` with its map ``job.dof``."""

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.errors import ProblemError
from shakedown.readers.dof_map import read_dof_map
from shakedown.readers.stiffness import Stiffness, completed, with_map
from shakedown.readers.text import integers, number, read_lines


def read_calculix_storage(path: str | os.PathLike[str], dofs: NDArray[np.intp] | None = None) -> Stiffness:
    """Read ``i j value`` lines (one triangle, numbered from 1), with the map beside them.

    Abaqus' ``FORMAT=COORDINATE`` has the same layout and no map of its own.

    Parameters
    ----------
    path
        The ``.sti`` file.
    dofs : (N, 2), optional
        The map; by default that of the ``.dof`` file of the same name.

    Raises
    ------
    ProblemError
        If a line is malformed, an index lies outside the map, or there is no map.
    """
    name = os.fspath(path)
    beside = Path(path).with_suffix(".dof")
    if dofs is None and beside.exists():
        dofs = read_dof_map(beside)
    indices, values = [], []
    for k, line in enumerate(read_lines(path), start=1):
        fields = line.split()
        if not fields:
            continue
        where = f"{name}: line {k}"
        if len(fields) != 3:
            raise ProblemError(
                f"{where}: expected 'row column value', found '{line.strip()[:60]}' (of Abaqus' formats, "
                "write *MATRIX OUTPUT, FORMAT=MATRIX INPUT)"
            )
        indices.append(integers(fields[:2], where))
        values.append(number(fields[2], where))
    if dofs is None:
        raise ProblemError(
            f"{name}: expected a map file (one line 'node direction' per row, in matrix order; CalculiX "
            f"writes it as {beside.name}), found none"
        )
    table = np.array(indices, dtype=np.intp) - 1
    N = len(dofs)
    if table.min() < 0 or table.max() >= N:
        raise ProblemError(f"{name}: expected row and column numbers 1 to {N}, found {table.max() + 1}")
    half = sparse.coo_array((np.array(values), (table[:, 0], table[:, 1])), shape=(N, N))
    if len(np.unique(table[:, 0] * N + table[:, 1])) < len(table):
        raise ProblemError(f"{name}: expected every entry once, found one twice")
    return with_map(completed(half), dofs, name, "row column value")
