"""The discs about a given slip, in units of energy and without dimension, and the programs over them."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shakedown.bounds.energy.ball_limits import DiscLimits, Places
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import CONE
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.scaling import power_of_two
from shakedown.programs.shared_blocks import SharedBlocks

ROUND_OFF = 4 * np.finfo(float).eps


@dataclass(frozen=True, eq=False)
class DiscsAbout:
    """(f p, a q) = g − H_i y − λ d in discs that leave the slack s_i R, y in units of energy about a slip.

    Dimensionless, by powers of two, one of each node's own included.

    Attributes
    ----------
    H : (n, 3, r)
        Coefficients of y in the discs of every node.
    node : (K,)
        Node of every disc.
    d, g : (K, 3)
        Coefficients of λ, right-hand sides.
    s : (n,)
        Coefficients of the radius.
    rows : (k, r)
        Coefficients of y in the rows of gaps.
    row_d, row_g, row_s : (k,)
        Their other coefficients.
    sizes : (K + k,)
        Largest term on the right-hand side of every disc and row.
    offset
        δ.
    length
        Unit of y, of R and of δ.
    unit, row_unit : (n,), (k,)
        What discs of every node, and rows, were multiplied by [1/force].
    shared, scale : …, (n, 3)
        The blocks of which H are multiples, row by row.
    """

    H: FloatArray
    node: Places
    d: FloatArray
    g: FloatArray
    s: FloatArray
    rows: FloatArray
    row_d: FloatArray
    row_g: FloatArray
    row_s: FloatArray
    sizes: FloatArray
    offset: float
    length: float
    unit: FloatArray
    row_unit: FloatArray
    shared: SharedBlocks
    scale: FloatArray

    @cached_property
    def disc_s(self) -> FloatArray:
        """s of every disc."""
        return self.s[self.node]

    @property
    def all_s(self) -> FloatArray:
        """s of every disc and row."""
        return np.append(self.disc_s, self.row_s)

    def reversed(self) -> "DiscsAbout":
        """The same in −λ."""
        return replace(self, d=-self.d, row_d=-self.row_d)

    def at_load(self, load_factor: float) -> "DiscsAbout":
        """At one load factor: nothing is left of λ."""
        return replace(
            self,
            g=self.g - load_factor * self.d,
            row_g=self.row_g - load_factor * self.row_d,
            d=np.zeros_like(self.d),
            row_d=np.zeros_like(self.row_d),
        )

    def discs_at(self, y: FloatArray, load_factor: float) -> FloatArray:
        """(f p, a q) of every disc, (K, 3)."""
        return np.asarray(self.g - (self.H @ y)[self.node] - load_factor * self.d)

    def slack(self, y: FloatArray, load_factor: float = 0.0) -> FloatArray:
        """Distance of every disc and row to its limit (K + k,)."""
        u = self.discs_at(y, load_factor)
        rows = self.row_g - self.rows @ y - load_factor * self.row_d
        return np.append(u[:, 0] - np.hypot(u[:, 1], u[:, 2]), rows)

    def excess(self, y: FloatArray, load_factor: float, radius: float) -> FloatArray:
        """Violation of every disc and row, relative to its largest term."""
        moved = np.append((np.abs(self.H) @ np.abs(y)).max(axis=1)[self.node], np.abs(self.rows) @ np.abs(y))
        loads = abs(load_factor) * np.append(np.abs(self.d).max(axis=1), np.abs(self.row_d))
        terms = np.maximum(np.maximum(moved, loads), np.maximum(self.sizes, radius * self.all_s))
        return (radius * self.all_s - self.slack(y, load_factor)) / np.where(terms > 0, terms, 1.0)

    def program(self, extra: FloatArray, rows_extra: FloatArray, rows_right: FloatArray) -> DiscProgram:
        """Minimise the last of w, negative, over these discs: of discs and rows the coefficients of w.

        Parameters
        ----------
        extra : (K, 3, p)
            Coefficients of w in the discs.
        rows_extra : (k + j, p)
            In the rows of gaps, and in j further rows without y.
        rows_right : (j,)
            Right-hand sides of these.
        """
        nothing = np.zeros((len(rows_right), self.H.shape[2]))
        return DiscProgram(
            blocks=self.H,
            node=self.node,
            extra=extra,
            right=self.g,
            rows=np.vstack([self.rows, nothing]),
            rows_extra=rows_extra,
            rows_right=np.append(self.row_g, rows_right),
            cost=np.append(np.zeros(extra.shape[2] - 1), -1.0),
            shared=self.shared,
            scale=self.scale,
        )

    def load_factor_program(self, *, reverse: bool = False) -> DiscProgram:
        """The largest λ ≥ 0, or −λ ≥ 0, for which ‖y‖ + δ ≤ R, w = (R, λ or −λ).

        Where no limit knows the radius, w = (λ,): it would have no end.
        """
        loads = np.append(self.row_d, 1.0 if reverse else -1.0)
        if not self.knows_radius:
            return self.program(self.d[:, :, None], loads[:, None], np.zeros(1))
        found = self.program(
            np.stack([self._of_radius(self.disc_s), self.d], axis=2),
            np.column_stack([np.append(self.row_s, 0.0), loads]),
            np.zeros(1),
        )
        return replace(found, norm=np.array([1.0, 0.0]), offset=self.offset)

    @property
    def knows_radius(self) -> bool:
        """Whether any limit depends on the radius by more than round-off."""
        return bool(self.all_s.max(initial=0.0) > ROUND_OFF)

    @cached_property
    def unit_of_radius(self) -> float:
        """Radii times this change the discs as much as y does; s may be next to nothing beside H."""
        return power_of_two(float(self.all_s.max(initial=0.0)))

    def margin_program(self) -> DiscProgram:
        """The largest δ, of either sign, for which ‖y‖ + δ ≤ R and R ≥ 0, w = (R − δ, δ) in these units.

        The length of y in those of y, the radius in units of its own: it may be larger by many orders.
        """
        unit = self.unit_of_radius
        found = self.program(
            np.stack([self._of_radius(self.disc_s), self._of_radius(self.disc_s / unit)], axis=2),
            np.vstack([np.column_stack([self.row_s, self.row_s / unit]), [-unit, -1.0]]),
            np.zeros(1),
        )
        return replace(found, norm=np.array([1.0, 0.0]))

    def radius_program(self, cap: float) -> DiscProgram:
        """The largest R up to a cap, whatever y is, w = (R,) in units of the radius."""
        unit = self.unit_of_radius
        ends = [0.0] if np.isinf(cap) else [0.0, cap * unit]
        return self.program(
            self._of_radius(self.disc_s / unit)[:, :, None],
            np.append(self.row_s / unit, [-1.0, 1.0][: len(ends)])[:, None],
            np.array(ends),
        )

    @cached_property
    def margin_sizes(self) -> FloatArray:
        """What margins of discs and rows are relative to (K + k,)."""
        slopes = np.linalg.norm(self.H, axis=(1, 2))[self.node]
        return np.maximum(self.sizes, np.append(slopes, np.linalg.norm(self.rows, axis=1)))

    def margin(self, y: FloatArray, load_factor: float, radius: float) -> float:
        """The smallest margin that discs and rows keep at y with a radius, relative, at most 1."""
        slack = self.slack(y, load_factor) - radius * self.all_s
        sizes = np.where(self.margin_sizes > 0, self.margin_sizes, 1.0)
        return min(1.0, float(np.min(slack / sizes, initial=1.0)))

    def widest_program(self, *, ball: bool) -> DiscProgram:
        """The largest margin t ≤ 1 that all keep, relative to their sizes, w = (R, λ, t).

        With the ball about y that holds δ; or, without, w = (t,) at one load factor, for R = 0. Where no
        limit knows the radius, w = (λ, t).
        """
        sizes = self.margin_sizes
        K, kept = len(self.node), np.array([ball and self.knows_radius, ball, True])
        discs = np.stack([self._of_radius(self.disc_s), self.d, self._of_radius(sizes[:K])], axis=2)
        rows = np.column_stack([self.row_s, self.row_d, sizes[K:]])
        ends = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0]])[kept[1:]]
        found = self.program(
            discs[..., kept], np.vstack([rows, ends])[:, kept], np.array([0.0, 1.0])[kept[1:]]
        )
        return replace(found, norm=np.array([1.0, 0.0, 0.0]), offset=self.offset) if kept[0] else found

    def _of_radius(self, values: FloatArray) -> FloatArray:
        """What is taken of the radius of every disc alone, (K, 3)."""
        return np.column_stack([values, np.zeros((len(values), CONE - 1))])


def discs_about(limits: DiscLimits, slip: FloatArray, distance: float = 0.0) -> DiscsAbout:
    """The discs about a slip, from which an energy distance is to be kept."""
    metric, node, n = limits.metric, limits.node, len(limits.f)
    scale = np.column_stack([np.ones(n), limits.stretch, limits.stretch])
    H = limits.shared_blocks.blocks * scale[:, :, None]
    rows = limits.gaps @ metric.inverse
    moved, terms = limits.G @ slip, np.abs(limits.G) @ np.abs(slip)
    g = _cleaned(limits.g - moved[node], np.abs(limits.g) + terms[node])
    row_terms = np.abs(limits.gaps) @ np.abs(slip)
    row_g = _cleaned(limits.gap_g - limits.gaps @ slip, np.abs(limits.gap_g) + row_terms)
    sizes = np.maximum(np.abs(limits.g).max(axis=1), terms.max(axis=1)[node])
    row_sizes = np.maximum(np.abs(limits.gap_g), row_terms)
    starts = np.flatnonzero(np.append(True, np.diff(node) > 0))
    of_nodes = np.maximum.reduceat(np.maximum(sizes, np.abs(limits.d).max(axis=1)), starts)
    unit = 1.0 / np.array([power_of_two(float(size)) for size in of_nodes])
    row_unit = 1.0 / np.array([power_of_two(float(size)) for size in row_sizes])
    slopes = np.append(
        np.abs(H).max(axis=(1, 2), initial=0.0) * unit, np.abs(rows).max(axis=1, initial=0.0) * row_unit
    )
    length = 1.0 / power_of_two(float(slopes.max(initial=0.0)))
    own_unit = (unit * length)[:, None]
    return DiscsAbout(
        H=H * own_unit[:, :, None],
        node=node,
        d=limits.d * scale[node] * unit[node, None],
        g=g * scale[node] * unit[node, None],
        s=limits.spread * unit * length,
        rows=rows * (row_unit * length)[:, None],
        row_d=limits.gap_d * row_unit,
        row_g=row_g * row_unit,
        row_s=limits.gap_spread * row_unit * length,
        sizes=np.append(sizes * unit[node], row_sizes * row_unit),
        offset=distance / metric.unit / length,
        length=length,
        unit=unit,
        row_unit=row_unit,
        shared=limits.shared_blocks,
        scale=scale * own_unit,
    )


def _cleaned(difference: FloatArray, terms: FloatArray) -> FloatArray:
    """A difference, with what is round-off of its terms set to exact zero."""
    return np.where(np.abs(difference) <= ROUND_OFF * terms, 0.0, difference)
