"""The largest ball of slips, in the energy norm, from which every motion is proved to shake down."""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from math import inf, isfinite, nan

import numpy as np
from numpy.typing import ArrayLike

from shakedown.bounds.energy.ball_limits import (
    BallLimits,
    EnergyMetric,
    ball_limits,
    check_resolved,
    without_margin,
)
from shakedown.bounds.energy.ball_search import ball_around, full_share, held_by_none, largest_ball, widest
from shakedown.bounds.energy.energy_results import (
    ALL_ADMISSIBLE,
    NO_SAFE_SLIP,
    NO_SLACK,
    NOT_HELD,
    WEDGED,
)
from shakedown.bounds.energy.energy_results import EnergyBall as EnergyBall
from shakedown.ground.constants import ROUND_OFF, FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked, checked_initial_slip, require_problem
from shakedown.joint.contact_zone import Zone, contact_zone
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem

JUST_LESS = 1.0 - 10 * ROUND_OFF  # factor on a radius that must be strictly smaller


@checked
def energy_ball(
    problem: Problem,
    load_factor: float,
    *,
    around: ArrayLike | None = None,
    transient: bool = True,
    open_nodes: Iterable[int] = (),
    split: bool = True,
    tolerances: Tolerances = DEFAULT,
) -> EnergyBall:
    """The largest ball from which shakedown is proved at one load factor, by a program over its limits.

    Maximise R over (v*, R) subject to f p ∓ q ≥ f_i γ_i R for every node, side and load
    step at the slip v*, with γ_i the energy norm of what pressure and slip of a node
    have to do with each other beyond the node itself. With a state given, maximise its
    margin R − ‖v − v*‖ instead, by a cone program: where no ball holds it, near the
    largest load factors, the largest ball is a small one in another place. With two tangential
    directions a_i |q| + f_i γ_i R ≤ f p at every load step (docs/energy.md, section 8), by cone programs.

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0, multiplies the periodic part of the loading.
    around : (n,), optional
        The state v that is to be as far inside as possible [length].
    transient
        Whether the transient load steps, where the problem has them, are still to come.
    open_nodes
        Nodes that are open through the whole period, all others closed; each adds the
        condition that its gap stays.
    split
        With two directions, whether the part c_i of a pressure that the node's own reaction determines is
        taken out of γ_i, in a few rounds; else c = 0. In the plane it always is.
    tolerances
        What counts as zero and as feasible (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If the load factor is negative or not finite, the state mis-shaped, or nothing
        holds the open nodes.
    ProblemError
        If nodes are open and the problem has no C.
    SolverError
        If the program ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> ball = shakedown.energy_ball(shakedown.example("two-node"), 0.36957278)
    >>> round(ball.radius, 3), ball.status, ball.nodes
    (63.312, <Status.OPTIMAL: 'optimal'>, (0, 1))
    >>> ball.contains(ball.slip), ball.contains([[0.0, 0.0], [9.0, 9.0]])
    (np.True_, array([ True, False]))
    """
    require_problem(problem)
    check_load_factor(load_factor, problem)
    state = None if around is None else checked_initial_slip(problem, around)
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    return _in_zone(zone, load_factor, state, tolerances, transient=transient, split=split)


def holding_ball(
    problem: Problem,
    load_factor: float,
    state: FloatArray,
    open_nodes: tuple[int, ...],
    tolerances: Tolerances,
) -> EnergyBall:
    """A ball that holds a state after the transient: in space the first that is met, if any does.

    Raises as :func:`energy_ball`, which finds the one that holds it best.
    """
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    return _in_zone(zone, load_factor, state, tolerances, transient=False, split=True, best=False)


def no_ball_holds(
    problem: Problem,
    load_factor: float,
    state: FloatArray,
    open_nodes: tuple[int, ...],
    tolerances: Tolerances,
) -> bool:
    """Whether it is proved, sooner than λ_E is found, that no ball holds a state before the transient.

    Where there are no shares to choose λ_E is one program, and says so itself.
    """
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    limits = ball_limits(zone, tolerances=tolerances)
    if not limits.own.any() or without_margin(zone, limits):
        return False
    return held_by_none(limits, load_factor, _of_closed(zone, limits, state))


def _of_closed(zone: Zone, limits: BallLimits, state: FloatArray) -> FloatArray:
    """The slips of the closed nodes of a state, relative to the pinned ones."""
    return limits.rigid.relative(state[zone.problem.layout.slips_of(zone.closed_nodes)])


