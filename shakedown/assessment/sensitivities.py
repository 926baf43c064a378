"""How a bound depends on friction, constant load and load amplitude at every node."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.assessment.row_rates import SIDES, RowRates, rates_of, spread_slopes
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.energy.energy_rows import EnergyRows, zone_rows
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.shown_values import DIGITS, plain
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, require_plane
from shakedown.joint.contact_zone import Zone, contact_zone
from shakedown.joint.coupled_parts import coupled_parts
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.program import INF, Program
from shakedown.programs.scaling import equilibration
from shakedown.programs.solver import solve

NOT_UNIQUE = "what limits it is not unique: several nodes, or load steps, do so alike"
ENDS_SOUGHT_UP_TO = 40  # nodes: two small programs for each of them
SAME = 10 * NEGLIGIBLE  # relative to the terms of a derivative: differences between optima that do not matter
KINDS = ("friction", "constant", "amplitude")
SMOOTH = 10.0**-DIGITS  # of the largest elasticity: one-sided values that differ by less are equal
SLOPE_ROUND_OFF = 64 * np.finfo(float).eps  # of a difference of slopes, relative to its terms


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
    parts = reached(zone, bound, tolerances)
    if not parts.optimum.unique:
        return _none(problem, bound, NOT_UNIQUE)
    return Sensitivities(
        symbol=bound.symbol,
        status=bound.status,
        reason="",
        load_factor=bound.load_factor,
        friction=parts.friction(problem, bound.load_factor),
        constant=parts.loads(parts.rates.constant, bound.load_factor),
        amplitude=parts.loads(parts.rates.amplitude, bound.load_factor),
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
class _Optimum:
    """The rows that are reached at an optimum of max λ, to first order: W x' + d λ' ≤ what a parameter gains.

    With the envelope theorem λ' is the gain weighted with the multipliers.

    Attributes
    ----------
    W : (k, N)
        Slopes of the rows reached, over the unknowns x [force/unit of x].
    d : (k,)
        Their coefficients of λ [force].
    multipliers : (k,)
        y ≥ 0 with Wᵀ y = 0 and dᵀ y = 1.
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

    W: FloatArray
    d: FloatArray
    multipliers: FloatArray
    rows: FloatArray | None
    slack: FloatArray | None
    at_tip: bool
    ray: FloatArray | None
    tolerances: Tolerances

    def derivative(self, gain: FloatArray, turn: FloatArray) -> FloatArray:
        """dλ as a parameter falls, and as it grows, (2,), per unit of it; NaN where there is none.

        Parameters
        ----------
        gain : (k, 2)
            Change of the slack of the rows as the parameter falls, and as it grows.
        turn : (k, N)
            How the change as it grows varies with x.
        """
        found = np.asarray(self.multipliers @ gain * SIDES)
        if turn.any() and not self._stays(turn):
            way = self.multipliers @ turn
            found += [-self._farthest(-way), self._farthest(way)]
        return found

    def _farthest(self, way: FloatArray) -> float:
        """The most that another optimal x may gain along a direction (Gol'shtein); NaN where not sought."""
        if self.rows is None or self.slack is None:
            return np.nan
        end = solve(Program(self.rows, self.slack, -way, lower=np.array(-INF), tolerances=self.tolerances))
        return float(way @ end.x) if end.status == Status.OPTIMAL else np.nan

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

    def _stays(self, turn: FloatArray) -> bool:
        """Whether all optimal x have the same gain."""
        moved, terms = turn @ self._elsewhere, np.abs(turn) @ np.abs(self._elsewhere)
        return bool(np.all(np.abs(moved) <= SAME * terms))


@dataclass(frozen=True)
class _Reached:
    """An optimum, the influences on the slack of the rows it reaches, and their gain from friction."""

    optimum: _Optimum
    rates: RowRates
    pressure: FloatArray  # (k, 2), at the optimum
    turn: FloatArray  # (k, N), over its unknowns

    def friction(self, problem: Problem, load_factor: float) -> Slopes:
        """Slopes for the friction of every node, and for a factor on all of them."""
        closed = self.rates.rubs
        derivative = np.zeros((problem.n, 2))
        for node in np.unique(self.rates.node[closed]):
            own = (closed & (self.rates.node == node)).astype(float)
            derivative[node] = self._weighted(own)
        together = self._weighted(np.where(closed, problem.f[self.rates.node], 0.0))
        return Slopes(derivative, derivative * problem.f[:, None] / load_factor, together / load_factor)

    def _weighted(self, share: FloatArray) -> FloatArray:
        gain, turn = share[:, None] * self.pressure, share[:, None] * self.turn
        return self.optimum.derivative(gain, turn)

    def loads(self, of_nodes: Callable[[NDArray[np.intp]], FloatArray], load_factor: float) -> Slopes:
        """Slopes for a factor on loads, at every node and at all of them."""
        still = np.zeros_like(self.turn)
        everywhere = np.arange(self.rates.zone.problem.n)
        acting = everywhere if self.rates.zone.open_nodes else np.unique(self.rates.node)
        derivative = np.zeros((len(everywhere), 2))
        for node in acting:
            derivative[node] = self.optimum.derivative(of_nodes(np.array([node])), still)
        together = self.optimum.derivative(of_nodes(everywhere), still)
        return Slopes(derivative, derivative / load_factor, together / load_factor)


