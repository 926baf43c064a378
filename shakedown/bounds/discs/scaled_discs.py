"""The program of the largest or smallest last unknown over the discs of all nodes, in numbers near 1."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.discs.disc_rows import DiscRows
from shakedown.bounds.discs.safe_proof import exact_products
from shakedown.ground.constants import (
    CONE,
    FOUR_DIGITS,
    ITERATIONS,
    MUCH,
    NEGLIGIBLE,
    ROUND_OFF,
    SIX_DIGITS,
    FloatArray,
)
from shakedown.ground.status import Status
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.self_dual import SelfDualSolution

Carrying = tuple[NDArray[np.intp], NDArray[np.intp]]  # discs and half-spaces by number


@dataclass(frozen=True, eq=False)
class UnscaledSolution:
    """The solution of a program in the units of its joint.

    Attributes
    ----------
    status
        Optimal, infeasible, unbounded or undecided.
    x : (k,)
        Slips at the unknowns of programs, or their direction [length]; NaN where infeasible.
    load_factor
        λ, and along a direction 1; NaN where infeasible.
    y : (j, 3), z : (o,)
        Multipliers of discs and half-spaces: Σ yᵀ s = 0 for all slips, with Σ yᵀ e = −1 of an optimum;
        of an infeasible program Σ yᵀ c = −1.
    carrying
        The discs and half-spaces that determine it: those with a multiplier, in numbers near 1.
    reduced_accuracy
        Whether gap or residuals are larger than usual.
    scaled, end
        The program in numbers near 1, and its end.
    """

    status: Status
    x: FloatArray
    load_factor: float
    y: FloatArray
    z: FloatArray
    carrying: Carrying
    reduced_accuracy: bool
    scaled: "ScaledDiscs" = field(repr=False)
    end: SelfDualSolution = field(repr=False)

    @property
    def optimal(self) -> bool:
        """Whether there is a solution."""
        return self.status == Status.OPTIMAL


@dataclass(frozen=True, eq=False)
class ScaledDiscs:
    """A program in numbers near 1, and how its numbers become those of the joint.

    Attributes
    ----------
    program
        The program of (ξ, λ), x = R⁻¹ ξ: in rows the half-spaces, then λ ≥ 0 and λ ≤ its cap.
    rows
        The limits, about the origin.
    origin : (k,)
        Slips from which those of the program are counted [length].
    weights : (n + o,)
        What the rows of a node, or a half-space, were multiplied by.
    unit
        Scale of the slacks, in the units of these rows.
    load_unit
        Scale of the last unknown.
    """

    program: DiscProgram
    rows: DiscRows
    origin: FloatArray
    weights: FloatArray
    unit: float
    load_unit: float

    def slips(self, x: FloatArray) -> FloatArray:
        """Unknowns (k,) [length] from a point (K + 1,) of the program; none where all of it is round-off."""
        return self.origin + self.changes(x)

    def changes(self, x: FloatArray) -> FloatArray:
        """What these are from the origin on, (k,) [length]."""
        if np.abs(x[:-1]).max(initial=0.0) <= ROUND_OFF:
            return np.zeros(len(self.origin))
        return np.asarray(self.unit * (self.rows.basis.to_slips @ x[:-1]))

    def multipliers(self, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Multipliers of the discs and of the half-spaces, from those of the program."""
        n = len(self.program.blocks)
        discs, weights, _ = self.program.parts(y)
        factor = self.weights * (self.load_unit / self.unit)
        gaps = len(self.weights) - n
        return discs * factor[:n][self.program.node][:, None], weights[:gaps] * factor[n:]


