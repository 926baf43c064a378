"""The load factor up to which a ball holds a given state, with how far it is confirmed."""

from dataclasses import dataclass, field, replace
from math import inf, nan

import numpy as np

from shakedown.bounds.energy.ball_limits import DiscLimits, without_margin
from shakedown.bounds.energy.best_ball import check_resolved, leaves_margins
from shakedown.bounds.energy.centre_and_shares import farthest, least_load, room_about
from shakedown.bounds.energy.reasons import NO_ROOM, TOO_FAR, UNLIMITED
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.programs.scaling import power_of_two


@dataclass(frozen=True)
class BestBound:
    """The bound of the closed nodes; see :class:`EnergyBound`."""

    status: Status
    reason: str
    share: FloatArray
    slip: FloatArray
    load_factor: float = nan
    least_load_factor: float = nan
    radius: float = nan
    active: tuple[tuple[int, int], ...] = ()
    multipliers: FloatArray = field(default_factory=lambda: np.zeros(0))
    residual: float = nan
    gap: float = nan


def best_bound(
    problem: Problem,
    limits: DiscLimits,
    start: FloatArray,
    distance: float,
    tolerances: Tolerances,
    *,
    split: bool,
) -> BestBound:
    """The largest load factor at which a ball holds a slip of a joint, and a distance around it.

    Found with a periodic part about as large as the constant one: of a small one nothing is lost beside it.
    """
    unit = _load_unit(limits)
    scaled = replace(limits, d=unit * limits.d, gap_d=unit * limits.gap_d)
    found = _best_bound(problem, scaled, start, distance, tolerances, split=split)
    return replace(
        found,
        load_factor=unit * found.load_factor,
        least_load_factor=unit * found.least_load_factor,
        multipliers=unit * found.multipliers,
    )


def _load_unit(limits: DiscLimits) -> float:
    """The power of two next to the load factor at which the periodic part is as large as the constant one."""
    varying = max(np.abs(each).max(initial=0.0) for each in (limits.d, limits.gap_d))
    constant = max(np.abs(each).max(initial=0.0) for each in (limits.g, limits.gap_g))
    return power_of_two(float(constant / varying)) if varying > 0 else 1.0


def _best_bound(
    problem: Problem,
    limits: DiscLimits,
    start: FloatArray,
    distance: float,
    tolerances: Tolerances,
    *,
    split: bool,
) -> BestBound:
    nowhere = np.full(limits.n, nan)
    reason = without_margin(limits)
    if reason:
        return BestBound(Status.INFEASIBLE, reason, limits.share, nowhere)
    check_resolved(limits, start, distance, tolerances)
    found = sought(farthest, limits, start, distance, tolerances, split=split)
    if isinstance(found, Missing):
        return BestBound(Status.UNDECIDED, found.reason, limits.share, nowhere)
    nothing = BestBound(Status.INFEASIBLE, TOO_FAR, found.limits.share, nowhere)
    if found.status == Status.INFEASIBLE:
        left = found.contradiction()
        if left > tolerances.feasibility:
            why = "the limits contradict each other, but no multipliers prove it"
            return replace(nothing, status=Status.UNDECIDED, reason=why)
        return replace(nothing, active=found.limits.names(found.carrying), residual=left)
    # What the constant part, the mean, allows is at least the mean of what the loop allows.
    centred = problem.q_mean is None and problem.p_mean is None
    if found.status == Status.UNBOUNDED:
        if not room_about(found.limits, start, distance).margin > tolerances.feasibility:
            return nothing  # a direction of growth, but nothing to start from
        least = 0.0 if centred else least_load(found.limits, start, distance)
        return replace(
            nothing, status=Status.UNBOUNDED, reason=UNLIMITED, load_factor=inf, least_load_factor=least
        )
    load_factor, limits = found.end.value, found.limits
    least = 0.0 if centred else least_load(limits, start, distance)
    if not leaves_margins(limits, found.slip, 0.5 * (least + load_factor), tolerances):
        return replace(nothing, reason=NO_ROOM)
    return BestBound(
        status=Status.OPTIMAL,
        reason="",
        share=limits.share,
        slip=found.slip,
        load_factor=load_factor,
        least_load_factor=least,
        radius=found.radius * limits.metric.unit,
        active=limits.names(found.carrying),
        multipliers=found.multipliers,
        residual=found.excess(load_factor),
        gap=found.gap,
    )
