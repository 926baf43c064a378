"""Faces of a contact in space: which of its nodes are the corners of each."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray

IntArray = NDArray[np.intp]
NONE = -1  # in the last column of a triangle


def checked_faces(numbers: FloatArray, n: int) -> IntArray | None:
    """Corners of faces (k, 4) as whole numbers; None where there is no face.

    Raises
    ------
    ProblemError
        If a corner is no node, or a face has one twice.

    Examples
    --------
    >>> checked_faces(np.array([[0.0, 1.0, 2.0, -1.0]]), 3)
    array([[ 0,  1,  2, -1]])
    """
    least = np.array([0, 0, 0, NONE])
    wrong = np.argwhere(~((numbers >= least) & (numbers < n) & (numbers == np.round(numbers))))
    if wrong.size:
        k, corner = wrong[0]
        raise ProblemError(
            f"key 'faces': expected numbers of nodes from 0 to {n - 1} (−1 as the last of a triangle), found "
            f"{numbers[k, corner]:g} at faces[{k}][{corner}]"
        )
    faces = numbers.astype(np.intp)
    ordered = np.sort(faces, axis=1)
    twice = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if twice.size:
        raise ProblemError(
            f"key 'faces': expected corners that differ, found {faces[twice[0]].tolist()} as face {twice[0]}"
        )
    return faces if len(faces) else None


def faces_among(faces: NDArray[np.integer], nodes: Sequence[int]) -> IntArray | None:
    """The faces that have all their corners among some nodes, with the numbers of these in their order.

    Examples
    --------
    >>> faces_among(np.array([[0, 1, 2, -1], [1, 2, 3, -1]]), [3, 2, 1])
    array([[ 2,  1,  0, -1]])
    """
    number = np.full(max(int(faces.max()), *nodes, 0) + 2, NONE - 1)
    number[list(nodes)] = np.arange(len(nodes))
    number[NONE] = NONE
    found = number[faces]
    kept = found[(found >= NONE).all(axis=1)]
    return kept if len(kept) else None


def wound(faces: NDArray[np.integer], places: FloatArray, normals: FloatArray) -> IntArray:
    """Faces, each with its corners in the order in which they go around the normals there, (n, 3).

    Examples
    --------
    >>> places, up = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]]), np.tile([0.0, 0, 1], (3, 1))
    >>> wound(np.array([[0, 2, 1, -1]]), places, up)
    array([[ 0,  1,  2, -1]])
    """
    first, second, third = (places[corner] for corner in faces.T[:3])
    across = np.cross(second - first, third - first)
    against = (across * normals[faces[:, 0]]).sum(axis=1) < 0
    turned = np.where(faces[:, 3:] == NONE, faces[:, [0, 2, 1, 3]], faces[:, [0, 3, 2, 1]])
    return np.where(against[:, None], turned, faces)


def split_face(corners: Sequence[int], others: Sequence[int], place: FloatArray) -> list[tuple[int, ...]]:
    """A face of an element as faces without nodes between their corners, four numbers each.

    Parameters
    ----------
    corners
        Three or four, in order around it.
    others
        Nodes on its sides, one each, and in its middle; or none.
    place : (c, 3)
        Where the corners and then the others are.

    Examples
    --------
    >>> square = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
    >>> sides = np.array([[1.0, 0, 0], [2, 1, 0], [1, 2, 0], [0, 1, 0]])
    >>> split_face([3, 5, 7, 9], [4, 6, 8, 10], np.concatenate([square, sides]))[0]
    (3, 4, 10, -1)
    >>> split_face([3, 5, 7], [], square[:3])
    [(3, 5, 7, -1)]
    """
    c = len(corners)
    if len(others) < c:
        return [(*corners, NONE)[:4]]
    at, beside = place[:c], place[c:]
    middles = 0.5 * (at + np.roll(at, -1, axis=0))
    nearest = [int(np.linalg.norm(beside - middle, axis=1).argmin()) for middle in middles]
    sides = [others[k] for k in nearest]
    within = [node for node in others if node not in sides]
    if within:
        return [(corners[k], sides[k], within[0], sides[k - 1]) for k in range(c)]
    tips = [(corners[k], sides[k], sides[k - 1], NONE) for k in range(c)]
    return [*tips, (*sides, NONE)[:4]]
