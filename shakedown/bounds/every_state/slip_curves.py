"""What slip of a node in any direction asks of its reaction, so that it costs energy: a curve."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.least_pressures import LeastPressures
from shakedown.bounds.every_state.scaled_joint import ScaledJoint
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS, NEGLIGIBLE, NEWTON_ROUNDS, ROUND_OFF, THREE_DIGITS


@dataclass(frozen=True)
class SlipCurves:
    """The points g(u) u of some nodes, u being a direction in which the node slips (statement 6.4).

    With g(u) = size + lean · u a node that slips along u has g(u) p ≥ π. With one direction the curve is
    two points, with two a limaçon.

    Attributes
    ----------
    size : (k,)
        |1 − f h_i| [–].
    lean : (k, d)
        f Y_i, by the multipliers of the node itself [–].
    loose : (k,)
        How far off these numbers may be, together [–].
    """

    size: FloatArray
    lean: FloatArray
    loose: FloatArray

    def part(self, nodes: NDArray[np.intp]) -> "SlipCurves":
        """Those of some of the nodes."""
        return SlipCurves(self.size[nodes], self.lean[nodes], self.loose[nodes])

    @property
    def length(self) -> FloatArray:
        """|lean|, (k,)."""
        return np.asarray(np.linalg.norm(self.lean, axis=-1))

    def point(self, u: FloatArray) -> FloatArray:
        """g(u) u of unit vectors (…, k, d)."""
        return np.asarray((self.size + np.sum(self.lean * u, axis=-1))[..., None] * u)

    def reach(self, y: FloatArray) -> FloatArray:
        """The largest y · t over the points t of every curve, of vectors (…, k, d): (…, k).

        With two directions the largest g(u) u · y is the least value, over ν > 0, of
        |y| (ν + c cos²ψ + γ² cos²ψ / 4ν + γ² sin²ψ / 4(ν + c)), where γ is the size, c = |lean| and
        2ψ the angle between lean and y (the dual of a quadratic form on the unit circle). Every ν is a bound.
        """
        if self.lean.shape[-1] == 1:
            return np.asarray(self.size * np.abs(y[..., 0]) + self.lean[:, 0] * y[..., 0])
        angle, along, across, nu = self._dual(y)
        beside = nu + self.length
        largest = self.length * np.cos(angle) ** 2 + nu + along**2 / nu + across**2 / beside
        return np.asarray(np.hypot(y[..., 0], y[..., 1]) * largest)

    def farthest(self, y: FloatArray) -> FloatArray:
        """The point t that :meth:`reach` reaches, (…, k, d)."""
        if self.lean.shape[-1] == 1:
            return self.point(np.where(y < 0, -1.0, 1.0))
        angle, _, across, nu = self._dual(y)
        beyond = np.arcsin(np.clip(across / (nu + self.length), -1.0, 1.0))
        return self.point(_unit(np.arctan2(y[..., 1], y[..., 0]) - angle + beyond))

    def around(self) -> FloatArray:
        """d + 1 points of every curve with the origin between them, (d + 1, k, d)."""
        if self.lean.shape[-1] == 1:
            return self.point(np.tile([[[1.0]], [[-1.0]]], (1, len(self.size), 1)))
        along = np.arctan2(self.lean[:, 1], self.lean[:, 0])
        aside = np.arccos(-np.minimum(0.5, 0.5 * self.size / np.maximum(self.length, 0.5 * self.size)))
        return self.point(_unit(np.stack([along, along + aside, along - aside])))

    def _dual(self, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """ψ, γ cos ψ / 2, γ sin ψ / 2 and the best ν, each (…, k): where both terms' slopes add to 1."""
        x, length = self.lean, self.length
        angle = 0.5 * np.arctan2(x[:, 0] * y[..., 1] - x[:, 1] * y[..., 0], np.sum(x * y, axis=-1))
        along, across = 0.5 * self.size * np.cos(angle), 0.5 * self.size * np.sin(angle)
        least = np.maximum(np.maximum(along, np.abs(across) - length), ROUND_OFF * self.size)
        nu = least
        for _ in range(NEWTON_ROUNDS):
            first, second = along / nu, across / (nu + length)
            square = first**2 + second**2
            slope = first**2 / nu + second**2 / (nu + length)
            before, nu = nu, np.maximum(nu + square * (np.sqrt(square) - 1.0) / slope, least)
            if (np.abs(nu - before) <= NEGLIGIBLE * nu).all():
                break
        return angle, along, across, nu


def slip_curves(joint: ScaledJoint, least: LeastPressures) -> SlipCurves:
    """The curves of all nodes; circles |t| = 1 (statement 6.3) where a curve nearly leaves the origin out."""
    every, f = np.arange(joint.n), joint.f
    lean = f[:, None] * least.multipliers.reshape(joint.n, joint.n, joint.d)[every, every]
    own = f * least.weights[every, every]
    size, long = np.abs(1.0 - own), np.linalg.norm(lean, axis=1)
    inside = size - long * (joint.d == 1) > THREE_DIGITS * (1.0 + long)
    return SlipCurves(
        size=np.where(inside, size, 1.0),
        lean=np.where(inside[:, None], lean, 0.0),
        loose=np.where(inside, f * least.error + 8 * EPS * (1.0 + own + long), 8 * EPS),
    )


def _unit(angle: FloatArray) -> FloatArray:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
