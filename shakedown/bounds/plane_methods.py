"""Safe slips in the plane: linear programs over the two opposite limits of every node."""

from dataclasses import replace
from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.bound_result import Bound
from shakedown.bounds.certificate import (
    UPPER_CERTIFIED_UP_TO,
    Certificate,
    Disputed,
    certified_upper,
    significant,
)
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
from shakedown.bounds.row_programs import contradiction, load_factor_program
from shakedown.ground.errors import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import Constraints, by_side, constraints, rows_named
from shakedown.joint.contact_zone import Zone
from shakedown.joint.problem import Problem
from shakedown.programs.program import Solution
from shakedown.programs.solver import solve, widest

FEW_NODES = MOST_ZONES = ALL_COMPARED_UP_TO = inf
HOLDING_BALL_SOONER = False
CHANGES_AT_ONCE: tuple[int, ...] = ()


def limit_of_rows(problem: Problem, rows: Constraints, certify: bool, tolerances: Tolerances) -> Bound:
    """λ_max of a joint in the plane over some of its rows; in exact arithmetic where asked for."""
    outcome = solve(load_factor_program(rows, towards=-1.0, tolerances=tolerances))
    found: Certificate | Missing = Missing("")
    if certify:
        found = sought(certified_upper, problem, outcome, tolerances)
    certificate = found if isinstance(found, Certificate) else None
    status = outcome.status if certificate is None else certificate.status
    answer = {Status.OPTIMAL: _optimal, Status.INFEASIBLE: _infeasible, Status.UNBOUNDED: _unbounded}[status]
    return answer(rows, outcome, certificate, tolerances).but(
        uncertified=found.reason if isinstance(found, Missing) else "",
        disputed=isinstance(found, Disputed),
        reduced_accuracy=outcome.reduced_accuracy,
        pinned=rows.pinned,
        in_floats=_in_floats(rows, outcome),
    )


def _in_floats(rows: Constraints, outcome: Solution) -> FloatArray:
    """The slip and the load factor that a program found, (n + 1,); NaN where it found none."""
    if not outcome.optimal:
        return np.full(rows.n + 1, nan)
    return np.append(rows.slips(outcome.x[:-1]), outcome.x[-1])


def _optimal(
    rows: Constraints, outcome: Solution, certificate: Certificate | None, tolerances: Tolerances
) -> Bound:
    if certificate is not None:
        load_factor, y = certificate.load_factor, certificate.multipliers
        slip = significant(rows, certificate.slip, load_factor, tolerances)[:-1]
        active, certified = np.array(certificate.rows, dtype=np.intp), (certificate.low, certificate.high)
    else:
        slip, load_factor = _in_floats(rows, outcome)[:-1], float(outcome.x[-1])
        y, active, certified = outcome.multipliers, outcome.meeting[0], None
    least, missing = _least(rows, tolerances)
    return Bound(
        kind="upper",
        status=Status.OPTIMAL,
        load_factor=load_factor,
        evidence=LargestLoadFactor(np.full(rows.n, nan), certificate is not None, missing),
        slip=slip,
        active=rows_named(rows, active),
        multipliers=y,
        reason="",
        residual=float(rows.relative_excess(slip, load_factor).max()),
        least_load_factor=least,
        certified=certified,
    )


def _least(rows: Constraints, tolerances: Tolerances) -> tuple[float, tuple[str, ...]]:
    """λ_lo; NaN where its program fails, and that it did."""
    found = sought(least_load_factor, rows, tolerances)
    return (nan, (f"λ_lo: {found.reason}",)) if isinstance(found, Missing) else (found, ())


def least_load_factor(rows: Constraints, tolerances: Tolerances) -> float:
    """λ_lo ≥ 0, from where on there are safe slips; NaN where there are none."""
    # A safe slip is safe at every smaller load factor; or v = 0 is safe under the mean load.
    if np.all(rows.d >= 0) or np.all(rows.g >= 0):
        return 0.0
    least = solve(load_factor_program(rows, towards=+1.0, tolerances=tolerances))
    if not least.optimal:
        return nan
    at_mean = rows.relative_excess(rows.slips(least.x[:-1]), 0.0).max()
    return 0.0 if at_mean <= tolerances.feasibility else float(least.x[-1])


