"""λ_max, the load factor above which shakedown is impossible, and the safe slip."""

from collections.abc import Iterable
from dataclasses import fields, replace
from math import inf, nan
from typing import Any, Literal

import numpy as np

from shakedown.bounds.bound_result import Bound, LargestLoadFactor, SafeSlip
from shakedown.bounds.certificate import UPPER_CERTIFIED_UP_TO
from shakedown.bounds.disc_rows import DiscRows, zone_rows
from shakedown.bounds.largest_load_factor import chosen_zone, largest_load_factor, relieving
from shakedown.bounds.scaled_solution import safest, scaled_discs, solve_scaled
from shakedown.ground.constants import CONE, LARGE, FloatArray
from shakedown.ground.errors import Missing, attempt
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.joint.constraints import Constraints, transient_path
from shakedown.joint.contact_zone import Part, Zone, contact_zone, coupled_parts, of_slips, weakest
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.program import Program
from shakedown.programs.simplex import solve


@checked
def safe_slip(
    problem: Problem,
    load_factor: float,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = (),
    transient: bool = False,
    tolerances: Tolerances = DEFAULT,
) -> SafeSlip:
    """The safe slip farthest from slipping: max t with G v + t‖Gᵢ‖ ≤ g − λ d (thesis (5.4)).

    From this slip, locked in when the transient load steps are over, the system shakes down at
    once: no node ever moves. The transient itself may move it: ``transient``.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    load_factor
        λ ≥ 0, the factor on the periodic part of the loading.
    open_nodes, transient
        As for :func:`upper_bound`, which of a zone gives the least safe slip; this one has the most slack.
    tolerances
        ``feasibility`` decides what is safe.

    Raises
    ------
    UsageError
        If the load factor is negative or not finite, or nodes are open before the transient.

    Examples
    --------
    >>> import shakedown
    >>> safe = shakedown.safe_slip(shakedown.example("two-node"), 0.70)
    >>> safe.status.value, bool(safe.margin > 0)
    ('optimal', True)
    >>> shakedown.safe_slip(shakedown.example("two-node"), 0.75).status.value
    'infeasible'
    """
    check_load_factor(load_factor, problem)
    zone, _ = chosen_zone(problem, open_nodes, tolerances)
    return safest_slip(zone, load_factor, transient, tolerances)


def safest_slip(zone: Zone, load_factor: float, transient: bool, tolerances: Tolerances) -> SafeSlip:
    """:func:`safe_slip` of a contact zone."""
    rows = zone_rows(zone, transient)
    found = safest(rows, load_factor, tolerances)
    slip, residual = rows.half_spaces.slips(found.x), rows.relative_excess(found.x, load_factor)
    status, margin, active = Status.OPTIMAL, found.margin, rows.named(*found.active_limits)
    if not residual <= tolerances.feasibility:
        status, slip = Status.INFEASIBLE, np.full(len(slip), nan)
    # no bounded margin comes so near to the largest that is looked for
    elif margin > 0.75 * found.cap:
        status, margin, active = Status.UNBOUNDED, inf, ()
    slip, pinned = (zone.slips(slip), zone.pinned) if zone.open_nodes else (slip, rows.half_spaces.pinned)
    reduced = found.reduced_accuracy
    return SafeSlip(status, load_factor, slip, margin, active, residual, reduced, zone.open_nodes, pinned)


MOST_SLIPS = 300  # of closed nodes; with more the program of the least slip takes longer than all others
WITHIN = 0.5  # share of the tolerance by which rows may be violated, as the set at λ_max may be flat
NOT_FOUND = (
    "no contact zone that was tried has a safe slip, and not all were: "
    "the nodes that stay open in the long run (simulate names them) may be given"
)


