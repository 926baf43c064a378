"""Safe slips in space: cone programs over the disc of every node and load step."""

from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.bound_result import Bound
from shakedown.bounds.discs.disc_limits import largest_load_factor, relieving
from shakedown.bounds.discs.disc_rows import DiscRows, disc_rows, zone_rows
from shakedown.bounds.discs.safest_slip import safest
from shakedown.bounds.results import (
    MOVED,
    NO_SAFE_STATE,
    RELIEVING,
    WEDGING,
    ZERO_AMPLITUDE,
    LargestLoadFactor,
    SafeSlip,
    ZoneLimit,
)
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.size_limits import ALL_PAIRS_UP_TO, CONE, LARGE
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import Constraints
from shakedown.joint.contact_zone import Zone

FEW_NODES = 50  # nodes up to which runs take hundredths of a second
HOLDING_BALL_SOONER = True
MOST_ZONES = 100  # each costs a cone program
ALL_COMPARED_UP_TO = ALL_PAIRS_UP_TO
CHANGES_AT_ONCE = (8, 4, 2)  # changes at once
INSIDE = 1.05  # ratio σ / |y| from which on multipliers are well inside their cone


def upper(zone: Zone, transient: bool, certify: bool | None, tolerances: Tolerances) -> Bound:
    """λ_max over the discs of all closed nodes."""
    if transient:
        zone.check_transient()
    problem, rows = zone.problem, zone_rows(zone, transient)
    plain = not zone.open_nodes and len(rows.c) == len(disc_rows(problem).c)
    certify = (problem.n <= LARGE if certify is None else certify) and plain
    balanced = plain and problem.q_mean is None and problem.p_mean is None
    found = largest_load_factor(rows, problem if certify else None, balanced, tolerances)
    slips, optimal = rows.half_spaces.slips(found.x), found.status == Status.OPTIMAL
    nowhere = np.full(len(slips), nan)
    direction = slips if found.status == Status.UNBOUNDED else nowhere
    return Bound(
        kind="upper",
        status=found.status,
        load_factor=found.load_factor,
        evidence=LargestLoadFactor(
            direction,
            found.exact,
            found.missing,
            np.append(slips, found.load_factor) if optimal else np.full(len(slips) + 1, nan),
        ),
        slip=slips if optimal else nowhere,
        active=rows.named(*found.carrying),
        multipliers=found.multipliers,
        reason=_reason(found.status, rows, transient),
        residual=found.residual,
        least_load_factor=found.least_load_factor,
        certified=found.certified,
        uncertified=found.uncertified,
        reduced_accuracy=found.reduced_accuracy,
        pinned=rows.half_spaces.pinned,
    )


def _reason(status: Status, rows: DiscRows, transient: bool) -> str:
    if status == Status.INFEASIBLE:
        return MOVED if transient else NO_SAFE_STATE
    if status == Status.OPTIMAL:
        return ""
    if not relieving(rows):
        return WEDGING
    return RELIEVING if rows.e.any() or rows.half_spaces.d.any() else ZERO_AMPLITUDE


def safe_slip(zone: Zone, load_factor: float, transient: bool, tolerances: Tolerances) -> SafeSlip:
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


def slip_limits(rows: Constraints, v: FloatArray) -> tuple[FloatArray, tuple[int, ...]]:
    """Cones |v_i| ≤ t in (x, t), of slips v = v(x) of all nodes, and the sizes of the cones of all rows."""
    slips = len(v)
    own = np.zeros((slips // 2, CONE, slips + 1))
    own[:, 0, -1] = -1.0
    own[:, 1:, :-1] = -v.reshape(-1, 2, slips)
    return own.reshape(-1, slips + 1), (*rows.cones.tolist(), *[CONE] * (slips // 2))


def zone_limit(zone: Zone, compared: bool, tolerances: Tolerances) -> ZoneLimit:
    """λ_max of a zone; ``compared``: with its margin where it has no safe slip."""
    rows, nothing = zone_rows(zone), np.zeros(0)
    found = largest_load_factor(rows, None, True, tolerances)
    if found.status == Status.UNBOUNDED:
        return ZoneLimit(inf, nothing, nothing)
    if found.status == Status.OPTIMAL:
        return ZoneLimit(found.load_factor, found.x, found.multipliers)
    margin = safest(rows, 0.0).margin if compared else 0.0
    return ZoneLimit(-inf, nothing, found.multipliers, margin)


def change_weights(zone: Zone, found: ZoneLimit, tolerances: Tolerances) -> dict[int, float]:
    """How strongly discs ask for a node to be opened (at its apex), and gaps to be closed (where they press).

    Without a safe slip (an empty x) a node is at its apex where its multipliers point inside the cone.
    """
    rows, x, load_factor = zone_rows(zone), found.x, found.load_factor
    y, z = np.split(found.multipliers, [3 * len(rows.c)])
    y = y.reshape(-1, 3)
    of_gaps = z * np.maximum(np.abs(rows.half_spaces.G).max(axis=1, initial=0.0), np.abs(rows.half_spaces.d))
    of_disc, of_gap = _terms(rows, x, load_factor)
    parts = z * of_gap  # in λ: next to the largest what carries nothing is round-off of interior points
    largest = max(parts.max(initial=0.0), (np.abs(y).max(axis=1) * of_disc).max(initial=0.0))
    pressing = np.flatnonzero((of_gaps > 0) & (parts > NEGLIGIBLE * largest))
    weights = {int(rows.half_spaces.node[k]): float(of_gaps[k]) for k in pressing}
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


def limits_left(zone: Zone, found: ZoneLimit) -> tuple[NDArray[np.intp], FloatArray]:
    """How near nodes are to opening or closing: nodes (k,), their f p and gaps over the largest terms."""
    rows, x, load_factor = zone_rows(zone), found.x, found.load_factor
    limits = rows.c[:, 0] + load_factor * rows.e[:, 0] + (rows.stiffness[:, 0] @ x)[rows.node]
    sizes = np.concatenate(_terms(rows, x, load_factor))
    left = np.append(limits, rows.slack(x, load_factor)[1]) / np.where(sizes > 0, sizes, 1.0)
    return np.append(rows.names[rows.node], rows.half_spaces.node), left


def _terms(rows: DiscRows, x: FloatArray, load_factor: float) -> tuple[FloatArray, FloatArray]:
    """The terms of discs (j,) and half-spaces (o,) added up; without slips those of the mean load."""
    H = rows.half_spaces
    if not x.size:
        return np.abs(rows.c).max(axis=1), np.abs(H.g)
    of_slip = (np.abs(rows.flat) @ np.abs(x)).reshape(-1, 3)[rows.node]
    discs = (of_slip + np.abs(rows.c) + load_factor * np.abs(rows.e)).max(axis=1)
    return discs, np.abs(H.coefficients) @ np.abs(x) + np.abs(H.g) + load_factor * np.abs(H.d)


def _largest_load(rows: DiscRows) -> FloatArray:
    found = np.zeros(len(rows.stiffness))
    np.maximum.at(found, rows.node, np.abs(rows.e).max(axis=1))
    return found
