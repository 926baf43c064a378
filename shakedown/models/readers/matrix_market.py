"""Matrix Market files, as Ansys and others export them, with a map file."""

import os
import re

import numpy as np
from scipy import sparse

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.formats import Format, begins
from shakedown.models.readers.row_map import Rows, is_matrix_market, row_map
from shakedown.models.readers.stiffness import Stiffness, checked, completed, numbered_entries
from shakedown.models.readers.text import integers, numbers, quoted, read_lines

_BANNER = re.compile(
    r"%%matrixmarket\s+matrix\s+(coordinate|array)\s+(?:real|integer)\s+(general|symmetric)\s*$",
    re.IGNORECASE,
)


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
    lines = [(k, line.strip()) for k, line in enumerate(read_lines(path), start=1) if line.strip()]
    if (banner := _BANNER.match(lines[0][1])) is None:
        raise ProblemError(
            f"{name}: line 1: expected 'matrix coordinate|array real general|symmetric', "
            f"found {quoted(lines[0][1])}"
        )
    coordinate, symmetric = banner[1].lower() == "coordinate", banner[2].lower() == "symmetric"
    size, *body = [line for line in lines[1:] if not line[1].startswith("%")] or [(1, "")]
    where = f"{name}: line {size[0]}"
    shape = integers(size[1].split(), where)
    if len(shape) != (3 if coordinate else 2) or not shape[0] == shape[1] > 0:
        raise ProblemError(f"{where}: expected the size of a square matrix, found {quoted(size[1])}")
    N = shape[0]
    dofs = row_map(rows, N, name, "Matrix Market")
    if coordinate:
        if len(body) != shape[2]:
            raise ProblemError(f"{name}: expected {shape[2]} entries, found {len(body)}")
        matrix = numbered_entries(body, lambda _: N, name)
        return checked(completed(matrix) if symmetric else matrix, dofs, "Matrix Market")
    values = [value for k, text in body for value in numbers(text.split(), f"{name}: line {k}")]
    expected = N * (N + 1) // 2 if symmetric else N * N
    if len(values) != expected:
        raise ProblemError(f"{name}: expected {expected} numbers, found {len(values)}")
    full = np.zeros((N, N)) if symmetric else np.reshape(values, (N, N)).T
    if symmetric:  # column by column of the lower triangle
        upper = np.triu_indices(N)
        full[upper] = full.T[upper] = values
    return checked(sparse.csr_array(full), dofs, "Matrix Market")


_READS = {"stiffness": read_matrix_market}
FORMATS = (Format("matrix-market", "Matrix Market", begins(is_matrix_market), _READS, ("rows",)),)
