"""The search for arcs of slip directions outside which no node ever reaches its limit at a load factor."""

from dataclasses import dataclass, replace
from functools import partial
from math import inf
from typing import NamedTuple

import numpy as np

from shakedown.bounds.accumulated.slip_arcs import (
    FINER,
    MARGIN,
    Arcs,
    Cells,
    Lids,
    NoLids,
    Numbers,
    all_cells,
    by_node,
    lids_of,
)
from shakedown.ground.constants import HALVINGS, NEGLIGIBLE, SEVEN_DIGITS, FloatArray
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.fields import LARGEST
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem

START = "start"
ALL_AROUND = "all directions"
STRETCH = 1.001  # largest length of the vectors at corners of cells


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

    ``reach`` (n, n) bounds what slip of a node changes in the limit of another [force/length].
    """

    def __init__(self, problem: Problem, start: FloatArray, start_error: FloatArray) -> None:
        n, d = problem.n, problem.directions
        self.problem = problem
        self._fB = problem.law.limit_rows(problem.B).reshape(n, n, d)
        self._A = problem.A.reshape(n, d, n, d)
        self._start, self._error = start, start_error
        self._off = np.flatnonzero(start_error)
        self.reach = _reach(problem)
        fB, A, size = self._fB.reshape(n, -1), problem.A, np.abs(start)
        self._locked = fB @ start, (A @ start).reshape(n, d)
        self._terms = np.abs(fB) @ size, (np.abs(A) @ size).reshape(n, d)

    def slacks(self, node: Numbers, e: FloatArray) -> Slacks:
        """Of nodes (c,) in directions (c, k, d), (c, k): at the initial slip, wherever within its error."""
        return self._after_slip(node, e, load_slacks(self.problem, node, e))

    def slacks_around(self, cells: Cells, parts: int) -> Slacks:
        """Of all nodes in all undivided cells: what loads leave there is worked out once."""
        known = _known_around(self.problem)
        if parts not in known:
            known[parts] = load_slacks(self.problem, cells.node, cells.corners)
        return self._after_slip(cells.node, cells.corners, known[parts])

    def _after_slip(self, node: Numbers, e: FloatArray, loads: Slacks) -> Slacks:
        """What the initial slip adds to slacks under the loads alone."""
        (of_fB, of_A), (size_fB, size_A) = self._locked, self._terms
        locked = of_fB[node, None] + np.einsum("ckx,cx->ck", e, of_A[node])
        terms = size_fB[node, None] + np.einsum("ckx,cx->ck", np.abs(e), size_A[node])
        locked -= NEGLIGIBLE * terms
        for i, mine in by_node(node) if self._off.size else ():
            locked[mine] -= self._uncertain(i, e[mine])
        return Slacks(loads.base + locked, loads.fall, loads.before + locked)

    def _uncertain(self, i: int, e: FloatArray) -> FloatArray:
        """What the error of the initial slip may take from the limit of a node in directions (c, k, d)."""
        off, square = self._off, 0.0
        for x in range(e.shape[-1]):
            square = square + (self._fB[i, off, x] + e @ self._A[i][:, off, x]) ** 2
        return np.asarray(np.sqrt(square) @ self._error[off])

    def check_pressed(self, load_factor: float) -> None:
        """Raise ``NoLids`` unless the first load presses all nodes, at every load factor up to one.

        The load rises to it under these pressures; where it admits the initial slip they are positive anyway.
        """
        problem, loop = self.problem, loading(self.problem)
        before = problem.layout.split(transient_path(problem))[1]
        first = before[:1] if len(before) else np.stack([loop.p0, loop.p0 + load_factor * loop.p1[0]])
        p = first.min(axis=0) + problem.B @ self._start
        p -= np.linalg.norm(problem.B.reshape(*self._fB.shape), axis=2) @ self._error
        if not p.min() > 0.0:
            raise NoLids(START, int(p.argmin()))

    def slopes(self, node: Numbers, e: FloatArray, arcs: Arcs) -> FloatArray:
        """Lower bounds on the effect of slip in arcs on limits of nodes (p,) in directions (p, d), (p, K)."""
        i = node[:, None]
        rows = self._fB[i, arcs.node]
        for x in range(e.shape[1]):
            rows += e[:, x, None, None] * self._A[i, x, arcs.node]
        return arcs.least(rows) - MARGIN * self.reach[i, arcs.node]


@once_per_problem
def _reach(problem: Problem) -> FloatArray:
    """(n, n): what slip of a node changes at most in the limit of another [force/length]."""
    n, d = problem.n, problem.directions
    fB, A = problem.law.limit_rows(problem.B).reshape(n, n, d), problem.A.reshape(n, d, n, d)
    return np.asarray(np.linalg.norm(fB, axis=2) + np.linalg.norm(A, axis=(1, 3)))


@once_per_problem
def _origins(problem: Problem) -> FloatArray:
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


@once_per_problem
def _known_around(problem: Problem) -> dict[int, Slacks]:
    """Slacks under the loads alone in all undivided cells, by the number of their parts."""
    return {}


def load_slacks(problem: Problem, node: Numbers, e: FloatArray) -> Slacks:
    """Slacks of nodes (c,) in directions (c, k, d) under the loads alone, without slip, (c, k)."""
    loop, before = loading(problem), problem.layout.split(transient_path(problem))
    found = Slacks(*(np.empty(e.shape[:2]) for _ in Slacks._fields))
    for i, mine in by_node(node):
        least = partial(_least, problem, i, e[mine])
        found.base[mine] = least(loop.q0[None], loop.p0[None])
        found.fall[mine] = np.maximum(-least(loop.q1, loop.p1), 0.0)
        found.before[mine] = least(*before)
    return found


def _least(problem: Problem, i: int, e: FloatArray, q: FloatArray, p: FloatArray) -> FloatArray:
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

    def closed(self, load_factor: float) -> "FoundArcs":
        """Extend the chosen cells until nodes slip only in these.

        Cells in which a node may slip are divided before they are chosen.

        Raises
        ------
        NoLids
            Where there is no end to the slips.
        """
        search = self
        self.limits.check_pressed(load_factor)
        while True:
            arcs, lids = search._lids(load_factor)
            entered = search._corners_entered(load_factor, arcs, lids)
            if not entered.any():
                return FoundArcs(search, load_factor, arcs, lids)
            search = search._with(entered)

    def _lids(self, load_factor: float) -> tuple[Arcs, Lids]:
        found = self.cells.arcs()
        if found is None:
            raise NoLids(ALL_AROUND, -1)
        arcs, arc, cell, corner = found
        kept = np.broadcast_to(arc[:, None], corner.shape)[corner]
        slack = self.slacks.at(load_factor)[cell][corner]
        slopes = self.limits.slopes(arcs.node[kept], self.cells.corners[cell][corner], arcs)
        return arcs, lids_of(arcs.node, kept, slack, slopes)

    def _corners_entered(self, load_factor: float, arcs: Arcs, lids: Lids) -> Numbers:
        """At how many of their corners a node may slip, of cells outside the arcs, (c,)."""
        cells, slack = self.cells, self.slacks.at(load_factor)
        most = STRETCH * self.limits.reach[:, arcs.node] @ lids.total
        near = np.flatnonzero(~cells.chosen & (slack.min(axis=1) <= most[cells.node]))
        e, k = cells.corners[near], slack.shape[1]
        slopes = self.limits.slopes(cells.node[near].repeat(k), e.reshape(-1, cells.d), arcs)
        given = slack[near].ravel()
        safe = given > lids.multipliers(given, slopes) @ lids.a
        entered = np.zeros(len(cells.node), dtype=np.intp)
        entered[near] = np.sum(~safe.reshape(-1, k), axis=1)
        return entered

    def _with(self, entered: Numbers) -> "ArcSearch":
        """Choose the cells that are entered at all corners, or as narrow as possible; divide other ones.

        So the ends of arcs are as exact as the narrowest cells, and inside arcs are wider ones.
        """
        cells, corners = self.cells, self.slacks.base.shape[1]
        parts = (entered > 0) & ((cells.size > FINER) | (cells.size > 1) & (entered < corners))
        chosen = replace(cells, chosen=cells.chosen | (entered > 0) & ~parts)
        if not parts.any():
            return replace(self, cells=chosen)
        divided, from_old = chosen.divided(parts)
        slacks = Slacks(*(part[from_old] for part in self.slacks))
        new = parts[from_old]
        for part, values in zip(
            slacks, self.limits.slacks(divided.node[new], divided.corners[new]), strict=True
        ):
            part[new] = values
        return replace(self, cells=divided, slacks=slacks)


@dataclass(frozen=True, eq=False)
class FoundArcs:
    """Arcs and lids that prove shakedown at every load factor up to one."""

    search: ArcSearch
    load_factor: float
    arcs: Arcs
    lids: Lids


def search_about(limits: ArcLimits, parts: int) -> ArcSearch:
    """A search with no cell chosen yet; cells may be divided into a number of parts."""
    cells = all_cells(_origins(limits.problem), limits.problem.directions, parts)
    return ArcSearch(limits, cells, limits.slacks_around(cells, parts))


def farthest(low: FoundArcs, at: float, accuracy: float) -> tuple[FoundArcs, NoLids | None]:
    """The largest load factor, to some relative accuracy, and why it is no larger.

    From one that is proved and one to be tried next. Conditions at a load factor cover all smaller ones.
    """
    first, high, why = low.load_factor, inf, None
    for _ in range(2 * HALVINGS):
        if high - low.load_factor <= accuracy * high < inf or at > LARGEST:
            break
        try:
            low = low.search.closed(at)
            at = min(2.0 * at - first, 0.5 * (at + high))
        except NoLids as reason:
            high, why = at, reason
            at = 0.5 * (low.load_factor + high)
    return low, why
