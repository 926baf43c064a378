"""CalculiX ``*FREQUENCY, SOLVER=MATRIXSTORAGE``: ``job.sti`` with its map ``job.dof``."""

import os
import re
from pathlib import Path

import numpy as np

from shakedown.models.readers.formats import Format
from shakedown.models.readers.row_map import Rows, read_row_map, row_map
from shakedown.models.readers.stiffness import Stiffness, checked, completed, numbered_entries
from shakedown.models.readers.text import REAL, read_lines

_LINE = re.compile(rf"^\s*\d+\s+\d+\s+{REAL}\s*$")
_HINT = " (of Abaqus' formats, write *MATRIX OUTPUT, FORMAT=MATRIX INPUT)"
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
    dofs = rows if isinstance(rows, np.ndarray) else np.zeros((0, 2), dtype=np.intp)

    def size(largest: int) -> int:
        """The rows of the map; one that names its rows may have more than the largest that has an entry."""
        nonlocal dofs
        if rows is None:
            dofs = row_map(rows, largest, name, NUMBERED)
        elif not isinstance(rows, np.ndarray):
            dofs = read_row_map(rows, largest)
        return len(dofs)

    entries = numbered_entries(enumerate(read_lines(path), start=1), size, name, _HINT)
    return checked(completed(entries), dofs, NUMBERED)


_TITLE, _READS = "Abaqus COORDINATE, CalculiX .sti", {"stiffness": read_calculix_storage}
FORMATS = (Format("numbered", _TITLE, lambda content: _LINE.match(content.first), _READS, ("rows",)),)
