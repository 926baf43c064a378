"""Arcs of directions of slip, and the search for those outside which no node reaches its limit."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from shakedown.ground.constants import (
    BLOCK,
    ITERATIONS,
    NEGLIGIBLE,
    ROUND_OFF,
    SEVEN_DIGITS,
    FloatArray,
    IntArray,
    Mask,
)
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.constraints import loading, transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import with_free_rigid_slips

SECTORS = 96  # sectors of a circle at the start
SUBDIVISIONS = 15  # parts of a cell that is divided
SECTOR_PARTS = {1: (1,), 2: (1, SUBDIVISIONS**2)}  # parts of a 96th of the circle, undivided at first


@dataclass(frozen=True, eq=False, repr=False)
class Arcs(Result):
    """Closed arcs of directions, less than 180° each, of one node each; those of one node do not overlap.

    Attributes
    ----------
    node : (K,)
        The node that may slip in these directions.
    first, last : (K, d)
        Unit vectors, counter-clockwise from the first to the last; in the plane both are the one direction.
    """

    node: IntArray
    first: FloatArray
    last: FloatArray

    def least(self, y: FloatArray) -> FloatArray:
        """The smallest y · u over the directions u of every arc, of vectors (…, K, d): (…, K)."""
        found = np.minimum(np.sum(y * self.first, axis=-1), np.sum(y * self.last, axis=-1))
        if y.shape[-1] == 1:
            return np.asarray(found)
        opposite = (crossed(self.first, -y) > 0) & (crossed(-y, self.last) > 0)
        return np.where(opposite, -np.hypot(y[..., 0], y[..., 1]), found)


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

    node: IntArray
    start: IntArray
    size: IntArray
    origin: FloatArray
    chosen: Mask
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

    def divided(self, which: Mask) -> tuple["Cells", IntArray]:
        """The cells with some of them divided, and of which one each is a part."""
        count = np.where(which, SUBDIVISIONS, 1)
        place = np.repeat(np.arange(len(count)), count)
        within = np.arange(len(place)) - np.repeat(np.cumsum(count) - count, count)
        size = (self.size // count)[place]
        start = self.start[place] + within * size
        return replace(self, node=self.node[place], start=start, size=size, chosen=self.chosen[place]), place

    def arcs(self) -> tuple[Arcs, IntArray, IntArray, Mask] | None:
        """The arcs formed by the chosen cells; None where these fill a circle.

        With the arc (k,) of every chosen cell, in order, its number among all cells (k,), and which of its
        corners (k, 1 or 3) hold the arc in their hull: the tips and the ends of the arc. A cell that two arcs
        meet in stands with both.
        """
        runs: list[tuple[IntArray, float, float]] = []
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
        return Arcs(node, self._directions(node, low), self._directions(node, high)), arc, cell, corner

    def _directions(self, node: IntArray, angle: IntArray | FloatArray) -> FloatArray:
        turn = self.origin[node] + 2.0 * np.pi * angle / self.circle
        return np.stack([np.cos(turn), np.sin(turn)], axis=-1)[..., : self.d]

    def _runs(self, mine: IntArray) -> list[tuple[IntArray, float, float]]:
        """Arcs of equal width, of chosen cells of one node that follow each other: cells, start and end.

        ``mine`` begins with a cell that is not chosen.
        """
        found = []
        for run in np.split(mine, np.flatnonzero(np.diff(self.chosen[mine])) + 1):
            if self.chosen[run[0]]:
                ends = self.start[run[0]] + np.cumsum(self.size[run])
                begins = ends - self.size[run]
                # six or more in a circle: in wider ones slip one way has little effect on slip another way
                parts = -(-6 * int(ends[-1] - begins[0]) // self.circle)
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


def by_node(node: IntArray) -> Iterator[tuple[int, slice]]:
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


START, OWN_LIMIT, COUPLING, ALL_DIRECTIONS = "start", "own limit", "coupling", "all directions"
REASONS = {
    "frictionless": "a node without friction slips under any load",
    START: "the first load step, or the mean load, leaves a node without pressure there",
    OWN_LIMIT: "slip of a node does not relieve its own limit",
    COUPLING: "slip of one node may cause slip of another, and so on without end",
    ALL_DIRECTIONS: "a node may slip in every direction",
    "round-off": "round-off decides whether the conditions hold",
}  # why nothing bounds the slips
MARGIN = 10 * ROUND_OFF  # relative to the terms of a sum: larger than the round-off of thousands of nodes
ROUNDED_UP = 1.0 + MARGIN


@dataclass(frozen=True, eq=False, repr=False)
class SlipArcs(Arcs):
    """Bounds on the slip of nodes by direction, s ≤ a + N s: the evidence of :func:`accumulated_bound`.

    Attributes
    ----------
    alone : (K,)
        a, an upper bound on the slip of the node with all others at rest [length].
    coupling : (K, K)
        N, how much farther it slips per slip of each other node, ρ(N) < 1, zero diagonal [–].
    inverse : (K, K)
        (I − N)⁻¹ ≥ 0.
    """

    alone: FloatArray
    coupling: FloatArray
    inverse: FloatArray

    @property
    def total(self) -> FloatArray:
        """S ≥ a + N S, rounded up: how far in all, (K,) [length]."""
        a = self.alone
        return np.asarray(self.inverse @ (a + NEGLIGIBLE * (a + a.max(initial=0.0))))

    def multipliers(self, slack: FloatArray, slopes: FloatArray) -> FloatArray:
        """y ≥ 0 with y ≥ −c + Nᵀ y for slopes c (p, K), (p, K): so c · s ≥ −y · a for all s.

        The least such y where a quick one leaves nothing of slacks (p,), and the least may.
        """
        y = np.maximum(np.maximum(-slopes, 0.0) @ self.inverse - np.maximum(slopes, 0.0), 0.0)
        short = np.flatnonzero((slack <= y @ self.alone) & (slack > 0.0))
        for some in np.array_split(short, len(short) * len(self.alone) ** 2 // BLOCK + 1):
            y[some] = self._least_multipliers(y[some], slack[some], slopes[some])
        return y

    def _least_multipliers(self, y: FloatArray, slack: FloatArray, slopes: FloatArray) -> FloatArray:
        """The least multipliers; the known ones where the least would leave no slack either.

        From those that are positive anyway on, one solution after the other from below.
        """
        found, rows, taken = y.copy(), np.arange(len(y)), slopes < 0.0
        for _ in range(ITERATIONS):
            both = taken[:, :, None] & taken[:, None, :]
            system = np.eye(len(self.alone)) - np.where(both, self.coupling.T, 0.0)
            least = np.linalg.solve(system, np.where(taken, -slopes[rows], 0.0)[..., None])[..., 0]
            more = (least @ self.coupling > slopes[rows]) & ~taken
            ended = ~more.any(axis=1)
            found[rows[ended]] = np.maximum(least[ended], 0.0)
            left = ~ended & (slack[rows] > least @ self.alone)
            rows, taken = rows[left], (taken | more)[left]
            if not rows.size:
                break
        return found


class NoSlipBound(Exception):
    """Raised where nothing bounds the slips; with the reason in a word, and the node."""

    def __init__(self, word: str, node: int) -> None:
        super().__init__(word, node)
        self.word, self.node = word, node


class Slacks(NamedTuple):
    """min(base − λ fall, before): the smallest slack under all loads up to a load factor.

    Attributes
    ----------
    base, fall, before : (…,)
        Under the mean load, what the load factor takes from it, and under the transient load steps [force].
    """

    base: FloatArray
    fall: FloatArray
    before: FloatArray

    @property
    def elastic(self) -> float:
        """The load factor at which the first slack that the mean load leaves is used up; inf without one."""
        falling = (self.fall > 0.0) & (self.base > 0.0)
        if falling.any():
            return float(np.min(self.base[falling] / self.fall[falling]))
        return np.inf if not self.fall.any() else 1.0

    def at(self, load_factor: float) -> FloatArray:
        """At a load factor, (…,)."""
        return np.minimum(self.base - load_factor * self.fall, self.before)


class ArcLimits:
    """The limits g_i(e) = f_i p_i + e · q_i of a joint about an initial slip, with margins above round-off.

    ``largest_effect`` (n, n) bounds the change of a node's limit per slip of another [force/length].
    """

    def __init__(self, problem: Problem, start: FloatArray, start_error: FloatArray) -> None:
        n, d = problem.n, problem.directions
        self.problem = problem
        self._fB, self._A, self.largest_effect = _by_pairs(problem)
        self._start, self._error = start, start_error
        fB, A, size = self._fB.reshape(n, -1), problem.A, np.abs(start)
        self._locked = fB @ start, (A @ start).reshape(n, d)
        self._terms = np.abs(fB) @ size, (np.abs(A) @ size).reshape(n, d)

    def slacks(self, node: IntArray, e: FloatArray) -> Slacks:
        """Of nodes (c,) in directions (c, k, d), (c, k): at the initial slip, wherever within its error."""
        problem, loop = self.problem, loading(self.problem)
        before, off = problem.layout.split(transient_path(problem)), np.flatnonzero(self._error)
        (of_fB, of_A), (size_fB, size_A) = self._locked, self._terms
        locked = of_fB[node, None] + np.einsum("ckx,cx->ck", e, of_A[node])
        terms = size_fB[node, None] + np.einsum("ckx,cx->ck", np.abs(e), size_A[node])
        locked -= NEGLIGIBLE * terms
        found = Slacks(*(np.empty(e.shape[:2]) for _ in Slacks._fields))
        for i, mine in by_node(node):
            least = partial(_least_limit, problem, i, e[mine])
            found.base[mine] = least(loop.q0[None], loop.p0[None])
            found.fall[mine] = np.maximum(-least(loop.q1, loop.p1), 0.0)
            found.before[mine] = least(*before)
            # what the error of the initial slip may take
            effects = (self._fB[i, off, y] + e[mine] @ self._A[i, :, off, y].T for y in range(e.shape[2]))
            locked[mine] -= np.sqrt(sum(effect**2 for effect in effects)) @ self._error[off]
        return Slacks(found.base + locked, found.fall, found.before + locked)

    def check_pressed(self, load_factor: float) -> None:
        """Raise ``NoSlipBound`` unless the first load presses all nodes, at every load factor up to one.

        The load rises to it under these pressures; where it admits the initial slip they are positive anyway.
        """
        problem, loop = self.problem, loading(self.problem)
        before = problem.layout.split(transient_path(problem))[1]
        first = before[:1] if len(before) else np.stack([loop.p0, loop.p0 + load_factor * loop.p1[0]])
        p = first.min(axis=0) + problem.B @ self._start
        p -= np.linalg.norm(problem.B.reshape(*self._fB.shape), axis=2) @ self._error
        if not p.min() > 0.0:
            raise NoSlipBound(START, int(p.argmin()))

    def slopes(self, node: IntArray, e: FloatArray, arcs: Arcs) -> FloatArray:
        """Lower bounds on the effect of slip in arcs on limits of nodes (p,) in directions (p, d), (p, K)."""
        i = node[:, None]
        rows = self._fB[i, arcs.node]
        for x in range(e.shape[1]):
            rows += e[:, x, None, None] * self._A[i, x, arcs.node]
        return arcs.least(rows) - MARGIN * self.largest_effect[i, arcs.node]


@once_per_problem
def _by_pairs(problem: Problem) -> tuple[FloatArray, FloatArray, FloatArray]:
    """f B (n, n, d) and A (n, d, n, d); the largest change of a node's limit per slip of another, (n, n)."""
    n, d = problem.n, problem.directions
    fB, A = problem.law.limit_rows(problem.B).reshape(n, n, d), problem.A.reshape(n, d, n, d)
    return fB, A, np.asarray(np.linalg.norm(fB, axis=2) + np.linalg.norm(A, axis=(1, 3)))


