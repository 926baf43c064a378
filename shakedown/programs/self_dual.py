"""A program over many small cones by interior points on the self-dual embedding, which proves its ends."""

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

import numpy as np

from shakedown.ground.constants import (
    ITERATIONS,
    MINOR,
    NEGLIGIBLE,
    NEWTON_ROUNDS,
    ROUND_OFF,
    SIX_DIGITS,
    FloatArray,
)
from shakedown.ground.errors import SolverError
from shakedown.ground.status import Status
from shakedown.ground.work_limit import on_one_thread
from shakedown.programs.disc_program import DiscProgram, Scaling, Solve

Step = tuple[FloatArray, FloatArray, FloatArray]  # dx, dy, G dx

REACHED = NEGLIGIBLE / 10  # gap and residuals at which the iteration stops
PROOF_FACTOR = REACHED / NEGLIGIBLE  # of its error: a proof is reached only where it proves something
USABLE = SIX_DIGITS  # the least accuracy where round-off stops it earlier
PATIENCE = 6  # iterations without progress after which round-off has stopped it
REFINEMENTS = 3  # at most, of every solution of the normal equations
STEP = 1 - MINOR  # share of the distance to the boundary


class Point(NamedTuple):
    """An iterate of the embedding: x, slacks and multipliers inside the cones, and its two numbers > 0."""

    x: FloatArray
    s: FloatArray
    y: FloatArray
    tau: float
    kappa: float


Points = tuple[Point, ...]
StopTest = Callable[[FloatArray, FloatArray], bool]  # of x and the multipliers


@dataclass(frozen=True)
class SelfDualSolution:
    """The result of the interior-point method.

    Attributes
    ----------
    status
        Optimal, infeasible, unbounded or undecided.
    x : (N,)
        The solution; for an unbounded program the direction, cᵀ x = −1.
    slack, multipliers : (R,)
        Slacks and multipliers of the rows; for an infeasible program multipliers with hᵀ y = −1.
    accuracy
        The largest of gap and residuals, relative.
    path
        The points on the way, with τ, among them those of another program that it began with.
    """

    status: Status
    x: FloatArray
    slack: FloatArray
    multipliers: FloatArray
    accuracy: float
    path: Points


@on_one_thread
@np.errstate(all="ignore")  # overflow is no solution, and is not taken for one
def solve_discs(
    program: DiscProgram, usable: float = USABLE, earlier: Points = (), enough: StopTest | None = None
) -> SelfDualSolution:
    """The solution of a program: its optimum, or what proves that there is none, to what round-off allows.

    The homogeneous self-dual embedding of Xu, Hung and Ye, with the scaling of Nesterov and Todd and
    the predictor and corrector of Mehrotra. An optimum less accurate than ``usable`` is none.
    ``earlier``, the iterates of a program that differs little, is a warm start as far as they suit this one.
    An iterate, (y, w) and multipliers, at which ``enough`` is true ends the iteration, however inaccurate.

    Raises
    ------
    SolverError
        If it comes to no end.

    Examples
    --------
    The largest w such that (1 − y, w) is within a circle of radius 1 about the origin, and |y| ≤ 0.2:

    >>> program = DiscProgram(
    ...     blocks=np.array([[[0.0], [1.0], [0.0]]]), node=np.array([0]),
    ...     extra=np.array([[[0.0], [0.0], [1.0]]]), right=np.array([[1.0, 1.0, 0.0]]),
    ...     rows=np.array([[1.0], [-1.0]]), rows_extra=np.zeros((2, 1)), rows_right=np.array([0.2, 0.2]),
    ...     cost=np.array([-1.0]),
    ... )
    >>> end = solve_discs(program)
    >>> str(end.status), end.x.round(6)
    ('optimal', array([0.2, 0.6]))
    """
    shared = _shared(program, earlier)
    end = _solved(program, usable, shared, enough)
    if shared and end.status == Status.UNDECIDED:
        end = _solved(program, usable, (), enough)
    if end.status == Status.UNDECIDED:
        raise SolverError(
            f"the program of {len(program.node)} discs ended without an answer, {end.accuracy:.1e} from one"
        )
    return end


def _shared(program: DiscProgram, earlier: Points) -> Points:
    """The iterates up to the last with residuals here small beside its gap; empty where there is none."""
    size_h, size_c = _sizes(program)
    if earlier and (earlier[0].x.shape, earlier[0].s.shape) != (program.costs.shape, program.limits.shape):
        return ()
    for last in range(len(earlier), 0, -1):
        x, s, y, tau, _ = earlier[last - 1]
        short = float(np.linalg.norm(program.times(x) + s - tau * program.limits)) / size_h
        left = float(np.linalg.norm(program.transposed(y) + tau * program.costs)) / size_c
        # such a point of another program serves as a start
        if max(short, left) * tau <= 0.5 * float(s @ y):
            return earlier[:last]
    return ()


