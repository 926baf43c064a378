"""The limits about a given slip, in units of energy and without dimension, and the programs over them."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shakedown.bounds.energy.ball_limits import BallLimits, Places, cleaned
from shakedown.ground.constants import CONE, SETTLED, FloatArray
from shakedown.programs.disc_program import DiscProgram, SharedBlocks
from shakedown.programs.program import power_of_two


@dataclass(frozen=True, eq=False)
class LimitsAbout:
    """(f p, a q) = g − H_i y − λ d in discs that leave the slack s_i R, and rows, y in units of energy.

    Dimensionless, by powers of two, one of each node's own included.

    Attributes
    ----------
    H : (n, 3, r)
        Coefficients of y in the discs of every node.
    node : (K,)
        Node of every disc.
    d, g : (K, 3)
        Coefficients of λ, right-hand sides.
    rows : (k, r)
        Coefficients of y in the rows.
    row_d, row_g : (k,)
        Their other coefficients.
    s : (K + k,)
        Coefficients of the radius in discs and rows.
    sizes : (K + k,)
        Largest term on the right-hand side of every disc and row.
    offset
        δ.
    length
        Unit of y, of R and of δ.
    unit : (K + k,)
        What discs and rows were multiplied by [1/force].
    shared, scale : …, (n, 3)
        The blocks of which H are multiples, row by row.
    """

    H: FloatArray
    node: Places
    d: FloatArray
    g: FloatArray
    rows: FloatArray
    row_d: FloatArray
    row_g: FloatArray
    s: FloatArray
    sizes: FloatArray
    offset: float
    length: float
    unit: FloatArray
    shared: SharedBlocks
    scale: FloatArray

    def reversed(self) -> "LimitsAbout":
        """The same in −λ."""
        return replace(self, d=-self.d, row_d=-self.row_d)

    def at_load(self, load_factor: float) -> "LimitsAbout":
        """At one load factor: nothing is left of λ."""
        return replace(
            self,
            g=self.g - load_factor * self.d,
            row_g=self.row_g - load_factor * self.row_d,
            d=np.zeros_like(self.d),
            row_d=np.zeros_like(self.row_d),
        )

    def discs_at(self, y: FloatArray) -> FloatArray:
        """(f p, a q) of every disc without a load factor, (K, 3)."""
        return np.asarray(self.g - (self.H @ y)[self.node])

    def slack(self, y: FloatArray, load_factor: float = 0.0) -> FloatArray:
        """Distance of every disc and row to its limit (K + k,)."""
        u = self.discs_at(y) - load_factor * self.d
        rows = self.row_g - self.rows @ y - load_factor * self.row_d
        return np.append(u[:, 0] - np.hypot(u[:, 1], u[:, 2]), rows)

    def program(
        self,
        columns: list[tuple[FloatArray, FloatArray]],
        ends: list[list[float]],
        right: list[float],
        *,
        within: bool,
    ) -> DiscProgram:
        """Minimise the last of w, negative, over these discs and rows.

        Parameters
        ----------
        columns
            Of every number of w its coefficients in the discs (K, 3) and in the rows (k,).
        ends, right
            Coefficients of w in further rows without y, and their right-hand sides.
        within
            Whether the length of y, with δ, is at most the first of w.
        """
        discs, rows = zip(*columns, strict=True)
        return DiscProgram(
            blocks=self.H,
            node=self.node,
            extra=np.stack(discs, axis=2),
            right=self.g,
            rows=np.vstack([self.rows, np.zeros((len(ends), self.H.shape[2]))]),
            rows_extra=np.vstack([np.column_stack(rows), *ends]),
            rows_right=np.append(self.row_g, right),
            cost=np.append(np.zeros(len(columns) - 1), -1.0),
            norm=np.eye(len(columns))[0] if within else None,
            offset=self.offset if within else 0.0,
            shared=self.shared,
            scale=self.scale,
        )

    def load_factor_program(self, *, reverse: bool = False) -> DiscProgram:
        """The largest λ ≥ 0, or −λ ≥ 0, for which ‖y‖ + δ ≤ R, w = (R, λ or −λ).

        Where no limit knows the radius, w = (λ,): it would have no end.
        """
        sign, known = 1.0 if reverse else -1.0, self.knows_radius
        columns = [self._of_radius(self.s), (self.d, self.row_d)]
        return self.program(columns[not known :], [[0.0, sign][not known :]], [0.0], within=known)

    @property
    def knows_radius(self) -> bool:
        """Whether any limit depends on the radius by more than round-off."""
        return bool(self.s.max(initial=0.0) > SETTLED)

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
        columns = [self._of_radius(self.s), self._of_radius(self.s / unit)]
        return self.program(columns, [[-unit, -1.0]], [0.0], within=True)

    def radius_program(self, cap: float) -> DiscProgram:
        """The largest R up to a cap, whatever y is, w = (R,) in units of the radius."""
        unit = self.unit_of_radius
        last = 1 if np.isinf(cap) else 2
        columns = [self._of_radius(self.s / unit)]
        return self.program(columns, [[-1.0], [1.0]][:last], [0.0, cap * unit][:last], within=False)

    @cached_property
    def margin_sizes(self) -> FloatArray:
        """What margins of discs and rows are relative to (K + k,)."""
        slopes = np.linalg.norm(self.H, axis=(1, 2))[self.node]
        return np.maximum(self.sizes, np.append(slopes, np.linalg.norm(self.rows, axis=1)))

    def margin(self, y: FloatArray, load_factor: float, radius: float) -> float:
        """The smallest margin that discs and rows keep at y with a radius, relative, at most 1."""
        slack = self.slack(y, load_factor) - radius * self.s
        sizes = np.where(self.margin_sizes > 0, self.margin_sizes, 1.0)
        return min(1.0, float(np.min(slack / sizes, initial=1.0)))

    def widest_program(self, *, ball: bool) -> DiscProgram:
        """The largest margin t ≤ 1 that all keep, relative to their sizes, w = (R, λ, t).

        With the ball about y that holds δ; or, without, w = (t,) at one load factor, for R = 0. Where no
        limit knows the radius, w = (λ, t).
        """
        columns = [self._of_radius(self.s), (self.d, self.row_d), self._of_radius(self.margin_sizes)]
        first = 2 if not ball else int(not self.knows_radius)
        ends = [[0.0, -1.0, 0.0][first:], [0.0, 0.0, 1.0][first:]][not ball :]
        return self.program(columns[first:], ends, [0.0, 1.0][not ball :], within=first == 0)

    def _of_radius(self, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values (K + k,) as what is taken of the radius of every disc alone (K, 3), and of rows (k,)."""
        discs, rows = np.split(values, [len(self.node)])
        return np.column_stack([discs, np.zeros((len(discs), CONE - 1))]), rows


