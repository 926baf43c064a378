"""The largest ball of slips, in the energy norm, from which every motion is proved to shake down."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from math import inf, nan

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.bounds.energy.ball_limits import DiscLimits, disc_limits
from shakedown.bounds.energy.best_ball import BestBall, best_ball
from shakedown.bounds.energy.closed_ball import closed_radius
from shakedown.bounds.energy.cone_rows import margin_rows
from shakedown.bounds.energy.energy_metric import EnergyMetric
from shakedown.bounds.energy.energy_rows import EnergyRows, check_resolved, without_margin
from shakedown.bounds.energy.farthest import end_of
from shakedown.bounds.energy.reasons import ALL_ADMISSIBLE, NO_ROOM, NO_SAFE_SLIP, NOT_HELD, WEDGED
from shakedown.bounds.energy.zone_rows import zone_rows
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import (
    check_load_factor,
    checked,
    checked_initial_slip,
    real_array,
    require_problem,
)
from shakedown.joint.contact_zone import Zone, contact_zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.margin import widest
from shakedown.programs.program import INF, Program, Solution
from shakedown.programs.scaling import typical_size
from shakedown.programs.solver import solve

JUST_LESS = 1.0 - 1e-12  # of a radius that must be smaller than that


@dataclass(frozen=True, eq=False, repr=False)
class EnergyBall(Result):
    """A ball of slips that no motion leaves, and in which every motion shakes down.

    A joint with all nodes closed, at a slip that is admissible under its load and less
    than ``radius`` away from ``slip`` in the energy norm, comes to rest after a finite
    total slip; no node ever opens. This holds at ``load_factor``, in whatever order the
    loads of the loop and those in between are passed. With open nodes it is said of a state
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
    zone
        The open nodes and the joint of the closed ones; None with all nodes closed.
    share : (n, 2)
        With two directions what part c of the change of its own tangential reaction is counted as the
        change of the pressure of every closed node (docs/energy.md, section 8) [1]; else empty.
    shortfall
        With two directions, where no ball was found to hold the state given: how far that is from one,
        −max (R − ‖v − v*‖) [√(force · length)]; else NaN. States less than that away from it are in none
        with the same shares.
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
    zone: Zone | None = field(default=None, repr=False)
    share: FloatArray = field(default_factory=lambda: np.zeros((0, 2)), repr=False)
    shortfall: float = nan

    @property
    def open_nodes(self) -> tuple[int, ...]:
        """The nodes that stay open."""
        return () if self.zone is None else self.zone.open_nodes

    @property
    def pinned(self) -> tuple[int, ...]:
        """Where the joint can move as a whole: the slips that ``slip`` is given relative to, by number."""
        closed = self._closed
        return tuple(int(closed[k]) for k in self.metric.pinned)

    @property
    def nodes(self) -> tuple[int, ...]:
        """The nodes that limit the ball."""
        return tuple(dict.fromkeys(node for node, _ in self.active))

    def distance(self, slip: ArrayLike) -> FloatArray:
        """Energy distance of slips (…, n) from the centre, (…) [√(force · length)]; inf without a ball."""
        given = real_array("slip", slip)
        if given.ndim == 0 or given.shape[-1] != len(self.slip):
            raise UsageError(f"slip: expected shape (..., {len(self.slip)}), found {given.shape}")
        if self.status == Status.INFEASIBLE:
            return np.full(given.shape[:-1], inf)
        with np.errstate(over="ignore", invalid="ignore"):  # too far for floats is far
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

    def contains(self, slip: ArrayLike) -> np.bool_ | np.ndarray:
        """Whether slips (…, n) are inside the ball, by more than round-off, (…)."""
        return np.less(self.distance(slip), self.inner_radius)

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
    """The largest ball from which shakedown is proved at one load factor, by a linear program.

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
    if problem.directions > 1:
        held = None if state is None else state[problem.layout.slips_of(zone.closed_nodes)]
        ball = _in_space(zone, load_factor, held, tolerances, transient=transient, split=split)
        return _in_zone(zone, ball)
    rows = zone_rows(zone, transient=transient, tolerances=tolerances)
    reason = without_margin(problem, rows)
    if reason:
        return _in_zone(zone, _nothing(rows, load_factor, reason))
    if state is None:
        return _in_zone(zone, largest_ball(rows, load_factor, tolerances))
    held = rows.rigid.relative(state[list(zone.closed_nodes)])
    check_resolved(rows, held, 0.0, tolerances)
    return _in_zone(zone, ball_around(rows, load_factor, held, tolerances))


def _in_zone(zone: Zone, ball: EnergyBall) -> EnergyBall:
    """A ball of the closed nodes' slips in terms of all nodes."""
    return replace(ball, slip=zone.slips(ball.slip), zone=zone) if zone.open_nodes else ball


