"""Shape functions of facets, and a change of basis: corners of quadratic facets get a share of a pressure.

The nodes of a facet are its corners in order, then the nodes between them, then one in the middle.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import ITERATIONS

CORNERS = {(2, 2): 2, (2, 3): 2, (3, 3): 3, (3, 6): 3, (3, 4): 4, (3, 8): 4, (3, 9): 4}  # by dimension, nodes
# u_middle = α (u_corner + u_corner) + (1 − 2 α) û_middle: ∫N̂ is then 2/15 and 1/5 of a triangle of six nodes,
# 1/20 and 1/5 of a quadrilateral of eight, where ∫N of the corners is 0 and −1/12
ALPHA = 0.2
CHANGED = {(3, 6), (3, 8)}
_SIGNS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def shapes(kind: tuple[int, int], place: FloatArray) -> FloatArray:
    """Values of the functions of a facet, (…, k), at local places (…, 1) or (…, 2).

    Examples
    --------
    >>> shapes((3, 6), np.array([1 / 3, 1 / 3])).round(3).tolist()
    [-0.111, -0.111, -0.111, 0.444, 0.444, 0.444]
    """
    if kind[0] == 2:
        return _line(place[..., 0], kind[1])
    if CORNERS[kind] == 3:
        corners = np.stack([1 - place[..., 0] - place[..., 1], place[..., 0], place[..., 1]], axis=-1)
        if kind[1] == 3:
            return corners
        middle = 4 * corners * np.roll(corners, -1, axis=-1)
        return np.concatenate([corners * (2 * corners - 1), middle], axis=-1)
    return _square(place, kind[1])


def changed_shapes(kind: tuple[int, int], place: FloatArray) -> FloatArray:
    """Shape functions in the changed basis, N̂ = N T, (…, k): their integrals are all positive."""
    found = shapes(kind, place)
    return found @ basis_change(kind) if kind in CHANGED else found


def basis_change(kind: tuple[int, int]) -> FloatArray:
    """T with u = T û on one facet, (k, k)."""
    corners = CORNERS[kind]
    between = [(corners + k, k, (k + 1) % corners) for k in range(corners)]
    return np.asarray(corner_basis(np.array(between), kind[1]).toarray())


def corner_basis(between: NDArray[np.intp], size: int, *, inverse: bool = False) -> sparse.csr_array:
    """T with u = T û, (size, size), or T⁻¹.

    ``between`` (t, 3) has an unknown between two corners, and those of the corners; −1 is one that is not
    there.
    """
    own, mixed = (1 / (1 - 2 * ALPHA), -ALPHA / (1 - 2 * ALPHA)) if inverse else (1 - 2 * ALPHA, ALPHA)
    middle, corners = between[:, :1], between[:, 1:]
    diagonal = np.ones(size)
    diagonal[middle] = own
    there = corners >= 0
    where = np.broadcast_to(middle, corners.shape)[there], corners[there]
    parts = sparse.csr_array((np.full(there.sum(), mixed), where), shape=(size, size))
    return sparse.csr_array(sparse.diags_array(diagonal) + parts)


def local_places(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Local places (n, g, 2) of points (n, g, 2) in the plane on facets with corners (n, 3 or 4, 2)."""
    first = corners[:, :1]
    if corners.shape[1] == 3:
        return np.asarray(
            np.linalg.solve((corners[:, 1:] - first).swapaxes(1, 2)[:, None], (points - first)[..., None])[
                ..., 0
            ]
        )
    along = np.zeros_like(points)
    size = np.ptp(corners, axis=1).max()
    for _ in range(ITERATIONS):
        sides = 1 + along[:, :, None, :] * _SIGNS
        left = points - np.einsum("ngc,ncd->ngd", 0.25 * sides[..., 0] * sides[..., 1], corners)
        slopes = 0.25 * np.stack([_SIGNS[:, 0] * sides[..., 1], _SIGNS[:, 1] * sides[..., 0]], axis=-1)
        jacobian = np.einsum("ngca,ncd->ngda", slopes, corners)
        along += np.linalg.solve(jacobian, left[..., None])[..., 0]
        if np.abs(left).max(initial=0.0) <= 4 * np.finfo(float).eps * size:
            break
    return along


def _line(t: FloatArray, count: int) -> FloatArray:
    if count == 2:
        return np.stack([(1 - t) / 2, (1 + t) / 2], axis=-1)
    return np.stack([t * (t - 1) / 2, t * (t + 1) / 2, 1 - t * t], axis=-1)


def _square(place: FloatArray, count: int) -> FloatArray:
    s, t = place[..., 0, None], place[..., 1, None]
    across, along = 1 + s * _SIGNS[:, 0], 1 + t * _SIGNS[:, 1]
    linear = 0.25 * across * along
    if count == 4:
        return linear
    bubble = [(1 - s * s) * (1 - t), (1 + s) * (1 - t * t), (1 - s * s) * (1 + t), (1 - s) * (1 - t * t)]
    middle = 0.5 * np.concatenate(bubble, axis=-1)
    if count == 9:  # each side function less its half of the middle one
        centre = (1 - s * s) * (1 - t * t)
        middle = middle - 0.5 * centre
        corners = linear - 0.5 * (middle + np.roll(middle, 1, axis=-1)) - 0.25 * centre
        return np.concatenate([corners, middle, centre], axis=-1)
    return np.concatenate([linear - 0.5 * (middle + np.roll(middle, 1, axis=-1)), middle], axis=-1)
