"""The limits about a given slip, without dimension, and the programs over them."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shakedown.bounds.energy.ball_limits import BallLimits, cleaned
from shakedown.ground.constants import CONE, CONVERGED, FloatArray
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.program import power_of_two


@dataclass(frozen=True, eq=False)
class LimitsAbout:
    """(f p, a q) = g − H_i y − λ d in discs that leave the slack s_i R, and rows, y in units of energy.

    Dimensionless, by powers of two, one of each node's own included.

    Attributes
    ----------
    base
        The program of the largest λ over (y, R, λ) with these limits: blocks H, right-hand sides g.
    sizes : (K + k,)
        Largest term on the right-hand side of every disc and row.
    offset
        δ.
    length
        Unit of y, of R and of δ.
    unit : (K + k,)
        What discs and rows were multiplied by [1/force].
    load_unit
        Unit of λ: the power of two next to the load factor at which the periodic part is as large as the
        constant one. So nothing of a small one is lost beside it.
    """

    base: DiscProgram
    sizes: FloatArray
    offset: float
    length: float
    unit: FloatArray
    load_unit: float

    @cached_property
    def s(self) -> FloatArray:
        """Coefficients of the radius in discs and rows, (K + k,)."""
        return np.append(self.base.extra[:, 0, 0], self.base.rows_extra[:, 0])

    def reversed(self) -> "LimitsAbout":
        """The same in −λ."""
        signs = np.array([1.0, -1.0])
        extra, rows_extra = self.base.extra * signs, self.base.rows_extra * signs
        return replace(self, base=replace(self.base, extra=extra, rows_extra=rows_extra))

    def left(
        self, y: FloatArray, radius: float = 0.0, load_factor: float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """(f p − s R, a q) of every disc, (K, 3), and what is left of every row, (k,)."""
        known = self.base
        discs, rows, _ = known.cones.parts(known.limits - known.times(np.append(y, [radius, load_factor])))
        return discs, rows

    def slack(self, y: FloatArray, radius: float = 0.0, load_factor: float = 0.0) -> FloatArray:
        """Distance of every disc and row to its limit, less what a radius needs, (K + k,)."""
        discs, rows = self.left(y, radius, load_factor)
        return np.append(discs[:, 0] - np.hypot(discs[:, 1], discs[:, 2]), rows)

    def _program(
        self, columns: FloatArray, ends: FloatArray, right: list[float], *, within: bool
    ) -> DiscProgram:
        """Maximise the last of w over these discs and rows.

        Parameters
        ----------
        columns : (3, p)
            R, λ and what is taken of all margins, as combinations of w.
        ends, right
            Coefficients of w in further rows without y, and their right-hand sides.
        within
            Whether the length of y, with δ, is at most the first of w.
        """
        known, count = self.base, columns.shape[1]
        extra, margins = known.extra @ columns[:2], self._margin_sizes[:, None] * columns[2]
        extra[:, 0] += margins[: len(extra)]
        return replace(
            known,
            extra=extra,
            rows=np.vstack([known.rows, np.zeros((len(ends), known.rank))]),
            rows_extra=np.vstack([known.rows_extra @ columns[:2] + margins[len(extra) :], ends]),
            rows_right=np.append(known.rows_right, right),
            cost=-np.eye(count)[-1],
            norm=np.eye(count)[0] if within else None,
            offset=self.offset if within else 0.0,
        )

    def load_factor_program(self, *, reverse: bool = False) -> DiscProgram:
        """The largest λ ≥ 0, or −λ ≥ 0, for which ‖y‖ + δ ≤ R, w = (R, λ or −λ).

        Where no limit knows the radius, w = (λ,): it would have no end.
        """
        end, first = np.array([[0.0, 1.0 if reverse else -1.0]]), int(not self._knows_radius)
        return self._program(np.eye(3)[:, first:2], end[:, first:], [0.0], within=not first)

    @property
    def _knows_radius(self) -> bool:
        """Whether any limit depends on the radius by more than round-off."""
        return bool(self.s.max(initial=0.0) > CONVERGED)

    @cached_property
    def unit_of_radius(self) -> float:
        """Radii times this change the limits as much as y does; s may be next to nothing beside H."""
        return power_of_two(float(self.s.max(initial=0.0)))

    def margin_program(self) -> DiscProgram:
        """The largest margin, of either sign, for which ‖y‖ + margin ≤ R and R ≥ 0, w = (R − margin, margin).

        The length of y in its own units, the radius and the margin in units of the radius: they may be larger
        by many orders.
        """
        unit = self.unit_of_radius
        columns = np.array([[1.0, 1.0 / unit], [0.0, 0.0], [0.0, 0.0]])
        return self._program(columns, np.array([[-unit, -1.0]]), [0.0], within=True)

    def radius_program(self, cap: float) -> DiscProgram:
        """The largest R up to a cap, whatever y is, w = (R,) in units of the radius."""
        unit, last = self.unit_of_radius, 1 if np.isinf(cap) else 2
        ends, right = np.array([[-1.0], [1.0]]), [0.0, cap * unit]
        return self._program(np.eye(3)[:, :1] / unit, ends[:last], right[:last], within=False)

    @cached_property
    def _margin_sizes(self) -> FloatArray:
        """What margins of discs and rows are relative to (K + k,)."""
        slopes = np.linalg.norm(self.base.blocks, axis=(1, 2))[self.base.node]
        return np.maximum(self.sizes, np.append(slopes, np.linalg.norm(self.base.rows, axis=1)))

    def margin(self, y: FloatArray, radius: float = 0.0, load_factor: float = 0.0) -> float:
        """The smallest margin that discs and rows keep at y with a radius, relative, at most 1."""
        sizes = np.where(self._margin_sizes > 0, self._margin_sizes, 1.0)
        return min(1.0, float(np.min(self.slack(y, radius, load_factor) / sizes, initial=1.0)))

    def centre_program(self, *, ball: bool) -> DiscProgram:
        """The largest margin t ≤ 1 that all keep, relative to their sizes, w = (R, λ, t).

        With the ball about y that holds δ; or, without, w = (t,) at one load factor, for R = 0. Where no
        limit knows the radius, w = (λ, t).
        """
        first = 2 if not ball else int(not self._knows_radius)
        ends, right = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]), [0.0, 1.0]
        return self._program(
            np.eye(3)[:, first:], ends[not ball :, first:], right[not ball :], within=not first
        )


def limits_about(
    limits: BallLimits, slip: FloatArray, distance: float = 0.0, *, load_factor: float | None = None
) -> LimitsAbout:
    """The limits about a slip, from which an energy distance is to be kept; at a load factor without λ."""
    node, n, rows = limits.node, len(limits.f), limits.rows
    varying = max(np.abs(each).max(initial=0.0) for each in (limits.d, rows.d))
    constant = max(np.abs(each).max(initial=0.0) for each in (limits.g, rows.g))
    load_unit = power_of_two(float(constant / varying)) if varying > 0 and load_factor is None else 1.0
    d, row_d = load_unit * limits.d, load_unit * rows.d
    scale = np.column_stack([np.ones(n), limits.stretch, limits.stretch])
    H = limits.blocks * scale[:, :, None]
    moved, terms = limits.G @ slip, np.abs(limits.G) @ np.abs(slip)
    g = cleaned(limits.g - moved[node], np.abs(limits.g) + terms[node])
    row_terms = np.abs(rows.G) @ np.abs(slip)
    row_g = cleaned(rows.g - rows.G @ slip, np.abs(rows.g) + row_terms)
    sizes = np.maximum(np.abs(limits.g).max(axis=1), terms.max(axis=1)[node])
    row_sizes = np.maximum(np.abs(rows.g), row_terms)
    of_nodes = np.zeros(n)
    np.maximum.at(of_nodes, node, np.maximum(sizes, np.abs(d).max(axis=1)))
    unit, row_unit = _inverses(of_nodes), _inverses(np.maximum(row_sizes, np.abs(row_d)))
    slopes = np.append(
        np.abs(H).max(axis=(1, 2), initial=0.0) * unit,
        np.abs(rows.slopes).max(axis=1, initial=0.0) * row_unit,
    )
    length = 1.0 / power_of_two(float(slopes.max(initial=0.0)))
    units = np.append(unit[node], row_unit)
    s = limits.spread * units * length
    d, row_d = d * scale[node] * unit[node, None], row_d * row_unit
    right, row_right = g * scale[node] * unit[node, None], row_g * row_unit
    if load_factor is not None:
        right, row_right = right - load_factor * d, row_right - load_factor * row_d
        d, row_d = 0.0 * d, 0.0 * row_d
    extra = np.zeros((len(node), CONE, 2))
    extra[:, 0, 0], extra[:, :, 1] = s[: len(node)], d
    base = DiscProgram(
        blocks=H * (unit * length)[:, None, None],
        node=node,
        extra=extra,
        right=right,
        rows=rows.slopes * (row_unit * length)[:, None],
        rows_extra=np.column_stack([s[len(node) :], row_d]),
        rows_right=row_right,
        cost=np.array([0.0, -1.0]),
    )
    offset = distance / limits.metric.unit / length
    return LimitsAbout(base, np.append(sizes, row_sizes) * units, offset, length, units, load_unit)


def _inverses(sizes: FloatArray) -> FloatArray:
    """Powers of two that bring sizes near 1."""
    return 1.0 / np.array([power_of_two(float(size)) for size in sizes])
