"""The cone of many discs: second-order cones of three numbers each, then numbers ≥ 0 and a larger cone."""

from dataclasses import dataclass

import numpy as np

from shakedown.programs.interior.symmetric_cone import FloatArray, Scaling, SymmetricCone

SIZE = 3  # numbers of a disc: its radius, then a vector in the plane


@dataclass(frozen=True)
class DiscScaling:
    """The scaling of Nesterov and Todd of every disc and of the rest: W z = W⁻¹ s = ``point``.

    Attributes
    ----------
    axis : (K, 3)
        The unit vectors w of the discs, w₀² − |w₁|² = 1.
    factor : (K, 1)
        W of a disc is its factor times the hyperbolic reflection of its w.
    rest
        The scaling of the other numbers.
    point : (3K + …,)
        The scaled point.
    """

    axis: FloatArray
    factor: FloatArray
    rest: Scaling
    point: FloatArray

    def times(self, vector: FloatArray) -> FloatArray:
        """W · vector."""
        discs, others = _split(vector, len(self.axis))
        return _joined(self.factor * _turned(self.axis, discs), self.rest.times(others))

    def divided(self, vector: FloatArray) -> FloatArray:
        """W⁻¹ · vector."""
        discs, others = _split(vector, len(self.axis))
        return _joined(_turned(_mirrored(self.axis), discs) / self.factor, self.rest.divided(others))

    def inverse_squares(self) -> FloatArray:
        """W⁻² of every disc, (K, 3, 3)."""
        w = _mirrored(self.axis)
        squares = 2.0 * w[:, :, None] * w[:, None, :] + np.eye(SIZE)
        squares[:, 0, 0] -= 2.0
        return squares / self.factor[:, :, None] ** 2


@dataclass(frozen=True)
class DiscCones:
    """``discs`` vectors (u₀, u₁) of three numbers with |u₁| ≤ u₀, then a symmetric cone.

    Examples
    --------
    >>> cones = DiscCones(1, SymmetricCone(1))
    >>> cones.margin(np.array([5.0, 3.0, 4.0, 2.0])), cones.degree
    (0.0, 2)
    """

    discs: int
    rest: SymmetricCone

    @property
    def degree(self) -> int:
        """What slack · multiplier is divided by for its mean."""
        return self.discs + self.rest.degree

    @property
    def unit(self) -> FloatArray:
        """e with e ∘ u = u."""
        return _joined(np.tile([1.0, 0.0, 0.0], (self.discs, 1)), self.rest.unit)

    def margin(self, u: FloatArray) -> float:
        """The largest t with u − t e inside."""
        discs, others = _split(u, self.discs)
        return float(min(np.min(discs[:, 0] - _length(discs), initial=np.inf), self.rest.margin(others)))

    def product(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """u ∘ v, the product of Jordan."""
        (a, a_rest), (b, b_rest) = _split(u, self.discs), _split(v, self.discs)
        found = a[:, :1] * b + b[:, :1] * a
        found[:, 0] = np.einsum("ij,ij->i", a, b)
        return _joined(found, self.rest.product(a_rest, b_rest))

    def quotient(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """x with u ∘ x = v, for u inside."""
        (a, a_rest), (b, b_rest) = _split(u, self.discs), _split(v, self.discs)
        found = np.empty_like(a)
        found[:, 0] = np.einsum("ij,ij->i", _mirrored(a), b) / _determinant(a)
        found[:, 1:] = (b[:, 1:] - found[:, :1] * a[:, 1:]) / a[:, :1]
        return _joined(found, self.rest.quotient(a_rest, b_rest))

    def reach(self, u: FloatArray, step: FloatArray) -> float:
        """The largest t with u + t · step inside, for u inside; inf where every t is."""
        (a, a_rest), (b, b_rest) = _split(u, self.discs), _split(step, self.discs)
        square, half = _form(b, b), _form(a, b)
        root = half**2 - square * _determinant(a)
        with np.errstate(divide="ignore", invalid="ignore"):
            width = np.sqrt(root)
            ends = np.where(half < 0, _determinant(a) / (width - half), -(half + width) / square)
        ends = np.where((root < 0) | ((square >= 0) & (half >= 0)), np.inf, ends)
        return float(min(np.min(ends, initial=np.inf), self.rest.reach(a_rest, b_rest)))

    def scaling(self, slack: FloatArray, multiplier: FloatArray) -> DiscScaling:
        """The scaling in which slack and multiplier are the same point."""
        (s, s_rest), (z, z_rest) = _split(slack, self.discs), _split(multiplier, self.discs)
        size_s, size_z = (np.sqrt(_determinant(part))[:, None] for part in (s, z))
        unit_s, unit_z = s / size_s, z / size_z
        together = np.einsum("ij,ij->i", unit_s, unit_z)[:, None]
        axis = (unit_s + _mirrored(unit_z)) / np.sqrt(2.0 * (1.0 + together))
        factor = np.sqrt(size_s / size_z)
        rest = self.rest.scaling(s_rest, z_rest)
        return DiscScaling(axis, factor, rest, _joined(factor * _turned(axis, z), rest.point))


def _split(u: FloatArray, discs: int) -> tuple[FloatArray, FloatArray]:
    return u[: SIZE * discs].reshape(-1, SIZE), u[SIZE * discs :]


def _joined(discs: FloatArray, rest: FloatArray) -> FloatArray:
    return np.concatenate([discs.ravel(), rest])


def _length(u: FloatArray) -> FloatArray:
    return np.sqrt(u[:, 1] ** 2 + u[:, 2] ** 2)


def _determinant(u: FloatArray) -> FloatArray:
    """u₀² − |u₁|², without cancellation."""
    length = _length(u)
    return (u[:, 0] - length) * (u[:, 0] + length)


def _form(u: FloatArray, v: FloatArray) -> FloatArray:
    return u[:, 0] * v[:, 0] - u[:, 1] * v[:, 1] - u[:, 2] * v[:, 2]


def _mirrored(u: FloatArray) -> FloatArray:
    return u * np.array([1.0, -1.0, -1.0])


def _turned(axis: FloatArray, u: FloatArray) -> FloatArray:
    """The hyperbolic rotations that take the unit vector to the axes, applied to the rows of u."""
    along = np.einsum("ij,ij->i", axis[:, 1:], u[:, 1:])[:, None]
    found = u + axis * (u[:, :1] + along / (1.0 + axis[:, :1]))
    found[:, 0] = np.einsum("ij,ij->i", axis, u)
    return found