@checked
def upper_bound(
    problem: Problem,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = (),
    transient: bool = False,
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Bound:
    """The largest load factor at which a safe slip exists (thesis (5.16), on the 2n extremal rows).

    Parameters
    ----------
    problem
        The contact and its loading loop.
    open_nodes
        The nodes that stay open through the whole period, all others closed: the rows are
        those of the condensed joint, and each open node adds its gap. ``"auto"`` searches
        for the zone with the largest λ_max, beginning with the nodes that the mean load opens.
    transient
        Whether the slip has to be safe under the transient load steps too, which the load factor
        does not scale: it then stays as it is even if they are still to come. Only with all
        nodes in contact.
    certify
        Whether to re-solve the active rows in exact arithmetic and, where they are
        not exactly the best, to go on from them; by default up to 250 nodes, where it
        takes seconds. With two directions: whether to prove an enclosure, by default up to
        1000 nodes. Only with all nodes in contact, and without a transient.
    tolerances
        The tolerances that decide.

    Raises
    ------
    SolverError
        If the linear program ends without an answer.
    UsageError
        If an open node does not exist, if no node stays closed, if the open nodes are unsupported,
        or if nodes are open before the transient.
    ProblemError
        If nodes are open and the problem has no C.

    Examples
    --------
    >>> import shakedown
    >>> upper = shakedown.upper_bound(shakedown.example("two-node"))
    >>> upper.status.value, round(upper.load_factor, 6), upper.slip.round(5)
    ('optimal', 0.739146, array([-0.15635,  1.28773]))
    >>> low, high = upper.certified
    >>> low <= upper.load_factor <= high, high - low < 1e-15
    (True, True)
    """
    zone, others_left = chosen_zone(problem, open_nodes, tolerances)
    parts = coupled_parts(problem, zone.open_nodes)
    if len(parts) > 1 and problem.directions > 1:  # a linear program of all parts loses nothing
        found = _of_parts(zone, parts, transient, certify, tolerances)
    else:
        found = _of_zone(zone, transient, certify, tolerances)
    doubt = rigid_slips(zone.joint).doubt
    # a resistance in doubt may hold the body at any load factor
    if found.status == Status.UNBOUNDED and doubt:
        no_slip = np.full_like(found.slip, np.nan)
        return found.but(status=Status.UNDECIDED, load_factor=np.nan, direction=no_slip, reason=doubt)
    if others_left and found.status == Status.INFEASIBLE:
        return found.but(status=Status.UNDECIDED, reason=NOT_FOUND, active=(), exact=False)
    return found


def of_joint(limits: Any) -> Bound:
    """λ_max of a joint whose limits are computed (:data:`shakedown.bounds.registry.BOUNDS`)."""
    return upper_bound(
        limits.problem, open_nodes=limits.zone, certify=limits.certify, tolerances=limits.tolerances
    )


def _of_zone(zone: Zone, transient: bool, certify: bool | None, tolerances: Tolerances) -> Bound:
    """λ_max of the closed nodes."""
    problem, rows = zone.problem, zone_rows(zone, transient)
    with_transient = transient and len(transient_path(problem)) > 0
    plain = not zone.open_nodes and not with_transient
    if certify is None:
        certify = problem.n <= (UPPER_CERTIFIED_UP_TO if rows.in_plane else LARGE)
    balanced = plain and problem.q_mean is None and problem.p_mean is None
    found = largest_load_factor(rows, problem if certify and plain else None, balanced, tolerances)
    slips, nowhere = rows.half_spaces.slips(found.x), np.full(len(found.x), nan)
    bound = Bound(
        kind="upper",
        evidence=LargestLoadFactor(
            slips if found.status == Status.UNBOUNDED else nowhere, found.exact, found.missing
        ),
        slip=slips if found.status == Status.OPTIMAL else nowhere,
        active=rows.named(*found.active_limits),
        reason=_reason(found.status, rows, with_transient),
        pinned=rows.half_spaces.pinned,
        **{each.name: getattr(found, each.name) for each in fields(Bound) if hasattr(found, each.name)},
    )
    return _in_zone(zone, bound, tolerances) if zone.open_nodes else bound


def _reason(status: Status, rows: DiscRows, with_transient: bool) -> str:
    if status == Status.INFEASIBLE:
        return _no_safe_slip(with_transient)
    if status == Status.UNDECIDED:
        return "no direction was found along which slips stay safe at every load factor"
    if status == Status.OPTIMAL:
        return ""
    if not relieving(rows):
        return (
            "wedging: slip along one direction raises the friction limits faster than any load factor needs"
        )
    if rows.e.any() or rows.half_spaces.d.any():
        return "the periodic part of the loading brings no node nearer to its limits at any load factor"
    return "zero-amplitude loop: the loading does not change over the period, whatever the load factor"


def _no_safe_slip(with_transient: bool) -> str:
    if with_transient:
        return "no slip is safe both under the transient load steps and in the loop, at any load factor"
    return "no slip keeps every node within its friction limits, even under the mean load alone"


def _of_parts(
    zone: Zone, parts: tuple[Part, ...], transient: bool, certify: bool | None, tolerances: Tolerances
) -> Bound:
    """The bound of a joint in uncoupled parts, from those of each; safe slips of the others at its λ_max."""
    zones = [contact_zone(p.joint, p.among(zone.open_nodes), tolerances=tolerances) for p in parts]
    found = [_of_zone(each, transient, certify, tolerances) for each in zones]
    deciding, least = weakest(found), float(np.max([each.least_load_factor for each in found]))
    part, bound, reason = parts[deciding], found[deciding], found[deciding].reason
    if least > (1.0 + tolerances.feasibility) * bound.load_factor:  # where one is safe another is not
        bound = replace(bound, status=Status.INFEASIBLE, load_factor=nan, certified=None)
        reason = _no_safe_slip(transient)
    optimal, slip = bound.status == Status.OPTIMAL, np.full(zone.problem.layout.slip_size, nan)
    if optimal:
        for own, each in zip(parts, zones, strict=True):
            slip[own.slips] = safest_slip(each, bound.load_factor, transient, tolerances).slip
        slip[part.slips] = bound.slip
    multipliers = np.zeros(len(zone.constraints.g))
    multipliers[np.isin(zone.constraints.node, part.nodes)] = bound.multipliers
    known = [each.certified for each in found if each.certified is not None]
    certified = tuple(np.min(known, axis=0).tolist()) if len(known) == len(found) else None
    pinned = (int(own.slips[k]) for own, each in zip(parts, found, strict=True) for k in each.pinned)
    return bound.but(
        slip=slip,
        active=tuple((part.number(node), step) for node, step in bound.active),
        multipliers=multipliers,
        direction=of_slips(parts, (each.direction for each in found)),
        reason=part.renumbered(reason),
        residual=max(each.residual for each in found),
        least_load_factor=nan if bound.status == Status.INFEASIBLE else least,
        certified=certified if bound.certified is not None else None,
        exact=all(each.exact for each in found),
        uncertified=next((each.uncertified for each in found if each.uncertified), ""),
        missing=tuple(dict.fromkeys(words for each in found for words in each.missing)),
        reduced_accuracy=any(each.reduced_accuracy for each in found),
        open_nodes=zone.open_nodes,
        pinned=tuple(sorted(pinned)),
        parts=tuple(found),
    )


def _in_zone(zone: Zone, found: Bound, tolerances: Tolerances) -> Bound:
    """A bound on the closed nodes in terms of all nodes, with the least of its safe slips."""
    slip, residual, rows = found.slip, found.residual, zone.constraints
    if found.status == Status.OPTIMAL:
        slip = _least_slip(zone, found.load_factor, slip, tolerances)
        residual = float(rows.relative_excess(slip, found.load_factor).max())
    return found.but(
        slip=zone.slips(slip),
        residual=residual,
        direction=zone.spread(found.direction),
        open_nodes=zone.open_nodes,
        pinned=zone.pinned,
    )


def _least_slip(zone: Zone, load_factor: float, known: FloatArray, tolerances: Tolerances) -> FloatArray:
    """The safe slip that minimises the largest slip of a node (k,); ``known``, a safe one, if none is found.

    Where no more than its open nodes hold a body safe slips may be far away, and many: the program of λ_max
    ends in any of them. This one minimises t, |v_i| ≤ t at every node, v within every limit.
    """
    rows, within, limits = zone_rows(zone), WITHIN * tolerances.feasibility, zone.constraints
    H = rows.half_spaces
    if H.n > MOST_SLIPS:
        return known
    g, v = H.g - load_factor * H.d, H.slips(np.eye(H.n)).T
    g += within * np.maximum(np.abs(g), np.abs(H.coefficients) @ np.abs(known))
    held = replace(H, g=g, d=np.zeros_like(g))
    if rows.in_plane:
        found = attempt(_least_in_plane, held, v, tolerances)
    else:
        c, moved = rows.c + load_factor * rows.e, (np.abs(rows.flat) @ np.abs(known)).reshape(-1, CONE)
        c[:, 0] += within * np.maximum(np.abs(c), moved[rows.node]).max(axis=1)
        size = float(np.abs(known).max(initial=0.0)) or 1.0
        found = attempt(_least_in_space, replace(rows, c=c, half_spaces=held), v, size)
    if isinstance(found, Missing):
        return known
    slip = H.slips(found)
    return slip if limits.relative_excess(slip, load_factor).max() <= tolerances.feasibility else known


def _least_in_plane(limits: Constraints, v: FloatArray, tolerances: Tolerances) -> FloatArray:
    """The slips x in some rows with the least of the largest slip |v| of a node, v = v(x)."""
    matrix = np.block([[limits.coefficients, 0.0 * limits.g[:, None]], [v, -np.ones((len(v), 1))]])
    matrix = np.vstack([matrix, np.column_stack([-v, -np.ones(len(v))])])
    right, cost = np.append(limits.g, np.zeros(2 * len(v))), np.append(np.zeros(limits.n), 1.0)
    return solve(Program(matrix, right, cost, tolerances=tolerances)).x[:-1]


def _least_in_space(rows: DiscRows, v: FloatArray, size: float) -> FloatArray:
    """The slips likewise in some discs, whose constant parts alone count, with t in units of a size."""
    n = len(rows.stiffness)
    own, t = np.zeros((n, CONE, rows.stiffness.shape[-1])), np.zeros((n, CONE))
    own[:, 1:], t[:, 0] = v.reshape(n, CONE - 1, -1), size
    both = replace(
        rows,
        stiffness=np.concatenate([rows.stiffness, own]),
        node=np.append(rows.node, n + np.arange(n)),
        step=np.append(rows.step, np.zeros(n, dtype=np.intp)),
        c=np.vstack([rows.c, 0.0 * t]),
        e=np.vstack([0.0 * rows.e, t]),
        names=np.append(rows.names, rows.names),
    )
    return solve_scaled(scaled_discs(both, +1.0), proves=False).x
