"""Which part of an element face each of its nodes stands for."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
_GAUSS = np.sqrt(0.6)
_LINE = np.array([-_GAUSS, 0.0, _GAUSS]), np.array([5.0, 8.0, 5.0]) / 9
_TRIANGLE = np.array([[1 / 6, 1 / 6], [2 / 3, 1 / 6], [1 / 6, 2 / 3]]), np.full(3, 1 / 6)
_SIGNS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])  # corners of a square


def face_shares(points: FloatArray, corners: int, *, revolved: bool = False) -> FloatArray | None:
    """∫ N_j dA over a face for each of its nodes: what a unit pressure gives it as nodal force.

    The sides are taken as straight. Of a face with midside nodes the corners get less than
    the others: 1/6 and 2/3 of an edge, nothing and 1/3 of a triangle, −1/12 and 1/3 of a
    quadrilateral of eight nodes. An edge that revolves about the axis x = 0 sweeps 2 π r of area
    per length.

    Parameters
    ----------
    points : (k, 3)
        Nodes of the face, corners in order first, then the nodes between them [length].
    corners
        How many corners: 2 (an edge of a plane element, unit thickness), 3 or 4.
    revolved
        Whether the face is an edge of an axisymmetric element.

    Returns
    -------
    (k,) or None
        Areas [length²], of an edge that does not revolve lengths; None where no such face is known.

    Examples
    --------
    >>> face_shares(np.array([[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [3.0, 0.0, 0.0]]), 2).round(12)
    array([1., 1., 4.])
    """
    if len(points) not in (corners, 2 * corners - (corners == 2)) or corners not in (2, 3, 4):
        return None
    if revolved and corners != 2:
        return None
    shapes, middle, beside, weight = (_edge, _triangle, _square)[corners - 2](points)
    if revolved:
        weight = weight * 2 * np.pi * (points[:2, 0] @ shapes)
    if len(points) > corners:  # each node on a side takes half of itself from both corners
        shapes = shapes - 0.5 * np.stack([middle[list(sides)].sum(axis=0) for sides in beside])
        shapes = np.concatenate([shapes, middle])
    return np.asarray(shapes @ weight)


class _Face(NamedTuple):
    """Functions of the corners, of the nodes on the sides, sides at each corner, weights of the points."""

    shapes: FloatArray
    middle: FloatArray
    beside: tuple[tuple[int, ...], ...]
    weight: FloatArray


def _edge(points: FloatArray) -> _Face:
    xi, weight = _LINE
    half = 0.5 * float(np.linalg.norm(points[1] - points[0]))
    return _Face(np.stack([(1 - xi) / 2, (1 + xi) / 2]), (1 - xi**2)[None], ((0,), (0,)), half * weight)


def _triangle(points: FloatArray) -> _Face:
    place, weight = _TRIANGLE
    shapes = np.stack([1 - place.sum(axis=1), *place.T])
    middle = np.stack([4 * shapes[i] * shapes[(i + 1) % 3] for i in range(3)])
    twice = float(np.linalg.norm(np.cross(points[1] - points[0], points[2] - points[0])))
    return _Face(shapes, middle, ((0, 2), (0, 1), (1, 2)), twice * weight)


def _square(points: FloatArray) -> _Face:
    xi, eta = (axis.ravel() for axis in np.meshgrid(_LINE[0], _LINE[0]))
    along, across = 1 + xi * _SIGNS[:, :1], 1 + eta * _SIGNS[:, 1:]
    sides = [
        0.25 * (_SIGNS[:, :1] * across).T @ points[:4],  # ∂x/∂ξ
        0.25 * (_SIGNS[:, 1:] * along).T @ points[:4],
    ]
    middle = 0.5 * np.stack(
        [(1 - xi**2) * (1 - eta), (1 + xi) * (1 - eta**2), (1 - xi**2) * (1 + eta), (1 - xi) * (1 - eta**2)]
    )
    weight = np.outer(_LINE[1], _LINE[1]).ravel() * np.linalg.norm(np.cross(*sides), axis=1)
    return _Face(0.25 * along * across, middle, ((0, 3), (0, 1), (1, 2), (2, 3)), weight)