def _infeasible(
    rows: Constraints, outcome: Solution, certificate: Certificate | None, tolerances: Tolerances
) -> Bound:
    y, missing = np.full(len(rows.g), nan), tuple[str, ...]()
    if certificate is not None:
        y = certificate.multipliers
    else:
        found = sought(contradiction, rows, tolerances)
        if isinstance(found, Missing):
            missing = (f"multipliers: {found.reason}",)
        else:
            y = found.multipliers
    terms = np.abs(y) @ np.abs(rows.G)
    return Bound(
        kind="upper",
        status=Status.INFEASIBLE,
        load_factor=nan,
        evidence=LargestLoadFactor(np.full(rows.n, nan), certificate is not None, missing),
        slip=np.full(rows.n, nan),
        active=rows_named(rows, np.flatnonzero(y != 0)) if not missing else (),
        multipliers=y,
        reason=NO_SAFE_STATE,
        residual=float(np.max(np.abs(y @ rows.coefficients) / np.where(terms > 0, terms, 1.0))),
        least_load_factor=nan,
        certified=None,
    )


def _unbounded(
    rows: Constraints, outcome: Solution, certificate: Certificate | None, tolerances: Tolerances
) -> Bound:
    least, missing = _least(rows, tolerances)
    if np.all(rows.d <= 0):
        direction, reason = np.zeros(rows.n), ZERO_AMPLITUDE if not np.any(rows.d) else RELIEVING
    else:
        found, reason = sought(_widest_direction, rows, certificate, tolerances), WEDGING
        if isinstance(found, Missing):
            direction, missing = np.full(rows.n, nan), (*missing, f"direction: {found.reason}")
        else:
            direction = found
    terms = np.maximum(np.max(np.abs(rows.G * direction), axis=1), np.abs(rows.d))
    excess = (rows.G @ direction + rows.d) / np.where(terms > 0, terms, 1.0)
    return Bound(
        kind="upper",
        status=Status.UNBOUNDED,
        load_factor=inf,
        evidence=LargestLoadFactor(direction, certificate is not None, missing),
        slip=np.full(rows.n, nan),
        active=(),
        multipliers=np.zeros(len(rows.g)),
        reason=reason,
        residual=float(excess.max()),
        least_load_factor=least,
        certified=None if certificate is None else (inf, inf),
    )


def _widest_direction(
    rows: Constraints, certificate: Certificate | None, tolerances: Tolerances
) -> FloatArray:
    """v with G v + d ≤ 0, with slack where possible."""
    norms = np.linalg.norm(rows.G, axis=1)
    cap = float(np.max(np.abs(rows.d)[norms > 0] / norms[norms > 0], initial=0.0))
    found = widest(rows.coefficients, norms, -rows.d, cap=cap, tolerances=tolerances)
    return rows.slips(found.x) if found.margin >= 0 or certificate is None else certificate.slip


def upper(zone: Zone, transient: bool, certify: bool | None, tolerances: Tolerances) -> Bound:
    """λ_max of the closed nodes."""
    problem, rows = zone.problem, zone.rows(transient)
    certify = problem.n <= UPPER_CERTIFIED_UP_TO if certify is None else certify
    whole = rows is constraints(problem)  # certificates exist for these rows
    found = limit_of_rows(problem, rows, certify and whole, tolerances)
    moved = not whole and not zone.open_nodes and found.status == Status.INFEASIBLE
    return replace(found, reason=MOVED) if moved else found


