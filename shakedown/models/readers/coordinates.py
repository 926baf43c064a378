"""Coordinate lists: a node number and two or three coordinates per line."""

import os

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.table import read_table


def read_coordinates(path: str | os.PathLike[str]) -> Mesh:
    """Read a list of nodes, as Ansys and most other codes write one.

    Columns are node, x, y and where given z; the header, the delimiter and a
    decimal comma are found out (see :func:`shakedown.models.readers.table.number_table`).

    Raises
    ------
    ProblemError
        If there are not three or four columns, a node number is not whole or
        occurs twice.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "nodes.txt"
    >>> _ = path.write_text("Node\\tX (m)\\tY (m)\\tZ (m)\\t\\n7\\t0,5\\t-1,e-001\\t0\\n")
    >>> read_coordinates(path).coordinates.tolist()
    [[0.5, -0.1, 0.0]]
    """
    table = read_table(path)
    count = table.values.shape[1]
    if count not in (3, 4):
        raise ProblemError(f"{table.name}: expected the columns node, x, y and maybe z, found {count}")
    labels = np.array(table.whole(1), dtype=np.intp)
    xyz = np.zeros((len(labels), 3))
    xyz[:, : count - 1] = table.values[:, 1:]
    return Mesh.of_nodes(labels, xyz, table.name)
