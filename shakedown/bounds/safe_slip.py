"""Safe slips: slips that satisfy every frictional constraint, with as much room as possible."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf, nan
from typing import Literal

import numpy as np

from shakedown.bounds.best_zone import chosen_zone
from shakedown.bounds.discs.disc_rows import zone_rows
from shakedown.bounds.discs.safest_slip import safest
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.joint.constraints import Constraints, rows_named
from shakedown.joint.contact_zone import Zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.margin import widest


@dataclass(frozen=True, eq=False, repr=False)
class SafeSlip(Result):
    """The slip with the largest margin to all 2n rows at one load factor.

    Attributes
    ----------
    status
        Optimal; infeasible (no safe slip at this load factor); unbounded (the margin can
        be made as large as one likes; ``slip`` is a safe slip with a margin typical of
        the load).
    load_factor
        The load factor asked for.
    slip : (dn,)
        The safe slip [length]; NaN where there is none.
    margin
        Distance in slip space from the nearest row's hyperplane [length]; with two directions the
        largest t with |q_i| + t (f_i |B_i| + |A_i|) ≤ f_i p_i, which all slips up to t away keep
        (|A_i|: the spectral norm of the two rows). Inf where unbounded, negative where infeasible.
    active
        (node, side) of the rows at that distance; with two directions (node, load step).
    residual
        Largest relative violation of a row at ``slip``; ≤ 0 where it is safe.
    reduced_accuracy
        Whether the linear program ended only at loosened tolerances (1e-7).
    open_nodes
        The nodes that are open; their slip is their displacement under the mean load.
    pinned
        The nodes that slips are given relative to, where the joint can move as a whole.
    """

    status: Status
    load_factor: float
    slip: FloatArray
    margin: float
    active: tuple[tuple[int, int], ...]
    residual: float
    reduced_accuracy: bool = False
    open_nodes: tuple[int, ...] = ()
    pinned: tuple[int, ...] = ()


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
        As for :func:`upper_bound`.
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
    if problem.directions > 1:
        return _in_space(zone, load_factor, transient, tolerances)
    rows = zone.rows(transient)
    room = rows.g - load_factor * rows.d
    norms = np.linalg.norm(rows.G, axis=1)
    cap = _typical_distance(rows, load_factor, norms)
    found = widest(rows.coefficients, norms, room, cap=cap, tolerances=tolerances)
    slip = rows.slips(found.x)
    residual = float(rows.relative_excess(slip, load_factor).max())
    active = rows_named(rows, np.flatnonzero(found.multipliers))
    status, margin = Status.OPTIMAL, found.margin
    if residual > tolerances.feasibility:
        status, slip = Status.INFEASIBLE, np.full(rows.n, nan)
    elif margin > 0.75 * cap:
        status, margin, active = Status.UNBOUNDED, inf, ()
    reduced = found.reduced_accuracy
    slip = zone.slips(slip)
    return SafeSlip(
        status, load_factor, slip, margin, active, residual, reduced, zone.open_nodes, zone.pinned
    )


def _in_space(zone: Zone, load_factor: float, transient: bool, tolerances: Tolerances) -> SafeSlip:
    """The slip with the largest ball of safe slips around it, over the discs of all closed nodes."""
    if transient:
        zone.check_transient()
    rows = zone_rows(zone, transient)
    found = safest(rows, load_factor)
    residual = rows.relative_excess(found.x, load_factor)
    status, margin, active, slip = (
        Status.OPTIMAL,
        found.margin,
        rows.named(*found.carrying),
        rows.half_spaces.slips(found.x),
    )
    if not residual <= tolerances.feasibility:
        status, slip = Status.INFEASIBLE, np.full(len(slip), nan)
    elif margin > 0.75 * found.cap:
        status, margin, active = Status.UNBOUNDED, inf, ()
    slip, reduced = zone.slips(slip) if zone.open_nodes else slip, found.reduced_accuracy
    pinned = zone.pinned if zone.open_nodes else rows.half_spaces.pinned
    return SafeSlip(status, load_factor, slip, margin, active, residual, reduced, zone.open_nodes, pinned)


def _typical_distance(rows: Constraints, load_factor: float, norms: FloatArray) -> float:
    """Twice the largest margin that a bounded margin can have [length].

    The multipliers y of the largest margin t give t = yᵀ room with yᵀ norms = 1.
    """
    reach = np.abs(rows.g) + np.abs(load_factor * rows.d)
    steep = norms > 0
    distance = np.max(reach[steep] / norms[steep], initial=0.0)
    return 2.0 * float(distance) if distance > 0 else 1.0
