"""Matrix Market files, as Ansys and others export them, with a map file."""

import os
import re

import numpy as np
from scipy import sparse

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.formats import Format, register
from shakedown.models.readers.row_map import Rows, row_map
from shakedown.models.readers.stiffness import Stiffness, check_entries_once, checked, completed
from shakedown.models.readers.text import numbers_at_once, quoted, read_lines

_BANNER = re.compile(
    r"%%matrixmarket\s+matrix\s+(coordinate|array)\s+(?:real|integer)\s+(general|symmetric)\s*$",
    re.IGNORECASE,
)


def is_matrix_market(text: str) -> bool:
    """Whether a text begins as this format does."""
    return text.lstrip().lower().startswith("%%matrixmarket")


def read_matrix_market(path: str | os.PathLike[str], rows: Rows = None) -> Stiffness:
    """Read a real Matrix Market matrix; a symmetric one is mirrored.

    The reader is the project's own because SciPy's takes Fortran's 1.0D+02 as 1 and an array that is cut off
    as one that ends in zeros.

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
    lines = [line.strip() for line in read_lines(path) if line.strip()]
    if (banner := _BANNER.match(lines[0])) is None:
        raise ProblemError(
            f"{name}: line 1: expected 'matrix coordinate|array real general|symmetric', "
            f"found {quoted(lines[0])}"
        )
    coordinate, symmetric = banner[1].lower() == "coordinate", banner[2].lower() == "symmetric"
    body = [line for line in lines[1:] if not line.startswith("%")]
    shape = numbers_at_once(body[:1], name)
    if len(shape) != (3 if coordinate else 2) or not shape[0] == shape[1] == round(shape[0]) > 0:
        raise ProblemError(
            f"{name}: expected the size of a square matrix, found {quoted(' '.join(body[:1]))}"
        )
    N = int(shape[0])
    dofs = row_map(rows, N, name, "Matrix Market")
    values = numbers_at_once(body[1:], name)
    each, what = (3, "entries") if coordinate else (1, "numbers")
    expected = shape[2] if coordinate else N * (N + 1) // 2 if symmetric else N * N
    if len(values) != each * expected:
        raise ProblemError(f"{name}: expected {expected:g} {what}, found {len(values) / each:g}")
    if coordinate:
        matrix = _entries(values.reshape(-1, 3), N, name)
        return checked(completed(matrix) if symmetric else matrix, dofs, "Matrix Market")
    full = values.reshape(N, N) if not symmetric else np.zeros((N, N))
    if symmetric:  # column by column of the lower triangle
        upper = np.triu_indices(N)
        full[upper] = full.T[upper] = values
    return checked(sparse.csr_array(full.T), dofs, "Matrix Market")


def _entries(table: np.ndarray, N: int, name: str) -> sparse.coo_array:
    """The matrix of lines 'row column value'."""
    places = table[:, :2]
    wrong = np.flatnonzero(((places < 1) | (places > N) | (places != np.round(places))).any(axis=1))
    if wrong.size:
        row, column = places[wrong[0]]
        raise ProblemError(f"{name}: expected row and column 1 to {N}, found {row:g}, {column:g}")
    i, j = places.T.astype(np.intp) - 1
    check_entries_once(i, j, name)
    return sparse.coo_array((table[:, 2], (i, j)), shape=(N, N))


register(Format("matrix-market", "Matrix Market", read_matrix_market, ("rows",), begins=is_matrix_market))
