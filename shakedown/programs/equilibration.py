"""Powers of two that bring rows and columns near the size 1, free of round-off."""

from math import frexp, ldexp, sqrt

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT

_HALFWAY = sqrt(0.5)  # between two powers of two, on the scale of exponents


def power_of_two(size: float) -> float:
    """The power of two next to a size; 1 for the size zero."""
    if size <= 0:
        return 1.0
    mantissa, exponent = frexp(size)  # exact, so that units by powers of two shift nothing but the exponent
    return ldexp(1.0, min(exponent, 1023) if mantissa >= _HALFWAY else exponent - 1)


def typical_size(sizes: FloatArray) -> float:
    """The power of two next to the median of the sizes that are neither zero nor infinite."""
    finite = np.sort(sizes[np.isfinite(sizes) & (sizes > 0)])
    half = finite.size // 2
    return power_of_two(0.5 * float(finite[half] + finite[-1 - half]) if finite.size else 0.0)


def equilibration(
    matrix: FloatArray, sweeps: int = DEFAULT.equilibration_sweeps
) -> tuple[FloatArray, FloatArray]:
    """Row and column scales, powers of two, that bring every row and column near the size 1.

    Scaling by powers of two is free of round-off. Zero rows and columns keep the scale 1.
    The units of the columns are taken out first: a power of two in them changes no bit of
    what follows.
    """
    size = np.abs(matrix)
    units = np.ldexp(1.0, -np.frexp(size.max(axis=0, initial=0.0))[1])
    size = size * units
    rows, columns = np.ones(matrix.shape[0]), np.ones(matrix.shape[1])
    for _ in range(sweeps):
        scaled = size * rows[:, None] * columns
        rows /= _root(scaled.max(axis=1, initial=0.0))
        columns /= _root(scaled.max(axis=0, initial=0.0))
    rows /= _nonzero((size * rows[:, None] * columns).max(axis=1, initial=0.0))
    return np.exp2(np.round(np.log2(rows))), np.exp2(np.round(np.log2(columns))) * units


def _root(size: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(_nonzero(size)), dtype=float)


def _nonzero(size: FloatArray) -> FloatArray:
    return np.where(size > 0, size, 1.0)
