"""The diameter of a path in a plane, in memory proportional to its length, not its square."""

from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray

_BLOCK = 128  # points of a path that are handled together


def diameter(places: FloatArray) -> FloatArray:
    """The way between the two of some places (k, 2) that lie farthest apart: corners of their convex hull.

    Examples
    --------
    >>> diameter(np.array([[0.0, 0.0], [3.0, 4.0], [1.0, 1.0], [0.0, 1.0]])).tolist()
    [3.0, 4.0]
    """
    return _farthest(corners := _hull(places), corners)


def diameter_within(places: FloatArray, time: NDArray[np.intp], window: int) -> FloatArray:
    """The same for points whose times, (k,) increasing, differ by less than a window.

    Where every pair of two blocks counts, only the corners of their hulls are compared.

    Examples
    --------
    >>> steady = np.column_stack([np.arange(9.0), np.zeros(9)])
    >>> diameter_within(steady, np.arange(9), 4).tolist()
    [3.0, 0.0]
    """
    blocks = [(places[k : k + _BLOCK], time[k : k + _BLOCK]) for k in range(0, len(places), _BLOCK)]
    hulls = [_hull(own) for own, _ in blocks]
    found = [np.zeros(2)]
    for i, j in combinations_with_replacement(range(len(blocks)), 2):
        (one, first), (two, second) = blocks[i], blocks[j]
        if second[-1] - first[0] < window:
            found.append(_farthest(hulls[i], hulls[j]))
        elif second[0] - first[-1] < window:
            near = np.abs(second[None, :] - first[:, None]) < window
            found.append(_way(one, two, np.where(near, _apart(one, two), 0.0)))
    return _longest(found)


def _farthest(one: FloatArray, two: FloatArray) -> FloatArray:
    """The longest vector from a point of one set to one of another, in batches."""
    parts = (one[k : k + _BLOCK] for k in range(0, len(one), _BLOCK))
    return _longest([_way(part, two, _apart(part, two)) for part in parts])


def _way(one: FloatArray, two: FloatArray, apart: FloatArray) -> FloatArray:
    """The vector between the farthest points of two sets, by their distances."""
    i, j = np.unravel_index(apart.argmax(), apart.shape)
    return np.asarray(two[j] - one[i])


def _longest(ways: list[FloatArray]) -> FloatArray:
    return max(ways, key=lambda way: float(np.hypot(*way)))


def _apart(one: FloatArray, two: FloatArray) -> FloatArray:
    """Distances between points (k, 2) and (l, 2), (k, l)."""
    return np.asarray(np.hypot(*(one[:, None, :] - two[None, :, :]).transpose(2, 0, 1)))


def _hull(places: FloatArray) -> FloatArray:
    """Corners of the convex hull of points (k, 2), by Andrew's monotone chains."""
    ordered = np.unique(places, axis=0).tolist()
    return np.array([*_chain(ordered), *_chain(ordered[::-1])]).reshape(-1, 2)


def _chain(places: list[list[float]]) -> list[list[float]]:
    """The points at which a line around all of them turns left."""
    found: list[list[float]] = []
    for x, y in places:
        while len(found) > 1:
            (x0, y0), (x1, y1) = found[-2:]
            if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0:
                break
            found.pop()
        found.append([x, y])
    return found
