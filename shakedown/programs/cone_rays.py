"""Rays to the boundary of second-order cones, and polygons in the plane."""

import numpy as np

from shakedown.ground.constants import THREE_DIGITS, FloatArray
from shakedown.programs.simplex import widest


def leaves_cone(start: FloatArray, along: FloatArray) -> FloatArray:
    """The largest t ≥ 0 at which ``start + t along`` is in the cone |(x, y)| ≤ h, from its point ``start``.

    Vectors (…, 3) are (h, x, y). inf where it never leaves; 0 where it does so at once.

    Examples
    --------
    >>> leaves_cone(np.array([1.0, 0.0, 0.5]), np.array([[0.0, 0.0, 2.0], [2.0, 0.0, 2.0]]))
    array([0.25,  inf])
    """
    size = np.ldexp(1.0, np.frexp(np.abs(along).max(axis=-1))[1])
    c, x, y = np.moveaxis(start, -1, 0)  # |(x, y) + t b|² − (c + t d)² = α t² + 2 β t + γ, and γ ≤ 0
    d, b_x, b_y = np.moveaxis(along / size[..., None], -1, 0)
    alpha, beta = b_x**2 + b_y**2 - d**2, x * b_x + y * b_y - c * d
    gamma = np.minimum(x**2 + y**2 - c**2, 0.0)
    root = np.sqrt(np.maximum(beta**2 - alpha * gamma, 0.0))
    ends = (beta**2 >= alpha * gamma) & ((alpha > 0) | (beta > 0))
    top, below = np.where(beta > 0, -gamma, root - beta), np.where(beta > 0, beta + root, alpha)
    return np.divide(top, below, out=np.full_like(top, np.inf), where=ends) / size


def corners(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Corners of the polygon M x ≤ r, counter-clockwise, (c, 2).

    Empty where there is none, or none that is bounded and has an interior.

    Parameters
    ----------
    matrix, right : (k, 2), (k,)
        The sides. Rows of zeros are conditions that hold or do not.

    Examples
    --------
    >>> sides = np.array([[-1.0, 0.0], [0.0, -1.0], [1.0, 1.0]])
    >>> (corners(sides, np.array([0.0, 0.0, 2.0])).round(9) + 0.0).tolist()
    [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]
    """
    from scipy.spatial import HalfspaceIntersection, QhullError

    norms = np.linalg.norm(matrix, axis=1)
    steep = norms > 0
    if steep.sum() < 3 or (right[~steep] < 0).any():
        return np.empty((0, 2))
    sides, distance = matrix[steep] / norms[steep, None], right[steep] / norms[steep]
    size = float(np.abs(distance).max())
    far = size / THREE_DIGITS  # a corner that much farther than the sides belongs to an unbounded polygon
    found = widest(sides, np.ones(len(distance)), distance, cap=far)
    if not 0 < found.margin < 0.9 * far:
        return np.empty((0, 2))
    try:
        points = HalfspaceIntersection(np.column_stack([sides, -distance]), found.x).intersections
    except QhullError:
        return np.empty((0, 2))
    if not np.isfinite(points).all():
        return np.empty((0, 2))
    around = points - found.x
    return np.asarray(points[np.argsort(np.arctan2(around[:, 1], around[:, 0]))])
