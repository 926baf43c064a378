"""How a bound depends on friction, constant load and load amplitude at every node."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.assessment.one_sided import OneSidedOptimum
from shakedown.assessment.row_rates import SIDES, RowRates, rates_of, spread_slopes
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.energy.energy_rows import EnergyRows, zone_rows
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import DIGITS, plain
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, require_plane
from shakedown.joint.contact_zone import Zone, contact_zone
from shakedown.joint.coupled_parts import coupled_parts
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

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
        Optimal; else that of the bound, of which there are no derivatives then.
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
def sensitivities(
    problem: Problem,
    bound: Bound,
    *,
    one_sided: bool = True,
    tolerances: Tolerances = DEFAULT,
) -> Sensitivities:
    """By how much λ_max or λ_E changes with friction, constant load and load amplitude, at every node.

    The bound is the optimum of a program over rows g − G v − λ d (less the slack R s of the ball, for
    λ_E); its derivative is that of the rows at the optimum, weighted with the multipliers (envelope theorem):

        dλ/df_i = Σ y p_i,    dλ/dc_i = Σ y (f p⁰ ∓ q⁰)_i,    dλ/da_i = λ Σ y (f p¹ ∓ q¹)_i

    over the rows of node i, p_i less ∂(f γ)/∂f R for λ_E. Nothing is solved again but where the optimum is
    degenerate: then a small program over its multipliers gives the derivative on either side.
    What varies is one quantity of one node; stiffness, the other nodes, the initial slip, the distance
    and the zone stay. Where nodes are open the loads of all nodes act on the closed ones.

    The factor on all constant loads together has the elasticity 1 (for λ_E from slip zero without a
    distance), that on all amplitudes −1.

    Parameters
    ----------
    problem
        The joint and its loading.
    bound
        Its λ_max, not through the transient, or its λ_E.
    one_sided
        Whether to go on at a degenerate optimum: up to six small programs a node, minutes for 250 nodes.
    tolerances
        Those with which the bound was computed.

    Raises
    ------
    UsageError
        If the bound is not one of this joint.
    SolverError
        If the optimum is degenerate and ``one_sided`` is False.

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
    if bound.slip.shape != (problem.layout.slip_size,):
        raise UsageError(f"bound: expected one of a joint with {problem.n} nodes, found {bound.slip.size}")
    symbol = bound.symbol
    reason = bound.reason if bound.status != Status.OPTIMAL else ""
    if not reason and not bound.load_factor > 0:
        reason = "at λ = 0 nothing is left to lose"
    if reason:
        none = Slopes(*(np.full(shape, np.nan) for shape in ((problem.n, 2), (problem.n, 2), 2)))
        return Sensitivities(symbol, bound.status, reason, bound.load_factor, none, none, none)
    if bound.kind == "energy" and bound.parts:
        return _of_parts(problem, bound, one_sided, tolerances)
    zone = contact_zone(problem, bound.open_nodes, tolerances=tolerances)
    if bound.kind == "upper":
        parts = _of_upper(zone, bound, one_sided, tolerances)
    else:
        parts = _of_energy(zone, bound, one_sided, tolerances)
    return Sensitivities(
        symbol=symbol,
        status=bound.status,
        reason="",
        load_factor=bound.load_factor,
        friction=parts.friction(problem, bound.load_factor),
        constant=parts.loads(parts.rates.constant, bound.load_factor),
        amplitude=parts.loads(parts.rates.amplitude, bound.load_factor),
    )


def _of_parts(problem: Problem, bound: Bound, one_sided: bool, tolerances: Tolerances) -> Sensitivities:
    """Those of the uncoupled part that decides; where several do, no node of one alone raises the least."""
    parts, most = coupled_parts(problem, bound.open_nodes), (1.0 + tolerances.feasibility) * bound.load_factor
    deciding = [
        (part, each) for part, each in zip(parts, bound.parts, strict=True) if each.load_factor <= most
    ]
    several = len(deciding) > 1
    found = [sensitivities(p.joint, each, one_sided=one_sided, tolerances=tolerances) for p, each in deciding]

    def everywhere(kind: str) -> Slopes:
        of_nodes = np.zeros((2, problem.n, 2))
        slopes: list[Slopes] = [getattr(each, kind) for each in found]
        for (part, _), each in zip(deciding, slopes, strict=True):
            own = np.array([each.derivative, each.elasticity])
            if several:
                own = np.stack([np.maximum(own[..., 0], 0.0), np.minimum(own[..., 1], 0.0)], axis=-1)
            of_nodes[:, part.nodes] = own
        together = np.array([each.together for each in slopes])
        return Slopes(of_nodes[0], of_nodes[1], np.array([together[:, 0].max(), together[:, 1].min()]))

    slopes = {kind: everywhere(kind) for kind in KINDS}
    return Sensitivities("λ_E", bound.status, "", bound.load_factor, **slopes)


@dataclass(frozen=True)
class _Reached:
    """An optimum, the influences on the slack of the rows it reaches, and their gain from friction."""

    optimum: OneSidedOptimum
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


def _of_upper(zone: Zone, bound: Bound, one_sided: bool, tolerances: Tolerances) -> _Reached:
    before = len(bound.multipliers) > len(zone.constraints.g)
    rows, slip = zone.rows(before), bound.slip[zone.problem.layout.slips_of(zone.closed_nodes)]
    excess = rows.relative_excess(slip, bound.load_factor)
    chosen = np.flatnonzero((excess >= -tolerances.feasibility) | (bound.multipliers > 0))
    rates = rates_of(zone, bound.load_factor, before=before).among(chosen)
    y, slack = bound.multipliers[chosen], np.maximum(-rows.excess(slip, bound.load_factor), 0.0)
    slack[chosen] = 0.0  # otherwise round-off there would set the scale of the others
    optimum = OneSidedOptimum(
        W=rows.coefficients[chosen],
        d=rows.d[chosen],
        multipliers=y / (y @ rows.d[chosen]),
        tip=np.zeros(len(chosen)),
        rows=rows.coefficients,
        slack=slack,
        ray=None,
        tolerances=tolerances,
        programs=one_sided,
    )
    return _Reached(optimum, rates, rates.pressures(slip), rates.pressure_slopes())


def _of_energy(zone: Zone, bound: Bound, one_sided: bool, tolerances: Tolerances) -> _Reached:
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
    optimum = OneSidedOptimum(
        W=rows.G[chosen] @ metric.inverse + s[:, None] * ray,
        d=rows.d[chosen],
        multipliers=y / (y @ rows.d[chosen]),
        tip=s if at_tip else np.zeros(len(chosen)),
        rows=None,
        slack=slack,
        ray=ray if s @ y > 0 else None,
        tolerances=tolerances,
        programs=one_sided,
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
