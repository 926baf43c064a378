"""The largest ball of slips, in the energy norm, from which every motion is proved to shake down."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf, isfinite, nan
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.bounds.bound_result import Bound, Evidence
from shakedown.bounds.energy.ball_limits import (
    BallLimits,
    EnergyMetric,
    ball_limits,
    check_resolved,
    without_margin,
)
from shakedown.bounds.energy.ball_search import ball_around, full_share, held_by_none, largest_ball, safest
from shakedown.ground.constants import ROUND_OFF, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import (
    check_load_factor,
    checked,
    checked_initial_slip,
    real_array,
    require_problem,
)
from shakedown.joint.constraints import loading
from shakedown.joint.contact_zone import Zone, contact_zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

# Why there is no energy ball, or no end to it, in the words of an answer.
NO_SAFE_SLIP = "no slip keeps every node within its friction limits at this load factor"
NOT_HELD = "no ball at this load factor reaches the state given"
NO_SLACK = "no slip leaves every node a margin to both its friction limits at this load factor"
TOO_FAR = "no safe slip is close enough to the initial slip"


@dataclass(frozen=True, eq=False, repr=False)
class EnergyBall(Result):
    """A ball of slips that no motion leaves, and in which every motion shakes down.

    A joint with all nodes closed, at a slip that is admissible under its load and less
    than ``radius`` away from ``slip`` in the energy norm, comes to rest after a finite
    total slip; no node ever opens. This holds at ``load_factor``, in whatever order the
    loads of the loop and those in between are passed. With open nodes it holds for a state
    in which these are open, in equilibrium, and all others closed: it stays so; distances
    are those of the closed nodes' slips, in the energy norm of the joint that is left.

    Attributes
    ----------
    status
        ``"optimal"``; ``"infeasible"`` (there is no ball: ``radius`` is 0, ``slip`` NaN);
        ``"unbounded"`` (``radius`` can be as large as one likes; where it is inf about one
        centre, every admissible state shakes down, else one ball is given).
    load_factor
        The load factor asked for.
    radius
        R [√(force · length)], the square root of twice an energy.
    slip : (n,)
        v*, the centre: a safe slip [length]; of an open node its displacement under the mean load.
    active
        (node, side) of the rows that limit the ball; with two directions (node, load step).
    residual
        Largest violation of a row, relative to its terms.
    reason
        The status in words; empty where optimal.
    metric
        The energy norm.
    inner_radius
        ``radius`` less what round-off may hide: within it a state is inside for certain.
    share : (n, 2)
        With two directions what part c of the change of its own tangential reaction is counted as the
        change of the pressure of every closed node (docs/energy.md, eq. 1) [1]; else empty.
    zone
        The open nodes and the joint of the closed ones; None with all nodes closed.
    """

    status: Status
    load_factor: float
    radius: float
    slip: FloatArray
    active: tuple[tuple[int, int], ...]
    residual: float
    reason: str
    metric: EnergyMetric = field(repr=False)
    inner_radius: float
    share: FloatArray = field(repr=False)
    zone: Zone | None = field(default=None, repr=False)

    @property
    def open_nodes(self) -> tuple[int, ...]:
        """The nodes that stay open."""
        return () if self.zone is None else self.zone.open_nodes

    @property
    def pinned(self) -> tuple[int, ...]:
        """Where the joint can move as a whole: the slips that ``slip`` is given relative to, by number."""
        closed = self._closed
        return tuple(int(closed[k]) for k in self.metric.pinned)

    def distance(self, slip: ArrayLike) -> FloatArray:
        """Energy distance of slips (…, n) from the centre, (…) [√(force · length)]; inf without a ball."""
        given = real_array("slip", slip)
        if given.ndim == 0 or given.shape[-1] != len(self.slip):
            raise UsageError(f"slip: expected shape (..., {len(self.slip)}), found {given.shape}")
        if self.status == Status.INFEASIBLE:
            return np.full(given.shape[:-1], inf)
        with np.errstate(over="ignore", invalid="ignore"):  # overflow: too far away
            away = self.metric.norm(self._of_closed(given - self.slip))
        return np.where(np.isnan(away), inf, away)

    def margin(self, slip: ArrayLike) -> FloatArray:
        """``radius`` − ``distance(slip)``: how far slips (…, n) may be off and stay in the ball, (…)."""
        return np.asarray(self.radius - self.distance(slip))

    def single_node_margin(self, slip: ArrayLike) -> FloatArray:
        """How far any one node of slips (…, n) may be off, the others in place, (…) [length].

        A slip x of node j alone has the energy norm x √A_jj; with two directions at most that of the
        stiffest of its directions.
        """
        return np.asarray(self.margin(slip) / np.sqrt(self.metric.stiffest))

    def contains(self, slip: ArrayLike, *, off: float = 0.0) -> np.bool_ | np.ndarray:
        """Whether slips (…, n) are inside the ball, by more than round-off, (…).

        Wherever every node may be that is ``off`` by no more [length].
        """
        most = off * len(self._closed) * float(np.sqrt(self.metric.stiffest))
        return np.less(self.distance(slip) + most, self.inner_radius)

    def at(self, direction: ArrayLike, reach: float = 1.0) -> FloatArray:
        """Slips (…, n) on the surface, or at ``reach`` times the radius, along vectors (…, r).

        Directions are those of the energy norm: normally distributed numbers give
        states spread evenly over the surface. r is the rank of A.
        """
        away = np.asarray(direction, dtype=float)
        away = away / np.linalg.norm(away, axis=-1, keepdims=True)
        relative = self.radius / self.metric.unit
        change = reach * relative * (away @ self.metric.inverse.T)
        return np.asarray(self.slip + (change if self.zone is None else self.zone.follow(change)))

    def _of_closed(self, slips: FloatArray) -> FloatArray:
        return slips if self.zone is None else slips[..., self._closed]

    @property
    def _closed(self) -> NDArray[np.intp]:
        """The slips of the closed nodes among those of all nodes."""
        if self.zone is None:
            return np.arange(len(self.slip))
        return self.zone.problem.layout.slips_of(self.zone.closed_nodes)


@dataclass(frozen=True, eq=False, repr=False)
class EnergyCertificate(Result):
    """Numbers that strictly satisfy the conditions of the energy bound in exact arithmetic.

    Of a joint in uncoupled parts each part has a ball of its own; ``radius`` is that of the part with the
    least load factor.

    Attributes
    ----------
    load_factor
        A load factor at which shakedown is proved without any round-off.
    slip : (n,)
        The centre of the ball [length].
    radius
        A radius that reaches the initial state and the distance around it [√(force · length)].
    """

    load_factor: float
    slip: FloatArray
    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class BallEvidence(Evidence):
    """What only λ_E has, below which every motion from around an initial slip is proved to shake down.

    At every load factor strictly between ``least_load_factor`` and ``load_factor`` a
    motion that begins with all nodes closed, at a slip within the energy distance
    ``distance`` of ``initial_slip``, comes to rest after a finite total slip, and no
    node ever opens. With open nodes it holds for a motion that begins with exactly these
    open, in equilibrium, and all others closed: it stays so. From all nodes closed at the
    same slips another state may be reached. It is infeasible where nothing is proved at any load factor,
    unbounded where shakedown is proved at every one from the least on, undecided where no solver came to an
    end that the rows confirm.

    Its ``slip`` (dn,) is v*, the safe slip in the middle of the ball at λ_E [length]. ``active`` are the
    rows that limit λ_E; where infeasible those that contradict each other. ``residual`` is the largest
    violation of a row at (slip, radius, λ_E), relative to its terms; where infeasible, by how much the
    multipliers fail to prove it. ``multipliers`` μ ≥ 0 (k,) prove λ_E, dᵀμ = 1, of the rows of the closed
    nodes and then of the gaps, each kind with its transient after it; zero or empty unless optimal. With two
    directions there is one for each of ``active``, that of its radius f p: at a reaction q* that of a q is
    −q*/|q*| times as large. ``certified`` is the load factor of ``certificate``. Each part of a joint in
    uncoupled parts has a ball of its own, at its own λ_E, of which ``slip`` is the centre (v₀ where that is
    unbounded); all else is that of the part with the least one.

    Attributes
    ----------
    radius
        Radius of that ball, ‖v₀ − v*‖ + distance [√(force · length)]; NaN unless optimal.
    initial_slip : (dn,)
        v₀ [length]; of an open node its displacement under the mean load.
    distance
        δ, the energy distance asked for [√(force · length)].
    gap
        Load factor that the multipliers prove not to be exceeded, relative to λ_E, less 1.
    certificate
        What exact arithmetic confirms (up to 40 nodes, all closed, A exactly positive
        semi-definite), else None.
    share : (n, 2)
        With two directions what part c of the change of its own tangential reaction is counted as the
        change of the pressure of every closed node (docs/energy.md, eq. 1) [1]; else empty.
    """

    DOCUMENT: ClassVar[str] = (
        "load_factor least_load_factor slip radius distance status reason certified uncertified residual "
        "initial_slip open_nodes active gap pinned"
    )
    TABLE: ClassVar[str] = "initial_slip slip"

    radius: float
    initial_slip: FloatArray
    distance: float
    gap: float
    certificate: EnergyCertificate | None = None
    share: FloatArray = field(default_factory=lambda: np.zeros((0, 2)), repr=False)


def no_bound(start: FloatArray, distance: float, reason: str, status: Status = Status.INFEASIBLE) -> Bound:
    """A bound that proves nothing from a slip, with the reason."""
    nowhere = np.full(len(start), nan)
    return Bound(
        kind="energy",
        status=status,
        load_factor=nan,
        evidence=BallEvidence(nan, start, distance, nan),
        slip=nowhere,
        reason=reason,
        least_load_factor=nan,
    )


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
    """The largest ball from which shakedown is proved at one load factor, by optimisation.

    Maximise R over (v*, R) subject to f p ∓ q ≥ f_i γ_i R for every node, side and load
    step at the slip v*, with γ_i the energy norm of what pressure and slip of a node
    have to do with each other beyond the node itself. With a state given, maximise its
    margin R − ‖v − v*‖ instead, by a cone program: where no ball holds it, near the
    largest load factors, the largest ball is a small one in another place. With two tangential
    directions a_i |q| + f_i γ_i R ≤ f p at every load step (docs/energy.md, eq. 3), by cone programs.

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
    >>> round(ball.radius, 3), ball.status
    (63.312, <Status.OPTIMAL: 'optimal'>)
    >>> ball.contains(ball.slip), ball.contains([[0.0, 0.0], [9.0, 9.0]])
    (np.True_, array([ True, False]))
    """
    require_problem(problem)
    check_load_factor(load_factor, problem)
    state = None if around is None else checked_initial_slip(problem, around)
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    limits = ball_limits(zone, transient=transient, tolerances=tolerances)
    held = None if state is None else _of_closed(zone, limits, state)

    def slack(ball: EnergyBall) -> float:
        """The radius of a ball, or how far the state may be disturbed in it; −inf without one."""
        if not ball.radius > 0:
            return -inf
        left = ball.radius if held is None else float(ball.margin(held))
        return left if left > 0 else -inf

    ball = _ball(zone, limits, load_factor, held, tolerances, split=split)
    if ball.share.any():
        most = closed_radius(zone.joint, limits.metric, ball.slip, (load_factor,))
        if not ball.radius < most:  # a node might open in a jump within it
            most *= 1.0 - 10 * ROUND_OFF  # strictly smaller
            inner = most * (1.0 - tolerances.feasibility)
            capped = replace(ball, status=Status.OPTIMAL, reason="", radius=most, inner_radius=inner)
            simple = _ball(zone, limits, load_factor, held, tolerances, split=False)
            ball = max(simple, capped, key=slack)
    return replace(ball, slip=zone.slips(ball.slip), zone=zone) if zone.open_nodes else ball


def no_ball_holds(
    problem: Problem,
    load_factor: float,
    state: FloatArray,
    open_nodes: tuple[int, ...],
    tolerances: Tolerances,
    transient: bool = True,
) -> bool:
    """Whether it is proved, sooner than λ_E or the best ball is found, that no ball holds a state.

    Before the transient, or after it. Where there are no shares to choose these are one program, and say so
    themselves.
    """
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    limits = ball_limits(zone, transient=transient, tolerances=tolerances)
    if not limits.own.any() or without_margin(zone, limits):
        return False
    return held_by_none(limits, load_factor, _of_closed(zone, limits, state))


def _of_closed(zone: Zone, limits: BallLimits, state: FloatArray) -> FloatArray:
    """The slips of the closed nodes of a state, relative to the pinned ones."""
    return limits.rigid.relative(state[zone.problem.layout.slips_of(zone.closed_nodes)])


def _ball(
    zone: Zone,
    limits: BallLimits,
    load_factor: float,
    held: FloatArray | None,
    tolerances: Tolerances,
    *,
    split: bool,
) -> EnergyBall:
    """The largest ball of the closed nodes, or the one in which a state has the largest margin."""
    result = partial(_result, load_factor, tolerances)
    if reason := without_margin(zone, limits):
        return result(limits, Status.INFEASIBLE, reason)
    if held is not None:
        check_resolved(limits, held, 0.0, tolerances)
    each = limits.shared(full_share(limits)) if split else limits
    if not each.spread.any():  # no slip shifts a limit of another node
        slip, margin = safest(each, load_factor)
        if margin > tolerances.feasibility:
            reason = "slip of one node shifts no limit of another: every admissible state shakes down"
            return result(each, Status.UNBOUNDED, reason, slip, inf)
        if not limits.own.any():
            return result(limits, Status.INFEASIBLE, NO_SLACK)
    if held is None:
        found = largest_ball(limits, load_factor, split=split)
    else:
        found = ball_around(limits, load_factor, held, split=split)
    if found.status == Status.INFEASIBLE:
        return result(limits, Status.INFEASIBLE, NO_SAFE_SLIP if held is None else NOT_HELD)
    metric = limits.metric
    if held is not None and not found.value > ROUND_OFF * float(metric.norm(held)) / metric.unit:
        return result(limits, Status.INFEASIBLE, NOT_HELD)
    if not leaves_margins(found.limits, found.slip, load_factor, tolerances):
        return result(limits, Status.INFEASIBLE, NO_SLACK)
    wedged = "the centre may move away without end, and the radius grows with it: this is one ball of many"
    away = 0.0 if held is None else float(metric.norm(found.slip - held)) / metric.unit
    radius = max(0.0, min(found.radius, found.value + away))
    reason = wedged if found.status == Status.UNBOUNDED else ""
    return result(found.limits, found.status, reason, found.slip, radius, found.limits.names(found.active))


def _result(
    load_factor: float,
    tolerances: Tolerances,
    limits: BallLimits,
    status: Status,
    reason: str,
    slip: FloatArray | None = None,
    radius: float = 0.0,
    active: tuple[tuple[int, int], ...] = (),
) -> EnergyBall:
    """The ball about a slip with a relative radius; without one there is none."""
    size, needed = radius * limits.metric.unit, radius if isfinite(radius) else 0.0
    return EnergyBall(
        status=status,
        load_factor=load_factor,
        radius=size,
        slip=np.full(limits.n, nan) if slip is None else slip,
        active=active,
        residual=nan if slip is None else limits.residual(slip, load_factor, needed),
        reason=reason,
        metric=limits.metric,
        inner_radius=size * (1.0 - tolerances.feasibility),
        share=limits.share,
    )


def leaves_margins(limits: BallLimits, slip: FloatArray, load_factor: float, tolerances: Tolerances) -> bool:
    """Whether some slip has a margin > 0 to every limit: then so has one next to every centre.

    The ball needs no slack at a limit with spread 0, but the proof needs a margin there too.
    """
    tight = limits.relative_slack(slip, load_factor) <= tolerances.feasibility
    return not tight.any() or safest(limits, load_factor)[1] > tolerances.feasibility


def closed_radius(
    problem: Problem, metric: EnergyMetric, slip: FloatArray, load_factors: tuple[float, ...]
) -> float:
    """The radius [√(force · length)] up to which p*_i(t) ≥ ‖B_i‖_{A⁻¹} R (docs/energy.md, Theorem 5).

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
