"""The energy bound of a joint in space: cone programs over its discs, with how far it is confirmed."""

from dataclasses import replace
from math import inf

import numpy as np

from shakedown.bounds.bound_result import Bound
from shakedown.bounds.energy.ball_limits import DiscLimits, disc_limits, without_margin
from shakedown.bounds.energy.centre_and_shares import ball_margin, largest_load_factor, least_load
from shakedown.bounds.energy.disc_ball import (
    check_resolved,
    closed_radius,
    holds_without_load,
    leaves_margins,
)
from shakedown.bounds.energy.energy_metric import EnergyMetric
from shakedown.bounds.energy.energy_results import NO_SLACK, TOO_FAR, UNLIMITED, BallEvidence, Inner, no_bound
from shakedown.bounds.energy.exact_discs import ExactDiscs
from shakedown.ground.errors import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.contact_zone import Zone
from shakedown.joint.problem import Problem
from shakedown.programs.scaling import power_of_two

NOT_CLEARLY = "as stored A without the pinned slips is not clearly positive definite"


def energy_bound(
    zone: Zone, given: FloatArray, distance: float, tolerances: Tolerances, *, split: bool
) -> Bound:
    """λ_E of the closed nodes of a zone."""
    limits = disc_limits(zone, tolerances=tolerances)
    start = limits.rigid.relative(given)
    found = best_bound(zone.joint, limits, start, distance, tolerances, split=split)
    if found.share.any() and not _without_jumps_that_open(zone.joint, limits.metric, found):
        found = best_bound(zone.joint, limits, start, distance, tolerances, split=False)
    return replace(found, pinned=limits.rigid.pinned)  # without the rows of all load steps at once


def strictly_inside(zone: Zone, bound: Bound, tolerances: Tolerances) -> Inner | Missing:
    """Where all conditions of a bound have the largest margins, with all nodes closed."""
    limits = disc_limits(zone, tolerances=tolerances).shared(bound.share)
    exact = ExactDiscs(zone.joint, bound.share)
    if not exact.regular:
        return Missing(limits.rigid.doubt or NOT_CLEARLY)
    widest = ball_margin(limits, bound.initial_slip, bound.distance)
    return Inner(exact, widest.slip, widest.load_factor)


def _without_jumps_that_open(joint: Problem, metric: EnergyMetric, found: Bound) -> bool:
    """Whether the proof with shares is complete: no node opens in a jump, at any load factor from 0 on."""
    if found.status != Status.OPTIMAL:
        return found.status != Status.UNBOUNDED
    between = (0.0, found.load_factor)
    return found.radius < closed_radius(joint, metric, found.slip, between) and (
        (joint.q_mean is None and joint.p_mean is None)
        or holds_without_load(joint, metric, found.share, found.slip, found.radius)
    )


def best_bound(
    problem: Problem,
    limits: DiscLimits,
    start: FloatArray,
    distance: float,
    tolerances: Tolerances,
    *,
    split: bool,
) -> Bound:
    """The largest load factor at which a ball holds a slip of a joint, and a distance around it.

    Found with a periodic part about as large as the constant one: of a small one nothing is lost beside it.
    """
    unit = _load_unit(limits)
    scaled = replace(limits, d=unit * limits.d, gap_d=unit * limits.gap_d)
    found = sought(_best_bound, problem, scaled, start, distance, tolerances, split=split)
    if isinstance(found, Missing):
        return no_bound(start, distance, found.reason, Status.UNDECIDED).but(share=limits.share)
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
) -> Bound:
    nothing = no_bound(start, distance, TOO_FAR).but(share=limits.share)
    if reason := without_margin(limits):
        return replace(nothing, reason=reason)
    check_resolved(limits, start, distance, tolerances)
    found = largest_load_factor(limits, start, distance, tolerances, split=split)
    nothing = nothing.but(share=found.limits.share)
    if found.status == Status.INFEASIBLE:
        left = found.contradiction()
        if left > tolerances.feasibility:
            why = "the limits contradict each other, but no multipliers prove it"
            return replace(nothing, status=Status.UNDECIDED, reason=why)
        return replace(nothing, active=found.limits.names(found.carrying), residual=left)
    # What the constant part, the mean, allows is at least the mean of what the loop allows.
    centred = problem.q_mean is None and problem.p_mean is None
    if found.status == Status.UNBOUNDED:
        if not ball_margin(found.limits, start, distance).margin > tolerances.feasibility:
            return nothing  # a direction of growth, but nothing to start from
        least = 0.0 if centred else least_load(found.limits, start, distance)
        return replace(
            nothing, status=Status.UNBOUNDED, reason=UNLIMITED, load_factor=inf, least_load_factor=least
        )
    load_factor, limits = found.end.value, found.limits
    least = 0.0 if centred else least_load(limits, start, distance)
    if not leaves_margins(limits, found.slip, 0.5 * (least + load_factor), tolerances):
        return replace(nothing, reason=NO_SLACK)
    radius = found.radius * limits.metric.unit
    return Bound(
        kind="energy",
        status=Status.OPTIMAL,
        load_factor=load_factor,
        evidence=BallEvidence(radius, start, distance, found.gap, share=limits.share),
        slip=found.slip,
        active=limits.names(found.carrying),
        multipliers=found.multipliers,
        residual=found.excess(load_factor),
        least_load_factor=least,
    )
