"""How far apart the slips lie that states end on, in the same phase of a period and drift apart."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import AT_ONCE


class Scatter(NamedTuple):
    """Of the slips that some states end on.

    Attributes
    ----------
    spread
        Largest difference between any two of them at any one node [length].
    largest
        Largest slip among them [length], to compare with.
    """

    spread: float
    largest: float


NONE = Scatter(np.nan, np.nan)  # of no states


def slip_scatter(
    final_slip: FloatArray, rows: NDArray[np.intp], places: FloatArray, drift: FloatArray | None = None
) -> Scatter:
    """The scatter of the final slips of some states about the limit cycle of one of them.

    States may have stopped at different cycles of a period: each is compared with the place
    (end of a cycle) that it is nearest to. Of states that drift, the part of the slip along the
    drift says only when they stopped, and is left out.

    Parameters
    ----------
    final_slip : (s, dn)
        Slips that all states end on [length]; they may lie on the disk.
    rows
        Numbers of the states to compare.
    places : (p, dn)
        Slips at the ends of the cycles of the limit cycle of one of them [length].
    drift : (dn,), optional
        Growth of its slip per period [length].

    Examples
    --------
    >>> slip_scatter(np.array([[0.0, 1.0], [0.5, 1.0], [9.0, 9.0]]), np.array([0, 1]), np.zeros((1, 2)))
    Scatter(spread=0.5, largest=1.0)
    """
    if not len(rows):
        return NONE
    size = 0.0 if drift is None else float(np.linalg.norm(drift))
    along = np.zeros(places.shape[1]) if drift is None or not size else drift / size
    places = places - np.outer(places @ along, along)
    low, high, largest = np.full(len(along), np.inf), np.full(len(along), -np.inf), 0.0
    for start in range(0, len(rows), AT_ONCE):
        ends = np.asarray(final_slip[rows[start : start + AT_ONCE]])
        if size:
            ends = ends - np.outer(ends @ along, along)
        away = _from_nearest(ends, places)
        low, high = np.minimum(low, away.min(axis=0)), np.maximum(high, away.max(axis=0))
        largest = max(largest, float(np.abs(ends).max()))
    return Scatter(float((high - low).max()), largest)


def _from_nearest(ends: FloatArray, places: FloatArray) -> FloatArray:
    """Differences from that place which each of the slips is nearest to."""
    away = ends - places[0]
    for place in places[1:]:
        other = ends - place
        nearer = np.abs(other).max(axis=1) < np.abs(away).max(axis=1)
        away[nearer] = other[nearer]
    return np.asarray(away)
