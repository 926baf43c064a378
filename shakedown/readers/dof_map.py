"""Map files: which node and direction each row of a matrix belongs to."""

import os

import numpy as np
from numpy.typing import NDArray

from shakedown.errors import ProblemError
from shakedown.readers.text import integers, read_lines


def read_dof_map(path: str | os.PathLike[str]) -> NDArray[np.intp]:
    """Read ``node direction`` lines (also ``node,direction`` and CalculiX's ``node.direction``).

    Blank lines and lines that start with ``#``, ``%``, ``$``, ``!`` or ``*`` are skipped.

    Returns
    -------
    (N, 2)
        Node label and direction (1, 2, 3 = x, y, z) of every row, in matrix order.

    Raises
    ------
    ProblemError
        If a line does not hold two whole numbers.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "k.map"
    >>> _ = path.write_text("# node direction\\n7 1\\n7,2\\n9.1\\n")
    >>> read_dof_map(path).tolist()
    [[7, 1], [7, 2], [9, 1]]
    """
    table = []
    for k, line in enumerate(read_lines(path), start=1):
        text = line.strip()
        if not text or text[0] in "#%$!*":
            continue
        where = f"{os.fspath(path)}: line {k}"
        fields = text.replace(",", " ").replace(".", " ").split()
        if len(fields) != 2:
            raise ProblemError(f"{where}: expected 'node direction', found '{text}'")
        table.append(integers(fields, where))
    if not table:
        raise ProblemError(f"{os.fspath(path)}: expected a map of rows, found no line")
    return np.array(table, dtype=np.intp)
