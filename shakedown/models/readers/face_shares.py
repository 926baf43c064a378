"""Which part of an element face each of its nodes stands for."""

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.models.mortar.facet_shapes import CORNERS, shapes

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
    kind = (2 if corners == 2 else 3, len(points))
    if CORNERS.get(kind) != corners or (revolved and corners != 2):
        return None
    places, weight = (_edge, _triangle, _square)[corners - 2](points)
    if revolved:
        weight = weight * 2 * np.pi * (shapes((2, 2), places) @ points[:2, 0])
    return np.asarray(shapes(kind, places).T @ weight)


def _edge(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Local places and weights of points whose sum is the integral over the face; so of the others."""
    xi, weight = _LINE
    return xi[:, None], 0.5 * float(np.linalg.norm(points[1] - points[0])) * weight


def _triangle(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    places, weight = _TRIANGLE
    return places, float(np.linalg.norm(np.cross(points[1] - points[0], points[2] - points[0]))) * weight


def _square(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    xi, eta = (axis.ravel() for axis in np.meshgrid(_LINE[0], _LINE[0]))
    along, across = 1 + xi * _SIGNS[:, :1], 1 + eta * _SIGNS[:, 1:]
    sides = [
        0.25 * (_SIGNS[:, :1] * across).T @ points[:4],  # ∂x/∂ξ
        0.25 * (_SIGNS[:, 1:] * along).T @ points[:4],
    ]
    weight = np.outer(_LINE[1], _LINE[1]).ravel() * np.linalg.norm(np.cross(*sides), axis=1)
    return np.column_stack([xi, eta]), weight