def _solved(given: DiscProgram, usable: float, begun: Points, enough: StopTest | None) -> SelfDualSolution:
    (program, to_x, from_x), path = given.in_reactions, list(begun)
    unit = program.cones.unit
    point = path[-1] if path else Point(np.zeros(len(program.costs)), unit, unit, 1.0, 1.0)
    point = point._replace(x=from_x @ point.x)
    seen = program.times(point.x), program.transposed(point.y)
    best, idle = _judged(program, point, *seen), 0
    for _ in range(ITERATIONS):
        # near enough to stop after two iterations without progress
        patience = (
            1 if best.accuracy <= NEGLIGIBLE else PATIENCE - 1 if best.accuracy <= USABLE else 3 * PATIENCE
        )
        if best.accuracy <= REACHED or idle > patience:
            break
        scaling = program.cones.scaling(point.s, point.y)
        if not np.all(np.isfinite(scaling.point)):
            break
        try:
            point = _next(program, point, *seen, scaling)
        except np.linalg.LinAlgError:
            break
        if not (np.isfinite(point.x).all() and point.tau > 0 and point.kappa > 0):
            break
        path.append(point._replace(x=to_x @ point.x))
        seen = program.times(point.x), program.transposed(point.y)
        found = _judged(program, point, *seen)
        x, s, y = (part / point.tau for part in path[-1][:3])
        if enough is not None and enough(x, y):
            return SelfDualSolution(Status.OPTIMAL, x, s, y, found.accuracy, tuple(path))
        idle = 0 if found.accuracy < 0.9 * best.accuracy else idle + 1
        best = found if found.accuracy < best.accuracy else best
    least = usable if best.status == Status.OPTIMAL else USABLE
    status = best.status if best.accuracy <= least else Status.UNDECIDED
    return SelfDualSolution(status, to_x @ best.x, best.slack, best.multipliers, best.accuracy, tuple(path))


@np.errstate(all="ignore")  # what is not finite is no point
def inner_point(program: DiscProgram, end: SelfDualSolution, gap: float) -> Point | None:
    """A point of both programs well inside their cones, without residuals; None where there is none.

    From the point on the way to an optimum that has this mean of slack times multiplier, by Newton's
    method towards the centre there.
    """
    (program, to_x, from_x), cones, h, c = program.in_reactions, program.cones, program.limits, program.costs

    def mean(point: Point) -> float:
        return float(point.s @ point.y) / point.tau**2 / cones.degree

    if end.status != Status.OPTIMAL or not end.path:
        return None
    first = min(end.path, key=lambda point: abs(np.log(max(mean(point), 1e-300) / gap)))
    x, s, y, target = from_x @ first.x / first.tau, first.s / first.tau, first.y / first.tau, mean(first)
    for _ in range(NEWTON_ROUNDS):
        scaling = cones.scaling(s, y)
        centre = scaling.point
        left, short = -(program.transposed(y) + c), h - program.times(x) - s
        rest = max(float(np.abs(left).max()), float(np.abs(short).max()))
        if rest <= ROUND_OFF * max(1.0, float(np.abs(y).max()), float(np.abs(s).max())):
            return Point(to_x @ x, s, y, 1.0, 0.0)
        wanted = cones.quotient(centre, target * cones.unit - cones.product(centre, centre))
        try:
            dx, dy, Gdx = _newton_equations(program, scaling)(left, short - scaling.times(wanted))
        except np.linalg.LinAlgError:
            return None
        ds = short - Gdx
        way = min(1.0, 0.9 * cones.reach_from(s)(ds), 0.9 * cones.reach_from(y)(dy))
        if not np.isfinite(dx).all():
            return None
        x, s, y = x + way * dx, s + way * ds, y + way * dy
    return None


@np.errstate(all="ignore")  # what is not finite is of no use, and is not taken
def balanced_multipliers(program: DiscProgram, end: SelfDualSolution) -> FloatArray:
    """Multipliers with Gᵀ y + c = 0 next to those of an optimum, in the metric of its scaling."""
    (program, *_), y = program.in_reactions, end.multipliers
    scaling = program.cones.scaling(end.slack, y)
    left = program.transposed(y) + program.costs
    try:
        _, dy, _ = _newton_equations(program, scaling)(left, np.zeros_like(y))
    except np.linalg.LinAlgError:
        return np.full_like(y, np.nan)
    return y - dy


