"""Many small cones: numbers ≥ 0, then triples (u₀, u₁, u₂) with |(u₁, u₂)| ≤ u₀, in one vector."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

REFLECTION = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True)
class SmallScaling:
    """The scaling of Nesterov and Todd: W z = W⁻¹ s = ``point``, cone by cone.

    Attributes
    ----------
    point : (k + 3j,)
        The scaled point.
    diagonal : (k,)
        W on the numbers ≥ 0.
    axes : (j, 3)
        The unit vector w of every triple, w₀² − w₁² − w₂² = 1.
    factors : (j,)
        W on a triple is its factor times the hyperbolic rotation to w.
    """

    point: FloatArray
    diagonal: FloatArray
    axes: FloatArray
    factors: FloatArray

    def times(self, vector: FloatArray) -> FloatArray:
        """W · vector."""
        k = len(self.diagonal)
        turned = self.factors[:, None] * _turned(self.axes, vector[k:].reshape(-1, 3))
        return np.concatenate([self.diagonal * vector[:k], turned.ravel()])

    def divided(self, vector: FloatArray) -> FloatArray:
        """W⁻¹ · vector."""
        k = len(self.diagonal)
        back = _turned(self.axes @ REFLECTION, vector[k:].reshape(-1, 3)) / self.factors[:, None]
        return np.concatenate([vector[:k] / self.diagonal, back.ravel()])

    def inverse_squares(self) -> FloatArray:
        """W⁻² on every triple, (j, 3, 3)."""
        w = self.axes @ REFLECTION
        return (2.0 * w[:, :, None] * w[:, None, :] - REFLECTION) / (self.factors**2)[:, None, None]


@dataclass(frozen=True)
class SmallCones:
    """``positive`` numbers ≥ 0, then ``triples`` second-order cones of three.

    Examples
    --------
    >>> cones = SmallCones(1, 1)
    >>> cones.margin(np.array([2.0, 5.0, 3.0, 4.0]))
    0.0
    """

    positive: int
    triples: int

    @property
    def degree(self) -> int:
        """What slack · multiplier is divided by for its mean."""
        return self.positive + self.triples

    @property
    def unit(self) -> FloatArray:
        """e with e ∘ u = u."""
        e = np.zeros(self.positive + 3 * self.triples)
        e[: self.positive] = 1.0
        e[self.positive :: 3] = 1.0
        return e

    def parts(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The numbers (k,) and the triples (j, 3), as views."""
        return u[: self.positive], u[self.positive :].reshape(-1, 3)

    def margin(self, u: FloatArray) -> float:
        """The largest t with u − t e inside."""
        head, triples = self.parts(u)
        rooms = triples[:, 0] - _lengths(triples)
        return float(min(head.min(initial=np.inf), rooms.min(initial=np.inf)))

    def product(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """u ∘ v, the product of Jordan."""
        found = u * v
        (_, a), (_, b), (_, c) = self.parts(u), self.parts(v), self.parts(found)
        c[:, 0] = np.einsum("jk,jk->j", a, b)
        c[:, 1:] = a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:]
        return found

    def quotient(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """x with u ∘ x = v, for u inside."""
        found = v / u
        (_, a), (_, b), (_, c) = self.parts(u), self.parts(v), self.parts(found)
        c[:, 0] = np.einsum("jk,jk->j", a @ REFLECTION, b) / _determinants(a)
        c[:, 1:] = (b[:, 1:] - c[:, :1] * a[:, 1:]) / a[:, :1]
        return found

    def reach(self, u: FloatArray, step: FloatArray) -> float:
        """The largest t with u + t · step inside, for u inside; inf where every t is."""
        (head, a), (down, b) = self.parts(u), self.parts(step)
        falling = down < 0
        least = float(np.min(-head[falling] / down[falling], initial=np.inf))
        return min(least, float(_cone_reaches(a, b).min(initial=np.inf)))

    def scaling(self, slack: FloatArray, multiplier: FloatArray) -> SmallScaling:
        """The scaling in which slack and multiplier are the same point."""
        (head, s), (weights, z) = self.parts(slack), self.parts(multiplier)
        size_s, size_z = np.sqrt(_determinants(s)), np.sqrt(_determinants(z))
        s, unit_z = s / size_s[:, None], z / size_z[:, None]
        along = 1.0 + np.einsum("jk,jk->j", s, unit_z)
        axes = (s + unit_z @ REFLECTION) / np.sqrt(2.0 * along)[:, None]
        factors = np.sqrt(size_s / size_z)
        tail = factors[:, None] * _turned(axes, z)
        point = np.concatenate([np.sqrt(head * weights), tail.ravel()])
        return SmallScaling(point, np.sqrt(head / weights), axes, factors)


def _lengths(triples: FloatArray) -> FloatArray:
    return np.hypot(triples[:, 1], triples[:, 2])


def _determinants(u: FloatArray) -> FloatArray:
    """u₀² − u₁² − u₂², without cancellation."""
    length = _lengths(u)
    return (u[:, 0] - length) * (u[:, 0] + length)


def _turned(axes: FloatArray, u: FloatArray) -> FloatArray:
    """The hyperbolic rotation that takes the unit vector to the axis, applied to every triple."""
    along = np.einsum("jk,jk->j", axes[:, 1:], u[:, 1:])
    found = np.empty_like(u)
    found[:, 0] = axes[:, 0] * u[:, 0] + along
    found[:, 1:] = u[:, 1:] + axes[:, 1:] * (u[:, 0] + along / (1.0 + axes[:, 0]))[:, None]
    return found


def _cone_reaches(u: FloatArray, step: FloatArray) -> FloatArray:
    """Where u + t · step leaves its cone: the smallest positive root of its determinant."""
    mirrored = step @ REFLECTION
    a, b, c = np.einsum("jk,jk->j", mirrored, step), np.einsum("jk,jk->j", mirrored, u), _determinants(u)
    root = b * b - a * c
    for_ever = (root < 0) | ((a >= 0) & (b >= 0))
    root = np.sqrt(np.where(for_ever, 0.0, root))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.where(b < 0, c / (root - b), (-b - root) / a)
    return np.where(for_ever, np.inf, found)
