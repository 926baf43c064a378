"""How the slacks of the rows of a bound change with friction, constant load and amplitude."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.energy.energy_metric import EnergyMetric
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.joint.constraints import Side
from shakedown.joint.contact_zone import Zone
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem

SIDES = np.array([-1.0, 1.0])  # a parameter falls, or grows


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
