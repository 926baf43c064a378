"""How a bound depends on friction, constant load and load amplitude at every node."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.bound_result import Bound
from shakedown.bounds.energy.ball_limits import EnergyMetric, ball_limits
from shakedown.ground.constants import NEGLIGIBLE, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import DIGITS, plain
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, require_plane
from shakedown.joint.constraints import Side, loading, transient_path
from shakedown.joint.contact_zone import Zone, contact_zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.program import equilibration

NOT_UNIQUE = "what limits it is not unique: several nodes, or load steps, do so alike"
KINDS = ("friction", "constant", "amplitude")
SMOOTH = 10.0**-DIGITS  # of the terms of a derivative: one-sided values that differ by less are equal


@dataclass(frozen=True, eq=False, repr=False)
class Slopes(Result):
    """Derivatives of a load factor with respect to one quantity; NaN where it has none, at a kink.

    Attributes
    ----------
    derivative : (n,)
        dλ/dθ, θ the quantity at one node, all others as they are.
    elasticity : (n,)
        d ln λ / d ln θ: by how many per cent λ changes with one per cent of θ there.
    together
        The elasticity where the quantity changes by one factor at all nodes.
    """

    derivative: FloatArray
    elasticity: FloatArray
    together: float


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
        Why there are none, or not of every node, in words; else empty.
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
        """Whether there is a derivative everywhere: the optimum is not degenerate."""
        return bool(np.isfinite([getattr(self, kind).elasticity for kind in KINDS]).all())

    def ranked(self, at_least: float = SMOOTH) -> NDArray[np.intp]:
        """The nodes with a notable influence on the load factor, the most important first."""
        sizes = np.nansum([np.abs(getattr(self, kind).elasticity) for kind in KINDS], axis=0)
        order = np.argsort(-sizes, kind="stable")
        return order[sizes[order] > at_least * sizes.max(initial=0.0)]

    def to_dict(self) -> dict[str, Any]:
        """Every derivative as [as it falls, as it grows], which are the same."""
        known = {
            kind: {word: np.stack([each, each], axis=-1) for word, each in vars(getattr(self, kind)).items()}
            for kind in KINDS
        }
        about = {"status": self.status, "reason": self.reason, "load_factor": self.load_factor}
        return {key: plain(value) for key, value in (about | {"smooth": self.smooth} | known).items()}

    def columns(self) -> dict[str, Any]:
        """One row per node: the elasticities."""
        return {kind: getattr(self, kind).elasticity for kind in KINDS}


@checked
def sensitivities(problem: Problem, bound: Bound, *, tolerances: Tolerances = DEFAULT) -> Sensitivities:
    """By how much λ_max or λ_E changes with friction, constant load and load amplitude, at every node.

    The bound is the optimum of a program over rows g − G v − λ d (less the slack R s of the ball, for
    λ_E); its derivative is that of the rows at the optimum, weighted with the multipliers (envelope theorem):

        dλ/df_i = Σ y p_i,    dλ/dc_i = Σ y (f p⁰ ∓ q⁰)_i,    dλ/da_i = λ Σ y (f p¹ ∓ q¹)_i

    over the rows of node i, p_i less ∂(f γ)/∂f R for λ_E. Nothing is solved again. Where the multipliers are
    not unique, as where several nodes limit the joint alike, there is no such derivative: all are NaN, with
    the reason; and single ones are NaN where the load factor has a kink: the friction of a node at which
    several load steps, with unlike pressures, limit it alike.
    What varies is one quantity of one node; stiffness, the other nodes, the initial slip, the distance and
    the zone stay. Where nodes are open the loads of all nodes act on the closed ones.

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
    array([0.04 , 0.924])
    >>> round(found.constant.together, 9), found.smooth
    (1.0, True)
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
        return _none(problem, bound, "the joint falls into uncoupled parts, each with a limit of its own")
    zone = contact_zone(problem, bound.open_nodes, tolerances=tolerances)
    found = reached(zone, bound, tolerances)
    if found is None:
        return _none(problem, bound, NOT_UNIQUE)
    slopes = found.friction(), *found.loads()
    kinked = any(np.isnan(each.derivative).any() for each in slopes)
    why = "for some nodes several load steps limit it alike" * kinked
    return Sensitivities(bound.symbol, bound.status, why, bound.load_factor, *slopes)


