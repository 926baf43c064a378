"""Balls with the largest load factor, radius or margin: the best centre, then the best shares, by turns."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, nan
from typing import NamedTuple, TypeGuard

import numpy as np

from shakedown.bounds.discs.scaled_solution import ProvedSolution, balance
from shakedown.bounds.energy.about_slip import LimitsAbout, limits_about
from shakedown.bounds.energy.ball_limits import BallLimits, Places
from shakedown.bounds.energy.proved_solution import proved_solution, solution
from shakedown.ground.constants import (
    ALTERNATIONS,
    FOUR_DIGITS,
    HALVINGS,
    ITERATIONS,
    NEGLIGIBLE,
    PER_CENT,
    ROUND_OFF,
    SETTLED,
    SIX_DIGITS,
    FloatArray,
)
from shakedown.ground.errors import Missing, SolverError, sought
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.program import typical_size
from shakedown.programs.self_dual import Points

INSIDE = 4.0  # margin, in round-offs of a radius, by which a state is in a ball for certain
MOST = 1 - PER_CENT  # largest f |c|: the proof needs less than 1


@dataclass(frozen=True, eq=False)
class Found:
    """The solution of a program with the limits, shares included, that it was made of.

    Attributes
    ----------
    limits
        Limits and shares.
    about
        The limits about the slip that was given.
    end
        How the program ended.
    slip : (dn,)
        The centre [length].
    radius
        Its radius, relative [length].
    value
        The largest load factor, relative radius or margin.
    enough
        Whether this is all that is asked for, however far it is from the optimum.
    """

    limits: BallLimits
    about: LimitsAbout
    end: ProvedSolution
    slip: FloatArray
    radius: float
    value: float
    enough: bool = False

    @property
    def status(self) -> Status:
        """How the program ended."""
        return self.end.status

    @property
    def path(self) -> Points:
        """The points on the way to an optimum; of another end none."""
        return self.end.path if self.status == Status.OPTIMAL else ()

    @cached_property
    def weights(self) -> FloatArray:
        """Multipliers of the radii of discs, and of rows, without dimension, (K + k,)."""
        return np.append(self.end.discs[:, 0], self.end.rows[: len(self.about.row_g)])

    @property
    def carrying(self) -> Places:
        """The discs and rows that the proof rests on."""
        least = NEGLIGIBLE if self.status == Status.OPTIMAL else SIX_DIGITS  # else they are not polished
        return np.flatnonzero(self.weights > least * self.weights.max(initial=0.0))

    @property
    def multipliers(self) -> FloatArray:
        """In the units of the limits, of λ they add up to 1: of all rows, or of the discs that carry."""
        multipliers = self.weights * self.about.unit
        return multipliers[self.carrying] if len(self.about.node) else multipliers

    @property
    def gap(self) -> float:
        """What the multipliers prove not to be exceeded, relative to the value, less 1."""
        value = self.end.value
        return self.end.proved / value - 1.0 if value > 0 else self.end.proved


class BallMargin(NamedTuple):
    """The largest margin of all limits, relative to their sizes, and where: with relative radius."""

    margin: float
    slip: FloatArray
    load_factor: float
    radius: float


Solve = Callable[[BallLimits, Points], Found]  # from the way to the optimum with other shares


def largest_load_factor(
    limits: BallLimits, start: FloatArray, distance: float, tolerances: Tolerances, *, split: bool
) -> Found:
    """The largest load factor at which a ball holds a slip and the distance around it."""

    def solve(each: BallLimits, begun: Points) -> Found:
        about = limits_about(each, start, distance)
        end = proved_solution(about.load_factor_program(), lambda y: _largest_load(about, y), begun)
        return _found(each, about, end, start, end.value)

    def first_shares() -> BallLimits | None:
        """Shares that prove a load factor where neither none nor half of the own parts do; None unknown."""
        loosest = sought(solve, at_least(limits), ())
        if not isinstance(loosest, Missing) and loosest.status == Status.INFEASIBLE:
            return None
        each = limits.shared(0.5 * full_share(limits))
        for _ in range(ALTERNATIONS):
            margin, slip, load_factor, radius = ball_margin(each, start, distance)
            if margin > tolerances.feasibility:
                return each
            each = each.shared(best_share(each, slip, load_factor, radius))
        return None

    return _by_turns(limits, solve, None, split=split, first_shares=first_shares)


def least_load(limits: BallLimits, start: FloatArray, distance: float) -> float:
    """The smallest load factor ≥ 0 at which the same shares have a ball that holds a slip; NaN unknown."""
    about = limits_about(limits, start, distance).reversed()
    end = sought(proved_solution, about.load_factor_program(reverse=True), lambda y: _largest_load(about, y))
    if isinstance(end, Missing) or end.status != Status.OPTIMAL:
        return nan
    return -end.value if -end.value > ROUND_OFF else 0.0


def ball_margin(limits: BallLimits, start: FloatArray, distance: float) -> BallMargin:
    """The largest margin, relative, that all limits leave at any load factor to a ball that holds a slip."""
    about = limits_about(limits, start, distance)
    y, w = _widest(about.widest_program(ball=True))
    load_factor, radius = max(float(w[-2]), 0.0), float(np.linalg.norm(y)) + about.offset
    slip = start + limits.metric.inverse @ y * about.length
    return BallMargin(about.margin(y, load_factor, radius), slip, load_factor, radius * about.length)


def widest(limits: BallLimits, load_factor: float) -> tuple[FloatArray, float]:
    """The slip with the largest margin to all limits, relative, at a load factor; and that margin."""
    about = limits_about(limits, np.zeros(limits.n)).at_load(load_factor)
    y, _ = _widest(about.widest_program(ball=False))
    return limits.metric.inverse @ y * about.length, about.margin(y, 0.0, 0.0)


def _widest(program: DiscProgram) -> tuple[FloatArray, FloatArray]:
    """(y, w) with the largest margin; how large it is there is to be computed anew."""
    end = solution(program)
    if end.status != Status.OPTIMAL:
        raise SolverError(f"the program for the largest margin ended as '{end.status}'")
    return end.x[: program.rank], end.x[program.rank :]


def largest_ball(limits: BallLimits, load_factor: float, *, split: bool) -> Found:
    """The largest ball at a load factor; unbounded where the centre may move away with the radius."""
    start = np.zeros(limits.n)

    def solve(each: BallLimits, begun: Points) -> Found:
        about = limits_about(each, start).at_load(load_factor)
        unit = about.unit_of_radius

        def largest(y: FloatArray) -> FloatArray:
            return np.array([unit * _largest_radius(about, y)])

        end = proved_solution(about.radius_program(inf), largest, begun)
        status = end.status
        if status == Status.UNBOUNDED:
            wide = about.s > 0
            cap = typical_size(np.abs(about.slack(np.zeros_like(end.y)))[wide] / about.s[wide])
            end = proved_solution(about.radius_program(cap), largest)
        end = replace(end, status=status, w=end.w / unit, proved=end.proved / unit)
        return _found(each, about, end, start, end.value * about.length)

    return _by_turns(limits, solve, load_factor, split=split)


def ball_around(
    limits: BallLimits,
    load_factor: float,
    slip: FloatArray,
    tolerances: Tolerances,
    *,
    split: bool,
    best: bool = True,
) -> Found:
    """The ball at a load factor in which a slip has the largest margin R − ‖v − v*‖, of either sign.

    Or, unless the best is asked for, the first one that is met in which that margin is positive; the search
    ends, too, as soon as multipliers prove that none is, whatever the shares.
    """

    def inside(margin: float, radius: float) -> bool:
        return not best and margin > INSIDE * tolerances.feasibility * radius

    def solve(each: BallLimits, begun: Points) -> Found:
        about = limits_about(each, slip).at_load(load_factor)
        unit, program = about.unit_of_radius, about.margin_program()

        def enough(y: FloatArray, multipliers: FloatArray) -> bool:
            if best:
                return False
            length, margin = _largest_margin(about, y)
            held = inside(margin / unit, length + margin / unit)
            return held or _held_by_none(each, about, program, *program.parts(multipliers)[:2])

        end = proved_solution(program, lambda y: _largest_margin(about, y), begun, enough)
        margin = end.value / unit
        end = replace(end, w=np.array([margin + end.w[0], margin]), proved=end.proved / unit)
        found = _found(each, about, end, slip, margin * about.length)
        known = inside(found.value, found.radius)
        if not best and not known:
            known = _held_by_none(each, about, program, end.discs, end.rows)
        return replace(found, enough=known)

    return _by_turns(
        limits, solve, load_factor, split=split,
        refuted=lambda: not best and held_by_none(limits, load_factor, slip),
    )  # fmt: skip


def held_by_none(limits: BallLimits, load_factor: float, slip: FloatArray) -> bool:
    """Whether multipliers prove that no ball at a load factor holds a slip, whatever the shares."""
    least = at_least(limits)
    about = limits_about(least, slip).at_load(load_factor)
    program = about.margin_program()

    def refuted(discs: FloatArray, rows: FloatArray) -> bool:
        return _held_by_none(least, about, program, discs, rows)

    def known(y: FloatArray, multipliers: FloatArray) -> bool:
        return bool(_largest_margin(about, y)[-1] > 0.0) or refuted(*program.parts(multipliers)[:2])

    end = sought(proved_solution, program, lambda y: _largest_margin(about, y), (), known)
    return not isinstance(end, Missing) and refuted(end.discs, end.rows)


def at_least(limits: BallLimits) -> BallLimits:
    """The discs with a = 1 and s = f γ at its least, which allow all that any shares allow."""
    return replace(limits, share=np.zeros_like(limits.share), own=np.zeros_like(limits.own))


def _held_by_none(
    limits: BallLimits, about: LimitsAbout, program: DiscProgram, discs: FloatArray, rows: FloatArray
) -> bool:
    """Whether multipliers for shares zero prove that no ball holds the slip, whatever the shares.

    Any shares have a ≥ 1 and s at least f γ at its least, so what they allow the same discs with that s
    allow. There Σ z · (g − H y − s R) ≥ 0, and R ≥ ‖y‖ where the slip is held: none is where z · g < 0 and
    the length of Hᵀ z is at most s · z.
    """
    if limits.share.any():
        return False
    s = at_least(limits).spread * about.unit * about.length
    weights = np.append(discs[:, 0], rows[: len(about.row_g)])
    right = float(np.einsum("ij,ij", discs, program.right) + rows @ program.rows_right)
    of_y = balance(program, discs, rows)[0]
    return right < 0.0 and float(np.linalg.norm(of_y)) <= float(s @ weights)


def full_share(limits: BallLimits) -> FloatArray:
    """The share at which γ is least, as far as f |c| < 1 allows it."""
    size = limits.f * np.hypot(limits.own[:, 0], limits.own[:, 1])
    return limits.own * np.minimum(1.0, MOST / np.where(size > 0, size, 1.0))[:, None]


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
        return np.asarray((balance > 0) | (size > MOST))

    low, high = np.zeros(len(largest)), np.ones(len(largest))
    whole = ~too_far(high)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        beyond = too_far(middle)
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    c, _ = on_curve(np.where(whole, 1.0, low))
    return np.asarray(np.einsum("ijk,ik->ij", vectors, c))


def _by_turns(
    limits: BallLimits,
    solve: Solve,
    load_factor: float | None,
    *,
    split: bool,
    first_shares: Callable[[], BallLimits | None] = lambda: None,
    refuted: Callable[[], bool] = lambda: False,
) -> Found:
    """Shares zero, and half of those at which γ is least; from the better on by turns.

    The turns: the best shares for the centre, the best centre for the shares. Each starts with what the one
    before allows, so that none is worse. Where neither has a solution, ``first_shares`` are tried; and where
    it is ``refuted`` that any have one that is asked for, none are. The load factor is None where it is the
    value.
    """
    found = solve(limits, ())
    if not split or not limits.own.any() or found.status == Status.UNBOUNDED or found.enough or refuted():
        return found
    half = sought(solve, limits.shared(0.5 * full_share(limits)), found.path)
    if _is_solved(half):
        worse = found.status == Status.INFEASIBLE or half.status == Status.UNBOUNDED
        found = half if worse or half.value > found.value else found
    elif found.status == Status.INFEASIBLE and (shares := first_shares()) is not None:
        other = sought(solve, shares, ())
        found = other if _is_solved(other) else found
    for _ in range(ALTERNATIONS):
        if found.status != Status.OPTIMAL or found.enough:
            break
        at = found.value if load_factor is None else load_factor
        share = best_share(found.limits, found.slip, at, found.radius)
        other = sought(solve, found.limits.shared(share), found.path)
        if not _is_solved(other):
            break
        gain = inf if other.status == Status.UNBOUNDED else other.value - found.value
        small, found = FOUR_DIGITS * abs(other.value), other if gain > 0 else found
        if gain <= small:
            break
    return found


def _is_solved(found: Found | Missing) -> TypeGuard[Found]:
    return not isinstance(found, Missing) and found.status != Status.INFEASIBLE


def _found(
    limits: BallLimits, about: LimitsAbout, end: ProvedSolution, start: FloatArray, value: float
) -> Found:
    slip = start + limits.metric.inverse @ end.y * about.length
    return Found(limits, about, end, slip, float(end.w[0]) * about.length, value)


def _largest_radius(about: LimitsAbout, y: FloatArray) -> float:
    """The largest R that the limits leave at y; NaN where none does."""
    wide, slack = about.s > 0, about.slack(y)
    return float(np.min(slack[wide] / about.s[wide])) if wide.any() else nan


def _largest_margin(about: LimitsAbout, y: FloatArray) -> FloatArray:
    """The largest δ = R − ‖y‖ that the limits leave at y, as w of :meth:`LimitsAbout.margin_program`."""
    length = float(np.linalg.norm(y))
    return np.array([length, (_largest_radius(about, y) - length) * about.unit_of_radius])


def _largest_load(about: LimitsAbout, y: FloatArray) -> FloatArray:
    """R = ‖y‖ + δ and the largest λ that the limits allow at y with it; NaN where none does."""
    radius = float(np.linalg.norm(y)) + about.offset
    need, rows = np.split(radius * about.s, [len(about.node)])
    rows, rising = about.row_g - about.rows @ y - rows, about.row_d > 0
    load = float(np.min(rows[rising] / about.row_d[rising], initial=inf))
    return np.array([radius, min(load, _last_zero(about.discs_at(y), about.d, need))])


def _last_zero(u: FloatArray, d: FloatArray, need: FloatArray) -> float:
    """The largest λ with |u_1 − λ d_1| + need ≤ u_0 − λ d_0 in every row; inf where all allow every λ.

    The excess is convex in λ, so that Newton's method comes down to its last zero from above.
    """
    h, fall = u[:, 0] - need, np.hypot(d[:, 1], d[:, 2])
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
        if abs(step) <= SETTLED * abs(load):
            break
    return load
