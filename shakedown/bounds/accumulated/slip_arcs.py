"""The directions in which nodes may slip: both signs in the plane, sectors and arcs in space."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray

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
