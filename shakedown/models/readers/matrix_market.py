"""Matrix Market files, as Ansys and others export them, with a map file."""

import os
from collections.abc import Iterator

import numpy as np
from scipy import sparse

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.row_map import Rows, row_map
from shakedown.models.readers.stiffness import Stiffness, check_entries_once, checked, completed
from shakedown.models.readers.text import integers, number, numbers, quoted, read_lines

_Line = tuple[str, list[str]]


def is_matrix_market(lines: list[str]) -> bool:
    """Whether the lines of a file, as far as they are not blank, begin as this format does."""
    return lines[0].lower().startswith("%%matrixmarket")


def read_matrix_market(path: str | os.PathLike[str], rows: Rows = None) -> Stiffness:
    """Read a real Matrix Market matrix; a symmetric one is mirrored.

    The reader is the project's own because SciPy's crashes on damaged files.

    Parameters
    ----------
    path
        The file.
    rows
        The map, which the format does not hold; see :func:`shakedown.models.readers.row_map.row_map`.

    Raises
    ------
    ProblemError
        If the file is malformed or there is no map of its size.
    """
    name = os.fspath(path)
    lines = read_lines(path)
    banner = lines[0].lower().split()
    if (
        len(banner) != 5
        or banner[1] != "matrix"
        or banner[2] not in ("coordinate", "array")
        or banner[3] not in ("real", "integer")
        or banner[4] not in ("general", "symmetric")
    ):
        raise ProblemError(
            f"{name}: line 1: expected 'matrix coordinate|array real general|symmetric', "
            f"found {quoted(lines[0])}"
        )
    body = _body(lines, name)
    where, size = next(body, (name, []))
    shape = integers(size, where)
    coordinate, symmetric = banner[2] == "coordinate", banner[4] == "symmetric"
    if len(shape) != (3 if coordinate else 2) or min(shape) < 1 or shape[0] != shape[1]:
        raise ProblemError(f"{where}: expected the size of a square matrix, found {quoted(' '.join(size))}")
    read = _coordinate if coordinate else _array
    dofs = row_map(rows, shape[0], name, "Matrix Market")
    return checked(read(body, shape, symmetric, name), dofs, "Matrix Market")


def _body(lines: list[str], name: str) -> Iterator[_Line]:
    for k, line in enumerate(lines[1:], start=2):
        if line.strip() and not line.lstrip().startswith("%"):
            yield f"{name}: line {k}", line.split()


def _coordinate(body: Iterator[_Line], shape: list[int], symmetric: bool, name: str) -> sparse.sparray:
    keys, values = [], []
    for where, fields in body:
        if len(fields) != 3:
            raise ProblemError(f"{where}: expected 'row column value', found {quoted(' '.join(fields))}")
        row, column = integers(fields[:2], where)
        if not (1 <= row <= shape[0] and 1 <= column <= shape[1]):
            raise ProblemError(f"{where}: expected row and column 1 to {shape[0]}, found {row}, {column}")
        keys.append((row - 1, column - 1))
        values.append(number(fields[2], where))
    if len(values) != shape[2]:
        raise ProblemError(f"{name}: expected {shape[2]} entries, found {len(values)}")
    i, j = np.array(keys, dtype=np.intp).reshape(-1, 2).T
    check_entries_once(i, j, name)
    entries = sparse.coo_array((values, (i, j)), shape=tuple(shape[:2]))
    return completed(entries) if symmetric else entries


def _array(body: Iterator[_Line], shape: list[int], symmetric: bool, name: str) -> sparse.coo_array:
    """Values column by column; of a symmetric matrix the lower triangle only."""
    values = [value for where, fields in body for value in numbers(fields, where)]
    N = shape[0]
    expected = N * (N + 1) // 2 if symmetric else N * N
    if len(values) != expected:
        raise ProblemError(f"{name}: expected {expected} numbers, found {len(values)}")
    if not symmetric:
        return sparse.coo_array(np.array(values).reshape(N, N).T)
    upper = np.zeros((N, N))
    upper[np.triu_indices(N)] = values  # row by row of the upper is column by column of the lower
    return sparse.coo_array(upper + np.triu(upper, 1).T)