def safe_slip(zone: Zone, load_factor: float, transient: bool, tolerances: Tolerances) -> SafeSlip:
    """The slip with the largest margin to all rows."""
    rows = zone.rows(transient)
    right = rows.g - load_factor * rows.d
    norms = np.linalg.norm(rows.G, axis=1)
    cap = _typical_distance(rows, load_factor, norms)
    found = widest(rows.coefficients, norms, right, cap=cap, tolerances=tolerances)
    slip = rows.slips(found.x)
    residual = float(rows.relative_excess(slip, load_factor).max())
    active = rows_named(rows, np.flatnonzero(found.multipliers))
    status, margin = Status.OPTIMAL, found.margin
    if residual > tolerances.feasibility:
        status, slip = Status.INFEASIBLE, np.full(rows.n, nan)
    elif margin > 0.75 * cap:
        status, margin, active = Status.UNBOUNDED, inf, ()
    reduced = found.reduced_accuracy
    return SafeSlip(
        status, load_factor, zone.slips(slip), margin, active, residual, reduced, zone.open_nodes, zone.pinned
    )


def _typical_distance(rows: Constraints, load_factor: float, norms: FloatArray) -> float:
    """Twice the largest margin that a bounded margin can have [length].

    The multipliers y of the largest margin t give t = yᵀ (g − λ d) with yᵀ norms = 1.
    """
    reach = np.abs(rows.g) + np.abs(load_factor * rows.d)
    steep = norms > 0
    distance = np.max(reach[steep] / norms[steep], initial=0.0)
    return 2.0 * float(distance) if distance > 0 else 1.0


def slip_limits(rows: Constraints, v: FloatArray) -> tuple[FloatArray, tuple[int, ...]]:
    """Rows |v_i| ≤ t in (x, t), of slips v = v(x) of all nodes, and the sizes of the cones of all rows."""
    return np.column_stack([np.vstack([v, -v]), -np.ones(2 * len(v))]), ()


def zone_limit(zone: Zone, compared: bool, tolerances: Tolerances) -> ZoneLimit:
    """λ_max of a zone."""
    nothing, rows = np.zeros(0), zone.constraints
    end = solve(load_factor_program(rows, towards=-1.0, tolerances=tolerances))
    if end.status == "unbounded":
        return ZoneLimit(inf, nothing, nothing)
    if end.optimal:
        return ZoneLimit(float(end.x[-1]), rows.slips(end.x[:-1]), end.multipliers)
    against = contradiction(rows, tolerances)
    return ZoneLimit(-inf, nothing, against.multipliers, against.margin)


def change_weights(zone: Zone, found: ZoneLimit, tolerances: Tolerances) -> dict[int, float]:
    """How strongly the multipliers of rows suggest opening or closing a node."""
    rows, pressing = zone.constraints, found.multipliers
    weight = pressing * np.maximum(np.abs(rows.G).max(axis=1), np.abs(rows.d))
    sided = rows.sided
    weights = {int(rows.node[i]): float(weight[i]) for i in np.flatnonzero(~sided & (weight > 0))}
    by_node, nodes = by_side(weight[sided]), by_side(rows.node[sided])[:, 0]
    lifting = by_node.min(axis=1) > 0 if len(found.x) == 0 else _at_the_apex(found, rows, tolerances)
    lifting &= zone.problem.f[nodes] > 0  # without friction the pressure is a row of its own
    for node, share in zip(nodes[lifting], by_node[lifting].sum(axis=1), strict=True):
        weights[int(node)] = float(share)
    return weights


def _at_the_apex(found: ZoneLimit, rows: Constraints, tolerances: Tolerances) -> NDArray[np.bool_]:
    """Closed nodes with both limits active: pressure and shear vanish at their extreme steps."""
    tight = np.abs(rows.relative_excess(found.x, found.load_factor)) <= tolerances.feasibility
    return np.asarray(by_side(tight[rows.sided]).all(axis=1))


def limits_left(zone: Zone, found: ZoneLimit) -> tuple[NDArray[np.intp], FloatArray]:
    """How near nodes are to opening or closing: nodes (k,), and the slack left at their rows, relative."""
    rows = zone.constraints
    return rows.node, -rows.relative_excess(found.x, found.load_factor)
