"""A plan of quadrilaterals drawn out to hexahedra, level by level."""

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex

from shakedown.fem.body import KINDS
from shakedown.ground.constants import FloatArray


def extruded(
    points: FloatArray,  # (2, k): corners in the plan [length]
    quads: NDArray[np.intp],  # (4, e): corners of its elements, counter-clockwise
    levels: FloatArray,  # (l + 1,): heights of the layers' ends [length]
    there: NDArray[np.bool_],  # (l, e): which element a layer has
) -> MeshHex:
    """Hexahedra over the quadrilaterals of a plan, between ascending levels of z.

    Examples
    --------
    >>> plan = np.array([[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0]])
    >>> mesh = extruded(plan, np.arange(4)[:, None], np.array([0.0, 1.0, 3.0]), np.ones((2, 1), bool))
    >>> mesh.p.shape, mesh.t.shape
    ((3, 12), (8, 2))
    """
    count = points.shape[1]
    layer, element = np.nonzero(there)
    below = quads[:, element] + layer * count
    cells = np.vstack([below, below + count])[KINDS["hexahedron"].order]
    every = np.vstack([np.tile(points, len(levels)), np.repeat(levels, count)])
    used, flat = np.unique(cells, return_inverse=True)
    return MeshHex(np.ascontiguousarray(every[:, used]), np.ascontiguousarray(flat.reshape(cells.shape)))


def grid(across: int, up: int) -> NDArray[np.intp]:
    """Elements (4, across × up), counter-clockwise, of corners numbered row by row from below.

    Examples
    --------
    >>> grid(2, 1).T.tolist()
    [[0, 1, 4, 3], [1, 2, 5, 4]]
    """
    first = (np.arange(up)[:, None] * (across + 1) + np.arange(across)).ravel()
    return np.stack([first, first + 1, first + across + 2, first + across + 1])
