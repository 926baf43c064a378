"""The cone of a program: numbers ≥ 0, and at most one second-order cone behind them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Scaling:
    """The scaling of Nesterov and Todd: W z = W⁻¹ s = ``point``, for a slack s and a multiplier z inside.

    Attributes
    ----------
    point : (k + q,)
        The scaled point λ.
    diagonal : (k,)
        W on the numbers ≥ 0.
    axis : (q,)
        The unit vector w of the second-order cone, w₀² − |w₁|² = 1.
    factor
        W on the second-order cone is ``factor`` times the hyperbolic reflection of w.
    """

    point: FloatArray
    diagonal: FloatArray
    axis: FloatArray
    factor: float

    @cached_property
    def _back(self) -> FloatArray:
        """The axis of W⁻¹."""
        return _mirrored(self.axis)

    def times(self, vector: FloatArray) -> FloatArray:
        """W · vector."""
        k = len(self.diagonal)
        if not self.axis.size:
            return self.diagonal * vector
        return np.concatenate([self.diagonal * vector[:k], self.factor * _turned(self.axis, vector[k:])])

    def divided(self, vector: FloatArray) -> FloatArray:
        """W⁻¹ · vector."""
        k = len(self.diagonal)
        if not self.axis.size:
            return vector / self.diagonal
        return np.concatenate([vector[:k] / self.diagonal, _turned(self._back, vector[k:]) / self.factor])

    def inverse(self) -> FloatArray:
        """W⁻¹ on the second-order cone, (q, q)."""
        w = self._back
        found = np.eye(len(w)) + np.outer(w, w) / (1.0 + w[0])
        found[0] = found[:, 0] = w
        return found / self.factor

    def inverse_square(self) -> FloatArray:
        """W⁻² on the second-order cone, (q, q)."""
        w = self._back
        square = 2.0 * np.outer(w, w) + np.eye(len(w))
        square[:1, :1] -= 2.0
        return square / self.factor**2


@dataclass(frozen=True)
class SymmetricCone:
    """``positive`` numbers ≥ 0, then a vector (u₀, u₁) of ``second_order`` numbers with |u₁| ≤ u₀.

    Examples
    --------
    >>> cone = SymmetricCone(1, 3)
    >>> cone.margin(np.array([2.0, 5.0, 3.0, 4.0]))
    0.0
    """

    positive: int
    second_order: int = 0

    @property
    def degree(self) -> int:
        """What slack · multiplier is divided by for its mean."""
        return self.positive + bool(self.second_order)

    @property
    def unit(self) -> FloatArray:
        """e with e ∘ u = u."""
        e = np.zeros(self.positive + self.second_order)
        e[: self.positive + bool(self.second_order)] = 1.0
        return e

    def margin(self, u: FloatArray) -> float:
        """The largest t with u − t e inside."""
        head, tail = u[: self.positive], u[self.positive :]
        least = float(head.min(initial=np.inf))
        return min(least, float(tail[0] - np.linalg.norm(tail[1:]))) if self.second_order else least

    def product(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """u ∘ v, the product of Jordan."""
        found, k = u * v, self.positive
        if self.second_order:
            found[k] = u[k:] @ v[k:]
            found[k + 1 :] = u[k] * v[k + 1 :] + v[k] * u[k + 1 :]
        return found

    def quotient(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """x with u ∘ x = v, for u inside."""
        found, k = v / u, self.positive
        if self.second_order:
            tail, right = u[k:], v[k:]
            first = (tail[0] * right[0] - tail[1:] @ right[1:]) / _determinant(tail)
            found[k], found[k + 1 :] = first, (right[1:] - first * tail[1:]) / tail[0]
        return found

    def reach(self, u: FloatArray, step: FloatArray) -> float:
        """The largest t with u + t · step inside, for u inside; inf where every t is."""
        k = self.positive
        falling = step[:k] < 0
        least = float(np.min(-u[:k][falling] / step[:k][falling], initial=np.inf))
        return min(least, _cone_reach(u[k:], step[k:])) if self.second_order else least

    def scaling(self, slack: FloatArray, multiplier: FloatArray) -> Scaling:
        """The scaling in which slack and multiplier are the same point."""
        k = self.positive
        head, diagonal = np.sqrt(slack[:k] * multiplier[:k]), np.sqrt(slack[:k] / multiplier[:k])
        if not self.second_order:
            return Scaling(head, diagonal, np.zeros(0), 1.0)
        s, z = slack[k:], multiplier[k:]
        size_s, size_z = np.sqrt(_determinant(s)), np.sqrt(_determinant(z))
        s, z = s / size_s, z / size_z
        axis = (s + _mirrored(z)) / np.sqrt(2.0 * (1.0 + s @ z))
        factor = float(np.sqrt(size_s / size_z))
        tail = factor * _turned(axis, z * size_z)
        return Scaling(np.concatenate([head, tail]), diagonal, axis, factor)


def _determinant(u: FloatArray) -> float:
    """u₀² − |u₁|², without cancellation."""
    length = float(np.linalg.norm(u[1:]))
    return float((u[0] - length) * (u[0] + length))


def _mirrored(u: FloatArray) -> FloatArray:
    found = -u
    found[:1] = u[:1]
    return found


def _turned(axis: FloatArray, u: FloatArray) -> FloatArray:
    """The hyperbolic rotation that takes the unit vector to the axis, applied to u."""
    along = axis[1:] @ u[1:]
    found = u + axis * (u[0] + along / (1.0 + axis[0]))
    found[0] = axis @ u
    return found


def _cone_reach(u: FloatArray, step: FloatArray) -> float:
    """Where u + t · step leaves |u₁| ≤ u₀: seen from u as the unit vector, at 1 / (|step₁| − step₀).

    The roots of the determinant lose that where step and u are parallel.
    """
    size = np.sqrt(_determinant(u))
    seen = _turned(_mirrored(u / size), step) / size
    falling = float(np.linalg.norm(seen[1:]) - seen[0])
    return 1.0 / falling if falling > 0 else np.inf
