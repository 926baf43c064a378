"""Powers of two that bring rows and columns near the size 1, free of round-off."""

import numpy as np

from shakedown.model.problem import FloatArray
from shakedown.tolerances import DEFAULT


def power_of_two(size: float) -> float:
    """The power of two next to a size; 1 for the size zero."""
    return float(np.exp2(np.round(np.log2(size)))) if size > 0 else 1.0


def typical_size(sizes: FloatArray) -> float:
    """The power of two next to the median of the sizes that are neither zero nor infinite."""
    finite = sizes[np.isfinite(sizes) & (sizes > 0)]
    return power_of_two(float(np.median(finite)) if finite.size else 0.0)


def equilibration(
    matrix: FloatArray, sweeps: int = DEFAULT.equilibration_sweeps
) -> tuple[FloatArray, FloatArray]:
    """Row and column scales, powers of two, that bring every row and column near the size 1.

    Scaling by powers of two is free of round-off. Zero rows and columns keep the scale 1.
    """
    rows, columns = np.ones(matrix.shape[0]), np.ones(matrix.shape[1])
    size = np.abs(matrix)
    for _ in range(sweeps):
        scaled = size * rows[:, None] * columns
        rows /= _root(scaled.max(axis=1, initial=0.0))
        columns /= _root(scaled.max(axis=0, initial=0.0))
    rows /= _nonzero((size * rows[:, None] * columns).max(axis=1, initial=0.0))
    return np.exp2(np.round(np.log2(rows))), np.exp2(np.round(np.log2(columns)))


def _root(size: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(_nonzero(size)), dtype=float)


def _nonzero(size: FloatArray) -> FloatArray:
    return np.where(size > 0, size, 1.0)