def _in_space(
    zone: Zone,
    load_factor: float,
    state: FloatArray | None,
    tolerances: Tolerances,
    *,
    transient: bool,
    split: bool,
) -> EnergyBall:
    """The largest ball of a joint with two tangential directions, or the one that holds a state best."""
    limits = disc_limits(zone, transient=transient, tolerances=tolerances)
    found = best_ball(limits, load_factor, state, tolerances, split=split)
    radius = found.radius * limits.metric.unit
    if found.share.any():  # no node may open in a jump
        most = closed_radius(zone.joint, limits.metric, found.slip, (load_factor,)) / limits.metric.unit
        if found.radius >= most:
            simple = best_ball(limits, load_factor, state, tolerances, split=False)
            capped = replace(found, status=Status.OPTIMAL, reason="", radius=most * JUST_LESS)
            found = max(simple, capped, key=lambda ball: _room_for(limits, ball, state))
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


def _room_for(limits: DiscLimits, ball: BestBall, state: FloatArray | None) -> float:
    """The radius of a ball, or how far a state may be disturbed in it; −inf without one."""
    if not ball.radius > 0:
        return -inf
    if state is None:
        return ball.radius
    away = float(limits.metric.norm(limits.rigid.relative(state) - ball.slip)) / limits.metric.unit
    return ball.radius - away if ball.radius > away else -inf


def largest_ball(rows: EnergyRows, load_factor: float, tolerances: Tolerances = DEFAULT) -> EnergyBall:
    """The largest ball that keeps its room at every row, of whatever kind the rows are."""
    room = rows.g - load_factor * rows.d
    if not rows.spread.any():
        return _whole_space(rows, load_factor, tolerances)
    found = _widest_ball(rows, room, INF, tolerances)
    if found.status == "infeasible":
        return _nothing(rows, load_factor, NO_SAFE_SLIP)
    status = Status.OPTIMAL
    if not found.optimal:
        wide = rows.spread > 0
        cap = typical_size(np.abs(room[wide]) / rows.spread[wide])
        found, status = _widest_ball(rows, room, cap, tolerances), Status.UNBOUNDED
    active = np.flatnonzero(found.multipliers)
    ball = _ball(rows, load_factor, found.x[:-1], float(found.x[-1]), active, tolerances)
    if status == Status.UNBOUNDED and ball.status == Status.OPTIMAL:
        return replace(ball, status=status, reason=WEDGED)
    return ball


def ball_around(
    rows: EnergyRows, load_factor: float, state: FloatArray, tolerances: Tolerances = DEFAULT
) -> EnergyBall:
    """The ball in which a state has the largest margin, whatever the rows are."""
    if not rows.spread.any():
        return _whole_space(rows, load_factor, tolerances)
    about = margin_rows(rows, load_factor, state)
    end = end_of(about, tolerances)
    if end.status != Status.OPTIMAL:
        return _nothing(rows, load_factor, NOT_HELD)
    slip = state + rows.metric.inverse @ end.y * about.length
    relative = (float(np.linalg.norm(end.y)) + end.load_factor) * about.length
    return _ball(rows, load_factor, slip, relative, about.carrying(end.multipliers), tolerances)


