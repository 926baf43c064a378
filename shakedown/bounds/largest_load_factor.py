"""The largest load factor with a safe slip, and what proves it; which nodes stay open, by a search.

λ_max in space, call by call:

1. ``upper.upper_bound`` (public) has ``chosen_zone`` say which nodes stay open; ``disc_rows.zone_rows``
   writes the limits, one disc a node and load step.
2. Here ``_solved`` states the program in numbers near 1 and has it solved by
   ``scaled_solution.solve_scaled``.
3. ``solve_scaled`` calls ``programs.self_dual.solve_discs``: there λ_max is computed, by interior points.
   Back in ``solve_scaled`` Newton's method brings it to round-off.
4. Back here, ``_proved`` proves two load factors around it (``enclosure``).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import reduce
from itertools import chain, combinations
from math import inf, nan
from typing import Literal

import numpy as np

from shakedown.bounds import certificate
from shakedown.bounds.certificate import Disputed
from shakedown.bounds.disc_rows import DiscRows, zone_rows
from shakedown.bounds.enclosure import UNPROVED, enclosed, proved_infeasible, proved_unbounded
from shakedown.bounds.scaled_solution import Limits, UnscaledSolution, safest, scaled_discs, solve_scaled
from shakedown.ground.constants import ALL_PAIRS_UP_TO, ALL_SUBSETS_UP_TO, CONE, NEGLIGIBLE, FloatArray, Mask
from shakedown.ground.errors import Missing, SolverError, UsageError, attempt
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import require_problem
from shakedown.joint.constraints import by_side, loading
from shakedown.joint.contact_zone import Zone, contact_zone, coupled_parts
from shakedown.joint.problem import Problem
from shakedown.programs.program import NOWHERE, Solution
from shakedown.programs.self_dual import USABLE
from shakedown.programs.simplex import chebyshev_centre, solve


@dataclass(frozen=True, eq=False)
class Largest:
    """The largest load factor with a safe slip, and what proves it; named as a ``Bound`` is.

    Attributes
    ----------
    x : (k,)
        Slips, or where unbounded their direction, at the unknowns of programs [length].
    y : (j, 3), z : (o,)
        Multipliers of discs and half-spaces.
    active_limits
        The discs and half-spaces that determine it.
    end
        The end of the program that it is from, in the plane a linear one; of an unbounded one in space
        that of the program of the least load factor.
    """

    status: Status
    load_factor: float
    x: FloatArray
    y: FloatArray
    z: FloatArray
    active_limits: Limits
    residual: float
    least_load_factor: float = nan
    certified: tuple[float, float] | None = None
    exact: bool = False
    uncertified: str = ""
    missing: tuple[str, ...] = ()
    reduced_accuracy: bool = False
    disputed: bool = False
    end: UnscaledSolution | Solution | None = None

    @property
    def multipliers(self) -> FloatArray:
        """Of all rows, (3j + o,)."""
        return np.append(self.y.ravel(), self.z)


def largest_load_factor(
    rows: DiscRows, certified_for: Problem | None, balanced: bool, tolerances: Tolerances
) -> Largest:
    """λ_max of some limits, certified for the joint whose limits they are where it is given.

    ``balanced``: whether the loading has its own mean, so that a slip that is safe at any load factor is
    safe under the mean. Undecided where there seems to be no limit, but no direction of slips shows it.

    Raises
    ------
    SolverError
        If there is no end, or one that is not proved and misses its own conditions.
    """
    found = _limit(rows, balanced, tolerances)
    if certified_for is not None:
        proved = _by_exact_arithmetic if rows.in_plane else _by_enclosures
        found = proved(certified_for, rows, found, tolerances)
    if found.status == Status.UNBOUNDED and not (found.exact or found.residual <= tolerances.feasibility):
        return replace(found, status=Status.UNDECIDED, load_factor=nan, x=np.full_like(found.x, nan))
    if rows.in_plane or found.status != Status.OPTIMAL or found.certified is not None:
        return found
    missed = _missed(rows, found)
    if not missed <= tolerances.stored_digits:
        raise SolverError(
            f"the largest load factor misses its own conditions: a relative residual of {missed:.1e}"
        )
    return replace(found, reduced_accuracy=found.reduced_accuracy or missed > tolerances.agreement)


def _missed(rows: DiscRows, found: Largest) -> float:
    """How far an optimum breaks its limits, relative to the loads, or is from what its multipliers prove.

    What is left of the balance of multipliers counts at the slips found.
    """
    x, at, y, z, H = found.x, found.load_factor, found.y, found.z, rows.half_spaces
    loads = np.maximum(np.abs(rows.c), at * np.abs(rows.e)).max(axis=1)
    sizes = np.maximum(loads, NEGLIGIBLE * loads.max())  # a smaller load is no scale of its own
    broken = float(np.max(-rows.slack(x, at)[0] / np.where(sizes > 0, sizes, 1.0), initial=0.0))
    balance = (rows.sums @ y).ravel() @ rows.flat - z @ H.coefficients
    gap = abs(np.vdot(y, rows.c) + z @ H.g - at) + np.abs(balance) @ np.abs(x)
    terms = np.vdot(np.abs(y), np.abs(rows.c)) + np.abs(z) @ np.abs(H.g)
    return max(found.residual, broken, float(gap / (terms if terms > 0 else 1.0)))


def relieving(rows: DiscRows) -> bool:
    """Whether the periodic loads bring no node nearer to its limits."""
    slack = rows.e[:, 0] - np.hypot(rows.e[:, 1], rows.e[:, 2])
    return bool(np.all(slack >= 0) and np.all(rows.half_spaces.d <= 0))


def _limit(rows: DiscRows, balanced: bool, tolerances: Tolerances) -> Largest:
    """The limit by programs."""
    direction = np.zeros(rows.stiffness.shape[-1])
    if rows.in_plane or not relieving(rows):
        found = _solved(rows, -1.0, tolerances)
        if found.status == Status.OPTIMAL:
            # λ_lo = 0 where λ_max is, as it is no larger
            least, missing = _lambda_lo(rows, balanced or not found.load_factor, tolerances)
            return replace(found, least_load_factor=least, missing=missing)
        if found.status != Status.UNBOUNDED:
            return found
        direction = found.x
    if rows.in_plane:
        along, end = _direction(rows, tolerances), found.end
        least, missing = _lambda_lo(rows, balanced, tolerances)
        if isinstance(along, Missing):
            missing = (*missing, f"direction: {along.reason}")
            return replace(found, load_factor=inf, residual=nan, least_load_factor=least, missing=missing)
        direction = along
    else:
        start = _solved(rows, +1.0, tolerances)
        if start.status != Status.OPTIMAL:
            return start
        least, missing, end = _unless_safe_at_mean(rows, start, tolerances), (), start.end
    none, nothing = np.zeros_like(rows.c), np.zeros_like(rows.half_spaces.g)
    return Largest(
        Status.UNBOUNDED, inf, direction, none, nothing, NOWHERE, _excess_along(rows, direction),
        least_load_factor=least, missing=missing, end=end,
        reduced_accuracy=rows.in_plane and found.reduced_accuracy,
    )  # fmt: skip


def _solved(rows: DiscRows, towards: float, tolerances: Tolerances) -> Largest:
    """The end of a program of these limits; usually just computed, by the search of the zone."""
    if (towards, tolerances) not in rows.solved:
        rows.solved[towards, tolerances] = _extreme_load_factor(rows, towards, tolerances)
    return rows.solved[towards, tolerances]


def _extreme_load_factor(rows: DiscRows, towards: float, tolerances: Tolerances) -> Largest:
    """The largest (−1) or the smallest (+1) load factor, or that no slip is safe, which multipliers show.

    By a linear program over the rows in the plane, in space by a cone program over discs.
    """
    H, missing = rows.half_spaces, tuple[str, ...]()
    if rows.in_plane:
        linear = solve(certificate.load_factor_program(H, towards, tolerances))
        end: UnscaledSolution | Solution = linear
        x, at, y, z = linear.x[:-1], float(linear.x[-1]), np.zeros((0, CONE)), np.zeros_like(H.g)
        active = NOWHERE
        if linear.optimal:
            z, active = linear.multipliers, (rows.node, linear.meeting[0])
        elif linear.status == Status.INFEASIBLE:
            against = attempt(certificate.contradiction, H, tolerances)
            if isinstance(against, Missing):
                z, missing = np.full_like(H.g, nan), (f"multipliers: {against.reason}",)
            else:
                z, active = against.multipliers, (rows.node, np.flatnonzero(against.multipliers))
    else:
        usable = tolerances.stored_digits if towards < 0 else USABLE  # the largest is computed anew
        end = conic = solve_scaled(scaled_discs(rows, towards), usable)
        x, at, y, z, active = conic.x, conic.load_factor, conic.y, conic.z, conic.active_limits
    residual = rows.relative_excess(x, at) if end.optimal else _imbalance(rows, y, z)
    reduced = end.reduced_accuracy
    return Largest(
        end.status, at, x, y, z, active, residual, reduced_accuracy=reduced, missing=missing, end=end
    )


def _direction(rows: DiscRows, tolerances: Tolerances) -> FloatArray | Missing:
    """x with G v + d ≤ 0 in the plane, with slack where possible."""
    H = rows.half_spaces
    if relieving(rows):
        return np.zeros(H.n)
    norms = np.linalg.norm(H.G, axis=1)
    cap = float(np.max(np.abs(H.d)[norms > 0] / norms[norms > 0], initial=0.0))
    found = attempt(chebyshev_centre, H.coefficients, norms, -H.d, cap=cap, tolerances=tolerances)
    return found if isinstance(found, Missing) else found.x


def _by_exact_arithmetic(problem: Problem, rows: DiscRows, found: Largest, tolerances: Tolerances) -> Largest:
    """The limit of a joint in the plane as exact arithmetic has it, its status included."""
    if not isinstance(found.end, Solution):
        return found
    exact = attempt(certificate.certified_upper, problem, found.end, tolerances)
    if isinstance(exact, Missing):
        return replace(found, uncertified=exact.reason, disputed=isinstance(exact, Disputed))
    proved = replace(
        found,
        status=exact.status,
        load_factor=exact.load_factor,
        x=np.full(len(exact.slip), nan),
        z=exact.multipliers,
        active_limits=(rows.node, np.array(exact.rows, dtype=np.intp)),
        exact=True,
    )
    if exact.status == Status.INFEASIBLE:
        residual = _imbalance(rows, found.y, exact.multipliers)
        return replace(proved, residual=residual, least_load_factor=nan, missing=())
    if found.status == Status.INFEASIBLE:  # at loosened tolerances
        least, missing = _lambda_lo(rows, False, tolerances)
        proved = replace(proved, least_load_factor=least, missing=missing)
    if exact.status == Status.UNBOUNDED:
        known = found.status == Status.UNBOUNDED and found.residual <= 0
        x = found.x if known else exact.slip
        residual = _excess_along(rows, x)
    else:
        x = certificate.significant(rows.half_spaces, exact.slip, exact.load_factor, tolerances)[:-1]
        residual = rows.relative_excess(x, exact.load_factor)
    return replace(proved, x=x, residual=residual, certified=(exact.low, exact.high))


def _lambda_lo(rows: DiscRows, balanced: bool, tolerances: Tolerances) -> tuple[float, tuple[str, ...]]:
    """λ_lo; NaN where its program fails, and that it did."""
    H, still = rows.half_spaces, np.hypot(rows.c[:, 1], rows.c[:, 2]) <= rows.c[:, 0]
    # a safe slip is safe at every smaller load factor; or v = 0 is safe under the mean load
    if balanced or (np.all(still) and np.all(H.g >= 0)) or (rows.in_plane and np.all(H.d >= 0)):
        return 0.0, ()
    found = attempt(_solved, rows, +1.0, tolerances)
    if isinstance(found, Missing):
        return nan, (f"λ_lo: {found.reason}",)
    return (_unless_safe_at_mean(rows, found, tolerances) if found.status == Status.OPTIMAL else nan), ()


def _unless_safe_at_mean(rows: DiscRows, found: Largest, tolerances: Tolerances) -> float:
    """The least load factor at which a slip is safe, 0 where this one is so under the mean load."""
    safe = rows.relative_excess(found.x, 0.0) <= tolerances.feasibility
    return 0.0 if safe else max(found.load_factor, 0.0)


def _imbalance(rows: DiscRows, y: FloatArray, z: FloatArray) -> float:
    """What is left of the balance of multipliers, relative to its terms."""
    balance = (rows.sums @ y).ravel() @ rows.flat - z @ rows.half_spaces.coefficients
    terms = (rows.sums @ np.abs(y)).ravel() @ np.abs(rows.flat)
    terms = terms + np.abs(z) @ np.abs(rows.half_spaces.coefficients)
    return float(np.max(np.abs(balance) / np.where(terms > 0, terms, 1.0), initial=0.0))


def _excess_along(rows: DiscRows, direction: FloatArray) -> float:
    """The largest relative violation of e + N v along a direction."""
    gaps = replace(rows.half_spaces, g=-rows.half_spaces.d, d=np.zeros_like(rows.half_spaces.d))
    return replace(rows, c=rows.e, e=np.zeros_like(rows.e), half_spaces=gaps).relative_excess(direction, 0.0)


def _by_enclosures(problem: Problem, rows: DiscRows, found: Largest, tolerances: Tolerances) -> Largest:
    """The limit of a joint in space with what is proved of it."""
    end = found.end
    if not isinstance(end, UnscaledSolution):
        return found
    if found.status == Status.OPTIMAL:
        enclosure = enclosed(problem, rows, end, tolerances)
        if isinstance(enclosure, Missing):
            return replace(found, uncertified=enclosure.reason)
        at = float(np.clip(found.load_factor, *enclosure))
        return replace(found, load_factor=at, certified=enclosure, exact=True)
    if found.status == Status.INFEASIBLE:
        proved = proved_infeasible(problem, rows, end)
        return replace(found, exact=proved, uncertified="" if proved else UNPROVED)
    beyond = end.load_factor + end.scaled.load_unit
    far = [safest(rows, beyond).x, end.x + end.scaled.load_unit * found.x]
    if not proved_unbounded(problem, rows, found.x, [*((x, beyond) for x in far), (0.0 * found.x, 0.0)]):
        return replace(found, uncertified=UNPROVED)
    return replace(found, certified=(inf, inf), exact=True)


BLOCK_CHANGES = 10  # simultaneous changes allowed without reducing the number of nodes on the wrong side


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
    spare_changes, alone = BLOCK_CHANGES, 4 * problem.n
    while (wrong := _on_the_wrong_side(problem, is_open, friction)).any() and alone:
        if wrong.sum() < best:
            best, spare_changes = int(wrong.sum()), BLOCK_CHANGES
        elif spare_changes:
            spare_changes -= 1
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
    found = attempt(largest_load_factor, zone_rows(zone), None, True, tolerances)
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
