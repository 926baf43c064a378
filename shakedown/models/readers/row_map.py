"""Which node and direction each row of a matrix belongs to, from the files that say it."""

import os
import re

import numpy as np
from numpy.typing import NDArray

from shakedown.files.npz import read_array, read_header
from shakedown.ground.errors import ProblemError, found_in
from shakedown.models.readers.formats import Format, begins, format_of
from shakedown.models.readers.text import LARGEST_WHOLE, open_input, quoted, read_lines, whole_number

Rows = str | os.PathLike[str] | NDArray[np.intp] | None  # a map file, its content, or none
DIRECTIONS = {"UX": 1, "UY": 2, "UZ": 3, "ROTX": 4, "ROTY": 5, "ROTZ": 6}
_HEADING = re.compile("matrix|eqn?|equation|row|no|number|node|label|dof|dir(ection)?", re.IGNORECASE)
_COMMENT = "#%$!*"


def row_map(rows: Rows, size: int, where: str, format: str) -> NDArray[np.intp]:
    """Node and direction of each of ``size`` rows of a matrix that has no labels, (N, 2).

    Parameters
    ----------
    rows
        The map, or a file that holds it:

        - lines ``node direction`` (also ``node,direction`` and CalculiX's
          ``node.direction``), the direction as a number or as UX, UY, UZ, ROTX …;
        - lines ``equation node direction``, as Ansys' ``HBMAT`` writes them;
        - one node number per row or per node (also as a Matrix Market array, as
          Ansys exports its node vector): the directions are then 1, 2, … of each node;
        - any of these as an array of NumPy (``.npy``); directions and equations may count from 0;
        - an input deck of Abaqus or CalculiX: the nodes in its order, likewise;
        - Nastran bulk data with EXTRN, ASET, USET cards or the like.
    size
        Rows of the matrix.
    where, format
        The matrix file and what it is, for messages.

    Raises
    ------
    ProblemError
        If there is no map, it is malformed, or it is not one of ``size`` rows.
    """
    if rows is None:
        raise ProblemError(
            f"{where}: expected a map file (one line 'node direction' per row, in matrix order; Ansys' node "
            f"vector; the deck; Nastran's EXTRN or ASET cards) beside a {format} file, which has none of its "
            "own; found none"
        )
    table = rows if isinstance(rows, np.ndarray) else read_row_map(rows, size)
    if len(table) != size:
        raise ProblemError(f"{where}: expected a map of {size} lines, one per row, found {len(table)}")
    return table


def read_row_map(path: str | os.PathLike[str], size: int | None = None) -> NDArray[np.intp]:
    """Read a row map of any of the kinds that :func:`row_map` lists, (N, 2).

    Raises
    ------
    ProblemError
        If a line is malformed, or nodes without directions do not fit ``size`` rows.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "k.mapping"
    >>> _ = path.write_text("  Equation  Node  DOF\\n 1  7 UX\\n 2  7 UY\\n")
    >>> read_row_map(path).tolist()
    [[7, 1], [7, 2]]
    >>> _ = path.write_text("# node direction\\n7 1\\n7,2\\n9.1\\n")
    >>> read_row_map(path).tolist()
    [[7, 1], [7, 2], [9, 1]]
    >>> _ = path.write_text("7.0e+00 0.0e+00\\n7.0e+00 1.0e+00\\n")
    >>> read_row_map(path).tolist()
    [[7, 1], [7, 2]]
    """
    return format_of(path, "rows").reads["rows"](path, size)


def _array(path: str | os.PathLike[str], size: int | None) -> NDArray[np.intp]:
    """The map of the numbers of an ``.npy`` file."""
    name = os.fspath(path)
    with open_input(path) as file, found_in(name):
        header = read_header(file)
        file.seek(0)
        found = read_array(file, header, os.fstat(file.fileno()).st_size)
    if found.dtype.kind not in "iuf" or found.ndim not in (1, 2) or not found.size:
        raise ProblemError(
            f"{name}: expected numbers (node, direction) of every row, found {found.dtype} of shape "
            f"{found.shape}"
        )
    return _of_columns(found.astype(float).reshape(len(found), -1), size, name)