@once_per_problem
def origins(problem: Problem) -> FloatArray:
    """The direction from which the sectors of every node are counted, whatever its tangents are, (n,) [rad].

    That of the largest of its reactions, of what slips like the reactions change in them, and of what its
    slip changes in pressures; the first one of several as large.
    """
    layout, loop = problem.layout, loading(problem)
    if problem.directions == 1:
        return np.zeros(problem.n)
    q = np.vstack([loop.q0, loop.q1, layout.split(transient_path(problem))[0]])
    groups = [layout.by_node(rows) for rows in (q, q @ problem.A, problem.B)]
    lengths = [np.linalg.norm(each, axis=2) for each in groups]
    sizes = np.vstack([each / (each.max() or 1.0) for each in lengths])
    first = np.argmax(sizes >= (1.0 - SEVEN_DIGITS) * sizes.max(axis=0), axis=0)
    x, y = np.concatenate(groups)[first, np.arange(problem.n)].T
    return np.asarray(np.arctan2(y, x))


def _least_limit(problem: Problem, i: int, e: FloatArray, q: FloatArray, p: FloatArray) -> FloatArray:
    """The smallest f p + e · q of a node over load steps, less a margin; inf where there is none."""
    q, p = problem.layout.by_node(q)[:, i].T, problem.f[i] * p[:, i]
    values = p + e @ q - NEGLIGIBLE * (np.abs(p) + np.abs(e) @ np.abs(q))
    return np.asarray(values.min(axis=-1, initial=np.inf))


