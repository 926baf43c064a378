"""What slip in any direction asks of a reaction, when it is known how slip itself presses the node."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.least_pressures import LeastPressures
from shakedown.bounds.every_state.scaled_joint import ScaledJoint
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS

ROUND = 0.05  # least |1 − f h| at which a disc leans: below it nearly degenerates
MOST = 2.0  # size of a disc up to which the round-off of a reach is bounded


@dataclass(frozen=True)
class LeaningDiscs:
    """Discs of which the centre leans away: one of each of some nodes (docs/universal.md, statement 6.4).

    Attributes
    ----------
    lean : (c, 2)
        f Y_i, by the multipliers of the node itself [–].
    size : (c,)
        √((1 − f h_i)² + f² |Y_i|²), rounded up [–].
    """

    lean: FloatArray
    size: FloatArray

    def part(self, columns: NDArray[np.intp]) -> "LeaningDiscs":
        """Those of some columns."""
        return LeaningDiscs(self.lean[columns], self.size[columns])

    def reach(self, y: FloatArray) -> FloatArray:
        """The largest y · t over the points t of every disc, of vectors (…, c, 2): (…, c)."""
        return np.asarray(self.size * np.hypot(y[..., 0], y[..., 1]) + np.sum(self.lean * y, axis=-1))

    def farthest(self, y: FloatArray) -> FloatArray:
        """The point t that :meth:`reach` reaches, (…, c, 2)."""
        size = np.hypot(y[..., 0], y[..., 1])[..., None]
        unit = np.divide(y, size, out=np.zeros_like(y), where=size > 0)
        return np.asarray(self.size[:, None] * unit + self.lean)

    def corners(self, count: int) -> FloatArray:
        """Three directions, (3, c, 2), whose farthest points have the origin between them."""
        long = np.hypot(self.lean[:, 0], self.lean[:, 1])[:, None]
        along = np.divide(self.lean, long, out=np.tile([1.0, 0.0], (len(long), 1)), where=long > 0)
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        back = 0.5 + 0.5 * long / self.size[:, None]
        aside = np.sqrt(1.0 - back**2)
        return np.stack([along, -back * along + aside * across, -back * along - aside * across])

    def nearest(self, corner: FloatArray, count: int) -> NDArray[np.intp]:
        """Each node has one."""
        return np.zeros(len(self.size), dtype=np.intp)


def leaning_discs(joint: ScaledJoint, least: LeastPressures) -> tuple[LeaningDiscs, NDArray[np.bool_]]:
    """The discs of the nodes of some least pressures, and which of them are of use."""
    node = least.sectors.node
    every, f = np.arange(len(node)), joint.f[node]
    Y = least.multipliers.reshape(len(node), -1, 2)[every, node]
    turned = np.abs(1.0 - f * least.weights[every, node])
    long = np.hypot(Y[:, 0], Y[:, 1]) + least.error
    size = np.hypot(turned, f * long) * (1.0 + 8 * EPS) + f * least.error + 8 * EPS * (1.0 + f * long)
    return LeaningDiscs(f[:, None] * Y, size), np.asarray((turned > ROUND * (1.0 + f * long)) & (size < MOST))
