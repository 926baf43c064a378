"""Which node and direction each row of a matrix belongs to, from the files that say it."""

import os

import numpy as np
from numpy.typing import NDArray

from shakedown.files.npy import read_array, read_header
from shakedown.ground.errors import ProblemError, found_in
from shakedown.models.readers.deck import is_deck, read_deck
from shakedown.models.readers.nastran_bulk import is_bulk_data, read_analysis_set
from shakedown.models.readers.text import (
    LARGEST_WHOLE,
    open_input,
    quoted,
    read_bytes,
    read_lines,
    whole_number,
)

Rows = str | os.PathLike[str] | NDArray[np.intp] | None  # a map file, its content, or none
DIRECTIONS = {"UX": 1, "UY": 2, "UZ": 3, "ROTX": 4, "ROTY": 5, "ROTZ": 6}
HEADINGS = {  # of the columns of such lists
    "matrix", "eqn", "eq", "equation", "row", "no", "number", "node", "label", "dof", "direction", "dir",
}  # fmt: skip
_COMMENT = "#%$!*"
_NPY = b"\x93NUMPY"


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
    name = os.fspath(path)
    if read_bytes(path, len(_NPY)) == _NPY:
        return _of_columns(_array(path, name), size, name)
    lines = read_lines(path)
    if is_bulk_data(lines):
        return read_analysis_set(path)
    if is_deck(lines):
        return _implied(read_deck(path).labels, size, name)
    if lines[0].lower().startswith("%%matrixmarket"):
        return _implied(_node_vector(lines, name), size, name)
    return _of_columns(_listed(lines, name), size, name)


def _array(path: str | os.PathLike[str], name: str) -> NDArray[np.float64]:
    """The numbers of an ``.npy`` file, one row per row of the matrix."""
    with open_input(path) as file, found_in(name):
        header = read_header(file)
        file.seek(0)
        found = read_array(file, header, os.fstat(file.fileno()).st_size)
    if found.dtype.kind not in "iuf" or found.ndim not in (1, 2) or not found.size:
        raise ProblemError(
            f"{name}: expected numbers (node, direction) of every row, found {found.dtype} of shape "
            f"{found.shape}"
        )
    return found.astype(float).reshape(len(found), -1)


def _listed(lines: list[str], name: str) -> NDArray[np.float64]:
    """Lines of one to three numbers each, of which the last may be the name of a direction.

    Blank lines, a line of headings (node, dof …) at the head, and lines that start with ``#``, ``%``,
    ``$``, ``!`` or ``*`` are skipped.
    """
    table: list[list[int]] = []
    for k, line in enumerate(lines, start=1):
        fields = line.replace(",", " ").split()
        if not fields or fields[0][0] in _COMMENT:
            continue
        if not table and HEADINGS.issuperset(word.lower() for word in fields):
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
    return np.array(table, dtype=float)


def _of_columns(table: NDArray[np.float64], size: int | None, name: str) -> NDArray[np.intp]:
    """The map of columns equation (where there are three), node, direction; or of the nodes alone."""
    if table.shape[1] > 3 or not (np.abs(table) < LARGEST_WHOLE).all() or (table != np.round(table)).any():
        raise ProblemError(f"{name}: expected whole numbers in one to three columns, found others")
    found = table.astype(np.intp)
    if found.shape[1] == 1:
        return _implied(found[:, 0], size, name)
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


def _node_vector(lines: list[str], name: str) -> NDArray[np.intp]:
    """The whole numbers of a Matrix Market array with one column."""
    size, *body = [line for line in lines if line.strip() and line[0] != "%"] or [""]
    found = np.array([whole_number(text, name) for line in body for text in line.split()], dtype=np.intp)
    expected = sorted(whole_number(text, name) for text in size.split())
    if lines[0].lower().split()[2:4] != ["array", "integer"] or expected != sorted((1, len(found))):
        raise ProblemError(
            f"{name}: expected a node vector ('array integer', one column): expected "
            f"{max(expected, default=0)} nodes, found {len(found)} below {quoted(lines[0])}"
        )
    return found


def _implied(nodes: NDArray[np.intp], size: int | None, name: str) -> NDArray[np.intp]:
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
