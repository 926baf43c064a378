"""Which nodes stay open: the zone that the mean load suggests, and better ones."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import reduce
from itertools import chain, combinations
from math import inf
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.discs.disc_rows import DiscRows, zone_rows
from shakedown.bounds.discs.scaled_solution import safest
from shakedown.bounds.largest_load_factor import largest_load_factor
from shakedown.ground.constants import ALL_PAIRS_UP_TO, ALL_SUBSETS_UP_TO, NEGLIGIBLE, FloatArray
from shakedown.ground.errors import SolverError, UsageError
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import require_problem
from shakedown.joint.constraints import by_side
from shakedown.joint.contact_zone import Zone, contact_zone, coupled_parts
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem

PATIENCE = 10  # simultaneous changes allowed without reducing the number of nodes on the wrong side
ALONE = 4  # single changes per node after which the search ends

Mask = NDArray[np.bool_]


def opened_by_mean_load(problem: Problem, *, friction: bool = True) -> tuple[int, ...]:
    """The nodes that open under the mean load, closed ones not slipping, or sliding without friction.

    All nodes that pull or overlap change sides at once, as long as they become fewer; then the last of
    them alone (block principal pivoting, J. J. Júdice and F. M. Pires, Comput. Oper. Res. 21, 1994, 587).
    Without friction that ends in the solution, which is one only; with stuck nodes there may be none or many.
    None opens without C.

    Examples
    --------
    >>> import shakedown
    >>> opened_by_mean_load(shakedown.example("receding-block"), friction=False)[:3]
    (0, 1, 2)
    """
    if problem.C is None:
        return ()
    is_open, best = np.zeros(problem.n, dtype=bool), problem.n + 1
    patience, alone = PATIENCE, ALONE * problem.n
    while (wrong := _on_the_wrong_side(problem, is_open, friction)).any() and alone:
        if wrong.sum() < best:
            best, patience = int(wrong.sum()), PATIENCE
        elif patience:
            patience -= 1
        else:
            wrong[: np.flatnonzero(wrong)[-1]] = False
            alone -= 1
        is_open ^= wrong
    return tuple(int(i) for i in np.flatnonzero(is_open))


def _on_the_wrong_side(problem: Problem, is_open: Mask, friction: bool) -> Mask:
    """Closed nodes that pull and open ones that overlap, with these open under the mean load, (n,)."""
    kappa, layout, loop = problem.kappa, problem.layout, loading(problem)
    r_w, gaps = layout.joined(loop.q0, loop.p0), layout.gaps
    free = np.flatnonzero(layout.joined(np.repeat(is_open | (not friction), layout.d), is_open))
    u = layout.zeros()
    u[free] = _equilibrium(kappa[np.ix_(free, free)], -r_w[free])
    p = r_w[gaps] + kappa[gaps] @ u
    noise = np.abs(r_w[gaps]) + np.abs(kappa[gaps]) @ np.abs(u)
    return np.where(is_open, u[gaps] < 0, p < -8 * problem.n * np.finfo(float).eps * noise)


def _equilibrium(stiffness: FloatArray, force: FloatArray) -> FloatArray:
    """Displacements under a force; the smallest ones where a rigid motion leaves them open."""
    try:
        u = np.linalg.solve(stiffness, force)
    except np.linalg.LinAlgError:
        u = np.full(len(force), np.inf)
    with np.errstate(invalid="ignore"):
        left = np.abs(stiffness @ u - force).max(initial=0.0)
    if left <= NEGLIGIBLE * np.abs(force).max(initial=0.0):
        return np.asarray(u)
    return np.asarray(np.linalg.lstsq(stiffness, force, rcond=None)[0])


INSIDE = 1.05  # ratio σ / |y| from which on multipliers are well inside their cone


@dataclass(frozen=True, eq=False)
class ZoneLimit:
    """λ_max of a contact zone that is compared with others.

    Attributes
    ----------
    load_factor
        −inf where the zone has no safe slip, inf where nothing limits it.
    x : (k,)
        Where it is reached, in the unknowns of programs; empty without a limit.
    multipliers : (3j + o,)
        Of discs and half-spaces; empty where nothing limits it.
    margin
        By how much (negative) its limits exclude every slip under the mean load [length]; else 0: it tells
        zones without a safe slip apart.
    """

    load_factor: float
    x: FloatArray
    multipliers: FloatArray
    margin: float = 0.0


def zone_limit(zone: Zone, compared: bool, tolerances: Tolerances) -> ZoneLimit:
    """λ_max of a zone; ``compared``: with its margin where it has no safe slip."""
    rows, nothing = zone_rows(zone), np.zeros(0)
    found = largest_load_factor(rows, None, True, tolerances)
    if found.status == Status.UNBOUNDED:
        return ZoneLimit(inf, nothing, nothing)
    if found.status == Status.OPTIMAL:
        return ZoneLimit(found.load_factor, found.x, found.multipliers)
    margin = safest(rows, 0.0, tolerances).margin if compared else 0.0
    return ZoneLimit(-inf, nothing, np.nan_to_num(found.multipliers), margin)


def change_weights(zone: Zone, found: ZoneLimit, tolerances: Tolerances) -> dict[int, float]:
    """How strongly limits ask for a node to be opened (at its apex), and for a gap to be closed (it presses).

    Without a safe slip (an empty x) a node is at its apex where its multipliers point inside the cone.
    """
    rows, x, load_factor = zone_rows(zone), found.x, found.load_factor
    H = rows.half_spaces
    y, z = np.split(found.multipliers, [3 * len(rows.c)])
    y = y.reshape(-1, 3)
    weight = z * np.maximum(np.abs(H.G).max(axis=1, initial=0.0), np.abs(H.d))
    of_disc, of_half_space = _terms(rows, x, load_factor)
    parts = z * of_half_space  # in λ: what carries nothing is round-off of interior points
    largest = max(parts.max(initial=0.0), (np.abs(y).max(axis=1) * of_disc).max(initial=0.0))
    pressing = np.flatnonzero(~H.sided & (weight > 0) & (parts > NEGLIGIBLE * largest))
    weights = {int(H.node[k]): float(weight[k]) for k in pressing}
    if rows.in_plane:
        return weights | _at_apex_in_plane(zone, rows, found, weight, tolerances)
    sizes = np.abs(rows.stiffness).max(axis=(1, 2))
    shares = (rows.sums @ y[:, 0]) * np.maximum(sizes, _largest_load(rows))
    if x.size:
        s = rows.c + load_factor * rows.e + (rows.flat @ x).reshape(-1, 3)[rows.node]
        terms = (np.abs(rows.flat) @ np.abs(x)).reshape(-1, 3)[rows.node] + np.abs(rows.c)
        apex = (np.abs(s) <= tolerances.feasibility * terms.max(axis=1)[:, None]).all(axis=1)
    else:
        apex = y[:, 0] > INSIDE * np.hypot(y[:, 1], y[:, 2])
        apex &= y[:, 0] > NEGLIGIBLE * y[:, 0].max(initial=0.0)
    for node in np.unique(rows.node[apex]).tolist():
        weights[int(rows.names[node])] = float(shares[node])
    return weights


def _at_apex_in_plane(
    zone: Zone, rows: DiscRows, found: ZoneLimit, weight: FloatArray, tolerances: Tolerances
) -> dict[int, float]:
    """Closed nodes both of whose limits are active: pressure and shear vanish at their extreme steps."""
    H = rows.half_spaces
    shares, nodes = by_side(weight[H.sided]), by_side(H.node[H.sided])[:, 0]
    active = shares > 0
    if found.x.size:
        excess = H.relative_excess(H.slips(found.x), found.load_factor)
        active = by_side(np.abs(excess[H.sided]) <= tolerances.feasibility)
    lifting = active.all(axis=1) & (zone.problem.f[nodes] > 0)  # without friction the pressure is a row
    return dict(zip(nodes[lifting].tolist(), shares[lifting].sum(axis=1).tolist(), strict=True))


def limits_left(zone: Zone, found: ZoneLimit) -> tuple[NDArray[np.intp], FloatArray]:
    """How near nodes are to opening or closing: nodes (k,), what f p and half-spaces leave over the terms."""
    rows, x, load_factor = zone_rows(zone), found.x, found.load_factor
    limits = rows.c[:, 0] + load_factor * rows.e[:, 0] + (rows.stiffness[:, 0] @ x)[rows.node]
    sizes = np.concatenate(_terms(rows, x, load_factor))
    left = np.append(limits, rows.slack(x, load_factor)[1]) / np.where(sizes > 0, sizes, 1.0)
    return np.append(rows.names[rows.node], rows.half_spaces.node), left


def _terms(rows: DiscRows, x: FloatArray, load_factor: float) -> tuple[FloatArray, FloatArray]:
    """The terms of discs (j,) and half-spaces (o,) added up; without slips those of the mean load."""
    H = rows.half_spaces
    if not x.size:
        return np.abs(rows.c).max(axis=1, initial=0.0), np.abs(H.g) if len(rows.c) else np.ones_like(H.g)
    of_slip = (np.abs(rows.flat) @ np.abs(x)).reshape(-1, 3)[rows.node]
    discs = (of_slip + np.abs(rows.c) + load_factor * np.abs(rows.e)).max(axis=1)
    return discs, np.abs(H.coefficients) @ np.abs(x) + np.abs(H.g) + load_factor * np.abs(H.d)


def _largest_load(rows: DiscRows) -> FloatArray:
    found = np.zeros(len(rows.stiffness))
    np.maximum.at(found, rows.node, np.abs(rows.e).max(axis=1))
    return found


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
