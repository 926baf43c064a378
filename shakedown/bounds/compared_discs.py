"""Zones of a joint in space compared: their λ_max, and which of their nodes want to open or to close."""

from math import inf

import numpy as np

from shakedown.bounds.discs.disc_limits import largest_load_factor
from shakedown.bounds.discs.disc_rows import DiscRows, Indices
from shakedown.bounds.discs.safest_slip import safest
from shakedown.bounds.results import ZoneLimit
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances

INSIDE = 1.05  # σ over |y| from where on multipliers point well inside their cone


def zone_limit(rows: DiscRows, compared: bool, tolerances: Tolerances) -> ZoneLimit:
    """λ_max of a zone, for a search among zones; ``compared``: with its margin where it has no safe slip."""
    nothing, found = np.zeros(0), largest_load_factor(rows, None, True, tolerances)
    if found.status == Status.UNBOUNDED:
        return ZoneLimit(inf, nothing, nothing)
    if found.status == Status.OPTIMAL:
        return ZoneLimit(found.load_factor, found.x, found.multipliers)
    margin = safest(rows, 0.0).margin if compared else 0.0
    return ZoneLimit(-inf, nothing, found.multipliers, margin)


def change_weights(
    rows: DiscRows, x: FloatArray, load_factor: float, multipliers: FloatArray, tolerances: Tolerances
) -> dict[int, float]:
    """How strongly limits ask for a node of the joint to be opened (at its apex) or closed (its gap presses).

    Without a safe slip (an empty x) a node is at its apex where its multipliers point inside the cone.
    """
    y, z = multipliers[: 3 * len(rows.c)].reshape(-1, 3), multipliers[3 * len(rows.c) :]
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


def limits_left(rows: DiscRows, x: FloatArray, load_factor: float) -> tuple[Indices, FloatArray]:
    """How near nodes are to opening or closing: nodes (k,), their f p and gaps over the largest terms."""
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