def _of_upper(zone: Zone, bound: Bound, tolerances: Tolerances) -> _Reached:
    before = len(bound.multipliers) > len(zone.constraints.g)
    rows, slip = zone.rows(before), bound.slip[zone.problem.layout.slips_of(zone.closed_nodes)]
    excess = rows.relative_excess(slip, bound.load_factor)
    chosen = np.flatnonzero((excess >= -tolerances.feasibility) | (bound.multipliers > 0))
    rates = rates_of(zone, bound.load_factor, before=before).among(chosen)
    y, slack = bound.multipliers[chosen], np.maximum(-rows.excess(slip, bound.load_factor), 0.0)
    slack[chosen] = 0.0  # otherwise round-off there would set the scale of the others
    few = zone.problem.n <= ENDS_SOUGHT_UP_TO
    optimum = _Optimum(
        W=rows.coefficients[chosen],
        d=rows.d[chosen],
        multipliers=y / (y @ rows.d[chosen]),
        rows=rows.coefficients if few else None,
        slack=slack,
        at_tip=False,
        ray=None,
        tolerances=tolerances,
    )
    return _Reached(optimum, rates, rates.pressures(slip), rates.pressure_slopes())


def _of_energy(zone: Zone, bound: Bound, tolerances: Tolerances) -> _Reached:
    rows = zone_rows(zone, tolerances=tolerances)
    metric, closed = rows.metric, zone.problem.layout.slips_of(zone.closed_nodes)
    slip, start = bound.slip[closed], bound.initial_slip[closed]
    at_tip = _is_kept(rows, start, bound.load_factor, bound.distance / metric.unit, tolerances)
    slip, reach = (start, bound.distance / metric.unit) if at_tip else (slip, bound.radius / metric.unit)
    moved = metric.root @ (slip - start)
    sizes = rows.sizes(slip, bound.load_factor, reach)
    share = bound.multipliers * sizes
    slack = rows.slack(slip, bound.load_factor, reach) / sizes
    chosen = np.flatnonzero((slack <= tolerances.feasibility) | (share > SMOOTH * share.max()))
    before = len(rows.g) > len(zone.constraints.g)
    rates = rates_of(zone, bound.load_factor, scale=metric.unit**2, before=before).among(chosen)
    ray = np.zeros_like(moved) if at_tip else moved / np.linalg.norm(moved)
    s, y = rows.spread[chosen], bound.multipliers[chosen]
    widening = np.append(spread_slopes(zone.joint, metric, rows.spread[: 2 * zone.joint.n]), 0.0)
    needs = widening[np.where(rates.rubs, rates.row, -1)]
    optimum = _Optimum(
        W=rows.G[chosen] @ metric.inverse + s[:, None] * ray,
        d=rows.d[chosen],
        multipliers=y / (y @ rows.d[chosen]),
        rows=None,
        slack=None,
        at_tip=at_tip and bool(s.any()),
        ray=ray if s @ y > 0 else None,
        tolerances=tolerances,
    )
    pressure = rates.pressures(slip) - reach * needs[:, None] * SIDES
    rising, growing = rates.pressure_slopes() @ metric.inverse, needs[:, None] * ray
    turn = rising - growing
    turn[np.abs(turn) <= SLOPE_ROUND_OFF * (np.abs(rising) + np.abs(growing))] = 0.0
    return _Reached(optimum, rates, pressure, turn)


def _is_kept(
    rows: EnergyRows, slip: FloatArray, load_factor: float, reach: float, tolerances: Tolerances
) -> bool:
    """Whether a slip is the centre of a ball of some radius at a load factor."""
    slack = rows.slack(slip, load_factor, reach) / rows.sizes(slip, load_factor, reach)
    return bool(slack.min() >= -tolerances.feasibility)
