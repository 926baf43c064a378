"""Bounds on total slip: lids on arcs, and the slack of a limit that remains for all slips below them."""

from dataclasses import dataclass

import numpy as np

from shakedown.bounds.accumulated.slip_arcs import Numbers
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import ITERATIONS, NEGLIGIBLE, ROUND_OFF
from shakedown.ground.size_limits import BLOCK

OWN, TOGETHER = "own limit", "coupling"
MARGIN = 10 * ROUND_OFF  # relative to the terms of a sum: larger than the round-off of thousands of nodes
UP = 1.0 + MARGIN


@dataclass(frozen=True, eq=False)
class Lids:
    """Slips s ≥ 0 with s ≤ a + N s: how far nodes can slip in their arcs, ρ(N) < 1.

    Attributes
    ----------
    a : (K,)
        How far with all others at rest [length].
    N : (K, K)
        How much farther by slip of the others, zero diagonal [–].
    inverse : (K, K)
        (I − N)⁻¹ ≥ 0.
    """

    a: FloatArray
    N: FloatArray
    inverse: FloatArray

    @property
    def total(self) -> FloatArray:
        """S ≥ a + N S, rounded up: no slip is larger, (K,) [length]."""
        return np.asarray(self.inverse @ (self.a + NEGLIGIBLE * (self.a + self.a.max(initial=0.0))))

    def multipliers(self, slack: FloatArray, slopes: FloatArray) -> FloatArray:
        """y ≥ 0 with y ≥ −c + Nᵀ y for slopes c (p, K), (p, K): so c · s ≥ −y · a for all s.

        The least such y where a quick one leaves nothing of slacks (p,), and the least may.
        """
        y = np.maximum(np.maximum(-slopes, 0.0) @ self.inverse - np.maximum(slopes, 0.0), 0.0)
        short = np.flatnonzero((slack <= y @ self.a) & (slack > 0.0))
        for some in np.array_split(short, len(short) * len(self.a) ** 2 // BLOCK + 1):
            y[some] = self._least(y[some], slack[some], slopes[some])
        return y

    def _least(self, y: FloatArray, slack: FloatArray, slopes: FloatArray) -> FloatArray:
        """The least multipliers; the known ones where the least would leave no slack either.

        From those that are positive anyway on, one solution after the other from below.
        """
        found, rows, taken = y.copy(), np.arange(len(y)), slopes < 0.0
        for _ in range(ITERATIONS):
            both = taken[:, :, None] & taken[:, None, :]
            system = np.eye(len(self.a)) - np.where(both, self.N.T, 0.0)
            least = np.linalg.solve(system, np.where(taken, -slopes[rows], 0.0)[..., None])[..., 0]
            more = (least @ self.N > slopes[rows]) & ~taken
            ended = ~more.any(axis=1)
            found[rows[ended]] = np.maximum(least[ended], 0.0)
            left = ~ended & (slack[rows] > least @ self.a)
            rows, taken = rows[left], (taken | more)[left]
            if not rows.size:
                break
        return found


class NoLids(Exception):
    """Raised where there are no lids; with the reason in a word, and the node."""

    def __init__(self, word: str, node: int) -> None:
        super().__init__(word, node)
        self.word, self.node = word, node


def lids_of(node: Numbers, arc: Numbers, slack: FloatArray, slopes: FloatArray) -> Lids:
    """The lids of arcs of nodes (K,), from slacks (p,) and slopes (p, K) at points of the arcs (p,).

    At every point g + own a ≥ 0 and own N ≥ −c, own > 0 the slope of the point's own arc.

    Raises
    ------
    NoLids
        Where slip does not relieve its own limit, or slips drive each other on.
    """
    count = len(node)
    own = slopes[np.arange(len(arc)), arc]
    if not np.all(own > 0.0):
        raise NoLids(OWN, int(node[arc[np.argmin(own)]]))
    begin = np.searchsorted(arc, np.arange(count))
    a, N = (
        UP * np.maximum(np.maximum.reduceat((-values.T / own).T, begin), 0.0) if count else values
        for values in (slack, slopes)
    )
    np.fill_diagonal(N, 0.0)
    try:
        inverse = np.linalg.inv(np.eye(count) - N)
    except np.linalg.LinAlgError:
        inverse = np.zeros_like(N)
    if not inverse.sum(axis=1).min(initial=1.0) > 0.0:  # (I − N) x = 1 has a positive x where ρ(N) < 1 alone
        raise NoLids(TOGETHER, int(node[np.argmax(N.sum(axis=1))]))
    return Lids(a, N, np.maximum(inverse, 0.0))