def _ball(
    rows: EnergyRows,
    load_factor: float,
    slip: FloatArray,
    relative: float,
    active: NDArray[np.intp],
    tolerances: Tolerances,
) -> EnergyBall:
    """The ball about a centre, its radius cut down to what the rows allow in floats."""
    relative = max(_ratio(rows, slip, load_factor, relative), 0.0)
    if not _leaves_margins(rows, slip, load_factor, tolerances):
        return _nothing(rows, load_factor, NO_ROOM)
    radius = relative * rows.metric.unit
    excess = -rows.room(slip, load_factor, relative) / rows.sizes(slip, load_factor, relative)
    return EnergyBall(
        status=Status.OPTIMAL,
        load_factor=load_factor,
        radius=radius,
        slip=slip,
        active=rows.names(active),
        residual=float(excess.max()),
        reason="",
        metric=rows.metric,
        inner_radius=radius * (1.0 - tolerances.feasibility),
    )


def _widest_ball(rows: EnergyRows, room: FloatArray, cap: float, tolerances: Tolerances) -> Solution:
    """Maximise R in 0 ≤ R ≤ cap over the columns (v, R)."""
    n = rows.n
    return solve(
        Program(
            np.column_stack([rows.coefficients, rows.spread]),
            room,
            cost=np.append(np.zeros(n), -1.0),
            lower=np.append(np.full(n, -INF), 0.0),
            upper=np.append(np.full(n, INF), cap),
            tolerances=tolerances,
        )
    )


def _ratio(rows: EnergyRows, slip: FloatArray, load_factor: float, relative: float) -> float:
    """The largest radius, up to the one found, that the rows allow about a slip in floats."""
    wide = rows.spread > 0
    return min(relative, float(np.min(rows.room(slip, load_factor)[wide] / rows.spread[wide])))


def _leaves_margins(rows: EnergyRows, slip: FloatArray, load_factor: float, tolerances: Tolerances) -> bool:
    """Whether some slip has a margin > 0 to every row: then so has one next to every centre.

    The ball needs no room at a row with spread 0, but the proof needs a margin there too.
    """
    tight = rows.room(slip, load_factor) <= tolerances.feasibility * rows.sizes(slip, load_factor)
    if not tight.any():
        return True
    return _widest_margin(rows, load_factor, tolerances)[1]


def _widest_margin(rows: EnergyRows, load_factor: float, tolerances: Tolerances) -> tuple[FloatArray, bool]:
    """The slip with the largest margin to the rows, and whether that is one."""
    sizes = np.ldexp(1.0, np.frexp(np.abs(rows.G).max(axis=1))[1])
    norms = np.linalg.norm(rows.G / sizes[:, None], axis=1)
    norms = np.where(norms > 0, norms, 1.0) * sizes
    room = rows.g - load_factor * rows.d
    cap = typical_size(np.abs(room) / norms)
    found = widest(rows.coefficients, norms, room, cap=cap, tolerances=tolerances)
    sizes = rows.sizes(found.x, load_factor)
    return found.x, bool(np.all(rows.room(found.x, load_factor) > tolerances.feasibility * sizes))


def _whole_space(rows: EnergyRows, load_factor: float, tolerances: Tolerances) -> EnergyBall:
    """No row needs room for the ball: its radius is infinite where a slip has margins at all."""
    slip, safe = _widest_margin(rows, load_factor, tolerances)
    if not safe:
        return _nothing(rows, load_factor, NO_ROOM)
    excess = -rows.room(slip, load_factor) / rows.sizes(slip, load_factor)
    return EnergyBall(
        Status.UNBOUNDED, load_factor, inf, slip, (), float(excess.max()), ALL_ADMISSIBLE, rows.metric, inf
    )


def _nothing(rows: EnergyRows, load_factor: float, reason: str) -> EnergyBall:
    nowhere = np.full(rows.n, nan)
    return EnergyBall(Status.INFEASIBLE, load_factor, 0.0, nowhere, (), nan, reason, rows.metric, 0.0)
