"""Sectors of directions in which a node slips, and how far a vector reaches in them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray


@dataclass(frozen=True)
class Sectors:
    """Sectors of the unit circle, each of one node: directions u within ``half`` of its middle.

    Attributes
    ----------
    node : (c,)
        The node that slips in these directions.
    middle : (c, 2)
        Unit vectors.
    half
        Half the angle of every sector: π of the whole circle, 0 of one direction.
    """

    node: NDArray[np.intp]
    middle: FloatArray
    half: float

    def __len__(self) -> int:
        return len(self.node)

    def part(self, columns: NDArray[np.intp]) -> "Sectors":
        """Some of them."""
        return Sectors(self.node[columns], self.middle[columns], self.half)

    def reach(self, y: FloatArray) -> FloatArray:
        """The largest y · u over the directions of every sector, of vectors (…, c, 2): (…, c)."""
        if self.half == 0.0:
            return np.asarray(np.sum(y * self.middle, axis=-1))
        size = np.hypot(y[..., 0], y[..., 1])
        return np.asarray(size if self.half >= np.pi else size * np.cos(self._beyond(y)))

    def farthest(self, y: FloatArray) -> FloatArray:
        """The direction u that :meth:`reach` reaches, (…, c, 2)."""
        along, across = self._in_frame(y)
        angle = np.clip(np.arctan2(across, along), -self.half, self.half)
        cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
        return np.asarray(cosine * self.middle + sine * turned(self.middle))

    def corners(self, count: int) -> FloatArray:
        """Three directions at equal angles, (3, c / count, 2)."""
        angle = 2.0 * np.pi * np.arange(3) / 3
        found = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return np.repeat(found[:, None], len(self) // count, axis=1)

    def nearest(self, corner: FloatArray, count: int) -> NDArray[np.intp]:
        """Which of the ``count`` sectors of every node is nearest to a direction (k, 2)."""
        middle = self.middle.reshape(-1, count, 2)
        return np.asarray(np.sum(middle * corner[:, None], axis=2).argmax(axis=1))

    def _beyond(self, y: FloatArray) -> FloatArray:
        along, across = self._in_frame(y)
        return np.maximum(np.arctan2(np.abs(across), along) - self.half, 0.0)

    def _in_frame(self, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        along = np.sum(y * self.middle, axis=-1)
        return along, np.sum(y * turned(self.middle), axis=-1)


def sectors_of(nodes: NDArray[np.intp], first: FloatArray, count: int) -> Sectors:
    """``count`` sectors of each of some nodes, together the circle; the middle of the first as given.

    Examples
    --------
    >>> four = sectors_of(np.array([0]), np.array([[1.0, 0.0]]), 4)
    >>> four.reach(np.array([3.0, 4.0])).round(3)
    array([ 4.95 ,  5.   ,  0.707, -0.707])
    """
    angles = 2.0 * np.pi * np.arange(count) / count
    middle = np.cos(angles)[:, None] * first[:, None] + np.sin(angles)[:, None] * turned(first)[:, None]
    return Sectors(np.repeat(nodes, count), middle.reshape(-1, 2), np.pi / count)


def every_direction(nodes: NDArray[np.intp]) -> Sectors:
    """One sector of every node: the whole circle."""
    return sectors_of(nodes, np.tile([1.0, 0.0], (len(nodes), 1)), 1)


def turned(vectors: FloatArray) -> FloatArray:
    """By a right angle."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)
