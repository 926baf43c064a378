"""What slip asks of a reaction as a disc, and the smallest one that holds a loop, which limits the loads."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.least_pressures import LeastPressures
from shakedown.bounds.every_state.scaled_joint import ScaledJoint
from shakedown.bounds.every_state.sectors import Sectors
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS, ITERATIONS, ROUND_OFF

ROUND = 0.05  # least |1 − f h| at which a disc leans: below it nearly degenerates
MOST = 2.0  # largest size of a disc for which the round-off of a reach is bounded


@dataclass(frozen=True)
class LeaningDiscs:
    """Discs with an offset centre, one for each of some nodes (docs/universal.md, statement 6.4).

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
        """The discs of some columns."""
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


@dataclass(frozen=True)
class Loops:
    """What limits some nodes: loops of loads q¹, and the least friction limits in sectors of each of them.

    Attributes
    ----------
    shapes
        The directions in which a node may slip, as sectors, as many for each node, one node after the
        other; or a disc of each node that leans.
    path : (m, k, 2)
        q¹ of these nodes at the load steps [force].
    growing : (m, k, s)
        f π¹ in each of s sectors [force]: what the least friction limit grows by with the load factor.
    constant : (k, s)
        f π⁰ > 0 under the mean load [force].
    """

    shapes: Sectors | LeaningDiscs
    path: FloatArray
    growing: FloatArray
    constant: FloatArray

    def part(self, nodes: NDArray[np.intp]) -> "Loops":
        """Those of some of the nodes."""
        count = self.constant.shape[1]
        columns = (count * nodes[:, None] + np.arange(count)).ravel()
        return Loops(
            self.shapes.part(columns), self.path[:, nodes], self.growing[:, nodes], self.constant[nodes]
        )

    def needed(self, centre: FloatArray) -> FloatArray:
        """The 1/λ required for each load step and sector, (m, k, s), by centres (k, 2)."""
        reach = self._reach(centre)
        return np.asarray((reach - self.growing) / self.constant)

    def needed_above(self, centre: FloatArray) -> FloatArray:
        """The largest of :meth:`needed`, rounded up by more than its round-off, (k,)."""
        terms = 2.0 * (np.abs(self.path).sum(axis=2) + np.abs(centre).sum(axis=1))
        loose = 8 * EPS * (terms[..., None] + np.abs(self.growing)) / self.constant
        worst = (self.needed(centre) + loose).max(axis=(0, 2))
        return np.asarray(worst + 8 * EPS * np.abs(worst))

    def round_off(self) -> FloatArray:
        """The error of 1/λ due to round-off of loads, (k,)."""
        size = np.abs(self.path).max(axis=(0, 2)) + np.abs(self.growing).max(axis=(0, 2))
        return np.asarray(16 * EPS * size / self.constant.min(axis=1))

    def worst(self, centre: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Where :meth:`needed` is largest: its value, direction u (k, 2), f π⁰ there and u · q¹ + f π¹."""
        needed = self.needed(centre)
        k = np.arange(len(centre))
        step, sector = np.unravel_index(
            needed.transpose(1, 0, 2).reshape(len(centre), -1).argmax(axis=1), needed.shape[::2]
        )
        columns = self.constant.shape[1] * k + sector
        u = self.shapes.part(columns).farthest(-(centre + self.path[step, k]))
        right = np.sum(u * self.path[step, k], axis=1) + self.growing[step, k, sector]
        return needed[step, k, sector], u, self.constant[k, sector], right

    def towards(self, corner: FloatArray) -> FloatArray:
        """The direction u nearest to a given one that a sector has, f π⁰, least u · q¹ + f π¹: (k, 4)."""
        k, count = np.arange(len(self.constant)), self.constant.shape[1]
        sector = self.shapes.nearest(corner, count)
        u = self.shapes.part(count * k + sector).farthest(corner)
        right = (np.sum(self.path * u, axis=2) + self.growing[:, k, sector]).min(axis=0)
        return np.column_stack([u, self.constant[k, sector], right])

    def _reach(self, centre: FloatArray) -> FloatArray:
        count = self.constant.shape[1]
        return self.shapes.reach(np.repeat(-(centre + self.path), count, axis=1)).reshape(self.growing.shape)


@dataclass(frozen=True)
class DiscCentres:
    """The centres η at which load factors are largest, and what proves them: 1/λ in ``below`` … ``above``.

    Attributes
    ----------
    centre : (k, 2)
        η: under the load factor λ the reaction A v* + q⁰ of the node is λ η [force].
    above, below : (k,)
        1/λ: with these centres at most ``above``; with none less than ``below``.
    """

    centre: FloatArray
    above: FloatArray
    below: FloatArray


def disc_centres(loops: Loops) -> DiscCentres:
    """Minimise over η the largest (reach of −(η + q¹_k) − f π¹_k) / (f π⁰), for all nodes at once.

    With one sector this is the smallest disc that holds the loop, whose points are discs themselves.
    By exchange (the dual simplex method, whose rows are tangents): three directions
    hold a centre from three sides; the one in which it misses most takes the place of one of them.
    """
    k = len(loops.constant)
    basis, centre, below = _start(loops)
    if not k:
        return DiscCentres(centre, below, below)
    best, above, going = centre.copy(), np.full(k, np.inf), np.arange(k)
    for _ in range(ITERATIONS):  # each exchanges one of three touching points: 10 to 40 are taken
        part = loops.part(going)
        reached = part.needed_above(centre[going])
        better = reached < above[going]
        above[going[better]], best[going[better]] = reached[better], centre[going[better]]
        needed, u, constant, right = part.worst(centre[going])
        open_yet = needed - below[going] > np.maximum(ROUND_OFF * np.abs(needed), part.round_off())
        if not open_yet.any():
            break
        going = going[open_yet]
        new = np.stack([u[:, 0], u[:, 1], constant, right], axis=1)[open_yet]
        found, ok = _exchanged(basis[going], new)
        basis[going[ok]] = found[ok]
        going = going[ok]
        if not len(going):
            break
        centre[going], below[going] = _vertex(basis[going])
    return DiscCentres(best, above, np.minimum(below, above))


def _start(loops: Loops) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Three directions at equal angles."""
    basis = np.stack(
        [loops.towards(corner) for corner in loops.shapes.corners(loops.constant.shape[1])], axis=1
    )
    centre, below = _vertex(basis)
    return basis, centre, below


def _vertex(basis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centre and 1/λ where three rows u · η + f π⁰ / λ + (u · q¹ + f π¹) ≥ 0 meet."""
    found = np.linalg.solve(basis[..., :3], -basis[..., 3:])[..., 0]
    return np.asarray(found[:, :2]), np.asarray(found[:, 2])


def _exchanged(basis: FloatArray, new: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """The bases with the new row in place of the one whose weight vanishes first, and which are regular."""
    columns = basis[..., :3].transpose(0, 2, 1)
    right = np.stack([np.broadcast_to([0.0, 0.0, 1.0], new[:, :3].shape), new[:, :3]], axis=2)
    weights, change = np.moveaxis(np.linalg.solve(columns, right), 2, 0)
    changes = change > ROUND_OFF
    ratio = np.where(changes, np.maximum(weights, 0.0) / np.where(changes, change, 1.0), np.inf)
    leaving, found = ratio.argmin(axis=1), basis.copy()
    found[np.arange(len(found)), leaving] = new
    regular = np.abs(np.linalg.det(found[..., :3])) > 4 * EPS * found[..., 2].max(axis=1)
    return found, regular & np.isfinite(ratio.min(axis=1))
