"""Safe slips: slips that satisfy every frictional constraint, with as much slack as possible."""

from collections.abc import Iterable
from math import inf, nan
from typing import Literal

import numpy as np

from shakedown.bounds.best_zone import chosen_zone
from shakedown.bounds.discs.disc_rows import zone_rows
from shakedown.bounds.discs.safest_slip import safest
from shakedown.bounds.results import SafeSlip as SafeSlip
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.joint.contact_zone import Zone
from shakedown.joint.problem import Problem

UNLIMITED = 0.75  # share of the largest margin that a bounded one can have from which on it is not bounded


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
    status, margin, active = Status.OPTIMAL, found.margin, rows.named(*found.carrying)
    if not residual <= tolerances.feasibility:
        status, slip = Status.INFEASIBLE, np.full(len(slip), nan)
    elif margin > UNLIMITED * found.cap:
        status, margin, active = Status.UNBOUNDED, inf, ()
    slip, pinned = (zone.slips(slip), zone.pinned) if zone.open_nodes else (slip, rows.half_spaces.pinned)
    reduced = found.reduced_accuracy
    return SafeSlip(status, load_factor, slip, margin, active, residual, reduced, zone.open_nodes, pinned)
