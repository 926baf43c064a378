"""Second-order cones |u₁| ≤ u₀ of three numbers, of one, and a large one, with Nesterov–Todd scaling.

A vector lists the cones of three numbers, then those of one (numbers ≥ 0), then the large one (F. Alizadeh
and D. Goldfarb, Math. Program. 95, 2003, 3; Y. E. Nesterov and M. J. Todd, Math. Oper. Res. 22, 1997, 1).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import CONE, FloatArray


@dataclass(frozen=True)
class Scaling:
    """The scaling W of Nesterov and Todd: W z = W⁻¹ s = ``point``, for a slack s and a multiplier z inside.

    Attributes
    ----------
    cones
        The cones.
    axis : (N,)
        The unit vector w of every cone, w₀² − |w₁|² = 1.
    factor : (c,)
        On a cone W is its factor times the hyperbolic rotation that takes the unit vector to w.
    point : (N,)
        The scaled point.
    """

    cones: "Cones"
    axis: FloatArray
    factor: FloatArray
    point: FloatArray

    @cached_property
    def _back(self) -> FloatArray:
        """The axis of W⁻¹."""
        return self.axis * self.cones.mirror

    @cached_property
    def _spread(self) -> FloatArray:
        return self.factor[self.cones.cone]

    def times(self, vector: FloatArray) -> FloatArray:
        """W · vector."""
        return self._spread * self.cones.rotated(self.axis, vector)

    def divided(self, vector: FloatArray) -> FloatArray:
        """W⁻¹ · vector."""
        return np.asarray(self.cones.rotated(self._back, vector) / self._spread)

    @property
    def of_numbers(self) -> FloatArray:
        """W on the cones of one number, (k, 1)."""
        return self.factor[self.cones.triples :][: self.cones.numbers, None]

    @property
    def of_large(self) -> tuple[FloatArray, float]:
        """Axis and factor of the large cone."""
        return self.axis[-self.cones.large :], float(self.factor[-1])

    def inverses(self) -> FloatArray:
        """W⁻¹ on the cones of three numbers, (j, 3, 3)."""
        w = self.cones.parts(self._back)[0]
        return _rotation(w) / self.factor[: len(w), None, None]

    def inverse_squares(self) -> FloatArray:
        """W⁻² on the cones of three numbers, (j, 3, 3)."""
        w = self.cones.parts(self._back)[0]
        return _squared_rotation(w) / self.factor[: len(w), None, None] ** 2

    def inverse_of_large(self) -> FloatArray:
        """W⁻¹ on the large cone, (q, q)."""
        return np.asarray(_rotation(self.cones.parts(self._back)[2][None])[0] / self.factor[-1])


@dataclass(frozen=True)
class Cones:
    """``triples`` cones of three numbers, ``numbers`` of one, then one of ``large`` numbers, or none for 0.

    Examples
    --------
    >>> cones = Cones(1, 1)
    >>> cones.margin(np.array([5.0, 3.0, 4.0, 2.0])), cones.degree
    (0.0, 2)
    """

    triples: int
    numbers: int
    large: int = 0

    @cached_property
    def degree(self) -> int:
        """The number of cones: what slack · multiplier is divided by for its mean."""
        return self.triples + self.numbers + bool(self.large)

    @cached_property
    def _sizes(self) -> list[int]:
        return [CONE] * self.triples + [1] * self.numbers + [self.large] * bool(self.large)

    @cached_property
    def heads(self) -> NDArray[np.intp]:
        """The place of u₀ of every cone, (c,)."""
        return np.cumsum([0, *self._sizes[:-1]], dtype=np.intp)[: self.degree]

    @cached_property
    def cone(self) -> NDArray[np.intp]:
        """The cone of every number, (N,)."""
        return np.repeat(np.arange(self.degree), self._sizes)

    @cached_property
    def unit(self) -> FloatArray:
        """e with e ∘ u = u: 1 at every u₀, else 0."""
        e = np.zeros(sum(self._sizes))
        e[self.heads] = 1.0
        return e

    @cached_property
    def mirror(self) -> FloatArray:
        """1 at every u₀, else −1."""
        return 2.0 * self.unit - 1.0

    @cached_property
    def _tail(self) -> FloatArray:
        return 1.0 - self.unit

    def parts(self, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The cones of three numbers (j, 3), those of one (k,), the large one (q,), as views."""
        first = CONE * self.triples
        last = first + self.numbers
        return u[:first].reshape(-1, CONE), u[first:last], u[last:]

    def _sums(self, u: FloatArray) -> FloatArray:
        return np.asarray(np.add.reduceat(u, self.heads) if self.degree else u)

    def _lengths(self, u: FloatArray) -> FloatArray:
        tail = u * self._tail
        return np.sqrt(self._sums(tail * tail))

    def _sizes_of(self, u: FloatArray) -> FloatArray:
        """The root of u₀² − |u₁|², without cancellation."""
        first, length = u[self.heads], self._lengths(u)
        return np.asarray(np.sqrt((first - length) * (first + length)))

    def margin(self, u: FloatArray) -> float:
        """The largest t with u − t e inside."""
        return float(np.min(u[self.heads] - self._lengths(u), initial=np.inf))

    def product(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """u ∘ v, the product of Jordan."""
        found = u[self.heads][self.cone] * v + v[self.heads][self.cone] * u
        found[self.heads] = self._sums(u * v)
        return found

    def quotient(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """x with u ∘ x = v, for u inside."""
        first = self._sums(self.mirror * u * v) / self._sizes_of(u) ** 2
        found = (v - first[self.cone] * u) / u[self.heads][self.cone]
        found[self.heads] = first
        return found

    def rotated(self, axis: FloatArray, u: FloatArray) -> FloatArray:
        """The hyperbolic rotations that take unit vectors to the axes, applied to u."""
        along, first, of_axis = self._sums(axis * u * self._tail), u[self.heads], axis[self.heads]
        found = u + axis * (first + along / (1.0 + of_axis))[self.cone]
        found[self.heads] = of_axis * first + along
        return np.asarray(found)

    def reach(self, u: FloatArray, step: FloatArray) -> float:
        """The largest t with u + t · step inside, for u inside; inf where every t is."""
        return self.reach_from(u)(step)

    def reach_from(self, u: FloatArray) -> Callable[[FloatArray], float]:
        """:meth:`reach` of steps from one point.

        Seen from u as the unit vector a step leaves the cone at 1 / (|step₁| − step₀): the roots of the
        determinant lose that where step and u are parallel.
        """
        sizes = self._sizes_of(u)
        axis = u * self.mirror / sizes[self.cone]

        def reach(step: FloatArray) -> float:
            seen = self.rotated(axis, step)
            nearness = float(np.max((self._lengths(seen) - seen[self.heads]) / sizes, initial=0.0))
            return 1.0 / nearness if nearness > 0 else np.inf

        return reach

    def scaling(self, slack: FloatArray, multiplier: FloatArray) -> Scaling:
        """The scaling in which slack and multiplier are the same point."""
        size_s, size_z = self._sizes_of(slack), self._sizes_of(multiplier)
        s, z = slack / size_s[self.cone], multiplier / size_z[self.cone]
        axis = (s + self.mirror * z) / np.sqrt(2.0 * (1.0 + self._sums(s * z)))[self.cone]
        factor = np.sqrt(size_s / size_z)
        return Scaling(self, axis, factor, factor[self.cone] * self.rotated(axis, multiplier))


def _rotation(axis: FloatArray) -> FloatArray:
    """The hyperbolic rotations to the axes (c, q) as matrices, (c, q, q)."""
    found = np.eye(axis.shape[1]) + axis[:, :, None] * axis[:, None, :] / (1.0 + axis[:, :1, None])
    found[:, 0], found[:, :, 0] = axis, axis
    return np.asarray(found)


def _squared_rotation(axis: FloatArray) -> FloatArray:
    squares = 2.0 * axis[:, :, None] * axis[:, None, :] + np.eye(axis.shape[1])
    squares[:, 0, 0] -= 2.0
    return np.asarray(squares)
