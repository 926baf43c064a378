"""How a bound depends on friction, constant load and load amplitude at every node."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.bound_result import Bound
from shakedown.bounds.energy.ball_limits import BallLimits, EnergyMetric, ball_limits
from shakedown.ground.constants import EPS, NEGLIGIBLE, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import DIGITS, plain
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import Status
from shakedown.joint.arguments import checked, require_plane
from shakedown.joint.constraints import Side, loading, transient_path
from shakedown.joint.contact_zone import Zone, contact_zone, coupled_parts
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.program import INF, Program, equilibration
from shakedown.programs.simplex import solve

NOT_UNIQUE = "what limits it is not unique: several nodes, or load steps, do so alike"
SAME = 10 * NEGLIGIBLE  # relative to the terms of a derivative: differences between optima that do not matter
KINDS = ("friction", "constant", "amplitude")
SMOOTH = 10.0**-DIGITS  # of the largest elasticity: one-sided values that differ by less are equal
SIDES = np.array([-1.0, 1.0])  # a parameter falls, or grows


@dataclass(frozen=True, eq=False, repr=False)
class Slopes(Result):
    """Derivatives of a load factor with respect to one quantity; column 0 as it falls, column 1 as it grows.

    Attributes
    ----------
    derivative : (n, 2)
        dλ/dθ, θ the quantity at one node, all others as they are.
    elasticity : (n, 2)
        d ln λ / d ln θ: by how many per cent λ changes with one per cent of θ there.
    together : (2,)
        The elasticity where the quantity changes by one factor at all nodes.
    """

    derivative: FloatArray
    elasticity: FloatArray
    together: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivities(Result):
    """Result of :func:`sensitivities`.

    Attributes
    ----------
    symbol
        ``"λ_max"`` or ``"λ_E"``.
    status
        That of the bound; of one that is not optimal there are no derivatives.
    reason
        Why there are none, in words; else empty.
    load_factor
        λ.
    friction
        θ = f_i, the friction coefficient of a node.
    constant
        θ = a factor on the constant load r⁰ of a node, on its transient load steps too where the
        bound has them.
    amplitude
        θ = a factor on the periodic load r¹ of a node.
    """

    symbol: str
    status: Status
    reason: str
    load_factor: float
    friction: Slopes
    constant: Slopes
    amplitude: Slopes

    @property
    def smooth(self) -> bool:
        """Whether both sides agree everywhere: the optimum is not degenerate."""
        values = np.vstack([getattr(self, kind).elasticity for kind in KINDS])
        size = np.nanmax(np.abs(values), initial=0.0)
        return bool(np.all(np.abs(values[:, 1] - values[:, 0]) <= SMOOTH * size))

    def ranked(self, at_least: float = SMOOTH) -> NDArray[np.intp]:
        """The nodes with a notable influence on the load factor, the most important first."""
        sizes = np.nansum([np.abs(getattr(self, kind).elasticity).max(axis=1) for kind in KINDS], axis=0)
        order = np.argsort(-sizes, kind="stable")
        return order[sizes[order] > at_least * sizes.max(initial=0.0)]

    def to_dict(self) -> dict[str, Any]:
        """Every derivative as [as it falls, as it grows]."""
        about = {"status": self.status, "reason": self.reason, "load_factor": self.load_factor}
        known = {kind: getattr(self, kind) for kind in KINDS}
        return {key: plain(value) for key, value in (about | {"smooth": self.smooth} | known).items()}

    def columns(self) -> dict[str, Any]:
        """One row per node: the elasticities as the quantity grows."""
        return {kind: getattr(self, kind).elasticity[:, 1] for kind in KINDS}


@checked
def sensitivities(problem: Problem, bound: Bound, *, tolerances: Tolerances = DEFAULT) -> Sensitivities:
    """By how much λ_max or λ_E changes with friction, constant load and load amplitude, at every node.

    The bound is the optimum of a program over rows g − G v − λ d (less the slack R s of the ball, for
    λ_E); its derivative is that of the rows at the optimum, weighted with the multipliers (envelope theorem):

        dλ/df_i = Σ y p_i,    dλ/dc_i = Σ y (f p⁰ ∓ q⁰)_i,    dλ/da_i = λ Σ y (f p¹ ∓ q¹)_i

    over the rows of node i, p_i less ∂(f γ)/∂f R for λ_E. Nothing is solved again. Where the multipliers are
    not unique, as where several nodes limit the joint alike, there is no such derivative: all are NaN, with
    the reason. Where the best slip is not unique, and its pressure matters, a small program tells how far the
    derivative by friction may go on either side, up to 40 nodes; beyond it is NaN. What varies is one
    quantity of one node; stiffness, the other nodes, the initial slip, the distance and the zone stay. Where
    nodes are open the loads of all nodes act on the closed ones.

    The factor on all constant loads together has the elasticity 1 (for λ_E from slip zero without a
    distance), that on all amplitudes −1.

    Parameters
    ----------
    problem
        The joint and its loading.
    bound
        Its λ_max, not through the transient, or its λ_E.
    tolerances
        Those with which the bound was computed.

    Raises
    ------
    UsageError
        If the bound is of another kind, or not one of this joint.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> found = sensitivities(joint, shakedown.upper_bound(joint))
    >>> found.friction.elasticity.round(3)
    array([[0.04 , 0.04 ],
           [0.924, 0.924]])
    >>> found.constant.together.round(9), found.smooth
    (array([1., 1.]), True)
    """
    require_plane("sensitivities", problem)
    reached = {"upper": _of_upper, "energy": _of_energy}.get(bound.kind)
    if reached is None:
        raise UsageError(f"bound: expected λ_max or λ_E, found {bound.symbol}")
    if bound.slip.shape != (problem.layout.slip_size,):
        raise UsageError(f"bound: expected one of a joint with {problem.n} nodes, found {bound.slip.size}")
    reason = bound.reason if bound.status != Status.OPTIMAL else ""
    if not reason and not bound.load_factor > 0:
        reason = "at λ = 0 nothing is left to lose"
    if reason:
        return _none(problem, bound, reason)
    if bound.kind == "energy" and bound.parts:
        return _of_parts(problem, bound, tolerances)
    zone = contact_zone(problem, bound.open_nodes, tolerances=tolerances)
    found = reached(zone, bound, tolerances)
    if not found.unique:
        return _none(problem, bound, NOT_UNIQUE)
    return Sensitivities(
        symbol=bound.symbol,
        status=bound.status,
        reason="",
        load_factor=bound.load_factor,
        friction=found.friction(),
        constant=found.loads(found.rates.constant),
        amplitude=found.loads(found.rates.amplitude),
    )


def _none(problem: Problem, bound: Bound, reason: str) -> Sensitivities:
    none = Slopes(*(np.full(shape, np.nan) for shape in ((problem.n, 2), (problem.n, 2), 2)))
    return Sensitivities(bound.symbol, bound.status, reason, bound.load_factor, none, none, none)


def _of_parts(problem: Problem, bound: Bound, tolerances: Tolerances) -> Sensitivities:
    """Those of the uncoupled part that decides; none where several do."""
    parts, most = coupled_parts(problem, bound.open_nodes), (1.0 + tolerances.feasibility) * bound.load_factor
    deciding = [
        (part, each) for part, each in zip(parts, bound.parts, strict=True) if each.load_factor <= most
    ]
    if len(deciding) > 1:
        return _none(problem, bound, NOT_UNIQUE)
    part, own = deciding[0]
    found = sensitivities(part.joint, own, tolerances=tolerances)

    def everywhere(slopes: Slopes) -> Slopes:
        of_nodes = np.zeros((2, problem.n, 2))
        of_nodes[:, part.nodes] = slopes.derivative, slopes.elasticity
        return Slopes(of_nodes[0], of_nodes[1], slopes.together)

    changed: dict[str, Any] = {kind: everywhere(getattr(found, kind)) for kind in KINDS}
    return replace(found, **changed)


@dataclass(frozen=True)
class RowRates:
    """Changes of the slack g − G v − λ d of some rows of a zone, per change of a parameter, at fixed v and λ.

    Every row is the least of its load steps: at a tie the change for the better and that for the
    worse are not opposite, so that each comes for a parameter that falls (column 0) and for one that grows.

    Attributes
    ----------
    zone
        The joint, and its open nodes.
    row : (k,)
        Rows by number, in the order of ``zone.constraints``.
    before : (k,)
        Whether it is the row of the transient load steps.
    scale : (k,)
        What a row is multiplied by.
    load_factor
        λ.
    """

    zone: Zone
    row: NDArray[np.intp]
    before: NDArray[np.bool_]
    scale: FloatArray
    load_factor: float

    def among(self, chosen: NDArray[np.intp]) -> "RowRates":
        """Some of the rows."""
        return replace(self, row=self.row[chosen], before=self.before[chosen], scale=self.scale[chosen])

    @property
    def node(self) -> NDArray[np.intp]:
        """The node of every row, numbered in the whole joint."""
        return self.zone.constraints.node[self.row]

    def pressures(self, slip: FloatArray) -> FloatArray:
        """Rate of the slack with the node's own friction at the slips of the closed nodes, (k, 2) [force].

        It is the pressure of the node where it grows; of a row without friction zero.
        """
        p = self._condensed(self._loads)[1] + self.zone.joint.B @ slip
        rates = np.zeros((len(p), len(self.row)))
        rates[:, self.rubs] = p[:, self.row[self.rubs] // 2]
        return self._worst(rates)

    def pressure_slopes(self) -> FloatArray:
        """∂p/∂v of the node of every row, over the unknowns of programs, (k, n) [force/length]."""
        joint, slopes = self.zone.joint, np.zeros((len(self.row), self.zone.joint.layout.slip_size))
        slopes[self.rubs] = self.zone.constraints.rigid.columns(joint.B)[self.row[self.rubs] // 2]
        return slopes

    def constant(self, nodes: NDArray[np.intp]) -> FloatArray:
        """Rate of the slack with a factor on the constant load of some nodes, transient included, (k, 2)."""
        return self._worst(self._slacks(self._of_nodes(self._constant, nodes)))

    def amplitude(self, nodes: NDArray[np.intp]) -> FloatArray:
        """Rate of the slack with a factor on the periodic load of some nodes, (k, 2) [force]."""
        periodic = self._loads - self._constant
        return self._worst(self._slacks(self._of_nodes(periodic, nodes)))

    @property
    def rubs(self) -> NDArray[np.bool_]:
        """Which rows are friction limits, rather than gaps or pressures."""
        return self.zone.constraints.sided[self.row]

    @cached_property
    def _loads(self) -> FloatArray:
        """The welded reactions of every load step at λ, those of the transient last, (m + k, 2n)."""
        loop, joined = loading(self.zone.problem), self.zone.problem.layout.joined
        return np.vstack([joined(*loop.at(self.load_factor)), transient_path(self.zone.problem)])

    @cached_property
    def _constant(self) -> FloatArray:
        """The part of these loads that the load factor does not multiply."""
        loop, problem = loading(self.zone.problem), self.zone.problem
        mean = np.tile(problem.layout.joined(loop.q0, loop.p0), (problem.m, 1))
        return np.vstack([mean, transient_path(problem)])

    def _of_nodes(self, loads: FloatArray, nodes: NDArray[np.intp]) -> FloatArray:
        chosen, part = self.zone.problem.layout.of_nodes(nodes), np.zeros_like(loads)
        part[:, chosen] = loads[:, chosen]
        return part

    def _condensed(self, loads: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Welded reactions of the closed nodes with the open ones free, and their gaps at zero slip."""
        zone, layout = self.zone, self.zone.problem.layout
        if not zone.open_nodes:
            return *layout.split(loads), np.zeros((len(loads), 0))
        free, held = layout.of_nodes(zone.open_nodes), layout.of_nodes(zone.closed_nodes)
        moved = loads[:, free] @ zone.flexibility
        left = loads[:, held] - moved @ zone.problem.kappa[np.ix_(free, held)]
        return *zone.joint.layout.split(left), -moved[:, len(moved.T) // (layout.d + 1) * layout.d :]

    def _slacks(self, loads: FloatArray) -> FloatArray:
        """The slack of every row at zero slip under each load, (m + k, rows)."""
        q, p, gaps = self._condensed(loads)
        return np.hstack([self.zone.joint.law.cone(q, p), gaps])[:, self.row]

    @cached_property
    def _tied(self) -> NDArray[np.bool_]:
        """The load steps that determine each row, (m + k, rows)."""
        step = np.arange(len(self._loads))[:, None]
        slacks = np.where((step >= self.zone.problem.m) == self.before, self._slacks(self._loads), np.inf)
        tangential, normal = np.abs(self._loads), np.abs(self._loads)
        tangential[:, self.zone.problem.layout.gaps], normal[:, self.zone.problem.layout.slips] = 0.0, 0.0
        size = (np.abs(self._slacks(tangential)) + np.abs(self._slacks(normal))).max(axis=0)
        return slacks <= slacks.min(axis=0) + NEGLIGIBLE * size

    def _worst(self, rates: FloatArray) -> FloatArray:
        """The least rate over the determining load steps, for a falling and for a growing parameter."""
        both = np.where(self._tied[..., None], rates[..., None] * SIDES, np.inf)
        return both.min(axis=0) * self.scale[:, None]


@dataclass(frozen=True, kw_only=True)
class _Optimum:
    """The rows that are reached at an optimum of max λ, to first order: W x' + d λ' ≤ what a parameter gains.

    With the envelope theorem λ' is the gain weighted with the multipliers.

    Attributes
    ----------
    rates
        What influences their slack.
    W : (k, N)
        Their slopes over the unknowns x [force/unit of x].
    d : (k,)
        Their coefficients of λ [force].
    multipliers : (k,)
        y ≥ 0 with Wᵀ y = 0 and dᵀ y = 1.
    pressure : (k, 2)
        Gain from the node's own friction, as it falls, and as it grows [force].
    turn : (k, N)
        How the gain as it grows varies with x.
    rows, slack
        All rows (K, N) and their slacks (K,), which say how far other optimal x are; None where x is bent by
        a cone, or there are so many nodes that seeking them takes long.
    at_tip
        Whether the optimum is the tip of a cone, where multipliers are not unique.
    ray : (N,)
        With a cone the only direction along which x can be changed at all.
    tolerances
        What is regular.
    """

    rates: RowRates
    W: FloatArray
    d: FloatArray
    multipliers: FloatArray
    pressure: FloatArray
    turn: FloatArray
    rows: FloatArray | None = None
    slack: FloatArray | None = None
    at_tip: bool = False
    ray: FloatArray | None = None
    tolerances: Tolerances

    @cached_property
    def unique(self) -> bool:
        """Whether the multipliers are."""
        matrix = np.column_stack([self.W, self.d])
        row, column = equilibration(matrix, self.tolerances.equilibration_sweeps)
        values = np.linalg.svd(matrix * row[:, None] * column, compute_uv=False)
        return not self.at_tip and int((values > SAME * values[0]).sum()) == len(self.d)

    @cached_property
    def _elsewhere(self) -> FloatArray:
        """Directions (N, q) in which x may change and stay optimal."""
        share = self.multipliers * np.abs(self.W).max(axis=1, initial=0.0)
        sizes = np.abs(self.W).max(axis=0, initial=0.0)
        columns = np.where(sizes > 0, 1.0 / np.where(sizes > 0, sizes, 1.0), 1.0)
        held = self.W[share > SAME * share.max(initial=0.0)] * columns
        if self.ray is not None:
            moved, terms = held @ (self.ray / columns), np.abs(held) @ np.abs(self.ray / columns)
            free = np.all(np.abs(moved) <= SAME * terms)
            return self.ray[:, None] if free else np.zeros((len(self.ray), 0))
        values, directions = np.linalg.svd(held / np.abs(held).max(axis=1, keepdims=True))[1:]
        rank = int((values > SAME * values.max(initial=0.0)).sum())
        return np.asarray((directions[rank:] * columns).T)

    def friction(self) -> Slopes:
        """Slopes for the friction of every node, and for a factor on all of them."""
        problem, load_factor = self.rates.zone.problem, self.rates.load_factor
        closed, derivative = self.rates.rubs, np.zeros((problem.n, 2))
        for node in np.unique(self.rates.node[closed]):
            derivative[node] = self._of_friction(closed & (self.rates.node == node))
        together = self._of_friction(np.where(closed, problem.f[self.rates.node], 0.0))
        return Slopes(derivative, derivative * problem.f[:, None] / load_factor, together / load_factor)

    def _of_friction(self, share: NDArray[Any]) -> FloatArray:
        """Derivative by the friction of some rows; NaN where other optimal x gain more and are not sought."""
        turn, found = share[:, None] * self.turn, self._weighted(share[:, None] * self.pressure)
        if turn.any():
            moved, terms = turn @ self._elsewhere, np.abs(turn) @ np.abs(self._elsewhere)
            if (np.abs(moved) > SAME * terms).any():
                way = self.multipliers @ turn
                found += [-self._farthest(-way), self._farthest(way)]
        return found

    def _farthest(self, way: FloatArray) -> float:
        """The most that another optimal x may gain along a direction (Gol'shtein); NaN where not sought."""
        if self.rows is None or self.slack is None:
            return np.nan
        end = solve(Program(self.rows, self.slack, -way, lower=np.array(-INF), tolerances=self.tolerances))
        return float(way @ end.x) if end.status == Status.OPTIMAL else np.nan

    def _weighted(self, gain: FloatArray) -> FloatArray:
        """dλ as a parameter falls, and as it grows, (2,), where slacks gain so much, (k, 2)."""
        return np.asarray(self.multipliers @ gain * SIDES)

    def loads(self, of_nodes: Callable[[NDArray[np.intp]], FloatArray]) -> Slopes:
        """Slopes for a factor on loads, at every node and at all of them."""
        zone, load_factor = self.rates.zone, self.rates.load_factor
        everywhere = np.arange(zone.problem.n)
        derivative = np.zeros((len(everywhere), 2))
        for node in everywhere if zone.open_nodes else np.unique(self.rates.node):
            derivative[node] = self._weighted(of_nodes(np.array([node])))
        together = self._weighted(of_nodes(everywhere))
        return Slopes(derivative, derivative / load_factor, together / load_factor)


def _of_upper(zone: Zone, bound: Bound, tolerances: Tolerances) -> _Optimum:
    before = len(bound.multipliers) > len(zone.constraints.g)
    rows, slip = zone.rows(before), bound.slip[zone.problem.layout.slips_of(zone.closed_nodes)]
    excess = rows.relative_excess(slip, bound.load_factor)
    chosen = np.flatnonzero((excess >= -tolerances.feasibility) | (bound.multipliers > 0))
    rates = rates_of(zone, bound.load_factor, before=before).among(chosen)
    y, slack = bound.multipliers[chosen], np.maximum(-rows.excess(slip, bound.load_factor), 0.0)
    slack[chosen] = 0.0  # otherwise round-off there would set the scale of the others
    return _Optimum(
        rates=rates,
        W=rows.coefficients[chosen],
        d=rows.d[chosen],
        multipliers=y / (y @ rows.d[chosen]),
        pressure=rates.pressures(slip),
        turn=rates.pressure_slopes(),
        # nodes: two small programs for each of them
        rows=rows.coefficients if zone.problem.n <= 40 else None,
        slack=slack,
        tolerances=tolerances,
    )


def _of_energy(zone: Zone, bound: Bound, tolerances: Tolerances) -> _Optimum:
    limits = ball_limits(zone, tolerances=tolerances)
    metric, closed = limits.metric, zone.problem.layout.slips_of(zone.closed_nodes)
    slip, start = bound.slip[closed], bound.initial_slip[closed]
    at_tip = _is_kept(limits, start, bound.load_factor, bound.distance / metric.unit, tolerances)
    slip, reach = (start, bound.distance / metric.unit) if at_tip else (slip, bound.radius / metric.unit)
    moved = metric.root @ (slip - start)
    sizes = limits.sizes(slip, bound.load_factor, reach)
    share = bound.multipliers * sizes
    slack = limits.slack(slip, bound.load_factor, reach) / sizes
    chosen = np.flatnonzero((slack <= tolerances.feasibility) | (share > SMOOTH * share.max()))
    before = len(limits.rows.g) > len(zone.constraints.g)
    rates = rates_of(zone, bound.load_factor, scale=metric.scale, before=before).among(chosen)
    ray = np.zeros_like(moved) if at_tip else moved / np.linalg.norm(moved)
    s, y = limits.rows.spread[chosen], bound.multipliers[chosen]
    widening = np.append(spread_slopes(zone.joint, metric, limits.rows.spread[: 2 * zone.joint.n]), 0.0)
    needs = widening[np.where(rates.rubs, rates.row, -1)]
    rising, growing = rates.pressure_slopes() @ metric.inverse, needs[:, None] * ray
    turn = rising - growing
    # of a difference of slopes, relative to its terms
    turn[np.abs(turn) <= 64 * EPS * (np.abs(rising) + np.abs(growing))] = 0.0
    return _Optimum(
        rates=rates,
        W=limits.rows.G[chosen] @ metric.inverse + s[:, None] * ray,
        d=limits.rows.d[chosen],
        multipliers=y / (y @ limits.rows.d[chosen]),
        pressure=rates.pressures(slip) - reach * needs[:, None] * SIDES,
        turn=turn,
        at_tip=at_tip and bool(s.any()),
        ray=ray if s @ y > 0 else None,
        tolerances=tolerances,
    )


def _is_kept(
    limits: BallLimits, slip: FloatArray, load_factor: float, reach: float, tolerances: Tolerances
) -> bool:
    """Whether a slip is the centre of a ball of some radius at a load factor."""
    slack = limits.slack(slip, load_factor, reach) / limits.sizes(slip, load_factor, reach)
    return bool(slack.min() >= -tolerances.feasibility)


def rates_of(zone: Zone, load_factor: float, *, scale: float = 1.0, before: bool = False) -> RowRates:
    """The rates of all rows of a zone; those of the transient in the order of the energy rows."""
    o = len(zone.open_nodes)
    closed = len(zone.constraints.g) - o
    times = 2 if before else 1
    row = np.concatenate([np.tile(np.arange(closed), times), np.tile(closed + np.arange(o), times)])
    late = np.concatenate([np.repeat([False, True][:times], closed), np.repeat([False, True][:times], o)])
    return RowRates(zone, row, late, np.where(row < closed, 1.0, scale), load_factor)


def spread_slopes(problem: Problem, metric: EnergyMetric, spread: FloatArray) -> FloatArray:
    """∂(f γ)/∂f of every node and side, (2n,) [force/length], where ``spread`` is f γ.

    γ does not depend on f up to the node's own critical friction A_ii / |B_ii|; beyond it is that of
    the limit itself, f γ = ‖f B_i ∓ A_i‖.
    """
    f, side = np.repeat(problem.f, 2), np.tile([1.0, Side.FORWARD], problem.n)
    A, B = (np.repeat(M @ metric.inverse, 2, axis=0) for M in (problem.A, problem.B))
    limit = f[:, None] * B - side[:, None] * A
    own, stiff = (np.repeat(np.diagonal(M), 2) for M in (problem.B, problem.A))
    beyond = (side * f * own > stiff) & (spread > 0)
    slopes = np.divide(spread, f, out=np.zeros_like(spread), where=f > 0)
    slopes[beyond] = np.sum(limit * B, axis=1)[beyond] / spread[beyond]
    return slopes
