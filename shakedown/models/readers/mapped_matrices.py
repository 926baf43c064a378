"""Matrices without labels, and the maps from files beside them that say which node and direction a row is.

Matrix Market, Harwell–Boeing (``HBMAT`` and ``*EXPORT`` of Ansys), and lines ``i j value`` (``.sti`` of
CalculiX, ``COORDINATE`` of Abaqus).
"""

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from shakedown.ground.constants import FloatArray, IntArray
from shakedown.ground.errors import ProblemError
from shakedown.models.readers import parsing, stiffness
from shakedown.models.readers.formats import Format, format_of
from shakedown.models.readers.parsing import LARGEST_WHOLE, quoted, unfit, whole_number
from shakedown.models.readers.stiffness import Rows, Stiffness

DIRECTIONS = {"UX": 1, "UY": 2, "UZ": 3, "ROTX": 4, "ROTY": 5, "ROTZ": 6}
_HEADING = re.compile("matrix|eqn?|equation|row|no|number|node|label|dof|dir(ection)?", re.IGNORECASE)
_COMMENT = "#%$!*"


def row_map(rows: Rows, size: int, where: str, format: str) -> IntArray:
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
          (directions and equations may count from 0);
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
        raise unfit(where, f"a map of {size} lines, one per row", len(table))
    return table


def read_row_map(path: str | os.PathLike[str], size: int | None = None) -> IntArray:
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


def _listed(path: str | os.PathLike[str], size: int | None) -> IntArray:
    """The map of lines of one to three numbers each, of which the last may be the name of a direction.

    Blank lines, a line of headings (node, dof …) at the head, and lines that start with ``#``, ``%``,
    ``$``, ``!`` or ``*`` are skipped.
    """
    name, table = os.fspath(path), list[list[int]]()
    for k, line in enumerate(parsing.read_lines(path), start=1):
        fields = line.replace(",", " ").split()
        if not fields or fields[0][0] in _COMMENT:
            continue
        if not table and all(map(_HEADING.fullmatch, fields)):
            continue
        if len(fields) == 1 and fields[0].replace(".", "").isdigit():
            fields = fields[0].split(".")  # 'node.direction'
        where = f"{name}: line {k}"
        if len(fields) > 3 or (table and len(fields) != len(table[0])):
            raise unfit(where, "'node direction' (or 'equation node direction')", quoted(line))
        table.append([DIRECTIONS.get(text.upper()) or whole_number(text, where) for text in fields])
    if not table:
        raise unfit(name, "a map of rows", "no line")
    return _of_columns(np.array(table, dtype=float), size, name)


def _of_columns(table: FloatArray, size: int | None, name: str) -> IntArray:
    """The map of columns equation (where there are three), node, direction; or of the nodes alone."""
    if table.shape[1] > 3 or not (np.abs(table) < LARGEST_WHOLE).all() or (table != np.round(table)).any():
        raise unfit(name, "whole numbers in one to three columns", "others")
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


def implied_rows(nodes: IntArray, size: int | None, name: str) -> IntArray:
    """Nodes without directions: each has the same number of rows, in the order x, y, z."""
    if size is None:
        raise unfit(name, "rows 'node direction'", "nodes without directions")
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


_MARKET = re.compile(r"\s*%%matrixmarket", re.IGNORECASE)
_BANNER = re.compile(
    r"%%matrixmarket\s+matrix\s+(coordinate|array)\s+(real|integer)\s+(general|symmetric)\s*$", re.IGNORECASE
)


def _market(path: str | os.PathLike[str]) -> tuple[list[str], list[int], str, list[tuple[int, str]]]:
    """The words of the first line, the sizes, where these stand, and the lines behind them."""
    name = os.fspath(path)
    lines = [(k, line.strip()) for k, line in enumerate(parsing.read_lines(path), start=1) if line.strip()]
    if (banner := _BANNER.match(lines[0][1])) is None:
        raise unfit(
            f"{name}: line 1", "'matrix coordinate|array real general|symmetric'", quoted(lines[0][1])
        )
    size, *body = [line for line in lines[1:] if not line[1].startswith("%")] or [(1, "")]
    where = f"{name}: line {size[0]}"
    return [word.lower() for word in banner.groups()], parsing.integers(size[1].split(), where), where, body


def _node_vector(path: str | os.PathLike[str], size: int | None) -> IntArray:
    """The map of the whole numbers of an array with one column."""
    name = os.fspath(path)
    words, sizes, where, body = _market(path)
    found = np.array([whole_number(text, name) for _, line in body for text in line.split()], dtype=np.intp)
    if words[:2] != ["array", "integer"] or 1 not in sizes:
        raise unfit(where, "a node vector ('array integer', one column)", f"'{' '.join(words)}'")
    if max(sizes) != len(found):
        raise unfit(where, f"{max(sizes)} nodes", len(found))
    return implied_rows(found, size, name)