def _none(problem: Problem, bound: Bound, reason: str) -> Sensitivities:
    none = Slopes(np.full(problem.n, np.nan), np.full(problem.n, np.nan), np.nan)
    return Sensitivities(bound.symbol, bound.status, reason, bound.load_factor, none, none, none)


@dataclass(frozen=True, kw_only=True)
class _Optimum:
    """The rows that are reached at an optimum of max λ whose multipliers are unique.

    With the envelope theorem λ' is what a parameter gains, weighted with the multipliers. The gain is that of
    the slack g − G v − λ d at fixed v and λ, in every load step that determines the row.

    Attributes
    ----------
    zone, load_factor
        The joint and its open nodes; λ.
    slip
        That of the closed nodes [length].
    row : (k,)
        The rows by number, in the order of ``zone.constraints``.
    before : (k,)
        Whether it is the row of the transient load steps.
    multipliers : (k,)
        y ≥ 0 with dᵀ y = 1, d their coefficients of λ [force].
    scale : (k,)
        What a row is multiplied by.
    needs : (k,)
        What the ball takes of the slack per friction of the node [force]; of no meaning for gaps.
    """

    zone: Zone
    load_factor: float
    slip: FloatArray
    row: NDArray[np.intp]
    before: NDArray[np.bool_]
    multipliers: FloatArray
    scale: FloatArray | float = 1.0
    needs: FloatArray | float = 0.0

    def friction(self) -> Slopes:
        """Slopes for the friction of every node, and for a factor on all of them."""
        rubs = self.zone.constraints.sided[self.row]
        p = self._condensed(np.add(*self._loads))[1] + self.zone.joint.B @ self.slip
        gain = np.where(rubs, self.scale * p[:, np.where(rubs, self.row // 2, 0)] - self.needs, 0.0)

        def of(change: FloatArray) -> float:
            return self._weighted(np.where(rubs, change[self._node], 0.0) * gain)

        return self._slopes(of, self.zone.problem.f)

    def loads(self) -> list[Slopes]:
        """Slopes for a factor on the constant, and on the periodic load, at every node and at all of them."""

        def of(loads: FloatArray, change: FloatArray) -> float:
            return self._weighted(self._slacks(loads * np.tile(change, 2)))

        return [self._slopes(partial(of, loads), np.ones(self.zone.problem.n)) for loads in self._loads]

    def _slopes(self, of: Callable[[FloatArray], float], quantity: FloatArray) -> Slopes:
        """Slopes for a quantity (n,), of what its change brings."""
        derivative, unit = np.zeros(len(quantity)), np.eye(len(quantity))
        for node in range(len(quantity)) if self.zone.open_nodes else np.unique(self._node):
            derivative[node] = of(unit[node])
        return Slopes(derivative, derivative * quantity / self.load_factor, of(quantity) / self.load_factor)

    def _weighted(self, gain: FloatArray) -> float:
        """dλ where slacks gain so much in each load step, (m + k, rows); NaN where it is not the same there.

        A row loses the least of its load steps where a parameter falls, and gains the least where it grows.
        """
        tied = self._tied
        grown = self.multipliers @ np.where(tied, gain, np.inf).min(axis=0)
        fallen = self.multipliers @ np.where(tied, gain, -np.inf).max(axis=0)
        size = self.multipliers @ np.where(tied, np.abs(gain), 0.0).max(axis=0)
        return float(grown) if fallen - grown <= SMOOTH * size else np.nan

    @cached_property
    def _node(self) -> NDArray[np.intp]:
        """The node of every row, numbered in the whole joint."""
        return self.zone.constraints.node[self.row]

    @cached_property
    def _loads(self) -> tuple[FloatArray, FloatArray]:
        """Constant and periodic part at λ of every load step, those of the transient last, (m + k, 2n)."""
        problem, before = self.zone.problem, transient_path(self.zone.problem)
        loop, joined = loading(problem), problem.layout.joined
        constant = np.vstack([np.tile(joined(loop.q0, loop.p0), (problem.m, 1)), before])
        return constant, self.load_factor * np.vstack([joined(loop.q1, loop.p1), np.zeros_like(before)])

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
        return self.scale * np.hstack([self.zone.joint.law.cone(q, p), gaps])[:, self.row]

    @cached_property
    def _tied(self) -> NDArray[np.bool_]:
        """The load steps that determine each row, (m + k, rows)."""
        loads, layout = np.add(*self._loads), self.zone.problem.layout
        step = np.arange(len(loads))[:, None]
        slacks = np.where((step >= self.zone.problem.m) == self.before, self._slacks(loads), np.inf)
        tangential, normal = np.abs(loads), np.abs(loads)
        tangential[:, layout.gaps], normal[:, layout.slips] = 0.0, 0.0
        size = (np.abs(self._slacks(tangential)) + np.abs(self._slacks(normal))).max(axis=0)
        return slacks <= slacks.min(axis=0) + NEGLIGIBLE * size


def _of_upper(zone: Zone, bound: Bound, tolerances: Tolerances) -> _Optimum | None:
    """The optimum of λ_max; None where its multipliers are not unique."""
    transient = len(bound.multipliers) > len(zone.constraints.g)
    rows, slip = zone.rows(transient), bound.slip[zone.problem.layout.slips_of(zone.closed_nodes)]
    excess = rows.relative_excess(slip, bound.load_factor)
    chosen = np.flatnonzero((excess >= -tolerances.feasibility) | (bound.multipliers > 0))
    d, y = rows.d[chosen], bound.multipliers[chosen]
    if not _are_independent(rows.coefficients[chosen], d, tolerances):
        return None
    row, before = _numbered(zone, transient, chosen)
    return _Optimum(
        zone=zone, load_factor=bound.load_factor, slip=slip, row=row, before=before, multipliers=y / (y @ d)
    )


def _of_energy(zone: Zone, bound: Bound, tolerances: Tolerances) -> _Optimum | None:
    """The optimum of λ_E; None where its multipliers are not unique, as at the tip of the cone."""
    limits = ball_limits(zone, tolerances=tolerances)
    metric, closed = limits.metric, zone.problem.layout.slips_of(zone.closed_nodes)
    start, reach = bound.initial_slip[closed], bound.distance / metric.unit

    def slack(slip: FloatArray, reach: float) -> FloatArray:
        sizes = limits.sizes(slip, bound.load_factor, reach)
        return np.asarray(limits.slack(slip, bound.load_factor, reach) / sizes)

    at_tip = slack(start, reach).min() >= -tolerances.feasibility
    slip, reach = (start, reach) if at_tip else (bound.slip[closed], bound.radius / metric.unit)
    chosen = np.flatnonzero(slack(slip, reach) <= tolerances.feasibility)
    s, d, y = limits.rows.spread[chosen], limits.rows.d[chosen], bound.multipliers[chosen]
    moved = metric.root @ (slip - start)
    ray = np.zeros_like(moved) if at_tip else moved / np.linalg.norm(moved)
    slopes = limits.rows.G[chosen] @ metric.inverse + s[:, None] * ray
    if (at_tip and s.any()) or not _are_independent(slopes, d, tolerances):
        return None
    row, before = _numbered(zone, len(limits.rows.g) > len(zone.constraints.g), chosen)
    widening = spread_slopes(zone.joint, metric, limits.rows.spread[: 2 * zone.joint.n])
    return _Optimum(
        zone=zone,
        load_factor=bound.load_factor,
        slip=slip,
        row=row,
        before=before,
        multipliers=y / (y @ d),
        scale=np.where(row < len(zone.constraints.g) - len(zone.open_nodes), 1.0, metric.scale),
        needs=reach * widening[np.where(zone.constraints.sided[row], row, 0)],
    )


def _are_independent(slopes: FloatArray, d: FloatArray, tolerances: Tolerances) -> bool:
    """Whether rows over unknowns and λ are independent, so that their multipliers are unique."""
    matrix = np.column_stack([slopes, d])
    row, column = equilibration(matrix, tolerances.equilibration_sweeps)
    values = np.linalg.svd(matrix * row[:, None] * column, compute_uv=False)
    return int((values > 10 * NEGLIGIBLE * values[0]).sum()) == len(d)


def _numbered(
    zone: Zone, transient: bool, chosen: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Some rows of programs by their number in the zone, and whether each is of the transient."""
    count, times = len(zone.constraints.g), 1 + transient
    parts = np.split(np.arange(count), [count - len(zone.open_nodes)])
    row = np.concatenate([np.tile(part, times) for part in parts])
    late = np.concatenate([np.repeat(np.arange(times) > 0, len(part)) for part in parts])
    return row[chosen], late[chosen]


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