@dataclass(frozen=True, eq=False)
class ArcSearch:
    """Cells of directions, some of them chosen, with the slacks of their corners."""

    limits: ArcLimits
    cells: Cells
    slacks: Slacks

    @classmethod
    def of(cls, problem: Problem, start: FloatArray, start_error: FloatArray, parts: int) -> "ArcSearch":
        """With no cell chosen yet; cells may be divided into a number of parts."""
        if problem.law.frictionless.size:
            raise NoSlipBound("frictionless", int(problem.law.frictionless[0]))
        limits = ArcLimits(with_free_rigid_slips(problem), start, start_error)
        cells = all_cells(origins(limits.problem), problem.directions, parts)
        return cls(limits, cells, limits.slacks(cells.node, cells.corners))

    def closed(self, load_factor: float) -> tuple["ArcSearch", SlipArcs]:
        """Extend the chosen cells until nodes slip only in these, and bound their slips there.

        Cells in which a node may slip are divided before they are chosen.

        Raises
        ------
        NoSlipBound
            Where there is no end to the slips.
        """
        search = self
        self.limits.check_pressed(load_factor)
        while True:
            arcs = search._slips(load_factor)
            reached = search._corners_reached(load_factor, arcs)
            if not reached.any():
                return search, arcs
            search = search._extended(reached)

    def _slips(self, load_factor: float) -> SlipArcs:
        """Of the arcs of chosen cells: at every corner g + own a ≥ 0 and own N ≥ −c, own > 0 the own slope.

        Raises ``NoSlipBound`` where slip does not move a node away from its own limit, or ρ(N) ≥ 1.
        """
        found = self.cells.arcs()
        if found is None:
            raise NoSlipBound(ALL_DIRECTIONS, -1)
        arcs, arc, cell, corner = found
        node, count = arcs.node, len(arcs.node)
        kept = np.broadcast_to(arc[:, None], corner.shape)[corner]
        slack = self.slacks.at(load_factor)[cell][corner]
        slopes = self.limits.slopes(node[kept], self.cells.corners[cell][corner], arcs)
        own = slopes[np.arange(len(kept)), kept]
        if not np.all(own > 0.0):
            raise NoSlipBound(OWN_LIMIT, int(node[kept[np.argmin(own)]]))
        begin = np.searchsorted(kept, np.arange(count))
        a, N = (
            ROUNDED_UP * np.maximum(np.maximum.reduceat((-values.T / own).T, begin), 0.0) if count else values
            for values in (slack, slopes)
        )
        np.fill_diagonal(N, 0.0)
        try:
            inverse = np.linalg.inv(np.eye(count) - N)
        except np.linalg.LinAlgError:
            inverse = np.zeros_like(N)
        if not inverse.sum(axis=1).min(initial=1.0) > 0.0:  # (I − N) x = 1 has x > 0 where ρ(N) < 1 alone
            raise NoSlipBound(COUPLING, int(node[np.argmax(N.sum(axis=1))]))
        return SlipArcs(node, arcs.first, arcs.last, a, N, np.maximum(inverse, 0.0))

    def _corners_reached(self, load_factor: float, arcs: SlipArcs) -> IntArray:
        """At how many of their corners a node may slip, of cells outside the arcs, (c,)."""
        cells, slack = self.cells, self.slacks.at(load_factor)
        # largest length of the vectors at corners of cells
        most = 1.001 * self.limits.largest_effect[:, arcs.node] @ arcs.total
        near = np.flatnonzero(~cells.chosen & (slack.min(axis=1) <= most[cells.node]))
        e, k = cells.corners[near], slack.shape[1]
        slopes = self.limits.slopes(cells.node[near].repeat(k), e.reshape(-1, cells.d), arcs)
        given = slack[near].ravel()
        safe = given > arcs.multipliers(given, slopes) @ arcs.alone
        reached = np.zeros(len(cells.node), dtype=np.intp)
        reached[near] = np.sum(~safe.reshape(-1, k), axis=1)
        return reached

    def _extended(self, reached: IntArray) -> "ArcSearch":
        """Choose the cells that are reached at all corners, or as narrow as possible; divide other ones.

        So the ends of arcs are as exact as the narrowest cells, and inside arcs are wider ones.
        """
        cells, corners = self.cells, self.slacks.base.shape[1]
        parts = (reached > 0) & ((cells.size > SUBDIVISIONS) | (cells.size > 1) & (reached < corners))
        chosen = replace(cells, chosen=cells.chosen | (reached > 0) & ~parts)
        if not parts.any():
            return replace(self, cells=chosen)
        divided, from_old = chosen.divided(parts)
        slacks = Slacks(*(part[from_old] for part in self.slacks))
        new = parts[from_old]
        of_new = self.limits.slacks(divided.node[new], divided.corners[new])
        for part, values in zip(slacks, of_new, strict=True):
            part[new] = values
        return replace(self, cells=divided, slacks=slacks)
