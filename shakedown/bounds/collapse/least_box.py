"""The smallest box of slips that holds a state and that no slip of closed nodes leads out of."""

from dataclasses import dataclass
from math import inf

import numpy as np

from shakedown.bounds.uniqueness.coupling import coupling
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import MISJUDGED
from shakedown.joint.constraints import Constraints, by_side, constraints
from shakedown.joint.loading import transient_path
from shakedown.joint.problem import Problem


@dataclass(frozen=True)
class Box:
    """Slips low ≤ v ≤ high, each (n,) [length]."""

    low: FloatArray
    high: FloatArray

    def least(self, rows: FloatArray) -> FloatArray:
        """The least value of every row · v over the box."""
        return np.asarray(np.maximum(rows, 0.0) @ self.low + np.minimum(rows, 0.0) @ self.high)


class BoxMap:
    """The range of the limits of a joint over a box: z ← c + K z for z = (high, −low).

    With own stiffness o the forward limit of node i is L_i = c_i − Σ_j G_ij v_j / o_i, and the
    backward one likewise, mirrored. Its largest value over the box is a sum with weights K ≥ 0 of the
    sides of the box. In the weights d of the coupling ratio K (d, d) ≤ ρ* (d, d).

    Parameters
    ----------
    problem
        A joint with ρ* < 1.
    transient
        Whether the transient load steps are still to come.
    """

    def __init__(self, problem: Problem, *, transient: bool) -> None:
        self.problem, self.n = problem, problem.n
        self.rows: Constraints = constraints(problem)
        every = np.arange(2 * self.n)
        G, node = self.rows.G[every], self.rows.node[every]
        self._own = np.abs(G[every, node])
        others = G / self._own[:, None]
        others[every, node] = 0.0
        self._others = by_side(others)
        sides = _forward_first(others)  # of high by forward, of low by backward limits
        self._K = np.hstack([np.maximum(sides, 0.0), np.maximum(-sides, 0.0)])
        self._before = self._transient_limits() if transient else np.full(len(every), -inf)
        influence = coupling(problem)
        self._weights, self._ratio = np.tile(influence.weights, 2), influence.bound

    def _transient_limits(self) -> FloatArray:
        path = self.problem.layout.split(transient_path(self.problem))
        against = self.problem.law.against(*path)[:, : len(self._own)]
        return self._in_sides(against, axis=0)

    def _in_sides(self, excess: FloatArray, axis: int | None = None) -> FloatArray:
        """Excess of rows at slip zero as c, forward limits first."""
        slips = excess / self._own
        slips = slips if axis is None else slips.max(axis=axis, initial=-inf)
        return _forward_first(slips)

    def around(self, start: FloatArray, load_factor: float) -> Box:
        """The least box that holds a slip and that no motion leaves at any load factor up to this one.

        z = max(z₀, c + K z): a linear system in the sides that have been moved. More of them move from
        one step to the next, never fewer, so that it ends after 2n steps at the latest.
        """
        excess = (load_factor * np.maximum(self.rows.d, 0.0) - self.rows.g)[: len(self._own)]
        c = np.maximum(self._in_sides(excess), self._before)
        z0 = np.concatenate([start, -start])
        z, moved = z0, np.zeros(len(z0), dtype=bool)
        while True:
            more = (c + self._K @ z > z) & ~moved
            if not more.any():
                break
            moved |= more
            K = self._K[np.ix_(moved, moved)]
            right = c[moved] + self._K[np.ix_(moved, ~moved)] @ z0[~moved]
            z = z0.copy()
            z[moved] = np.maximum(np.linalg.solve(np.eye(len(K)) - K, right), z0[moved])
        missing = float(np.max((c + self._K @ z - z) / self._weights, initial=0.0))
        z = z + MISJUDGED * missing / (1.0 - self._ratio) * self._weights
        high, low = np.split(z, 2)
        return Box(-low, high)

    def apart_below(self, box: Box) -> FloatArray:
        """Load factors ≥ 0 below which both limits of a node stay apart all over a box (n,).

        Whatever limits the other nodes have: so in the box the node collapses no earlier.
        """
        slope, right = (by_side(x[: len(self._own)] / self._own) for x in (self.rows.d, self.rows.g))
        slope, right = slope[:, 0] + slope[:, 1], right[:, 0] + right[:, 1]
        right = right + box.least(-(self._others[:, 0] + self._others[:, 1]))
        rising = slope > 0
        meeting = np.divide(right, slope, out=np.full(self.n, inf), where=rising)
        return np.where(right > 0, np.where(rising, meeting, inf), 0.0)


def _forward_first(rows: FloatArray) -> FloatArray:
    """Row data, with the forward limits before the backward ones."""
    return np.concatenate([by_side(rows)[:, 1], by_side(rows)[:, 0]])
