"""The energy balls of a joint in space: cone programs over its discs, and what confirms them."""

from dataclasses import dataclass, replace
from math import inf, nan

import numpy as np

from shakedown.bounds.energy.ball_limits import DiscLimits, disc_limits, without_margin
from shakedown.bounds.energy.centre_and_shares import full_share, held_by_none, holding, largest, widest
from shakedown.bounds.energy.energy_metric import EnergyMetric
from shakedown.bounds.energy.energy_results import (
    ALL_ADMISSIBLE,
    NO_SAFE_SLIP,
    NO_SLACK,
    NOT_HELD,
    WEDGED,
    EnergyBall,
)
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import ROUND_OFF
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.contact_zone import Zone
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem

JUST_LESS = 1.0 - 10 * ROUND_OFF  # factor on a radius that must be strictly smaller


def closed_radius(
    problem: Problem, metric: EnergyMetric, slip: FloatArray, load_factors: tuple[float, ...]
) -> float:
    """The radius [√(force · length)] up to which p*_i(t) ≥ ‖B_i‖_{A⁻¹} R (docs/energy.md, 8).

    For every node and load step, at the load factors given and so between them: slip inside such a ball
    changes no pressure by more. Not positive where a pressure is not; inf for B = 0.

    Parameters
    ----------
    problem, metric
        The joint, all nodes closed, and its energy norm.
    slip : (2n,)
        The centre of the ball [length].
    load_factors
        λ.
    """
    need = np.linalg.norm(problem.B @ metric.inverse, axis=1) / metric.unit
    loop, own = loading(problem), problem.B @ slip
    steps = [loop.p0 + load_factor * loop.p1 for load_factor in load_factors]
    if problem.p_transient is not None:
        steps.append(problem.p_transient)
    least = np.min([step.min(axis=0) for step in steps if len(step)], axis=0) + own
    return float(np.min(np.divide(least, need, out=np.where(least > 0, np.inf, -np.inf), where=need > 0)))


def holds_without_load(
    problem: Problem, metric: EnergyMetric, share: FloatArray, slip: FloatArray, radius: float
) -> bool:
    """Whether the ball keeps its slack under the constant load alone, with these shares (n, 2)."""
    loop, layout = loading(problem), problem.layout
    q, p = layout.by_node(loop.q0 + problem.A @ slip), loop.p0 + problem.B @ slip
    rows = problem.B - np.einsum("ik,ikj->ij", share, problem.A.reshape(problem.n, 2, -1))
    gamma = np.linalg.norm(rows @ metric.inverse, axis=1) * radius / metric.unit
    stretch = np.hypot(1.0, problem.f * np.linalg.norm(share, axis=1))
    return bool((stretch * np.linalg.norm(q, axis=1) + problem.f * gamma <= problem.f * p).all())


@dataclass(frozen=True)
class BestBall:
    """A ball of slips, its radius in units of ``metric.unit``; see :class:`EnergyBall`."""

    status: Status
    reason: str
    slip: FloatArray
    radius: float
    active: tuple[tuple[int, int], ...]
    residual: float
    share: FloatArray
    shortfall: float = nan


def energy_ball(
    zone: Zone,
    load_factor: float,
    state: FloatArray | None,
    tolerances: Tolerances,
    *,
    transient: bool,
    split: bool,
    best: bool = True,
) -> EnergyBall:
    """The largest ball of the closed nodes, or the one that holds a state best, or the first that is met."""
    limits = disc_limits(zone, transient=transient, tolerances=tolerances)
    found = best_ball(limits, load_factor, state, tolerances, split=split, best=best)
    radius = found.radius * limits.metric.unit
    if found.share.any():  # no node may open in a jump
        most = closed_radius(zone.joint, limits.metric, found.slip, (load_factor,)) / limits.metric.unit
        if found.radius >= most:
            simple = best_ball(limits, load_factor, state, tolerances, split=False)
            capped = replace(found, status=Status.OPTIMAL, reason="", radius=most * JUST_LESS)
            found = max(simple, capped, key=lambda ball: _slack_of(limits, ball, state))
            if not best and _slack_of(limits, found, state) == -inf:  # the first one met was too large
                return energy_ball(zone, load_factor, state, tolerances, transient=transient, split=split)
        radius = found.radius * limits.metric.unit
    return EnergyBall(
        status=found.status,
        load_factor=load_factor,
        radius=radius,
        slip=found.slip,
        active=found.active,
        residual=found.residual,
        reason=found.reason,
        metric=limits.metric,
        inner_radius=radius * (1.0 - tolerances.feasibility),
        share=found.share,
        shortfall=found.shortfall * limits.metric.unit,
    )


def no_ball_holds(zone: Zone, load_factor: float, state: FloatArray, tolerances: Tolerances) -> bool:
    """Whether multipliers prove that no ball of the closed nodes holds a state, before any transient."""
    limits = disc_limits(zone, tolerances=tolerances)
    return not without_margin(limits) and held_by_none(limits, load_factor, limits.rigid.relative(state))


