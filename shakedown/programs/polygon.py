"""Polygons in the plane, given by their sides."""

import numpy as np

from shakedown.ground.constants import THREE_DIGITS, FloatArray
from shakedown.programs.simplex import widest


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
