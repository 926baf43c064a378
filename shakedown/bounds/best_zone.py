"""Which nodes of a partly open joint stay open: the contact zone in which the load factor can be largest."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import reduce
from itertools import chain, combinations
from math import inf
from typing import Literal

import numpy as np

from shakedown.bounds.opened_by_mean_load import opened_by_mean_load
from shakedown.bounds.zone_limits import ZoneLimit, change_weights, limits_left, zone_limit
from shakedown.ground.errors import SolverError, UsageError
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.size_limits import ALL_PAIRS_UP_TO, ALL_SUBSETS_UP_TO
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import require_problem
from shakedown.joint.contact_zone import Zone, contact_zone
from shakedown.joint.coupled_parts import coupled_parts
from shakedown.joint.problem import Problem

NEIGHBOURS = 8  # changes tried per round, the most promising first
NEAREST = 4  # nodes nearest to opening or closing that are tried in large joints
MOST_ZONES = 100  # that are solved in a search: each costs a program


@dataclass(frozen=True)
class ZoneSearch:
    """Result of :func:`best_zone`.

    Attributes
    ----------
    zone
        The best zone that was found; of joints of more than six nodes there may be better ones.
    load_factor
        Its λ_max; −inf where no zone visited has a safe slip at any load factor.
    opened
        The nodes that the mean load opens, sliding without friction.
    visited
        Number of zones that were solved, at most 100.
    left_out
        Whether there are zones that were not: then one of them may have a safe slip where none was found.
    """

    zone: Zone
    load_factor: float
    opened: tuple[int, ...]
    visited: int
    left_out: bool


@dataclass(frozen=True)
class _Visit:
    """One zone, None where all nodes are open or nothing holds the open ones, with its λ_max."""

    nodes: tuple[int, ...]
    zone: Zone | None
    found: ZoneLimit

    @property
    def load_factor(self) -> float:
        """λ_max; −inf without a safe slip."""
        return self.found.load_factor

    @property
    def failed(self) -> bool:
        """Whether its program did not finish."""
        return self.zone is not None and self.found is NOTHING

    @property
    def rank(self) -> tuple[float, float]:
        """A better zone has a larger rank."""
        return self.load_factor, self.found.margin

    def surpasses(self, other: "_Visit") -> bool:
        """Whether this zone is better by more than round-off."""
        if other.load_factor == -inf:  # no relative margin can be added to this
            (_, margin), (_, least) = self.rank, other.rank
            more = NEGLIGIBLE * abs(least) if least > -inf else 0.0
            return self.load_factor > -inf or margin > least + more
        return self.load_factor > other.load_factor + NEGLIGIBLE * abs(other.load_factor)


NOTHING = ZoneLimit(-inf, np.zeros(0), np.zeros(0), -inf)
Visitor = Callable[[tuple[int, ...]], _Visit]


def best_zone(problem: Problem, *, tolerances: Tolerances = DEFAULT) -> ZoneSearch:
    """Search the contact zone with the largest λ_max, one node at a time.

    It begins with the nodes that the mean load opens, sliding without friction or stuck, or with no open
    node at all. Of a zone's program a gap with a multiplier wants its node closed, and a node at its apex
    (pressure and shear are gone) wants to open; one node is changed at a time while λ_max grows. Where the
    mean load opens no node and the joint has a safe slip, that is the answer at once; else up to six nodes
    every zone is tried. The state without friction is safe under the mean load: what friction alone
    holds has none, every other joint a zone with a safe slip.

    Parameters
    ----------
    problem
        The joint and its loading.
    tolerances
        The tolerances that decide.

    Examples
    --------
    >>> import shakedown
    >>> search = best_zone(shakedown.example("receding-block"))
    >>> search.zone.open_nodes == search.opened
    True
    >>> search.opened
    (0, 1, 2, 3, 4, 28, 29, 30, 31, 32)
    """
    require_problem(problem)
    visited = dict[tuple[int, ...], _Visit]()

    def visit(nodes: tuple[int, ...]) -> _Visit:
        if nodes in visited:
            return visited[nodes]
        if len(visited) >= MOST_ZONES:  # counts as without a safe slip, so that the search ends
            return _Visit(nodes, None, NOTHING)
        climbing = all(one.load_factor == -inf for one in visited.values())
        visited[nodes] = _visit(problem, nodes, climbing, tolerances)
        return visited[nodes]

    opened = opened_by_mean_load(problem, friction=False)
    starts = list(dict.fromkeys([opened, opened_by_mean_load(problem), ()]))
    best = _first_of_the_best(map(visit, starts))
    most = 1 if problem.C is None else 2**problem.n - 1
    if most > 1 and (len(starts) > 1 or best.load_factor == -inf):
        if problem.n <= ALL_SUBSETS_UP_TO:
            sizes = (combinations(range(problem.n), size) for size in range(1, problem.n))
            found = [visit(nodes) for nodes in chain([best.nodes], *sizes)]
        else:
            starts.sort(key=lambda nodes: visit(nodes).rank, reverse=True)
            few = problem.n <= ALL_PAIRS_UP_TO
            found = [_climb(visit, start, few, tolerances) for start in (starts if few else starts[:1])]
        best = _first_of_the_best(found)
    zone = contact_zone(problem, ()) if best.zone is None else best.zone
    seen = sum(len(nodes) < problem.n and not one.failed for nodes, one in visited.items())
    return ZoneSearch(zone, best.load_factor, opened, len(visited), seen < most)


def _first_of_the_best(found: Iterable[_Visit]) -> _Visit:
    """The first of the zones that are equally good up to round-off."""
    return reduce(lambda best, other: other if other.surpasses(best) else best, found)


def _climb(visit: Visitor, start: tuple[int, ...], few: bool, tolerances: Tolerances) -> _Visit:
    """Climb from one zone to better ones, each differing in one node, first those that its limits ask for.

    Of joints of few nodes to the best of them, else to the first that is better.
    """
    best = visit(start)
    while True:  # ends, as every step is better than all before, and zones are finitely many
        for neighbours in (_asked_for(best, tolerances), _nearest(best, None if few else NEAREST)):
            tried = map(visit, neighbours)
            better = next((one for one in tried if one.surpasses(best)), best)
            better = _first_of_the_best(chain([better], tried)) if few else better
            if better is not best:
                break
        else:
            return best
        best = better


def _visit(problem: Problem, nodes: tuple[int, ...], compared: bool, tolerances: Tolerances) -> _Visit:
    """One zone; ``compared``: with others without a safe slip, if it has none itself.

    A zone whose program does not finish counts as without a safe slip, and is left out.
    """
    try:
        zone = contact_zone(problem, nodes, tolerances=tolerances)
    except UsageError:  # all nodes open, or open nodes that nothing holds
        return _Visit(nodes, None, NOTHING)
    try:
        return _Visit(nodes, zone, zone_limit(zone, compared, tolerances))
    except SolverError:
        return _Visit(nodes, zone, NOTHING)


def _asked_for(visit: _Visit, tolerances: Tolerances) -> Iterator[tuple[int, ...]]:
    """Zones suggested by the multipliers of its limits, the strongest first, each differing in one node."""
    if visit.zone is None:  # open nodes that nothing holds are closed again
        yield from (_changed(visit, node) for node in visit.nodes[:NEIGHBOURS])
        return
    if len(visit.found.multipliers) == 0:  # unbounded, so there is no better zone
        return
    weights = change_weights(visit.zone, visit.found, tolerances)
    asked = sorted(weights, key=weights.__getitem__, reverse=True)[:NEIGHBOURS]
    yield from (_changed(visit, node) for node in asked)


def _nearest(visit: _Visit, count: int | None) -> Iterator[tuple[int, ...]]:
    """Zones that differ from a safe one in one of the nodes next to opening or closing."""
    yield from (_changed(visit, node) for node in _by_slack(visit)[:count])


def _by_slack(visit: _Visit) -> list[int]:
    """The nodes of a safe zone in increasing order of slack; empty for other zones.

    Nodes at a limit up to round-off keep their order.
    """
    if visit.zone is None or len(visit.found.x) == 0:
        return []
    nodes, slack = limits_left(visit.zone, visit.found)
    least = np.full(visit.zone.problem.n, inf)
    np.minimum.at(least, nodes, np.where(np.abs(slack) > NEGLIGIBLE, slack, 0.0))
    return [int(node) for node in np.argsort(least, kind="stable")]


def _changed(visit: _Visit, node: int) -> tuple[int, ...]:
    """The zone in which a node is open that is closed here, or the other way round."""
    return tuple(sorted({*visit.nodes} ^ {node}))


def chosen_zone(
    problem: Problem, open_nodes: Iterable[int] | Literal["auto"], tolerances: Tolerances = DEFAULT
) -> tuple[Zone, bool]:
    """The requested zone: given node by node, or ``"auto"`` for the best one found.

    With it whether that is a zone without a safe slip, and others were left out.
    """
    if not isinstance(open_nodes, str):
        return contact_zone(problem, open_nodes, tolerances=tolerances), False
    if open_nodes != "auto":
        raise UsageError(f"open nodes: expected node numbers or 'auto', found {open_nodes!r}")
    parts = coupled_parts(problem)
    searches = [best_zone(part.joint, tolerances=tolerances) for part in parts]
    if len(parts) > 1 and min(search.load_factor for search in searches) > -inf:
        best = zip(parts, searches, strict=True)
        opened = [part.number(node) for part, search in best for node in search.zone.open_nodes]
        return contact_zone(problem, opened, tolerances=tolerances), False
    search = searches[0] if len(parts) == 1 else best_zone(problem, tolerances=tolerances)
    return search.zone, search.left_out and search.load_factor == -inf
