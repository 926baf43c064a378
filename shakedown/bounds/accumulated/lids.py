"""How far nodes can slip in all: lids on their arcs, and what all slips below them leave of a limit."""

from dataclasses import dataclass

import numpy as np

from shakedown.bounds.accumulated.slip_arcs import Numbers
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import ITERATIONS, NEGLIGIBLE

OWN, TOGETHER = "own limit", "coupling"
UP = 1.0 + 1e-12  # rounds up
SETTLED = 1e-3  # of what is missing, by which a bound must still fall for another product


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

        They fall from product to product, as long as that may leave something of slacks (p,).
        """
        y = np.maximum(np.maximum(-slopes, 0.0) @ self.inverse - np.maximum(slopes, 0.0), 0.0)
        short = np.flatnonzero((slack <= y @ self.a) & (slack > 0.0))
        for _ in range(ITERATIONS):
            if not short.size:
                break
            missing = y[short] @ self.a - slack[short]
            y[short] = np.maximum(y[short] @ self.N - slopes[short], 0.0)
            left = y[short] @ self.a - slack[short]
            short = short[(left >= 0.0) & (missing - left > SETTLED * missing)]
        return y


class NoLids(Exception):
    """There are no lids; why, in a word, and at which node."""

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
