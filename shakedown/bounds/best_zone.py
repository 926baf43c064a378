"""Which nodes stay open: the zone that the mean load suggests, and better ones."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import reduce
from itertools import chain, combinations
from math import inf
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.discs.disc_rows import zone_rows
from shakedown.bounds.largest_load_factor import largest_load_factor
from shakedown.ground.constants import ALL_PAIRS_UP_TO, ALL_SUBSETS_UP_TO, CONE, NEGLIGIBLE, FloatArray
from shakedown.ground.errors import Missing, UsageError, sought
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import require_problem
from shakedown.joint.constraints import by_side, loading
from shakedown.joint.contact_zone import Zone, contact_zone, coupled_parts
from shakedown.joint.problem import Problem

PATIENCE = 10  # simultaneous changes allowed without reducing the number of nodes on the wrong side

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
    # single changes per node after which the search ends
    patience, alone = PATIENCE, 4 * problem.n
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


def nearest_to_change(zone: Zone, x: FloatArray, load_factor: float) -> tuple[int, ...]:
    """All nodes in increasing order of what their pressures and gaps leave, relative to the terms of each.

    At slips (k,). Those at a limit up to round-off keep their order.
    """
    rows, H = zone_rows(zone), zone_rows(zone).half_spaces
    left = [rows.c[:, 0] + load_factor * rows.e[:, 0] + (rows.stiffness[:, 0] @ x)[rows.node]]
    terms = [np.abs(rows.c).max(axis=1, initial=0.0) + load_factor * np.abs(rows.e).max(axis=1, initial=0.0)]
    terms[0] += (np.abs(rows.flat) @ np.abs(x)).reshape(-1, CONE).max(axis=1, initial=0.0)[rows.node]
    slack = H.g - H.coefficients @ x - load_factor * H.d
    sizes = np.abs(H.coefficients) @ np.abs(x) + np.abs(H.g) + load_factor * np.abs(H.d)
    sided = H.sided & rows.in_plane  # f p is half of what the two limits of a node leave
    left += [by_side(slack[sided]).sum(axis=1), slack[~sided]]
    terms += [by_side(sizes[sided]).sum(axis=1), sizes[~sided]]
    nodes = np.concatenate([rows.names[rows.node], by_side(H.node[sided])[:, 0], H.node[~sided]])
    size = np.concatenate(terms)
    shares = np.concatenate(left) / np.where(size > 0, size, 1.0)
    least = np.full(zone.problem.n, inf)
    np.minimum.at(least, nodes, np.where(np.abs(shares) > NEGLIGIBLE, shares, 0.0))
    return tuple(np.argsort(least, kind="stable").tolist())


NEAREST = 4  # nodes nearest to opening or closing that are tried in large joints


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
    """One zone, None where all nodes are open or nothing holds the open ones, with its λ_max.

    −inf where it has no safe slip, inf where nothing limits it; whether its program came to an end, and the
    nodes to change, those first that come nearest to opening or closing, of a limit.
    """

    nodes: tuple[int, ...]
    zone: Zone | None = None
    load_factor: float = -inf
    ended: bool = True
    nearest: tuple[int, ...] = ()


Visitor = Callable[[tuple[int, ...]], _Visit]


def best_zone(problem: Problem, *, tolerances: Tolerances = DEFAULT) -> ZoneSearch:
    """Search the contact zone with the largest λ_max, one node at a time.

    It begins with the nodes that the mean load opens, sliding without friction or stuck, or with no open
    node at all. One node is changed at a time while λ_max grows, the one nearest to opening or closing first;
    beyond sixteen nodes the four nearest ones are tried. Where the mean load opens no node and the joint has
    a safe slip, that is the answer at once; else up to six nodes every zone is tried. The state without
    friction is safe under the mean load: what friction alone holds has none, every other joint a zone with
    a safe slip.

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
        # each costs a program; beyond them one
        if len(visited) >= 100:  # counts as without a safe slip, so that the search ends
            return _Visit(nodes)
        visited[nodes] = _visit(problem, nodes, tolerances)
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
            starts.sort(key=lambda nodes: visit(nodes).load_factor, reverse=True)
            few = problem.n <= ALL_PAIRS_UP_TO
            found = [_climb(visit, start, few) for start in (starts if few else starts[:1])]
        best = _first_of_the_best(found)
    zone = best.zone
    if zone is None:  # all nodes open is no zone, and a state that may be reached: nothing is impossible then
        nearly = (one.zone for nodes, one in visited.items() if len(nodes) == problem.n - 1)
        zone = next(filter(None, nearly), contact_zone(problem, ()))
    seen = sum(len(nodes) < problem.n and one.ended for nodes, one in visited.items())
    return ZoneSearch(zone, best.load_factor, opened, len(visited), seen < most)


def _first_of_the_best(found: Iterable[_Visit]) -> _Visit:
    """The first of the zones that are equally good up to round-off."""

    def better(best: _Visit, other: _Visit) -> _Visit:
        return other if other.load_factor > best.load_factor * (1.0 + NEGLIGIBLE) else best

    return reduce(better, found)


def _climb(visit: Visitor, start: tuple[int, ...], few: bool) -> _Visit:
    """Climb from one zone to better ones, each differing in one node.

    To the best by one of the nodes nearest to opening or closing; of joints of few nodes others come next.
    """
    best = visit(start)
    while True:  # ends, as every step is better than all before, and zones are finitely many
        nearest = best.nearest if best.zone else best.nodes  # what nothing holds is closed again
        for nodes in (nearest[:NEAREST], nearest[NEAREST:] if few else ()):
            better = _first_of_the_best([best, *(visit(_changed(best, node)) for node in nodes)])
            if better is not best:
                break
        else:
            return best
        best = better


def _visit(problem: Problem, nodes: tuple[int, ...], tolerances: Tolerances) -> _Visit:
    """One zone; one whose program does not finish counts as without a safe slip, and is left out."""
    try:
        zone = contact_zone(problem, nodes, tolerances=tolerances)
    except UsageError:  # all nodes open, or open nodes that nothing holds
        return _Visit(nodes)
    found = sought(largest_load_factor, zone_rows(zone), None, True, tolerances)
    if isinstance(found, Missing):
        return _Visit(nodes, zone, ended=False)
    if found.status != Status.OPTIMAL:
        return _Visit(nodes, zone, inf if found.status == Status.UNBOUNDED else -inf)
    nearest = nearest_to_change(zone, found.x, found.load_factor)
    return _Visit(nodes, zone, found.load_factor, nearest=nearest)


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
