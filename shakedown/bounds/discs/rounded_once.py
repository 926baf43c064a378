"""Products rounded once, and inverses that are proved to be near their own: what proofs are computed with."""

from math import fsum, inf

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import HALVINGS

HALF_ULP = 0.5 * np.finfo(float).eps  # of a rounding, relative
TINY = float(np.finfo(float).tiny)  # what an underflow may lose, at most, in a sum of products
SUMS = 16 * HALF_ULP  # of what is put together of few rounded parts, relative to them
SPLITTER = 2.0 ** (HALVINGS // 2) + 1.0  # parts a number in two of half its digits
REPAIRABLE = 0.25  # largest norm of I − R A for an approximate inverse R of A


def exact_products(matrix: FloatArray, x: FloatArray) -> FloatArray:
    """M x with every entry rounded once: products split without error, their sums rounded once.

    Examples
    --------
    >>> exact_products(np.array([[1e16, 1.0, -1e16]]), np.ones(3))
    array([1.])
    """
    found = np.empty(len(matrix))
    x_high = _high(x)
    x_low = x - x_high
    for i, row in enumerate(matrix):
        high = _high(row)
        low, product = row - high, row * x
        rest = low * x_low - (((product - high * x_high) - low * x_high) - high * x_low)
        found[i] = fsum(np.concatenate([product, rest]).tolist())
    return found


def _high(values: FloatArray) -> FloatArray:
    """The first 26 bits."""
    lifted = SPLITTER * values
    return np.asarray(lifted - (lifted - values))


class Inverse:
    """A symmetric matrix with an approximate inverse, and how near to its own that is proved to be (U3)."""

    def __init__(self, matrix: FloatArray) -> None:
        """Invert it in units in which its diagonal is near 1."""
        diagonal, size = np.diag(matrix), len(matrix)
        powers = -np.frexp(np.where(diagonal > 0, diagonal, 1.0))[1] // 2
        self.lengths = np.ldexp(1.0, powers)
        scaled = matrix * self.lengths * self.lengths[:, None]
        try:
            self.approximate = np.linalg.inv(scaled)
        except np.linalg.LinAlgError:
            self.approximate = np.full((size, size), np.nan)
        with np.errstate(all="ignore"):
            rest = np.abs(np.eye(size) - self.approximate @ scaled).sum(axis=1)
            rounding = np.abs(self.approximate) @ np.abs(scaled).sum(axis=1)
            norm = np.max(rest + (size + 8) * 2 * HALF_ULP * (rounding + 1.0), initial=0.0)
        self.norm = float(norm) if np.isfinite(norm) else inf

    @property
    def proved(self) -> bool:
        """Whether it is near enough to its own inverse to be used."""
        return self.norm <= REPAIRABLE

    def solved(self, forces: FloatArray) -> FloatArray:
        """The inverse times forces, about."""
        return np.asarray(self.lengths * (self.approximate @ (self.lengths * forces)))

    def bound(self, forces: FloatArray) -> FloatArray:
        """The sizes of the exact inverse times r at most, for |r| ≤ forces."""
        reach = np.abs(self.approximate) @ (self.lengths * forces) * (1.0 + len(forces) * 2 * HALF_ULP)
        reach = reach + self.norm / (1.0 - self.norm) * reach.max(initial=0.0)
        return np.asarray(self.lengths * reach * (1.0 + SUMS))
