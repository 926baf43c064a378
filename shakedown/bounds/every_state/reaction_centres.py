"""The reactions about which the load of each node swings with least friction, and how far that is enough."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.slip_curves import SlipCurves
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS, ITERATIONS, ROUND_OFF


@dataclass(frozen=True)
class Loops:
    """What limits some nodes: loops of loads q¹, and the least friction limits during each of them.

    Attributes
    ----------
    curves
        What slip in any direction asks of the reaction.
    path : (m, k, d)
        q¹ of these nodes at the load steps [force].
    growing : (m, k)
        f π¹ [force]: what the least friction limit grows by with the load factor.
    constant : (k,)
        f π⁰ > 0 under the mean load [force].
    """

    curves: SlipCurves
    path: FloatArray
    growing: FloatArray
    constant: FloatArray

    def part(self, nodes: NDArray[np.intp]) -> "Loops":
        """Those of some of the nodes."""
        return Loops(
            self.curves.part(nodes), self.path[:, nodes], self.growing[:, nodes], self.constant[nodes]
        )

    def needed(self, centre: FloatArray) -> FloatArray:
        """The 1/λ required for each load step, (m, k), by centres (k, d)."""
        return np.asarray((self.curves.reach(-(centre + self.path)) - self.growing) / self.constant)

    def needed_above(self, centre: FloatArray) -> FloatArray:
        """The largest of :meth:`needed`, rounded up by more than its round-off, (k,)."""
        size = np.abs(self.path).sum(axis=2) + np.abs(centre).sum(axis=1)
        loose = (self.curves.loose + 16 * EPS * (self.curves.size + self.curves.length)) * size
        worst = self.needed(centre) + (loose + 16 * EPS * np.abs(self.growing)) / self.constant
        most = worst.max(axis=0)
        return np.asarray(most + 8 * EPS * np.abs(most))

    def round_off(self) -> FloatArray:
        """The error of 1/λ due to round-off of loads, (k,)."""
        size = np.abs(self.path).max(axis=(0, 2)) + np.abs(self.growing).max(axis=0)
        return np.asarray(16 * EPS * size / self.constant)

    def worst(self, centre: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where :meth:`needed` is largest: its value (k,), and the row t, f π⁰, t · q¹ + f π¹ (k, d + 2)."""
        needed, k = self.needed(centre), np.arange(len(centre))
        step = needed.argmax(axis=0)
        point = self.curves.farthest(-(centre + self.path[step, k]))
        right = np.sum(point * self.path[step, k], axis=1) + self.growing[step, k]
        return needed[step, k], np.column_stack([point, self.constant, right])

    def rows(self, points: FloatArray) -> FloatArray:
        """The rows of some points t (j, k, d) at their worst load steps, (k, j, d + 2)."""
        right = (np.einsum("mkd,jkd->jmk", self.path, points) + self.growing).min(axis=1)
        constant = np.broadcast_to(self.constant, right.shape)
        return np.concatenate([points, constant[..., None], right[..., None]], axis=2).swapaxes(0, 1)


def reaction_centres(loops: Loops) -> tuple[FloatArray, FloatArray]:
    """Minimise over η the largest (reach of −(η + q¹_k) − f π¹_k) / (f π⁰), for all nodes at once.

    Returns an upper bound of this 1/λ (k,), and η (k, d): under the load factor λ the reaction A v* + q⁰ of
    the node is λ η [force].

    By the exchange algorithm (Remez; the dual simplex method, whose rows are tangents): d + 1 points of
    the curve hold a centre from all sides; the one in which it misses most takes the place of one of them.
    """
    k = len(loops.constant)
    basis = loops.rows(loops.curves.around())
    centre, below = _vertex(basis)
    if not k:
        return below, centre
    best, above, going = centre.copy(), np.full(k, np.inf), np.arange(k)
    for _ in range(ITERATIONS):  # each exchanges one of d + 1 touching points: 10 to 40 are taken
        part = loops.part(going)
        reached = part.needed_above(centre[going])
        better = reached < above[going]
        above[going[better]], best[going[better]] = reached[better], centre[going[better]]
        needed, new = part.worst(centre[going])
        open_yet = needed - below[going] > np.maximum(ROUND_OFF * np.abs(needed), part.round_off())
        if not open_yet.any():
            break
        going = going[open_yet]
        found, ok = _exchanged(basis[going], new[open_yet])
        basis[going[ok]] = found[ok]
        going = going[ok]
        if not len(going):
            break
        centre[going], below[going] = _vertex(basis[going])
    return above, best


def _vertex(basis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centre and 1/λ where the rows t · η + f π⁰ / λ + (t · q¹ + f π¹) ≥ 0 meet."""
    found = np.linalg.solve(basis[..., :-1], -basis[..., -1:])[..., 0]
    return np.asarray(found[:, :-1]), np.asarray(found[:, -1])


def _exchanged(basis: FloatArray, new: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """The bases with the new row in place of the one whose weight vanishes first, and which are regular."""
    columns, row = basis[..., :-1].swapaxes(1, 2), new[:, :-1]
    weighed = np.zeros_like(row)
    weighed[:, -1] = 1.0
    weights, change = np.moveaxis(np.linalg.solve(columns, np.stack([weighed, row], axis=2)), 2, 0)
    changes = change > ROUND_OFF
    ratio = np.where(changes, np.maximum(weights, 0.0) / np.where(changes, change, 1.0), np.inf)
    leaving, found = ratio.argmin(axis=1), basis.copy()
    found[np.arange(len(found)), leaving] = new
    regular = np.abs(np.linalg.det(found[..., :-1])) > 4 * EPS * found[..., -2].max(axis=1)
    return found, regular & np.isfinite(ratio.min(axis=1))