def _judged(program: DiscProgram, point: Point, Gx: FloatArray, Gy: FloatArray) -> SelfDualSolution:
    """The point, with G x and Gᵀ y, as an optimum or as a proof of none, whichever it is nearer to."""
    x, s, y, tau = point.x, point.s, point.y, point.tau
    h, c = program.limits, program.costs
    size_h, size_c = _sizes(program)
    value, proved = float(c @ x), float(h @ y)
    gap = float(s @ y) / tau / max(abs(value), abs(proved), tau * USABLE)
    short = float(np.linalg.norm(Gx + s - tau * h)) / tau / size_h
    left = float(np.linalg.norm(Gy + tau * c)) / tau / size_c
    ends = [SelfDualSolution(Status.OPTIMAL, x / tau, s / tau, y / tau, max(gap, short, left), ())]
    if proved < 0:
        balance = float(np.linalg.norm(Gy)) / -proved * size_h
        ends.append(SelfDualSolution(Status.INFEASIBLE, x, s, y / -proved, balance * PROOF_FACTOR, ()))
    if value < 0:
        beyond = float(np.linalg.norm(Gx + s)) / -value * size_c
        ends.append(SelfDualSolution(Status.UNBOUNDED, x / -value, s / -value, y, beyond * PROOF_FACTOR, ()))
    return min(ends, key=lambda end: end.accuracy if np.isfinite(end.accuracy) else np.inf)


def _sizes(program: DiscProgram) -> tuple[float, float]:
    """The scales of the residuals of slacks and of multipliers."""
    return max(1.0, float(np.linalg.norm(program.limits))), max(1.0, float(np.linalg.norm(program.costs)))


def _next(program: DiscProgram, point: Point, Gx: FloatArray, Gy: FloatArray, scaling: Scaling) -> Point:
    """One step of Mehrotra's predictor and corrector."""
    cones, centre = program.cones, scaling.point
    x, s, y, tau, kappa = point
    h, c = program.limits, program.costs
    both = _newton_equations(program, scaling)
    left, short = -(Gy + tau * c), tau * h - Gx - s
    lost = -(kappa + float(c @ x) + float(h @ y))

    x1, y1, G1 = both(-c, h)
    slope = float(c @ x1) + float(h @ y1) - kappa / tau

    def step(share: float, target: FloatArray, target_tau: float) -> Point:
        """All residuals reduced by a share, slack ∘ multiplier and τ κ to their targets; s and y scaled."""
        wanted = cones.quotient(centre, target)
        x2, y2, G2 = both(share * left, share * short - scaling.times(wanted))
        dtau = (share * lost - target_tau / tau - float(c @ x2) - float(h @ y2)) / slope
        dx, dy = x2 + dtau * x1, scaling.times(y2 + dtau * y1)
        ds = scaling.divided(share * short + dtau * (h - G1) - G2)
        return Point(dx, ds, dy, dtau, (target_tau - kappa * dtau) / tau)

    def length(d: Point) -> float:
        ends = [-now / way for now, way in ((tau, d.tau), (kappa, d.kappa)) if way < 0]
        return min(1.0, *(STEP * end for end in ends), STEP * reach(d.s), STEP * reach(d.y))

    reach, square = cones.reach_from(centre), cones.product(centre, centre)
    ahead = step(1.0, -square, -tau * kappa)
    sigma = (1.0 - length(ahead)) ** 3
    mean = (float(s @ y) + tau * kappa) / (cones.degree + 1)
    corrected = sigma * mean * cones.unit - square - cones.product(ahead.s, ahead.y)
    d = step(1.0 - sigma, corrected, sigma * mean - tau * kappa - ahead.tau * ahead.kappa)
    way = length(d)
    return Point(
        x + way * d.x,
        s + way * scaling.times(d.s),
        y + way * scaling.divided(d.y),
        tau + way * d.tau,
        kappa + way * d.kappa,
    )


def _newton_equations(program: DiscProgram, scaling: Scaling) -> Callable[[FloatArray, FloatArray], Step]:
    """dx, dy of Gᵀ dy = first and G dx − W² dy = second, and G dx.

    By the normal equations, or by an orthogonal factor where round-off leaves them not definite.
    """
    try:
        solve = program.normal_equations(scaling)
    except np.linalg.LinAlgError:
        solve = program.orthogonal_factor(scaling)
    return lambda first, second: _refined(program, scaling, solve, first, second)


def _refined(
    program: DiscProgram, scaling: Scaling, solve: Solve, first: FloatArray, second: FloatArray
) -> Step:
    """dx, dy and G dx, refined by conjugate gradients with a factor.

    dy is summed up along with dx, so that its balance is not lost where W⁻² spans many orders.
    """
    right = first + program.transposed(scaling.divided(scaling.divided(second)))
    dx = solve(right)
    Gdx = program.times(dx)
    dy = scaling.divided(scaling.divided(Gdx - second))
    enough, way, last = ROUND_OFF * sqrt(right @ right), np.zeros_like(dx), 1.0
    for _ in range(REFINEMENTS):
        rest = first - program.transposed(dy)
        if not sqrt(rest @ rest) > enough:
            break
        ahead = solve(rest)
        slope = float(rest @ ahead)
        way, last = ahead + slope / last * way, slope
        Gway = program.times(way)
        along = scaling.divided(Gway)
        across = float(along @ along)
        length = slope / across if slope and across else np.inf  # zero slope: the rest is round-off
        if not np.isfinite(length):
            break
        dx, dy, Gdx = dx + length * way, dy + length * scaling.divided(along), Gdx + length * Gway
    return dx, dy, Gdx
