"""Which node and direction each row of a matrix belongs to, from the files that say it."""

import os

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.deck import is_deck, read_deck
from shakedown.models.readers.nastran_bulk import is_bulk_data, read_analysis_set
from shakedown.models.readers.text import integers, quoted, read_lines

Rows = str | os.PathLike[str] | NDArray[np.intp] | None  # a map file, its content, or none
DIRECTIONS = {"UX": 1, "UY": 2, "UZ": 3, "ROTX": 4, "ROTY": 5, "ROTZ": 6}
_COMMENT = "#%$!*"
HEADINGS = {  # of the columns of such lists
    "matrix", "eqn", "eq", "equation", "row", "no", "number", "node", "label", "dof", "direction", "dir",
}  # fmt: skip


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
    """
    lines, name = read_lines(path), os.fspath(path)
    if lines[0].lower().startswith("%%matrixmarket"):
        return _implied(_node_vector(lines, name), size, name)
    if is_bulk_data(lines):
        return read_analysis_set(path)
    if is_deck(lines):
        return _implied(read_deck(path).labels, size, name)
    return _listed(lines, size, name)


def _listed(lines: list[str], size: int | None, name: str) -> NDArray[np.intp]:
    """Lines ``node direction``, (N, 2).

    Blank lines, a line of headings (node, dof …) at the head, and lines that start with ``#``, ``%``,
    ``$``, ``!`` or ``*`` are skipped.
    """
    table: list[list[int]] = []
    width = 0
    for k, line in enumerate(lines, start=1):
        text = line.strip()
        if not text or text[0] in _COMMENT:
            continue
        where = f"{name}: line {k}"
        fields = text.replace(",", " ").replace(".", " ").replace("\t", " ").split()
        if not table and HEADINGS.issuperset(word.lower() for word in fields):
            continue
        width = width or len(fields)
        if len(fields) != width or not 1 <= width <= 3:
            raise ProblemError(
                f"{where}: expected 'node direction' (or 'equation node direction'), found {quoted(text)}"
            )
        last = DIRECTIONS.get(fields[-1].upper()) if width > 1 else None
        table.append(integers(fields if last is None else [*fields[:-1], str(last)], where))
    if not table:
        raise ProblemError(f"{name}: expected a map of rows, found no line")
    found = np.array(table, dtype=np.intp)
    if width == 1:
        if size is None:
            raise ProblemError(f"{name}: line 1: expected 'node direction', found nodes without directions")
        return _implied(found[:, 0], size, name)
    if width == 3:
        order = np.argsort(found[:, 0], kind="stable")
        wrong = np.flatnonzero(found[order, 0] != np.arange(1, len(found) + 1))
        if wrong.size:
            raise ProblemError(
                f"{name}: expected equations 1 to {len(found)}, each once, found {found[order[wrong[0]], 0]} "
                f"in the place of {wrong[0] + 1}"
            )
        found = found[order, 1:]
    return found


def _node_vector(lines: list[str], name: str) -> NDArray[np.intp]:
    """The whole numbers of a Matrix Market array with one column."""
    body = [(k, line) for k, line in enumerate(lines[1:], start=2) if line.strip() and line.strip()[0] != "%"]
    banner = lines[0].lower().split()
    size = integers(body[0][1].split(), f"{name}: line {body[0][0]}") if body else []
    if banner[2:4] != ["array", "integer"] or len(size) != 2 or 1 not in size:
        raise ProblemError(
            f"{name}: expected a node vector ('array integer', one column), found {quoted(lines[0])}"
        )
    values = [value for k, line in body[1:] for value in integers(line.split(), f"{name}: line {k}")]
    if len(values) != size[0] * size[1]:
        raise ProblemError(f"{name}: expected {size[0] * size[1]} nodes, found {len(values)}")
    return np.array(values, dtype=np.intp)


def _implied(nodes: NDArray[np.intp], size: int | None, name: str) -> NDArray[np.intp]:
    """Nodes without directions: each has the same number of rows, in the order x, y, z."""
    _, place, counts = np.unique(nodes, return_inverse=True, return_counts=True)
    if size is None:
        raise ProblemError(f"{name}: expected rows 'node direction', found nodes without directions")
    if counts.max() > 1:  # one entry per row
        each = int(counts[0])
        if (counts != each).any() or len(nodes) != size or each > len(DIRECTIONS):
            raise ProblemError(
                f"{name}: expected every node equally often, {size} entries in all, found {counts.min()} to "
                f"{counts.max()} times, {len(nodes)} entries; give a map with directions"
            )
        seen = np.zeros(len(counts), dtype=np.intp)
        directions = np.empty(size, dtype=np.intp)
        for k, own in enumerate(place.ravel()):
            seen[own] += 1
            directions[k] = seen[own]
        return np.column_stack([nodes, directions])
    each, left = divmod(size, len(nodes))
    if left or not 1 <= each <= len(DIRECTIONS):
        raise ProblemError(
            f"{name}: expected nodes for {size} rows with equally many directions each, found {len(nodes)} "
            "nodes (rows of constrained directions are missing from the matrix?); give a map with directions"
        )
    return np.column_stack([np.repeat(nodes, each), np.tile(np.arange(1, each + 1), len(nodes))])
