"""Balls with the largest load factor, radius or margin: centre and shares are optimised alternately."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf, nan
from typing import TypeGuard

import numpy as np

from shakedown.bounds.energy.about_slip import LimitsAbout, limits_about
from shakedown.bounds.energy.ball_limits import BallLimits
from shakedown.bounds.scaled_solution import polished
from shakedown.ground.constants import (
    ALTERNATIONS,
    CONVERGED,
    FOUR_DIGITS,
    HALVINGS,
    ITERATIONS,
    MINOR,
    NEGLIGIBLE,
    ROUND_OFF,
    SIX_DIGITS,
    FloatArray,
    IntArray,
)
from shakedown.ground.errors import Missing, SolverError, attempt
from shakedown.ground.status import Status
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.program import typical_size
from shakedown.programs.self_dual import Points, SelfDualSolution, solve_discs

LARGEST_SHARE = 1 - MINOR  # largest f |c|: the proof needs less than 1


@dataclass(frozen=True, eq=False)
class FoundBall:
    """The solution of a program with the limits, shares included, that it was made of.

    Attributes
    ----------
    limits
        Limits and shares.
    about
        The limits about the slip that was given.
    program, solution
        Maximise w_last, and how that ended.
    slip : (dn,)
        The centre [length].
    radius
        Its radius, relative [length].
    value
        The largest load factor, relative radius or margin that the limits allow there in floats.
    gap
        What the multipliers prove not to be exceeded, relative to the value, less 1.
    """

    limits: BallLimits
    about: LimitsAbout
    program: DiscProgram
    solution: SelfDualSolution
    slip: FloatArray
    radius: float
    value: float
    gap: float

    @property
    def status(self) -> Status:
        """How the program ended."""
        return self.solution.status

    @property
    def path(self) -> Points:
        """The points on the way to an optimum; of another end none."""
        return self.solution.path if self.status == Status.OPTIMAL else ()

    @cached_property
    def weights(self) -> FloatArray:
        """Multipliers of the radii of discs, and of rows, without dimension, (K + k,)."""
        return _weights(self.program, self.about, self.solution.multipliers)

    @property
    def active(self) -> IntArray:
        """The discs and rows that the proof rests on."""
        least = NEGLIGIBLE if self.status == Status.OPTIMAL else SIX_DIGITS  # else they are not polished
        return np.flatnonzero(self.weights > least * self.weights.max(initial=0.0))

    @property
    def multipliers(self) -> FloatArray:
        """In the units of the limits, of λ they add up to 1: of all rows, or of the discs that carry."""
        multipliers = self.every_multiplier
        return multipliers[self.active] if len(self.about.base.node) else multipliers

    @property
    def every_multiplier(self) -> FloatArray:
        """Those of all discs and rows, (K + k,)."""
        return self.weights * self.about.unit * self.about.load_unit

    @cached_property
    def contradiction(self) -> float:
        """By how much the multipliers fail to prove that the limits contradict each other (Farkas)."""
        program, (discs, rows, _) = self.program, self.program.cones.parts(self.solution.multipliers)
        of_y, of_w, right = _sums(program, self.solution.multipliers)
        weight = 0.0 if program.norm is None else float(of_w[0])
        value = weight * program.offset - right
        if not value > 0:
            return inf
        terms = np.einsum("ij,ij", np.abs(discs), np.abs(program.right))
        sizes = float(terms + np.abs(rows) @ np.abs(program.rows_right))
        return max(float(np.linalg.norm(of_y)) - weight, abs(float(of_w[-1])), 0.0) / max(sizes, value)


def _sums(program: DiscProgram, multipliers: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """What multipliers of discs and rows add up to in the columns y and w, and on the right-hand side."""
    some = multipliers.copy()
    discs, rows, tail = program.cones.parts(some)
    tail[:] = 0.0
    whole = program.transposed(some)
    right = float(np.einsum("ij,ij", discs, program.right) + rows @ program.rows_right)
    return whole[: program.rank], whole[program.rank :], right


def _weights(program: DiscProgram, about: LimitsAbout, multipliers: FloatArray) -> FloatArray:
    """Multipliers of the radii of discs, and of rows, without dimension, (K + k,)."""
    discs, rows, _ = program.cones.parts(multipliers)
    return np.append(discs[:, 0], rows[: len(about.base.rows)])


def _proved_bound(program: DiscProgram, end: SelfDualSolution) -> float:
    """The w_last that multipliers prove not to be exceeded at any y up to twice as far as that of the end.

    Weak duality, with what is left of the balance at its worst there.
    """
    of_y, of_w, right = _sums(program, end.multipliers)
    # the length of y may weigh as much as the first of w, of which it bounds it
    weight = 0.0 if program.norm is None else float(of_w[0])
    short = max(float(np.linalg.norm(of_y)) - weight, 0.0)
    value = right - weight * program.offset + 2 * float(np.linalg.norm(end.x[: program.rank])) * short
    return value / float(of_w[-1]) if of_w[-1] > 0 else nan


def _solved(
    limits: BallLimits,
    about: LimitsAbout,
    start: FloatArray,
    program: DiscProgram,
    allowed: Callable[[FloatArray], tuple[float, float]],
    earlier: Points = (),
    *,
    unit: float = 1.0,
) -> FoundBall:
    """The solution of a program, polished, with the radius and the value that the limits allow there.

    Parameters
    ----------
    limits, about, start
        The limits, and the same about a slip.
    program
        Maximise w_last, ``unit`` times the value, both relative.
    allowed
        The radius and the largest value that the limits allow at a given y in floats.
    earlier
        The way to the optimum of a program that differs little.

    Raises
    ------
    SolverError
        If the method comes to no end.
    """
    r = program.rank
    end = polished(program, solve_discs(program, FOUR_DIGITS, earlier))
    radius = value = gap = nan
    if end.status == Status.OPTIMAL:
        radius, value = allowed(end.x[:r])
        if end.accuracy <= NEGLIGIBLE or not np.isfinite(value):
            value = float(end.x[-1]) / unit
        most = _proved_bound(program, end) / unit
        gap = most / value - 1.0 if value > 0 else most
    slip = start + limits.metric.inverse @ end.x[:r] * about.length
    return FoundBall(limits, about, program, end, slip, radius, value, gap)


Solve = Callable[[BallLimits, Points], FoundBall]  # from the way to the optimum with other shares


def largest_load_factor(limits: BallLimits, start: FloatArray, distance: float, *, split: bool) -> FoundBall:
    """The largest load factor at which a ball holds a slip and the distance around it."""

    def solve(each: BallLimits, earlier: Points) -> FoundBall:
        about = limits_about(each, start, distance)
        program, unit = about.load_factor_program(), 1.0 / about.load_unit
        return _solved(each, about, start, program, partial(_largest_load, about), earlier, unit=unit)

    return _alternating(limits, solve, None, split=split)


def least_load(limits: BallLimits, start: FloatArray, distance: float) -> float:
    """The smallest load factor ≥ 0 at which the same shares have a ball that holds a slip; NaN unknown."""
    about = limits_about(limits, start, distance).reversed()
    program, unit = about.load_factor_program(reverse=True), 1.0 / about.load_unit
    end = attempt(_solved, limits, about, start, program, partial(_largest_load, about), unit=unit)
    if isinstance(end, Missing) or end.status != Status.OPTIMAL:
        return nan
    return -end.value if -end.value > ROUND_OFF else 0.0


def ball_margin(limits: BallLimits, start: FloatArray, distance: float) -> tuple[FloatArray, float, float]:
    """The largest margin, relative, that all limits leave at any load factor to a ball that holds a slip.

    Returns its centre, the load factor, and this margin.
    """
    about = limits_about(limits, start, distance)
    y, w = _centre(about.centre_program(ball=True))
    load_factor, radius = max(float(w[-2]), 0.0), float(np.linalg.norm(y)) + about.offset
    slip = start + limits.metric.inverse @ y * about.length
    return slip, load_factor * about.load_unit, about.margin(y, radius, load_factor)


def safest(limits: BallLimits, load_factor: float) -> tuple[FloatArray, float]:
    """The slip with the largest margin to all limits, relative, at a load factor; and that margin."""
    about = limits_about(limits, np.zeros(limits.n), load_factor=load_factor)
    y, _ = _centre(about.centre_program(ball=False))
    return limits.metric.inverse @ y * about.length, about.margin(y)


def _centre(program: DiscProgram) -> tuple[FloatArray, FloatArray]:
    """(y, w) with the largest margin, to four digits; how large it is there is to be computed anew."""
    end = solve_discs(program, FOUR_DIGITS)
    if end.status != Status.OPTIMAL:
        raise SolverError(f"the program for the largest margin ended as '{end.status}'")
    return end.x[: program.rank], end.x[program.rank :]


def largest_ball(limits: BallLimits, load_factor: float, *, split: bool) -> FoundBall:
    """The largest ball at a load factor; unbounded where the centre may move away with the radius."""
    start = np.zeros(limits.n)

    def solve(each: BallLimits, earlier: Points) -> FoundBall:
        about = limits_about(each, start, load_factor=load_factor)

        def up_to(cap: float, earlier: Points) -> FoundBall:
            program, unit = about.radius_program(cap), about.unit_of_radius / about.length
            allowed = partial(_largest_margin, about, share=0.0)
            return _solved(each, about, start, program, allowed, earlier, unit=unit)

        found = up_to(inf, earlier)
        if found.status != Status.UNBOUNDED:
            return found
        wide = about.s > 0
        found = up_to(typical_size(np.abs(about.slack(np.zeros(about.base.rank)))[wide] / about.s[wide]), ())
        return replace(found, solution=replace(found.solution, status=Status.UNBOUNDED))

    return _alternating(limits, solve, load_factor, split=split)


def ball_around(limits: BallLimits, load_factor: float, slip: FloatArray, *, split: bool) -> FoundBall:
    """The ball at a load factor in which a slip has the largest margin R − ‖v − v*‖, of either sign."""

    def solve(each: BallLimits, earlier: Points) -> FoundBall:
        about = limits_about(each, slip, load_factor=load_factor)
        program, unit = about.margin_program(), about.unit_of_radius / about.length
        return _solved(each, about, slip, program, partial(_largest_margin, about), earlier, unit=unit)

    return _alternating(limits, solve, load_factor, split=split)


def held_by_none(limits: BallLimits, load_factor: float, slip: FloatArray) -> bool:
    """Whether multipliers prove that no ball at a load factor holds a slip, whatever the shares.

    Any shares have a ≥ 1 and s at least f γ at its least, so what they allow the same discs with that s
    allow. There Σ z · (g − H y − s R) ≥ 0, and R ≥ ‖y‖ where the slip is held: none is where z · g < 0 and
    the length of Hᵀ z is at most s · z.
    """
    least = replace(limits, share=np.zeros_like(limits.share), own=np.zeros_like(limits.own))
    about = limits_about(least, slip, load_factor=load_factor)
    program = about.margin_program()

    def refuted(multipliers: FloatArray) -> bool:
        of_y, _, right = _sums(program, multipliers)
        short = float(np.linalg.norm(of_y)) <= float(about.s @ _weights(program, about, multipliers))
        return right < 0.0 and short

    def known(x: FloatArray, multipliers: FloatArray) -> bool:
        return bool(_largest_margin(about, x[: program.rank])[-1] > 0.0) or refuted(multipliers)

    end = attempt(solve_discs, program, FOUR_DIGITS, (), known)
    return not isinstance(end, Missing) and refuted(end.multipliers)


def full_share(limits: BallLimits) -> FloatArray:
    """The share at which γ is least, as far as f |c| < 1 allows it."""
    size = limits.f * np.hypot(limits.own[:, 0], limits.own[:, 1])
    return limits.own * np.minimum(1.0, LARGEST_SHARE / np.where(size > 0, size, 1.0))[:, None]


def best_share(limits: BallLimits, slip: FloatArray, load_factor: float, radius: float) -> FloatArray:
    """c of every node at which the least slack over its load steps is largest, (n, 2) [1].

    With A_ii = U diag(α) Uᵀ and c_i = A_ii⁻¹ B_ii the best lies on the curve
    c(t) = (t A_ii + (1 − t) α_max)⁻¹ t A_ii c_i, 0 ≤ t ≤ 1, from 0 to c_i: for any length |c| the least γ is
    there. The slack falls with a(c) |q*| at the load step with the least slack, and grows as γ falls; where
    the two balance the slack is largest, as it is concave in c. Found by bisection, for all nodes at once.

    Parameters
    ----------
    limits
        The limits; their own shares do not matter.
    slip, load_factor
        The centre of the ball [length], and the load factor.
    radius
        Its radius in units of ``metric.unit``.
    """
    u = limits.reactions(slip, load_factor)
    pressed, drawn, node = u[:, 0], np.hypot(u[:, 1], u[:, 2]), limits.node
    first = np.flatnonzero(np.append(True, np.diff(node) > 0))
    values, vectors = np.linalg.eigh(limits.stiffness)
    values = np.maximum(values, 0.0)  # eigenvalues of a singular stiffness are round-off
    largest = values[:, -1]
    turned = np.einsum("ijk,ij->ik", vectors, limits.own)

    def on_curve(t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """c(t) along the eigenvectors of A_ii, (n, 2), and (c_i − c(t)) / (1 − t)."""
        weights = t[:, None] * values
        whole = weights + ((1.0 - t) * largest)[:, None]
        parts = np.stack([weights * turned, largest[:, None] * turned])
        c, away = np.divide(parts, whole, out=np.zeros_like(parts), where=whole > 0)
        return c, away

    def too_far(t: FloatArray) -> np.ndarray:
        """Whether the slack already decreases with t, or f |c| is too large."""
        c, away = on_curve(t)
        size = limits.f * np.hypot(c[:, 0], c[:, 1])
        a = np.sqrt(1.0 + size**2)
        steep = np.sqrt(np.einsum("ij,ij->i", away**2, values))  # its length in the metric of γ
        taken = a[node] * drawn - pressed
        worst = np.maximum.reduceat(taken, first)
        tied = taken >= worst[node] - NEGLIGIBLE * (np.abs(pressed) + a[node] * drawn)
        at = np.maximum.reduceat(np.where(tied, drawn, 0.0), first)
        left = np.where(limits.least > 0, 1.0 - t, 1.0)  # where γ vanishes, 1 − t is divided out
        gamma = np.where(limits.least > 0, np.hypot(limits.least, left * steep), steep)
        balance = limits.f * at * gamma * t - radius * largest * left * a
        return np.asarray((balance > 0) | (size > LARGEST_SHARE))

    low, high = np.zeros(len(largest)), np.ones(len(largest))
    whole = ~too_far(high)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        beyond = too_far(middle)
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    c, _ = on_curve(np.where(whole, 1.0, low))
    return np.asarray(np.einsum("ijk,ik->ij", vectors, c))


def _alternating(
    limits: BallLimits,
    solve: Solve,
    load_factor: float | None,
    *,
    split: bool,
) -> FoundBall:
    """Alternating optimisation of centre and shares, from shares zero or half of those at which γ is least.

    In turn the best shares for the centre, and the best centre for the shares; no step makes the value
    worse. The load factor is None where it is the value.
    """
    found = solve(limits, ())
    if not split or not limits.own.any() or found.status == Status.UNBOUNDED:
        return found
    half = attempt(solve, limits.shared(0.5 * full_share(limits)), found.path)
    if _is_solved(half):
        worse = found.status == Status.INFEASIBLE or half.status == Status.UNBOUNDED
        found = half if worse or half.value > found.value else found
    for _ in range(ALTERNATIONS):
        if found.status != Status.OPTIMAL:
            break
        at = found.value if load_factor is None else load_factor
        share = best_share(found.limits, found.slip, at, found.radius)
        other = attempt(solve, found.limits.shared(share), found.path)
        if not _is_solved(other):
            break
        gain = inf if other.status == Status.UNBOUNDED else other.value - found.value
        small, found = FOUR_DIGITS * abs(other.value), other if gain > 0 else found
        if gain <= small:
            break
    return found


def _is_solved(found: FoundBall | Missing) -> TypeGuard[FoundBall]:
    return not isinstance(found, Missing) and found.status != Status.INFEASIBLE


def _largest_margin(about: LimitsAbout, y: FloatArray, share: float = 1.0) -> tuple[float, float]:
    """The largest R that the limits leave at y, NaN where they know none, and R − share ‖y‖ [length].

    What a limit leaves is known to round-off only: none that R hardly changes decides by it.
    """
    wide, slack = about.s > 0, about.slack(y) + ROUND_OFF * about.sizes
    radius = float(np.min(slack[wide] / about.s[wide])) if wide.any() else nan
    return radius * about.length, (radius - share * float(np.linalg.norm(y))) * about.length


def _largest_load(about: LimitsAbout, y: FloatArray) -> tuple[float, float]:
    """R = ‖y‖ + δ, relative [length], and the largest λ that the limits allow at y with it."""
    radius = float(np.linalg.norm(y)) + about.offset
    discs, rows = about.left(y, radius)
    row_d = about.base.rows_extra[:, 1]
    load = float(np.min(rows[row_d > 0] / row_d[row_d > 0], initial=inf))
    load = min(load, _last_zero(discs, about.base.extra[:, :, 1]))
    return radius * about.length, load * about.load_unit


def _last_zero(u: FloatArray, d: FloatArray) -> float:
    """The largest λ with |u_1 − λ d_1| ≤ u_0 − λ d_0 in every row; inf where all allow every λ.

    The excess is convex in λ, so that Newton's method comes down to its last zero from above.
    """
    h, fall = u[:, 0], np.hypot(d[:, 1], d[:, 2])
    leaving = fall + d[:, 0] > 0  # beyond this load |u_1 − λ d_1| ≥ λ |d_1| − |u_1| is too large
    load = float(np.min((h + np.hypot(u[:, 1], u[:, 2]))[leaving] / (fall + d[:, 0])[leaving], initial=inf))
    if load == inf:
        return load
    for _ in range(ITERATIONS):
        q, left = u[:, 1:] - load * d[:, 1:], h - load * d[:, 0]
        size = np.hypot(q[:, 0], q[:, 1])
        along = np.einsum("ij,ij->i", q, d[:, 1:]) / np.where(size > 0, size, 1.0)
        slope = d[:, 0] + np.where(size > 0, -along, fall)
        rising = slope > 0
        step = float(np.min((left - size)[rising] / slope[rising], initial=inf))
        if step == inf:
            break
        load += step
        if abs(step) <= CONVERGED * abs(load):
            break
    return load