def scaled_discs(rows: DiscRows, towards: float, cap: float = np.inf) -> ScaledDiscs:
    """The program of the largest (towards −1) or smallest (+1) last unknown ≥ 0, at most ``cap``."""
    rows, origin = without_mean(rows)
    basis = rows.basis
    n, K, Q = len(rows.stiffness), basis.Q.shape[1], basis.shared.blocks
    lengths = np.append(np.linalg.norm(Q, axis=(1, 2)), np.linalg.norm(basis.Q[3 * n :], axis=1))
    loads = np.append(_largest(rows), np.maximum(np.abs(rows.half_spaces.g), np.abs(rows.half_spaces.d)))
    first = 1.0 / np.where(basis.sizes > 0, basis.sizes, 1.0)
    moved = lengths > 0
    second = 1.0 / np.where(moved, lengths, 1.0)
    heights = loads * first * second
    # A row that no slip changes has no length of its own: it stands as high as the others do, in any units.
    constant = ~moved & (heights > 0)
    second[constant] *= (_median(heights[moved]) or 1.0) / heights[constant]
    heights = loads * first * second
    # times the median of loads: no row is kept farther from its limit than that
    most = _median(heights) / SIX_DIGITS
    second[heights > most] *= most / heights[heights > most]
    weights = first * second
    w = weights[:n][rows.node][:, None]
    C, E = rows.c * w, rows.e * w
    gap_c, gap_e = rows.half_spaces.g * weights[n:], rows.half_spaces.d * weights[n:]
    unit = _median(np.append(np.linalg.norm(C, axis=1), np.abs(gap_c)))
    if unit == 0.0:
        unit = _median(np.append(np.linalg.norm(E, axis=1), np.abs(gap_e))) or 1.0
    load_unit = unit / (_median(np.append(np.linalg.norm(E, axis=1), np.abs(gap_e))) or unit)
    bounds = np.array([-1.0, 1.0])[: 1 + np.isfinite(cap)]
    program = DiscProgram(
        blocks=np.ascontiguousarray(Q * -second[:n, None, None]),
        node=rows.node,
        extra=E[:, :, None] * (-load_unit / unit),
        right=C / unit,
        rows=np.vstack([basis.Q[3 * n :] * second[n:, None], np.zeros((len(bounds), K))]),
        rows_extra=np.append(gap_e * load_unit / unit, bounds)[:, None],
        rows_right=np.concatenate([gap_c / unit, [0.0, cap / load_unit][: len(bounds)]]),
        cost=np.array([towards]),
        shared=basis.shared,
        scale=np.repeat(-second[:n, None], CONE, axis=1),
    )
    return ScaledDiscs(program, rows, origin, weights, unit, load_unit)


def without_mean(rows: DiscRows) -> tuple[DiscRows, FloatArray]:
    """The limits counted from slips that take the reactions of the mean load, and these slips (k,).

    Where those are so much larger than what friction bears that its limits would be lost in their round-off;
    else the limits as they are. These slips are sums of parts, so that no digit of what they leave is lost.
    """
    one = np.unique(rows.node, return_index=True)[1]
    mean, flat, H, parts = rows.c[one], rows.flat, rows.half_spaces, list[FloatArray]()
    limits, reactions = np.abs(mean[:, 0]), np.hypot(mean[:, 1], mean[:, 2])
    if not np.any((limits > 0) & (reactions * FOUR_DIGITS > limits)):
        return rows, np.zeros(flat.shape[1])

    def left(matrix: FloatArray, constant: FloatArray) -> FloatArray:
        terms = np.column_stack([*[matrix] * len(parts), constant.ravel()])
        return exact_products(terms, np.concatenate([*parts, np.ones(1)]))

    tangential = rows.stiffness[:, 1:].reshape(-1, flat.shape[1])
    inverse, rest = np.linalg.pinv(tangential), mean
    for _ in range(ITERATIONS):
        parts.append(-inverse @ rest[:, 1:].ravel())
        before, rest = rest, left(flat, mean).reshape(-1, 3)
        if not np.abs(rest[:, 1:]).max() < MUCH * np.abs(before[:, 1:]).max():
            break
    near = replace(H, g=left(-H.coefficients, H.g))
    return rows.under(c=rest[rows.node] + (rows.c - mean[rows.node]), half_spaces=near), np.sum(parts, axis=0)


def in_units(scaled: ScaledDiscs, end: SelfDualSolution) -> UnscaledSolution:
    """What the interior points found, in the units of the joint."""
    y, z = scaled.multipliers(end.multipliers)
    x, load_factor = scaled.slips(end.x), float(end.x[-1] * scaled.load_unit)
    if end.status == Status.UNBOUNDED:  # per load factor
        x, load_factor = scaled.changes(end.x) / load_factor, 1.0
    if end.status == Status.INFEASIBLE:
        x, load_factor = np.full(len(x), np.nan), np.nan
        size = -float(np.vdot(y, scaled.rows.c) + z @ scaled.rows.half_spaces.g)
        y, z = y / size, z / size
    discs, others, _ = scaled.program.parts(end.multipliers)
    weights, others = discs[:, 0], others[: len(z)]
    least = NEGLIGIBLE * max(weights.max(initial=0.0), others.max(initial=0.0))
    carrying = np.flatnonzero(weights > least), np.flatnonzero(others > least)
    reduced = end.accuracy > NEGLIGIBLE
    return UnscaledSolution(end.status, x, load_factor, y, z, carrying, reduced, scaled, end)


def _largest(rows: DiscRows) -> FloatArray:
    """The largest load of every node [force]."""
    found = np.zeros(len(rows.stiffness))
    np.maximum.at(found, rows.node, np.maximum(np.abs(rows.c), np.abs(rows.e)).max(axis=1))
    return found


def _median(sizes: FloatArray) -> float:
    weighing = sizes[sizes > 0]
    return float(np.median(weighing)) if weighing.size else 0.0
