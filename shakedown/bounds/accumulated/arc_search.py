"""The search for arcs of slip directions outside which no node ever reaches its limit at a load factor."""

from dataclasses import dataclass, replace
from math import inf
from typing import NamedTuple

import numpy as np

from shakedown.bounds.accumulated.lids import MARGIN, Lids, NoLids, lids_of
from shakedown.bounds.accumulated.slip_arcs import Arcs, Cells, Flags, Numbers, all_cells
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import HALVINGS, NEGLIGIBLE
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.numbers import LARGEST
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
        self._start, self._error = start.reshape(n, d), start_error
        self.reach = np.linalg.norm(self._fB, axis=2) + np.linalg.norm(self._A, axis=(1, 3))

    def slacks(self, node: Numbers, e: FloatArray) -> Slacks:
        """Of nodes (c,) in directions (c, k, d), (c, k): at the initial slip, wherever within its error."""
        found = Slacks(*(np.empty(e.shape[:2]) for _ in Slacks._fields))
        for i in np.unique(node).tolist():
            for part, values in zip(found, self._slacks_of(i, e[node == i]), strict=True):
                part[node == i] = values
        return found

    def _slacks_of(self, i: int, e: FloatArray) -> Slacks:
        fB, A, start = self._fB[i], self._A[i], self._start
        locked = np.sum(fB * start) + e @ np.sum(A * start, axis=(1, 2))
        terms = np.sum(np.abs(fB * start)) + np.abs(e) @ np.sum(np.abs(A * start), axis=(1, 2))
        off = np.flatnonzero(self._error)
        rows = fB[off] + np.einsum("cke,ejx->ckjx", e, A[:, off])
        locked -= np.linalg.norm(rows, axis=3) @ self._error[off] + NEGLIGIBLE * terms
        loop, before = loading(self.problem), self.problem.layout.split(transient_path(self.problem))
        mean = self._least(i, e, loop.q0[None], loop.p0[None])
        fall = np.maximum(-self._least(i, e, loop.q1, loop.p1), 0.0)
        return Slacks(mean + locked, fall, self._least(i, e, *before) + locked)

    def _least(self, i: int, e: FloatArray, q: FloatArray, p: FloatArray) -> FloatArray:
        """The smallest f p + e · q over load steps, less a margin; inf where there is none."""
        q, p = self.problem.layout.by_node(q)[:, i].T, self.problem.f[i] * p[:, i]
        values = p + e @ q - NEGLIGIBLE * (np.abs(p) + np.abs(e) @ np.abs(q))
        return np.asarray(values.min(axis=-1, initial=np.inf))

    def check_pressed(self, load_factor: float) -> None:
        """Raise ``NoLids`` unless the first load presses all nodes, at every load factor up to one.

        The load rises to it under these pressures; where it admits the initial slip they are positive anyway.
        """
        problem, loop = self.problem, loading(self.problem)
        before = problem.layout.split(transient_path(problem))[1]
        first = before[:1] if len(before) else np.stack([loop.p0, loop.p0 + load_factor * loop.p1[0]])
        p = first.min(axis=0) + problem.B @ self._start.ravel()
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
            entered = search._entered(load_factor, arcs, lids)
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

    def _entered(self, load_factor: float, arcs: Arcs, lids: Lids) -> Flags:
        """The cells outside the arcs in which a node may slip."""
        cells, slack = self.cells, self.slacks.at(load_factor)
        most = STRETCH * self.limits.reach[:, arcs.node] @ lids.total
        near = np.flatnonzero(~cells.chosen & (slack.min(axis=1) <= most[cells.node]))
        e, k = cells.corners[near], slack.shape[1]
        slopes = self.limits.slopes(cells.node[near].repeat(k), e.reshape(-1, cells.d), arcs)
        given = slack[near].ravel()
        safe = given > lids.multipliers(given, slopes) @ lids.a
        entered = np.zeros(len(cells.node), dtype=bool)
        entered[near] = ~safe.reshape(slack[near].shape).all(axis=1)
        return entered

    def _with(self, entered: Flags) -> "ArcSearch":
        """Divide cells, and choose those that are as narrow as possible."""
        cells, parts = self.cells, entered & self.cells.divisible
        chosen = replace(cells, chosen=cells.chosen | (entered & ~parts))
        if not parts.any():
            return replace(self, cells=chosen)
        divided = chosen.divided(parts)
        from_old = np.repeat(np.arange(len(cells.node)), np.where(parts, cells.size, 1))
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
    cells = all_cells(limits.problem.n, limits.problem.directions, parts)
    return ArcSearch(limits, cells, limits.slacks(cells.node, cells.corners))


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
