"""Coordinate lists: a node number and two or three coordinates per line."""

import os
import re

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.formats import Format
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.table import number_table
from shakedown.models.readers.text import read_lines

_NLIST = re.compile(r"\s*NODE\s+X\s+Y\s+Z\b")


def read_coordinates(path: str | os.PathLike[str]) -> Mesh:
    """Read a list of nodes, as Ansys and most other codes write one.

    Columns are node, x, y and where given z; the header, the delimiter and a
    decimal comma are found out (see :func:`shakedown.models.readers.table.number_table`). Of what NLIST of
    Ansys prints, with its headings, the angles are passed over.

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
    lines, name = read_lines(path), os.fspath(path)
    if heading := next((line for line in lines if _NLIST.match(line)), None):
        rows = [line if line.strip()[:1].isdigit() else "" for line in lines]
        table = number_table(rows, name, delimiter="space")
    else:
        table = number_table(lines, name)
    count = table.values.shape[1]
    if count not in ((4, 7) if heading else (3, 4)):
        raise ProblemError(f"{name}: expected the columns node, x, y and maybe z, found {count}")
    xyz = np.zeros((len(table.values), 3))
    xyz[:, : min(count - 1, 3)] = table.values[:, 1:4]
    return Mesh.of_nodes(np.array(table.whole(1), dtype=np.intp), xyz, name)


FORMATS = (Format("coordinates", "a list of nodes", None, {"mesh": read_coordinates}),)
