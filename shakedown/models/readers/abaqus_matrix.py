"""Abaqus ``*MATRIX OUTPUT, FORMAT=MATRIX INPUT``: labelled entries, and nodal loads."""

import os
import re
from collections.abc import Iterator

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.formats import Format, has
from shakedown.models.readers.stiffness import Stiffness, from_entries
from shakedown.models.readers.text import (
    REAL,
    integers,
    number,
    quoted,
    read_lines,
    rows_of_numbers,
    whole_numbers,
)

NodalLoads = dict[tuple[int, int], float]
ABAQUS_MATRIX = "Abaqus matrix input"
_LINE = re.compile(rf"^\s*-?\d+\s*,\s*\d+\s*,\s*-?\d+\s*,\s*\d+\s*,\s*{REAL}\s*,?\s*$")


def read_abaqus_matrix(path: str | os.PathLike[str]) -> Stiffness:
    """Read ``node,dof, node,dof, value`` lines: either triangle, or both.

    Negative labels are internal nodes of Abaqus; they stay, to be condensed with
    the interior. 1e36 on the diagonal marks constrained rows; it stays too.

    Raises
    ------
    ProblemError
        If a line is malformed or an entry occurs twice.
    """
    name = os.fspath(path)
    lines = [(k, text.rstrip(",")) for k, text in _data_lines(path)]
    expected = "'node,dof, node,dof, value' (*MATRIX OUTPUT, FORMAT=MATRIX INPUT)"
    places, table = rows_of_numbers(lines, 5, name, expected)
    if not places:
        raise ProblemError(f"{name}: expected matrix entries, found none")
    keys = whole_numbers(table[:, :4], places, name)
    return from_entries(keys[:, :2], keys[:, 2:], table[:, 4], name, ABAQUS_MATRIX)


def read_nodal_loads(path: str | os.PathLike[str]) -> NodalLoads:
    """Read ``node, dof, value`` lines (Abaqus ``*CLOAD``): {(node, direction): force}.

    Raises
    ------
    ProblemError
        If a line is malformed or a degree of freedom occurs twice.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "job_LOAD1.mtx"
    >>> _ = path.write_text("** Assembled nodal loads\\n*CLOAD, REAL\\n12,2, -5.0e+01\\n")
    >>> read_nodal_loads(path)
    {(12, 2): -50.0}
    """
    loads: NodalLoads = {}
    for k, text in _data_lines(path):
        where, fields = f"{os.fspath(path)}: line {k}", text.rstrip(",").split(",")
        if len(fields) != 3:
            raise ProblemError(f"{where}: expected 'node, dof, value', found {quoted(text)}")
        if fields[0].strip()[:1].isalpha():
            raise ProblemError(
                f"{where}: expected a node label, found the set {quoted(fields[0])} (list sets in the "
                "configuration: forces = [[set, direction, value]])"
            )
        node, direction = integers(fields[:2], where)
        if (node, direction) in loads:
            raise ProblemError(f"{where}: expected every (node, dof) once, found ({node}, {direction}) twice")
        loads[node, direction] = number(fields[2], where)
    return loads


def _data_lines(path: str | os.PathLike[str]) -> Iterator[tuple[int, str]]:
    """Number and text of every line that is neither a keyword nor a remark."""
    for k, line in enumerate(read_lines(path), start=1):
        text = line.strip()
        if text and not text.startswith("*"):
            yield k, text


FORMATS = (Format("abaqus-matrix", "Abaqus MATRIX INPUT", has(_LINE), {"stiffness": read_abaqus_matrix}),)
