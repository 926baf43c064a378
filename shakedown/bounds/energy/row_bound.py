"""The energy bound of a joint in the plane: a cone program over the rows of its zone, and what checks it."""

from dataclasses import replace
from math import inf, nan

import numpy as np

from shakedown.bounds.bound_result import Bound
from shakedown.bounds.energy.cone_rows import ConeRows, cone_rows
from shakedown.bounds.energy.energy_results import NO_SLACK, TOO_FAR, UNLIMITED, BallEvidence, Inner, no_bound
from shakedown.bounds.energy.energy_rows import EnergyRows, check_resolved, without_margin, zone_rows
from shakedown.bounds.energy.exact_check import ExactBall
from shakedown.bounds.energy.row_solution import RowSolution, contradiction, row_solution, widest_margin
from shakedown.ground.errors import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, SETTLED
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.contact_zone import Zone

NOT_REGULAR = "to the last stored digit A is not positive semi-definite, or B reaches outside its range"


def energy_bound(
    zone: Zone, given: FloatArray, distance: float, tolerances: Tolerances, *, split: bool
) -> Bound:
    """λ_E of the closed nodes of a zone; what a node determines of its pressure is always split off."""
    found = _bound(zone, given, distance, tolerances)
    return replace(found, pinned=zone.pinned)


def _bound(zone: Zone, given: FloatArray, distance: float, tolerances: Tolerances) -> Bound:
    rows = zone_rows(zone, tolerances=tolerances)
    start = rows.rigid.relative(given)
    if reason := without_margin(zone.problem, rows):
        return no_bound(start, distance, reason)
    check_resolved(rows, start, distance, tolerances)
    found = sought(farthest_load_factor, rows, start, distance, tolerances)
    if isinstance(found, Missing):
        return no_bound(start, distance, found.reason, Status.UNDECIDED)
    return found


def strictly_inside(zone: Zone, bound: Bound, tolerances: Tolerances) -> Inner | Missing:
    """Where all conditions of a bound have the largest margins, with all nodes closed."""
    rows, exact = zone_rows(zone, tolerances=tolerances), ExactBall(zone.problem, transient=True)
    if not exact.regular:
        return Missing(rows.rigid.doubt or NOT_REGULAR)
    about = cone_rows(rows, bound.initial_slip, bound.distance)
    widest = widest_margin(about)
    slip = bound.initial_slip + rows.metric.inverse @ widest.y * about.length
    return Inner(exact, slip, widest.load_factor)


def farthest_load_factor(
    rows: EnergyRows, start: FloatArray, distance: float, tolerances: Tolerances = DEFAULT
) -> Bound:
    """The energy bound for rows of any kind."""
    about = cone_rows(rows, start, distance)
    end = row_solution(about, tolerances)
    if end.status == Status.INFEASIBLE:
        nothing = no_bound(start, distance, TOO_FAR)
        return replace(
            nothing, active=rows.names(about.carrying(end.multipliers)), residual=contradiction(about, end)
        )
    if end.status == Status.UNBOUNDED and not widest_margin(about).margin > tolerances.feasibility:
        return no_bound(start, distance, TOO_FAR)  # a direction of growth, but nothing to start from
    least = _least_load_factor(about, tolerances)  # required: the proof begins there
    if end.status == Status.UNBOUNDED:
        nothing = no_bound(start, distance, UNLIMITED)
        return replace(nothing, status=Status.UNBOUNDED, load_factor=inf, least_load_factor=least)
    if _without_margin(about, end, tolerances):
        return no_bound(start, distance, NO_SLACK)
    return _optimal(rows, about, end, start, least)


def _least_load_factor(about: ConeRows, tolerances: Tolerances) -> float:
    if np.all(about.d[:-1] >= 0):  # rows that hold at one load factor hold at every smaller one
        return 0.0
    end = row_solution(about.reversed(), tolerances)
    return abs(end.load_factor) if end.status == Status.OPTIMAL else nan


def _without_margin(about: ConeRows, end: RowSolution, tolerances: Tolerances) -> bool:
    """Whether some row has no margin at any slip: neither here nor at any smaller load factor."""
    reach = float(np.linalg.norm(end.y)) + about.offset
    margins = -about.excess(end.y, end.load_factor)[:-1]
    needs = reach * about.s[:-1] / np.where(about.sizes[:-1] > 0, about.sizes[:-1], 1.0)
    doubtful = (margins <= tolerances.feasibility) & (needs <= tolerances.feasibility) & (about.d[:-1] <= 0)
    return bool(doubtful.any()) and widest_margin(about).margin <= tolerances.feasibility


def _optimal(rows: EnergyRows, about: ConeRows, end: RowSolution, start: FloatArray, least: float) -> Bound:
    slip = start + rows.metric.inverse @ end.y * about.length
    relative = (float(np.linalg.norm(end.y)) + about.offset) * about.length
    multipliers, proved = _of_rows(rows, end.multipliers[:-1]), about.proved(end.multipliers)
    uncertain = SETTLED * float(multipliers @ rows.sizes(slip, end.load_factor, relative))
    load_factor = max(end.load_factor, 0.0)
    if (
        uncertain > NEGLIGIBLE * load_factor
    ):  # digits are lost beside the mean load: rounded down by all of them
        load_factor = max(load_factor - uncertain, 0.0)
    excess = -rows.slack(slip, load_factor, relative) / rows.sizes(slip, load_factor, relative)
    distance = about.offset * about.length * rows.metric.unit
    gap = proved / load_factor - 1.0 if load_factor > 0 else proved
    return Bound(
        kind="energy",
        status=Status.OPTIMAL,
        load_factor=load_factor,
        evidence=BallEvidence(relative * rows.metric.unit, start, distance, gap),
        slip=slip,
        active=rows.names(about.carrying(end.multipliers)),
        multipliers=multipliers,
        residual=float(excess.max()),
        least_load_factor=least,
    )


def _of_rows(rows: EnergyRows, multipliers: FloatArray) -> FloatArray:
    """Multipliers of the dimensionless rows in the units of the rows; zero where λ = 0 decides."""
    pull = float(rows.d @ multipliers)
    return multipliers / pull if pull > 0 else np.zeros_like(multipliers)