def _listed(path: str | os.PathLike[str], size: int | None) -> NDArray[np.intp]:
    """The map of lines of one to three numbers each, of which the last may be the name of a direction.

    Blank lines, a line of headings (node, dof …) at the head, and lines that start with ``#``, ``%``,
    ``$``, ``!`` or ``*`` are skipped.
    """
    name, table = os.fspath(path), list[list[int]]()
    for k, line in enumerate(read_lines(path), start=1):
        fields = line.replace(",", " ").split()
        if not fields or fields[0][0] in _COMMENT:
            continue
        if not table and all(map(_HEADING.fullmatch, fields)):
            continue
        if len(fields) == 1 and fields[0].replace(".", "").isdigit():
            fields = fields[0].split(".")  # 'node.direction'
        where = f"{name}: line {k}"
        if len(fields) > 3 or (table and len(fields) != len(table[0])):
            raise ProblemError(
                f"{where}: expected 'node direction' (or 'equation node direction'), found {quoted(line)}"
            )
        table.append([DIRECTIONS.get(text.upper()) or whole_number(text, where) for text in fields])
    if not table:
        raise ProblemError(f"{name}: expected a map of rows, found no line")
    return _of_columns(np.array(table, dtype=float), size, name)


def _of_columns(table: NDArray[np.float64], size: int | None, name: str) -> NDArray[np.intp]:
    """The map of columns equation (where there are three), node, direction; or of the nodes alone."""
    if table.shape[1] > 3 or not (np.abs(table) < LARGEST_WHOLE).all() or (table != np.round(table)).any():
        raise ProblemError(f"{name}: expected whole numbers in one to three columns, found others")
    found = table.astype(np.intp)
    if found.shape[1] == 1:
        return implied_rows(found[:, 0], size, name)
    if found.shape[1] == 3:
        first = int(found[:, 0].min() != 0)
        order = np.argsort(found[:, 0], kind="stable")
        wrong = np.flatnonzero(found[order, 0] != np.arange(first, first + len(found)))
        if wrong.size:
            raise ProblemError(
                f"{name}: expected equations 1 to {len(found)}, each once, found {found[order[wrong[0]], 0]} "
                f"in the place of {wrong[0] + 1}"
            )
        found = found[order, 1:]
    if np.isin(found[found[:, 1] == 0, 0], found[found[:, 1] > 0, 0]).any():  # no scalar points
        found[:, 1] += 1
    return found


def _node_vector(path: str | os.PathLike[str], size: int | None) -> NDArray[np.intp]:
    """The map of the whole numbers of a Matrix Market array with one column."""
    name, lines = os.fspath(path), read_lines(path)
    head, *body = [line for line in lines if line.strip() and line[0] != "%"] or [""]
    found = np.array([whole_number(text, name) for line in body for text in line.split()], dtype=np.intp)
    expected = sorted(whole_number(text, name) for text in head.split())
    if lines[0].lower().split()[2:4] != ["array", "integer"] or expected != sorted((1, len(found))):
        raise ProblemError(
            f"{name}: expected a node vector ('array integer', one column): expected "
            f"{max(expected, default=0)} nodes, found {len(found)} below {quoted(lines[0])}"
        )
    return implied_rows(found, size, name)


def implied_rows(nodes: NDArray[np.intp], size: int | None, name: str) -> NDArray[np.intp]:
    """Nodes without directions: each has the same number of rows, in the order x, y, z."""
    if size is None:
        raise ProblemError(f"{name}: expected rows 'node direction', found nodes without directions")
    _, place, counts = np.unique(nodes, return_inverse=True, return_counts=True)
    if counts.max() == 1:
        each, left = divmod(size, len(nodes))
        if left or not 1 <= each <= len(DIRECTIONS):
            raise ProblemError(
                f"{name}: expected nodes for {size} rows with equally many directions each, found "
                f"{len(nodes)} nodes (rows of constrained directions are missing from the matrix?); give a "
                "map with directions"
            )
        return np.column_stack([np.repeat(nodes, each), np.tile(np.arange(1, each + 1), len(nodes))])
    each = int(counts[0])
    if (counts != each).any() or len(nodes) != size or each > len(DIRECTIONS):
        raise ProblemError(
            f"{name}: expected every node equally often, {size} entries in all, found {counts.min()} to "
            f"{counts.max()} times, {len(nodes)} entries; give a map with directions"
        )
    directions = np.empty(size, dtype=np.intp)
    directions[np.argsort(place.ravel(), kind="stable")] = np.tile(np.arange(1, each + 1), len(counts))
    return np.column_stack([nodes, directions])


def is_matrix_market(text: str) -> bool:
    """Whether a text begins as Matrix Market does."""
    return text.lstrip().lower().startswith("%%matrixmarket")


FORMATS = (
    Format("npy", "an array of NumPy", begins(re.compile("\x93NUMPY").match), {"rows": _array}),
    Format("node vector", "Matrix Market", begins(is_matrix_market), {"rows": _node_vector}),
    Format("rows", "a list of rows", None, {"rows": _listed}),
)
