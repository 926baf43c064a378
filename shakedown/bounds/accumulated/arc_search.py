"""Arcs of slip that are wide enough at a load factor: outside them no node ever reaches its limit."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from shakedown.bounds.accumulated.arc_limits import ArcLimits, Slacks
from shakedown.bounds.accumulated.lids import Lids, NoLids, lids_of
from shakedown.bounds.accumulated.slip_arcs import Arcs, Cells, Flags, all_cells
from shakedown.ground.round_off import HALVINGS
from shakedown.joint.numbers import LARGEST

ALL_AROUND = "all directions"
STRETCH = 1.001  # of directions at corners of cells, at most


@dataclass(frozen=True, eq=False)
class ArcSearch:
    """Cells of directions, some of them chosen, with the slacks of their corners."""

    limits: ArcLimits
    cells: Cells
    slacks: Slacks

    def closed(self, load_factor: float) -> "FoundArcs":
        """With as many more cells chosen as it takes that nodes slip in chosen ones only.

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
        """The cells outside the arcs in which a node may come to slip."""
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
        """With cells divided, and with those chosen that are as narrow as can be."""
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
    """Nothing chosen; the cells may be divided into so many parts."""
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
