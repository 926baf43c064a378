"""λ_max of a contact zone that is compared with others, and which of its nodes are about to change."""

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.discs.disc_rows import DiscRows, zone_rows
from shakedown.bounds.discs.safest_slip import safest
from shakedown.bounds.largest_load_factor import largest_load_factor
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import by_side
from shakedown.joint.contact_zone import Zone

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