def _slack_of(limits: DiscLimits, ball: BestBall, state: FloatArray | None) -> float:
    """The radius of a ball, or how far a state may be disturbed in it; −inf without one."""
    if not ball.radius > 0:
        return -inf
    if state is None:
        return ball.radius
    away = float(limits.metric.norm(limits.rigid.relative(state) - ball.slip)) / limits.metric.unit
    return ball.radius - away if ball.radius > away else -inf


def best_ball(
    limits: DiscLimits,
    load_factor: float,
    state: FloatArray | None,
    tolerances: Tolerances,
    *,
    split: bool,
    best: bool = True,
) -> BestBall:
    """The largest ball at a load factor, or the one in which a state has the largest margin.

    Or, unless the best is asked for, the first one that is met in which the state has a margin.
    """
    reason = without_margin(limits)
    if reason:
        return _nothing(limits, reason)
    held = None if state is None else limits.rigid.relative(state)
    if held is not None:
        check_resolved(limits, held, 0.0, tolerances)
    everywhere = _in_every_ball(limits, split=split)
    if everywhere is not None:
        slip, margin = widest(everywhere, load_factor)
        if margin > tolerances.feasibility:
            residual = _residual(everywhere, load_factor, slip, 0.0)
            return BestBall(Status.UNBOUNDED, ALL_ADMISSIBLE, slip, inf, (), residual, everywhere.share)
        if not limits.own.any():
            return _nothing(limits, NO_SLACK)
    if held is None:
        found, missing = largest(limits, load_factor, tolerances, split=split), NO_SAFE_SLIP
    else:
        found, missing = holding(limits, load_factor, held, tolerances, split=split, best=best), NOT_HELD
    if found.status == Status.INFEASIBLE:
        return _nothing(limits, missing)
    if held is not None and not found.end.value > 0:
        short = -found.end.value * found.about.length
        return replace(_nothing(limits, NOT_HELD), shortfall=short)
    limits, slip = found.limits, found.slip
    if not leaves_margins(limits, slip, load_factor, tolerances):
        return _nothing(limits, NO_SLACK)
    radius = _radius_left(limits, slip, load_factor, found.radius)
    return BestBall(
        found.status,
        WEDGED if found.status == Status.UNBOUNDED else "",
        slip,
        radius,
        limits.names(found.carrying),
        _residual(limits, load_factor, slip, radius),
        limits.share,
    )


def check_resolved(limits: DiscLimits, slip: FloatArray, distance: float, tolerances: Tolerances) -> None:
    """Raise ``UsageError`` where a slip, or a distance around it, drowns the loads in its round-off."""
    loads = float(np.abs(limits.g).max() + np.abs(limits.d).max())
    most = tolerances.stored_digits / np.finfo(float).eps * loads
    metric, G, around = limits.metric, limits.G.reshape(-1, limits.n), 0.0
    with np.errstate(over="ignore"):
        locked = float((np.abs(G) @ np.abs(slip)).max())
        if distance > 0.0:
            reach = float(np.linalg.norm(G @ metric.inverse, axis=1).max(initial=0.0))
            around = reach * distance / metric.unit
    for name, found in (("initial slip", locked), ("distance", around)):
        if loads > 0 and found > most:
            raise UsageError(f"{name}: expected reactions below {most:.3g} from it, found {found:.3g}")


def leaves_margins(limits: DiscLimits, slip: FloatArray, load_factor: float, tolerances: Tolerances) -> bool:
    """Whether some slip has a margin > 0 to every limit: then so has one next to every centre."""
    tight = limits.slack(slip, load_factor) <= tolerances.feasibility * limits.sizes(slip, load_factor)
    return not tight.any() or widest(limits, load_factor)[1] > tolerances.feasibility


def _in_every_ball(limits: DiscLimits, *, split: bool) -> DiscLimits | None:
    """The limits with shares at which no slip shifts a limit of another node; None where there are none."""
    each = limits.shared(full_share(limits)) if split else limits
    return None if each.spread.any() or each.gap_spread.any() else each


def _residual(limits: DiscLimits, load_factor: float, slip: FloatArray, radius: float) -> float:
    """The largest violation of a limit, relative to its terms."""
    excess = -limits.slack(slip, load_factor, radius)
    return float(np.max(excess / limits.sizes(slip, load_factor, radius)))


def _radius_left(limits: DiscLimits, slip: FloatArray, load_factor: float, most: float) -> float:
    """The largest radius, up to the one found, that the limits allow about a slip in floats."""
    spread = np.append(limits.spread[limits.node], limits.gap_spread)
    wide = spread > 0
    return max(0.0, min(most, float(np.min(limits.slack(slip, load_factor)[wide] / spread[wide]))))


def _nothing(limits: DiscLimits, reason: str) -> BestBall:
    nowhere = np.full(limits.n, nan)
    return BestBall(Status.INFEASIBLE, reason, nowhere, 0.0, (), nan, limits.share)