def _in_zone(
    zone: Zone,
    load_factor: float,
    state: FloatArray | None,
    tolerances: Tolerances,
    *,
    transient: bool,
    split: bool,
    best: bool = True,
) -> EnergyBall:
    """The ball of the closed nodes of a zone in terms of all nodes; no node may open in a jump within it."""
    limits = ball_limits(zone, transient=transient, tolerances=tolerances)
    held = None if state is None else _of_closed(zone, limits, state)

    def found(split: bool, best: bool = True) -> EnergyBall:
        ball = _ball(zone, limits, load_factor, held, tolerances, split=split, best=best)
        if not ball.share.any():
            return ball
        most = closed_radius(zone.joint, limits.metric, ball.slip, (load_factor,))
        if ball.radius < most:
            return ball
        most *= JUST_LESS
        inner = most * (1.0 - tolerances.feasibility)
        capped = replace(ball, status=Status.OPTIMAL, reason="", radius=most, inner_radius=inner)
        simple = _ball(zone, limits, load_factor, held, tolerances, split=False)
        kept = max(simple, capped, key=slack)
        return found(split) if not best and slack(kept) == -inf else kept  # the first one met was too large

    def slack(ball: EnergyBall) -> float:
        """The radius of a ball, or how far the state may be disturbed in it; −inf without one."""
        if not ball.radius > 0:
            return -inf
        left = ball.radius if held is None else float(ball.margin(held))
        return left if left > 0 else -inf

    ball = found(split, best)
    return replace(ball, slip=zone.slips(ball.slip), zone=zone) if zone.open_nodes else ball


def _ball(
    zone: Zone,
    limits: BallLimits,
    load_factor: float,
    held: FloatArray | None,
    tolerances: Tolerances,
    *,
    split: bool,
    best: bool = True,
) -> EnergyBall:
    """The largest ball of the closed nodes, the one in which a state has the largest margin, or the first."""
    result = partial(_result, load_factor, tolerances)
    if reason := without_margin(zone, limits):
        return result(limits, Status.INFEASIBLE, reason)
    if held is not None:
        check_resolved(limits, held, 0.0, tolerances)
    each = limits.shared(full_share(limits)) if split else limits
    if not each.spread.any():  # no slip shifts a limit of another node
        slip, margin = widest(each, load_factor)
        if margin > tolerances.feasibility:
            return result(each, Status.UNBOUNDED, ALL_ADMISSIBLE, slip=slip, radius=inf)
        if not limits.own.any():
            return result(limits, Status.INFEASIBLE, NO_SLACK)
    if held is None:
        found = largest_ball(limits, load_factor, split=split)
    else:
        found = ball_around(limits, load_factor, held, tolerances, split=split, best=best)
    if found.status == Status.INFEASIBLE:
        return result(limits, Status.INFEASIBLE, NO_SAFE_SLIP if held is None else NOT_HELD)
    if held is not None and not found.value > 0:
        return result(limits, Status.INFEASIBLE, NOT_HELD, shortfall=-found.value * limits.metric.unit)
    spread, slack = found.limits.spread, found.limits.slack(found.slip, load_factor)
    if not leaves_margins(found.limits, found.slip, load_factor, tolerances):
        return result(limits, Status.INFEASIBLE, NO_SLACK)
    most = float(np.min(slack[spread > 0] / spread[spread > 0]))  # what the limits allow in floats
    return result(
        found.limits,
        found.status,
        WEDGED if found.status == Status.UNBOUNDED else "",
        slip=found.slip,
        radius=max(0.0, min(found.radius, most)),
        active=found.limits.names(found.carrying),
    )


def _result(
    load_factor: float,
    tolerances: Tolerances,
    limits: BallLimits,
    status: Status,
    reason: str,
    *,
    slip: FloatArray | None = None,
    radius: float = 0.0,
    active: tuple[tuple[int, int], ...] = (),
    shortfall: float = nan,
) -> EnergyBall:
    """The ball about a slip with a relative radius; without one there is none."""
    needed = radius if isfinite(radius) else 0.0
    return EnergyBall(
        status=status,
        load_factor=load_factor,
        radius=radius * limits.metric.unit,
        slip=np.full(limits.n, nan) if slip is None else slip,
        active=active,
        residual=nan if slip is None else limits.residual(slip, load_factor, needed),
        reason=reason,
        metric=limits.metric,
        inner_radius=radius * limits.metric.unit * (1.0 - tolerances.feasibility),
        share=limits.share,
        shortfall=shortfall,
    )


def leaves_margins(limits: BallLimits, slip: FloatArray, load_factor: float, tolerances: Tolerances) -> bool:
    """Whether some slip has a margin > 0 to every limit: then so has one next to every centre.

    The ball needs no slack at a limit with spread 0, but the proof needs a margin there too.
    """
    tight = limits.slack(slip, load_factor) <= tolerances.feasibility * limits.sizes(slip, load_factor)
    return not tight.any() or widest(limits, load_factor)[1] > tolerances.feasibility


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
    slip : (dn,)
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
