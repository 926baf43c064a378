"""The directions in which nodes may slip, and bounds on how far."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import BLOCK, ITERATIONS, NEGLIGIBLE, ROUND_OFF, FloatArray

Numbers = NDArray[np.intp]
Flags = NDArray[np.bool_]

SECTORS = 96  # sectors of a circle at the start
FINER = 15  # parts of a cell that is divided
WIDEST = (
    6  # least number of arcs in a circle; in wider ones slip in one direction hardly hinders that in another
)


@dataclass(frozen=True, eq=False)
class Arcs:
    """Closed arcs of directions, less than 180° each, of one node each; those of one node do not overlap.

    Attributes
    ----------
    node : (K,)
        The node that slips in these directions.
    first, last : (K, d)
        Unit vectors, counter-clockwise from the first to the last; in the plane both are the one direction.
    """

    node: Numbers
    first: FloatArray
    last: FloatArray

    def __len__(self) -> int:
        return len(self.node)

    def least(self, y: FloatArray) -> FloatArray:
        """The smallest y · u over the directions u of every arc, of vectors (…, K, d): (…, K)."""
        found = np.minimum(np.sum(y * self.first, axis=-1), np.sum(y * self.last, axis=-1))
        if y.shape[-1] == 1:
            return np.asarray(found)
        opposite = (crossed(self.first, -y) > 0) & (crossed(-y, self.last) > 0)
        return np.where(opposite, -np.hypot(y[..., 0], y[..., 1]), found)


class Grouped(NamedTuple):
    """Arcs, with the cells that hold them, arc by arc; one that two arcs meet in stands with both.

    Attributes
    ----------
    arcs
        K of them.
    arc, cell : (k,)
        The arc of every chosen cell, in order, and its number among all cells.
    corner : (k, 1 or 3)
        The corners of these cells whose hull holds the arc: the tips and the ends of the arc.
    """

    arcs: Arcs
    arc: Numbers
    cell: Numbers
    corner: Flags


@dataclass(frozen=True, eq=False)
class Cells:
    """Sectors of directions that make up the circle of every node, in order; in the plane its two directions.

    Attributes
    ----------
    node : (c,)
        The node of every cell.
    start, size : (c,)
        Where it begins and how wide it is, in units of angle; in the plane 0 or half a circle, without width.
    origin : (n,)
        The direction of every node from which these are counted [rad].
    chosen : (c,)
        Whether the node may slip in these directions.
    circle
        Units of angle in the circle.
    d
        Tangential directions of a node.
    """

    node: Numbers
    start: Numbers
    size: Numbers
    origin: FloatArray
    chosen: Flags
    circle: int
    d: int

    @cached_property
    def corners(self) -> FloatArray:
        """Directions (c, 1 or 3, d) whose convex hull holds all of a cell."""
        first = self._directions(self.node, self.start)
        if self.d == 1:
            return first[:, None]
        last = self._directions(self.node, self.start + self.size)
        tip = (first + last) / (1.0 + np.sum(first * last, axis=1))[:, None]
        return np.stack([first, last, tip], axis=1)

    def divided(self, which: Flags) -> tuple["Cells", Numbers]:
        """The cells with some of them divided, and of which one each is a part."""
        count = np.where(which, FINER, 1)
        place = np.repeat(np.arange(len(count)), count)
        within = np.arange(len(place)) - np.repeat(np.cumsum(count) - count, count)
        size = (self.size // count)[place]
        start = self.start[place] + within * size
        return replace(self, node=self.node[place], start=start, size=size, chosen=self.chosen[place]), place

    def arcs(self) -> "Grouped | None":
        """The arcs formed by the chosen cells; None where these fill a circle."""
        runs: list[tuple[Numbers, float, float]] = []
        for node in np.unique(self.node[self.chosen]).tolist():
            mine = np.flatnonzero(self.node == node)
            if self.d == 1:
                runs += [(mine[[k]], float(k), float(k)) for k in range(2) if self.chosen[mine[k]]]
            elif self.chosen[mine].all():
                return None
            else:
                runs += self._runs(np.roll(mine, -int(np.argmin(self.chosen[mine]))))
        cell = np.concatenate([np.zeros(0, dtype=np.intp), *(run for run, _, _ in runs)])
        arc = np.repeat(np.arange(len(runs)), [len(run) for run, _, _ in runs])
        begins = np.diff(arc, prepend=-1) > 0
        ends = np.diff(arc, append=len(runs)) > 0
        corner = np.stack([begins, ends, np.ones(len(arc), dtype=bool)], axis=1)[:, : 1 if self.d == 1 else 3]
        node, (low, high) = self.node[cell[begins]], np.array([run[1:] for run in runs]).reshape(-1, 2).T
        arcs = Arcs(node, self._directions(node, low), self._directions(node, high))
        return Grouped(arcs, arc, cell, corner)

    def _directions(self, node: Numbers, angle: Numbers | FloatArray) -> FloatArray:
        turn = self.origin[node] + 2.0 * np.pi * angle / self.circle
        return np.stack([np.cos(turn), np.sin(turn)], axis=-1)[..., : self.d]

    def _runs(self, mine: Numbers) -> list[tuple[Numbers, float, float]]:
        """Arcs of equal width, of chosen cells of one node that follow each other: cells, start and end.

        ``mine`` begins with a cell that is not chosen.
        """
        found = []
        for run in np.split(mine, np.flatnonzero(np.diff(self.chosen[mine])) + 1):
            if self.chosen[run[0]]:
                ends = self.start[run[0]] + np.cumsum(self.size[run])
                begins = ends - self.size[run]
                parts = -(-WIDEST * int(ends[-1] - begins[0]) // self.circle)
                for low, high in pairwise(np.linspace(begins[0], ends[-1], parts + 1).tolist()):
                    found.append((run[(ends > low) & (begins < high)], low, high))
        return found


def all_cells(origin: FloatArray, d: int, parts: int) -> Cells:
    """The cells of nodes (n,) to begin with, none of them chosen, of so many parts each.

    Examples
    --------
    >>> all_cells(np.zeros(1), 1, 1).corners.ravel(), all_cells(np.zeros(2), 2, 1).corners.shape
    (array([ 1., -1.]), (192, 3, 2))
    """
    n = len(origin)
    starts, size = (np.arange(2), 0) if d == 1 else (parts * np.arange(SECTORS), parts)
    count = n * len(starts)
    return Cells(
        node=np.repeat(np.arange(n), len(starts)),
        start=np.tile(starts, n),
        size=np.full(count, size),
        origin=origin,
        chosen=np.zeros(count, dtype=bool),
        circle=2 if d == 1 else parts * SECTORS,
        d=d,
    )


def by_node(node: Numbers) -> Iterator[tuple[int, slice]]:
    """The nodes that stand in a row, and where.

    Examples
    --------
    >>> list(by_node(np.array([4, 4, 7])))
    [(4, slice(0, 2, None)), (7, slice(2, 3, None))]
    """
    begins = np.flatnonzero(np.diff(node, prepend=-1))
    for first, end in pairwise([*begins.tolist(), len(node)]):
        yield int(node[first]), slice(first, end)


def crossed(x: FloatArray, y: FloatArray) -> FloatArray:
    """x × y of vectors in the plane, (…, 2): positive where y is counter-clockwise from x."""
    return np.asarray(x[..., 0] * y[..., 1] - x[..., 1] * y[..., 0])


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