def read_matrix_market(path: str | os.PathLike[str], rows: Rows = None) -> Stiffness:
    """Read a real Matrix Market matrix; a symmetric one is mirrored.

    The reader is the project's own because SciPy's takes Fortran's 1.0D+02 as 1 and an array that is cut off
    as one that ends in zeros.

    Parameters
    ----------
    path
        The file.
    rows
        The map, which the format does not hold; see :func:`shakedown.models.readers.mapped_matrices.row_map`.

    Raises
    ------
    ProblemError
        If the file is malformed or there is no map of its size.
    """
    name = os.fspath(path)
    words, shape, where, body = _market(path)
    coordinate, symmetric = words[0] == "coordinate", words[2] == "symmetric"
    if len(shape) != (3 if coordinate else 2) or not shape[0] == shape[1] > 0:
        raise unfit(where, "the size of a square matrix", " ".join(map(str, shape)) or "none")
    N = shape[0]
    dofs = row_map(rows, N, name, "Matrix Market")
    if coordinate:
        if len(body) != shape[2]:
            raise unfit(name, f"{shape[2]} entries", len(body))
        matrix = stiffness.numbered_entries(body, lambda _: N, name)
        return stiffness.checked(stiffness.completed(matrix) if symmetric else matrix, dofs, "Matrix Market")
    values = [value for k, text in body for value in parsing.numbers(text.split(), f"{name}: line {k}")]
    expected = N * (N + 1) // 2 if symmetric else N * N
    if len(values) != expected:
        raise unfit(name, f"{expected} numbers", len(values))
    full = np.zeros((N, N)) if symmetric else np.reshape(values, (N, N)).T
    if symmetric:  # column by column of the lower triangle
        upper = np.triu_indices(N)
        full[upper] = full.T[upper] = values
    return stiffness.checked(sparse.csr_array(full), dofs, "Matrix Market")


_TYPE = re.compile(r"[RCP][SUHZR][AE](\s+\d+){3}(\s|$)", re.IGNORECASE)
_LAYOUT = re.compile(r"\((?:\d+P,?)?(\d{0,3})[IEDFG](\d{1,3})(?:\.\d+)?(?:E\d+)?\)", re.IGNORECASE)


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
    name, lines = os.fspath(path), parsing.read_lines(path)
    if not is_harwell_boeing("\n".join(lines[:4])):
        raise unfit(f"{name}: line 3", "a Harwell-Boeing matrix type", quoted(lines[0]))
    kind, *sizes = lines[2].split()
    N, columns, count = parsing.integers(sizes[:3], f"{name}: line 3")
    if kind.upper() not in ("RSA", "RUA") or columns != N or N < 1:
        raise unfit(
            f"{name}: line 3", "a real assembled square matrix (RSA or RUA)", f"{kind} {N} x {columns}"
        )
    lengths = parsing.integers([*lines[1].split(), "0"][1:5], f"{name}: line 2")
    layouts = [(int(n or 1), int(width)) for n, width in _LAYOUT.findall(lines[3].replace(" ", ""))]
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
        raise unfit(name, f"column pointers from 1 to {count + 1} in order", found)
    if count and (index.min() < 0 or index.max() >= N):
        raise unfit(name, f"rows 1 to {N}", index.max() + 1)
    column: IntArray = np.repeat(np.arange(N), np.diff(pointers))
    stiffness.check_entries_once(index, column, name)
    matrix = sparse.coo_array((sections[2], (index, column)), shape=(N, N))
    whole = matrix if kind.upper() == "RUA" else stiffness.completed(matrix)
    return stiffness.checked(whole, row_map(rows, N, name, "Harwell-Boeing"), "Harwell-Boeing")


def _section(
    lines: list[str], at: int, length: int, layout: tuple[int, int], size: int, name: str
) -> FloatArray:
    """The numbers of one section, split at blanks, or sliced by its Fortran format where they touch."""
    if length < 0 or at + length > len(lines):
        raise unfit(name, f"{length} lines from line {at + 1} on", "the end of the file")
    own, (repeat, width) = lines[at : at + length], layout
    fields = [field for line in own for field in line.split()]
    if len(fields) != size:  # numbers touch each other, or there is text beside them
        padded = (line.rstrip()[: repeat * width] for line in own)
        fields = [line[k : k + width] for line in padded for k in range(0, len(line), width)]
    if len(fields) != size:
        raise unfit(name, f"{size} numbers from line {at + 1} on", len(fields))
    return np.array(parsing.numbers(fields, f"{name}: from line {at + 1} on"))


_ENTRY = re.compile(rf"^\s*\d+\s+\d+\s+{parsing.REAL}\s*$")
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

    hint = " (of Abaqus' formats, write *MATRIX OUTPUT, FORMAT=MATRIX INPUT)"
    entries = stiffness.numbered_entries(enumerate(parsing.read_lines(path), start=1), size, name, hint)
    return stiffness.checked(stiffness.completed(entries), dofs, NUMBERED)


def _begins_with_entry(text: str) -> bool:
    """Whether the first line that is neither a keyword nor a remark is 'row column value'."""
    lines = (line for line in text.splitlines() if line.strip() and line.lstrip()[0] not in _COMMENT)
    return _ENTRY.match(next(lines, "")) is not None


_OF_MARKET: dict[str, Callable[..., Any]] = {"stiffness": read_matrix_market, "rows": _node_vector}
_BOEING, _NUMBERED = {"stiffness": read_harwell_boeing}, {"stiffness": read_calculix_storage}
FORMATS = (
    Format("matrix-market", "Matrix Market", _OF_MARKET, ("rows",), begins=_MARKET.match),
    Format("harwell-boeing", "Harwell-Boeing", _BOEING, ("rows",), begins=is_harwell_boeing),
    Format("numbered", "Abaqus COORDINATE, CalculiX .sti", _NUMBERED, ("rows",), begins=_begins_with_entry),
    Format("rows", "a list of rows", {"rows": _listed}),
)
