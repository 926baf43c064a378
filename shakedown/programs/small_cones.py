"""Many small cones: triples (u₀, u₁, u₂), |(u₁, u₂)| ≤ u₀, then numbers ≥ 0 and one large cone or none."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shakedown.ground.size_limits import CONE
from shakedown.programs.symmetric_cone import FloatArray, Scaling, SymmetricCone

MIRROR = np.array([1.0, -1.0, -1.0])


@dataclass(frozen=True)
class SmallScaling:
    """The scaling of Nesterov and Todd, cone by cone: W z = W⁻¹ s = ``point``.

    Attributes
    ----------
    axis : (j, 3)
        The unit vector w of every triple, w₀² − w₁² − w₂² = 1.
    factor : (j, 1)
        W on a triple is its factor times the hyperbolic rotation to w.
    rest
        The scaling of the other numbers.
    point : (3j + …,)
        The scaled point.
    """

    axis: FloatArray
    factor: FloatArray
    rest: Scaling
    point: FloatArray

    @cached_property
    def _back(self) -> FloatArray:
        """The axis of W⁻¹."""
        return _mirrored(self.axis)

    def times(self, vector: FloatArray) -> FloatArray:
        """W · vector."""
        triples, others = _split(vector, len(self.axis))
        return _joined(self.factor * _turned(self.axis, triples), self.rest.times(others))

    def divided(self, vector: FloatArray) -> FloatArray:
        """W⁻¹ · vector."""
        triples, others = _split(vector, len(self.axis))
        return _joined(_turned(self._back, triples) / self.factor, self.rest.divided(others))

    def divided_twice(self, vector: FloatArray) -> FloatArray:
        """W⁻² · vector, factor by factor."""
        triples, others = _split(vector, len(self.axis))
        once = _turned(self._back, triples) / self.factor
        return _joined(_turned(self._back, once) / self.factor, self.rest.divided(self.rest.divided(others)))

    def inverses(self) -> FloatArray:
        """W⁻¹ on every triple, (j, 3, 3)."""
        w = self._back
        found = np.eye(CONE) + w[:, :, None] * w[:, None, :] / (1.0 + w[:, :1, None])
        found[:, 0], found[:, :, 0] = w, w
        return np.asarray(found / self.factor[:, :, None])

    def inverse_squares(self) -> FloatArray:
        """W⁻² on every triple, (j, 3, 3)."""
        w = self._back
        squares = 2.0 * w[:, :, None] * w[:, None, :] + np.eye(CONE)
        squares[:, 0, 0] -= 2.0
        return squares / self.factor[:, :, None] ** 2


@dataclass(frozen=True)
class SmallCones:
    """``triples`` second-order cones of three numbers, then a symmetric cone.

    Examples
    --------
    >>> cones = SmallCones(1, SymmetricCone(1))
    >>> cones.margin(np.array([5.0, 3.0, 4.0, 2.0])), cones.degree
    (0.0, 2)
    """

    triples: int
    rest: SymmetricCone

    @property
    def degree(self) -> int:
        """What slack · multiplier is divided by for its mean."""
        return self.triples + self.rest.degree

    @cached_property
    def unit(self) -> FloatArray:
        """e with e ∘ u = u."""
        return _joined(np.tile([1.0, 0.0, 0.0], (self.triples, 1)), self.rest.unit)

    def parts(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The triples (j, 3) and the other numbers, as views."""
        return _split(u, self.triples)

    def margin(self, u: FloatArray) -> float:
        """The largest t with u − t e inside."""
        triples, others = _split(u, self.triples)
        return float(min(np.min(triples[:, 0] - _length(triples), initial=np.inf), self.rest.margin(others)))

    def product(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """u ∘ v, the product of Jordan."""
        (a, a_rest), (b, b_rest) = _split(u, self.triples), _split(v, self.triples)
        found = a[:, :1] * b + b[:, :1] * a
        found[:, 0] = np.einsum("ij,ij->i", a, b)
        return _joined(found, self.rest.product(a_rest, b_rest))

    def quotient(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """x with u ∘ x = v, for u inside."""
        (a, a_rest), (b, b_rest) = _split(u, self.triples), _split(v, self.triples)
        found = np.empty_like(a)
        found[:, 0] = np.einsum("ij,ij->i", _mirrored(a), b) / _determinant(a)
        found[:, 1:] = (b[:, 1:] - found[:, :1] * a[:, 1:]) / a[:, :1]
        return _joined(found, self.rest.quotient(a_rest, b_rest))

    def reach(self, u: FloatArray, step: FloatArray) -> float:
        """The largest t with u + t · step inside, for u inside; inf where every t is."""
        return self.reach_from(u)(step)

    def reach_from(self, u: FloatArray) -> Callable[[FloatArray], float]:
        """:meth:`reach` of steps from one point."""
        a, a_rest = _split(u, self.triples)
        size = np.sqrt(_determinant(a))[:, None]
        axis = _mirrored(a / size)

        def reach(step: FloatArray) -> float:
            b, b_rest = _split(step, self.triples)
            seen = _turned(axis, b) / size
            with np.errstate(divide="ignore"):
                ends = 1.0 / np.maximum(_length(seen) - seen[:, 0], 0.0)
            return float(min(np.min(ends, initial=np.inf), self.rest.reach(a_rest, b_rest)))

        return reach

    def scaling(self, slack: FloatArray, multiplier: FloatArray) -> SmallScaling:
        """The scaling in which slack and multiplier are the same point."""
        (s, s_rest), (z, z_rest) = _split(slack, self.triples), _split(multiplier, self.triples)
        size_s, size_z = (np.sqrt(_determinant(part))[:, None] for part in (s, z))
        unit_s, unit_z = s / size_s, z / size_z
        together = np.einsum("ij,ij->i", unit_s, unit_z)[:, None]
        axis = (unit_s + _mirrored(unit_z)) / np.sqrt(2.0 * (1.0 + together))
        factor = np.sqrt(size_s / size_z)
        rest = self.rest.scaling(s_rest, z_rest)
        return SmallScaling(axis, factor, rest, _joined(factor * _turned(axis, z), rest.point))


def _split(u: FloatArray, triples: int) -> tuple[FloatArray, FloatArray]:
    return u[: CONE * triples].reshape(-1, CONE), u[CONE * triples :]


def _joined(triples: FloatArray, rest: FloatArray) -> FloatArray:
    return np.concatenate([triples.ravel(), rest])


def _length(u: FloatArray) -> FloatArray:
    return np.sqrt(u[:, 1] ** 2 + u[:, 2] ** 2)


def _determinant(u: FloatArray) -> FloatArray:
    """u₀² − u₁² − u₂², without cancellation."""
    length = _length(u)
    return (u[:, 0] - length) * (u[:, 0] + length)


def _mirrored(u: FloatArray) -> FloatArray:
    return u * MIRROR


def _turned(axis: FloatArray, u: FloatArray) -> FloatArray:
    """The hyperbolic rotations that take the unit vector to the axes, applied to the rows of u."""
    along = axis[:, 1] * u[:, 1] + axis[:, 2] * u[:, 2]
    found = u + axis * (u[:, 0] + along / (1.0 + axis[:, 0]))[:, None]
    found[:, 0] = np.einsum("ij,ij->i", axis, u)
    return found