def limits_about(limits: BallLimits, slip: FloatArray, distance: float = 0.0) -> LimitsAbout:
    """The limits about a slip, from which an energy distance is to be kept."""
    node, n = limits.node, len(limits.f)
    scale = np.column_stack([np.ones(n), limits.stretch, limits.stretch])
    H = limits.shared_blocks.blocks * scale[:, :, None]
    moved, terms = limits.G @ slip, np.abs(limits.G) @ np.abs(slip)
    g = cleaned(limits.g - moved[node], np.abs(limits.g) + terms[node])
    row_terms = np.abs(limits.rows.G) @ np.abs(slip)
    row_g = cleaned(limits.rows.g - limits.rows.G @ slip, np.abs(limits.rows.g) + row_terms)
    sizes = np.maximum(np.abs(limits.g).max(axis=1), terms.max(axis=1)[node])
    row_sizes = np.maximum(np.abs(limits.rows.g), row_terms)
    of_nodes = np.zeros(n)
    np.maximum.at(of_nodes, node, np.maximum(sizes, np.abs(limits.d).max(axis=1)))
    unit = _inverses(of_nodes)
    row_unit = _inverses(np.maximum(row_sizes, np.abs(limits.rows.d)))
    slopes = np.append(
        np.abs(H).max(axis=(1, 2), initial=0.0) * unit,
        np.abs(limits.rows.slopes).max(axis=1, initial=0.0) * row_unit,
    )
    length = 1.0 / power_of_two(float(slopes.max(initial=0.0)))
    units = np.append(unit[node], row_unit)
    return LimitsAbout(
        H=H * (unit * length)[:, None, None],
        node=node,
        d=limits.d * scale[node] * unit[node, None],
        g=g * scale[node] * unit[node, None],
        rows=limits.rows.slopes * (row_unit * length)[:, None],
        row_d=limits.rows.d * row_unit,
        row_g=row_g * row_unit,
        s=limits.spread * units * length,
        sizes=np.append(sizes, row_sizes) * units,
        offset=distance / limits.metric.unit / length,
        length=length,
        unit=units,
        shared=limits.shared_blocks,
        scale=scale * (unit * length)[:, None],
    )


def _inverses(sizes: FloatArray) -> FloatArray:
    """Powers of two that bring sizes near 1."""
    return 1.0 / np.array([power_of_two(float(size)) for size in sizes])
