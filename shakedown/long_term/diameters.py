"""How far apart the places of a path in a plane lie, in memory that grows with the path, not its square."""

from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray

_BLOCK = 128  # places of a path that are looked at together


def diameter(places: FloatArray) -> float:
    """The largest distance between two of some places (k, 2): between corners of their convex hull.

    Examples
    --------
    >>> diameter(np.array([[0.0, 0.0], [3.0, 4.0], [1.0, 1.0], [0.0, 1.0]]))
    5.0
    """
    return _farthest(corners := _hull(places), corners)


def diameter_within(places: FloatArray, time: NDArray[np.intp], window: int) -> float:
    """The same of places whose times, (k,) increasing, differ by less than a window.

    Blocks of places between which every pair counts are looked at by the corners of their hulls.

    Examples
    --------
    >>> steady = np.column_stack([np.arange(9.0), np.zeros(9)])
    >>> diameter_within(steady, np.arange(9), 4)
    3.0
    """
    blocks = [(places[k : k + _BLOCK], time[k : k + _BLOCK]) for k in range(0, len(places), _BLOCK)]
    hulls = [_hull(own) for own, _ in blocks]
    largest = 0.0
    for i, j in combinations_with_replacement(range(len(blocks)), 2):
        (one, first), (two, second) = blocks[i], blocks[j]
        if second[-1] - first[0] < window:
            largest = max(largest, _farthest(hulls[i], hulls[j]))
        elif second[0] - first[-1] < window:
            near = np.abs(second[None, :] - first[:, None]) < window
            largest = max(largest, float(_apart(one, two)[near].max(initial=0.0)))
    return largest


def _farthest(one: FloatArray, two: FloatArray) -> float:
    """The largest distance of a place of one kind from one of another, some of them at a time."""
    rows = (_apart(one[k : k + _BLOCK], two).max(initial=0.0) for k in range(0, len(one), _BLOCK))
    return float(max(rows, default=0.0))


def _apart(one: FloatArray, two: FloatArray) -> FloatArray:
    """Distances between places (k, 2) and (l, 2), (k, l)."""
    return np.asarray(np.hypot(*(one[:, None, :] - two[None, :, :]).transpose(2, 0, 1)))


def _hull(places: FloatArray) -> FloatArray:
    """Corners of the convex hull of places (k, 2), by Andrew's chains: below to the right, above back."""
    ordered = np.unique(places, axis=0).tolist()
    return np.array([*_chain(ordered), *_chain(ordered[::-1])]).reshape(-1, 2)


def _chain(places: list[list[float]]) -> list[list[float]]:
    """The places that a line around all of them turns left at."""
    found: list[list[float]] = []
    for x, y in places:
        while len(found) > 1:
            (x0, y0), (x1, y1) = found[-2:]
            if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0:
                break
            found.pop()
        found.append([x, y])
    return found
