"""Centre and shares by turns: the best centre for given shares, the best shares for that centre."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, nan
from typing import NamedTuple

import numpy as np

from shakedown.bounds.discs.scaled_solution import ProvedSolution, balance, proved_solution
from shakedown.bounds.energy.about_slip import DiscsAbout, discs_about
from shakedown.bounds.energy.ball_limits import DiscLimits, Places
from shakedown.bounds.energy.own_share import MOST, best_share
from shakedown.ground.errors import Missing, SolverError, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import ALTERNATIONS, FOUR_DIGITS, ITERATIONS, NEGLIGIBLE
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.disc_solver import DiscSolution, solved
from shakedown.programs.scaling import typical_size
from shakedown.programs.self_dual import Points

INSIDE = 4.0  # margin, in round-offs of a radius, by which a state is in a ball for certain
ROUND_OFF = 4 * np.finfo(float).eps


@dataclass(frozen=True, eq=False)
class Found:
    """The solution of a program with the limits, shares included, that it was made of.

    Attributes
    ----------
    limits
        Limits and shares.
    about
        The discs about the slip that was given.
    end
        How the program ended.
    slip : (n,)
        The centre [length].
    radius
        Its radius, relative [length].
    """

    limits: DiscLimits
    about: DiscsAbout
    end: ProvedSolution
    slip: FloatArray
    radius: float

    @property
    def status(self) -> Status:
        """How the program ended."""
        return self.end.status

    @property
    def way(self) -> Points:
        """The points on the way to an optimum; of another end none."""
        return self.end.path if self.status == Status.OPTIMAL else ()

    @property
    def carrying(self) -> Places:
        """The discs and gaps that the proof rests on."""
        weights = self._weights
        return np.flatnonzero(weights > NEGLIGIBLE * weights.max(initial=0.0))

    @property
    def multipliers(self) -> FloatArray:
        """Those of ``carrying``, of the radii of discs, in the units of the limits; of λ they add up to 1."""
        return (self._weights * np.append(self.about.unit[self.about.node], self.about.row_unit))[
            self.carrying
        ]

    @property
    def _weights(self) -> FloatArray:
        return np.append(self.end.discs[:, 0], self.end.rows[: len(self.about.row_g)])

    @property
    def gap(self) -> float:
        """What the multipliers prove not to be exceeded, relative to the value, less 1."""
        value = self.end.value
        return self.end.proved / value - 1.0 if value > 0 else self.end.proved

    def excess(self, load_factor: float) -> float:
        """The largest violation of a limit at the centre, relative to its terms."""
        excess = -self.limits.slack(self.slip, load_factor, self.radius)
        return float(np.max(excess / self.limits.sizes(self.slip, load_factor, self.radius)))

    def contradiction(self) -> float:
        """By how much multipliers fail to prove that the limits contradict each other (Farkas)."""
        end, about = self.end, self.about
        program = about.load_factor_program()
        value = -float(np.einsum("ij,ij", end.discs, program.right) + end.rows @ program.rows_right)
        of_y, of_w = balance(program, end.discs, end.rows)
        weight = 0.0 if program.norm is None else float(of_w[0])
        value += weight * about.offset
        if not value > 0:
            return inf
        sizes = float(np.einsum("ij,ij", np.abs(end.discs), np.abs(program.right))) or 1.0
        return max(float(np.linalg.norm(of_y)) - weight, abs(float(of_w[-1])), 0.0) / max(sizes, value)


class BallMargin(NamedTuple):
    """The largest margin of all limits, relative to their sizes, and where: with relative radius."""

    margin: float
    slip: FloatArray
    load_factor: float
    radius: float


Solve = Callable[[DiscLimits, Points], Found]  # from the way to the optimum with other shares


def largest_load_factor(
    limits: DiscLimits, start: FloatArray, distance: float, tolerances: Tolerances, *, split: bool
) -> Found:
    """The largest load factor at which a ball holds a slip and the distance around it."""

    def one(each: DiscLimits, begun: Points = ()) -> Found:
        about = discs_about(each, start, distance)
        end = proved_solution(about.load_factor_program(), lambda y: _largest_load(about, y), begun)
        return _found(each, about, end, start)

    def margin(each: DiscLimits) -> BallMargin:
        return ball_margin(each, start, distance)

    return _by_turns(limits, one, lambda found: found.end.value, margin, tolerances, split=split)


def least_load(limits: DiscLimits, start: FloatArray, distance: float) -> float:
    """The smallest load factor ≥ 0 at which the same shares have a ball that holds a slip; NaN unknown."""
    about = discs_about(limits, start, distance).reversed()
    end = sought(proved_solution, about.load_factor_program(reverse=True), lambda y: _largest_load(about, y))
    if isinstance(end, Missing) or end.status != Status.OPTIMAL:
        return nan
    return max(0.0, -end.value)


def ball_margin(limits: DiscLimits, start: FloatArray, distance: float) -> BallMargin:
    """The largest margin, relative, that all limits leave at any load factor to a ball that holds a slip."""
    about = discs_about(limits, start, distance)
    return _margin_about(limits, about, start)


def _margin_about(limits: DiscLimits, about: DiscsAbout, start: FloatArray) -> BallMargin:
    end = _widest(about, ball=True)
    load_factor, radius = max(float(end.w[-2]), 0.0), float(np.linalg.norm(end.y)) + about.offset
    slip = start + limits.metric.inverse @ end.y * about.length
    return BallMargin(about.margin(end.y, load_factor, radius), slip, load_factor, radius * about.length)


def _widest(about: DiscsAbout, *, ball: bool) -> DiscSolution:
    """Where the largest margin is; how large it is there is to be computed anew."""
    end = solved(about.widest_program(ball=ball), FOUR_DIGITS)
    if end.status != Status.OPTIMAL:
        raise SolverError(f"the program for the largest margin ended as '{end.status}'")
    return end


def largest(limits: DiscLimits, load_factor: float, tolerances: Tolerances, *, split: bool) -> Found:
    """The largest ball at a load factor; unbounded where the centre may move away with the radius."""
    start = np.zeros(limits.n)

    def one(each: DiscLimits, begun: Points = (), cap: float = inf) -> Found:
        about = discs_about(each, start).at_load(load_factor)
        unit = about.unit_of_radius
        program = about.radius_program(cap)
        end = proved_solution(program, lambda y: np.array([unit * _largest_radius(about, y)]), begun)
        end = replace(end, w=end.w / unit, proved=end.proved / unit)
        if end.status == Status.UNBOUNDED and cap == inf:
            slack, wide = about.slack(np.zeros_like(end.y)), about.all_s > 0
            wider = one(each, cap=typical_size(np.abs(slack)[wide] / about.all_s[wide]))
            return replace(wider, end=replace(wider.end, status=Status.UNBOUNDED))
        return _found(each, about, end, start)

    return _by_turns(
        limits,
        one,
        lambda found: found.end.value * found.about.length,
        None,
        tolerances,
        split=split,
        load_factor=load_factor,
    )


def holding(
    limits: DiscLimits,
    load_factor: float,
    state: FloatArray,
    tolerances: Tolerances,
    *,
    split: bool,
    best: bool,
) -> Found:
    """The ball at a load factor in which a state has the largest margin R − ‖v − v*‖, of either sign.

    Or, unless the best is asked for, the first one that is met in which that margin is positive; the search
    ends, too, as soon as multipliers prove that none is, whatever the shares.
    """

    def inside(margin: float, radius: float) -> bool:
        return not best and margin > INSIDE * tolerances.feasibility * radius

    def one(each: DiscLimits, begun: Points = ()) -> Found:
        about = discs_about(each, state).at_load(load_factor)
        unit, program = about.unit_of_radius, about.margin_program()

        def enough(y: FloatArray, multipliers: FloatArray) -> bool:
            if best:
                return False
            length, margin = _largest_margin(about, y)
            discs, rows, _ = program.parts(multipliers)
            return inside(margin / unit, length + margin / unit) or _held_by_none(
                each, about, program, discs, rows
            )

        end = proved_solution(program, lambda y: _largest_margin(about, y), begun, enough)
        margin = end.value / unit
        end = replace(end, w=np.array([margin + end.w[0], margin]), proved=end.proved / unit)
        return _found(each, about, end, state)

    def value(found: Found) -> float:
        return found.end.value * found.about.length

    def known(found: Found) -> bool:
        held = inside(value(found), found.radius)
        if held or best:
            return held
        about, end, alone = found.about, found.end, not found.limits.share.any()
        return _held_by_none(found.limits, about, about.margin_program(), end.discs, end.rows) or (
            split and alone and held_by_none(limits, load_factor, state)
        )

    return _by_turns(limits, one, value, None, tolerances, split=split, load_factor=load_factor, enough=known)


def held_by_none(limits: DiscLimits, load_factor: float, state: FloatArray) -> bool:
    """Whether multipliers prove that no ball at a load factor holds a state, whatever the shares."""
    least = at_least(limits)
    about = discs_about(least, state).at_load(load_factor)
    program = about.margin_program()

    def refuted(discs: FloatArray, rows: FloatArray) -> bool:
        return _held_by_none(least, about, program, discs, rows)

    def known(y: FloatArray, multipliers: FloatArray) -> bool:
        return bool(_largest_margin(about, y)[-1] > 0.0) or refuted(*program.parts(multipliers)[:2])

    end = sought(proved_solution, program, lambda y: _largest_margin(about, y), (), known)
    return not isinstance(end, Missing) and refuted(end.discs, end.rows)


def at_least(limits: DiscLimits) -> DiscLimits:
    """The discs with a = 1 and s = f γ at its least, which allow all that any shares allow."""
    return replace(limits, share=np.zeros_like(limits.share), own=np.zeros_like(limits.own))


def _held_by_none(
    limits: DiscLimits, about: DiscsAbout, program: DiscProgram, discs: FloatArray, rows: FloatArray
) -> bool:
    """Whether multipliers for shares zero prove that no ball holds the slip, whatever the shares.

    Any shares have a ≥ 1 and s at least f γ at its least, so what they allow the same discs with that s
    allow. There Σ z · (g − H y − s R) ≥ 0, and R ≥ ‖y‖ where the slip is held: none is where z · g < 0 and
    the length of Hᵀ z is at most s · z.
    """
    if limits.share.any():
        return False
    least = limits.f * limits.least * about.unit * about.length
    right = float(np.einsum("ij,ij", discs, program.right) + rows @ program.rows_right)
    weight = float(least[about.node] @ discs[:, 0] + about.row_s @ rows[: len(about.row_s)])
    of_y = balance(program, discs, rows)[0]
    return right < 0.0 and float(np.linalg.norm(of_y)) <= weight


def widest(limits: DiscLimits, load_factor: float) -> tuple[FloatArray, float]:
    """The slip with the largest margin to all limits, relative, at a load factor; and that margin."""
    about = discs_about(limits, np.zeros(limits.n)).at_load(load_factor)
    y = _widest(about, ball=False).y
    return limits.metric.inverse @ y * about.length, about.margin(y, 0.0, 0.0)


def full_share(limits: DiscLimits) -> FloatArray:
    """The share at which γ is least, as far as f |c| < 1 allows it."""
    size = limits.f * np.hypot(limits.own[:, 0], limits.own[:, 1])
    return limits.own * np.minimum(1.0, MOST / np.where(size > 0, size, 1.0))[:, None]


def _by_turns(
    limits: DiscLimits,
    one: Solve,
    value: Callable[[Found], float],
    margin: Callable[[DiscLimits], BallMargin] | None,
    tolerances: Tolerances,
    *,
    split: bool,
    load_factor: float | None = None,
    enough: Callable[[Found], bool] = lambda found: False,
) -> Found:
    """Shares zero, and half of those at which γ is least; from the better on by turns.

    The turns: the best shares for the centre, the best centre for the shares. Each starts with what the one
    before allows, so that none is worse. Where neither has a solution, the one of larger margin goes on.
    """
    found = one(limits, ())
    if not split or not limits.own.any() or found.status == Status.UNBOUNDED or enough(found):
        return found
    half = sought(one, limits.shared(0.5 * full_share(limits)), found.way)
    if not isinstance(half, Missing) and half.status != Status.INFEASIBLE:
        worse = found.status == Status.INFEASIBLE or half.status == Status.UNBOUNDED
        found = half if worse or value(half) > value(found) else found
    elif found.status == Status.INFEASIBLE and margin is not None:
        found = _first_solution(limits, one, margin, tolerances) or found
    return _turns(found, one, value, load_factor, enough)


def _turns(
    found: Found,
    one: Solve,
    value: Callable[[Found], float],
    load_factor: float | None,
    enough: Callable[[Found], bool],
) -> Found:
    """Rounds from a solution on, until they gain little."""
    for _ in range(ALTERNATIONS):
        if found.status != Status.OPTIMAL or enough(found):
            break
        at = found.end.value if load_factor is None else load_factor
        share = best_share(found.limits, found.slip, at, found.radius)
        other = sought(one, found.limits.shared(share), found.way)
        if isinstance(other, Missing) or other.status == Status.INFEASIBLE:
            break
        gain = inf if other.status == Status.UNBOUNDED else value(other) - value(found)
        if gain <= 0:
            break
        found = other
        if gain <= FOUR_DIGITS * abs(value(found)):
            break
    return found


def _first_solution(
    limits: DiscLimits,
    one: Solve,
    margin_of: Callable[[DiscLimits], BallMargin],
    tolerances: Tolerances,
) -> Found | None:
    """A solution with shares other than zero, None where none is found, or there is none for any shares."""
    loosest = sought(one, at_least(limits), ())
    if not isinstance(loosest, Missing) and loosest.status == Status.INFEASIBLE:
        return None
    each = limits.shared(0.5 * full_share(limits))
    for _ in range(ALTERNATIONS):
        margin, slip, load_factor, radius = margin_of(each)
        if margin > tolerances.feasibility:
            found = sought(one, each, ())
            return None if isinstance(found, Missing) or found.status == Status.INFEASIBLE else found
        each = each.shared(best_share(each, slip, load_factor, radius))
    return None


def _found(limits: DiscLimits, about: DiscsAbout, end: ProvedSolution, start: FloatArray) -> Found:
    slip = start + limits.metric.inverse @ end.y * about.length
    return Found(limits, about, end, slip, float(end.w[0]) * about.length)


def _largest_radius(about: DiscsAbout, y: FloatArray) -> float:
    """The largest R that the limits leave at y; NaN where none does."""
    wide, slack = about.all_s > 0, about.slack(y)
    return float(np.min(slack[wide] / about.all_s[wide])) if wide.any() else nan


def _largest_margin(about: DiscsAbout, y: FloatArray) -> FloatArray:
    """The largest δ = R − ‖y‖ that the limits leave at y, as w of :meth:`DiscsAbout.margin_program`."""
    length = float(np.linalg.norm(y))
    return np.array([length, (_largest_radius(about, y) - length) * about.unit_of_radius])


def _largest_load(about: DiscsAbout, y: FloatArray) -> FloatArray:
    """R = ‖y‖ + δ and the largest λ that the limits allow at y with it; NaN where none does.

    The excess of a disc is convex in λ: the first step of Newton's method ends above its last zero, and the
    others come down to it.
    """
    radius = float(np.linalg.norm(y)) + about.offset
    at_zero, need = about.discs_at(y, 0.0), radius * about.disc_s
    rows = about.row_g - about.rows @ y - radius * about.row_s
    rising = about.row_d > 0
    load = float(np.min(rows[rising] / about.row_d[rising], initial=inf))
    load = min(load, _last_zero(at_zero, about.d, need))
    return np.array([radius, load])


def _last_zero(u: FloatArray, d: FloatArray, need: FloatArray) -> float:
    """The largest λ with |u_1 − λ d_1| + need ≤ u_0 − λ d_0 in every row; inf where all allow every λ."""
    # The last zero of |q|² − h², with q = u_1 − λ d_1 and h = u_0 − need − λ d_0: a λ² − 2 b λ + c.
    h, fall = u[:, 0] - need, np.hypot(d[:, 1], d[:, 2])
    a = (fall - d[:, 0]) * (fall + d[:, 0])
    b = np.einsum("ij,ij->i", u[:, 1:], d[:, 1:]) - h * d[:, 0]
    c = np.einsum("ij,ij->i", u[:, 1:], u[:, 1:]) - h**2
    with np.errstate(all="ignore"):
        root = np.sqrt(np.maximum(b * b - a * c, 0.0))
        last = np.where(b >= 0, (b + root) / a, c / (b - root))
    leaving = (fall + d[:, 0] > 0) & ~np.isnan(last)
    load = float(np.min(last[leaving], initial=inf))
    if load == inf:
        return load
    for _ in range(ITERATIONS):  # the root of a small difference may lack half the digits
        q, left = u[:, 1:] - load * d[:, 1:], h - load * d[:, 0]
        size = np.hypot(q[:, 0], q[:, 1])
        along = np.einsum("ij,ij->i", q, d[:, 1:]) / np.where(size > 0, size, 1.0)
        slope = d[:, 0] + np.where(size > 0, -along, fall)
        rising = slope > 0
        step = float(np.min((left - size)[rising] / slope[rising], initial=inf))
        if step == inf:
            break
        load += step
        if abs(step) <= ROUND_OFF * abs(load):
            break
    return load
