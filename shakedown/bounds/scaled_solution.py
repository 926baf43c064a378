"""The program of λ_max in space, scaled and solved, and that of the safest slip."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from shakedown.bounds.disc_rows import DiscRows, disc_rows
from shakedown.ground.constants import (
    CONE,
    FOUR_DIGITS,
    ITERATIONS,
    NEGLIGIBLE,
    NEWTON_ROUNDS,
    NOTABLE,
    ROUND_OFF,
    SIX_DIGITS,
    FloatArray,
)
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import on_one_thread
from shakedown.joint.problem import Problem
from shakedown.programs.disc_program import DiscProgram, Solve
from shakedown.programs.program import exact_products, median_size
from shakedown.programs.self_dual import USABLE, SelfDualSolution, balanced_multipliers, solve_discs
from shakedown.programs.simplex import chebyshev_centre

Limits = tuple[NDArray[np.intp], NDArray[np.intp]]  # numbers of discs and of half-spaces


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
    active_limits
        The discs and half-spaces that determine it: those with a multiplier, in numbers near 1.
    reduced_accuracy
        Whether gap or residuals are larger than usual.
    scaled, scaled_solution
        The program in numbers near 1, and its solution.
    """

    status: Status
    x: FloatArray
    load_factor: float
    y: FloatArray
    z: FloatArray
    active_limits: Limits
    reduced_accuracy: bool
    scaled: "ScaledDiscs" = field(repr=False)
    scaled_solution: SelfDualSolution = field(repr=False)

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
    row_scales : (n + o,)
        What the rows of a node, or a half-space, were multiplied by.
    unit
        Scale of the slacks, in the units of these rows.
    load_unit
        Scale of the last unknown.
    """

    program: DiscProgram
    rows: DiscRows
    origin: FloatArray
    row_scales: FloatArray
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
        discs, others, _ = self.program.cones.parts(y)
        factor = self.row_scales * (self.load_unit / self.unit)
        gaps = len(self.row_scales) - n
        return discs * factor[:n][self.program.node][:, None], others[:gaps] * factor[n:]


def scaled_discs(rows: DiscRows, towards: float, cap: float = np.inf) -> ScaledDiscs:
    """The program of the largest (towards −1) or smallest (+1) last unknown ≥ 0, at most ``cap``."""
    rows, origin = without_mean(rows)
    basis = rows.basis
    n, K = len(rows.stiffness), basis.Q.shape[1]
    Q = basis.Q[: CONE * n].reshape(n, CONE, K)
    lengths = np.append(np.linalg.norm(Q, axis=(1, 2)), np.linalg.norm(basis.Q[3 * n :], axis=1))
    of_nodes = np.zeros(n)
    np.maximum.at(of_nodes, rows.node, np.maximum(np.abs(rows.c), np.abs(rows.e)).max(axis=1))
    loads = np.append(of_nodes, np.maximum(np.abs(rows.half_spaces.g), np.abs(rows.half_spaces.d)))
    first = 1.0 / np.where(basis.sizes > 0, basis.sizes, 1.0)
    moved = lengths > 0
    second = 1.0 / np.where(moved, lengths, 1.0)
    heights = loads * first * second
    # A row that no slip changes has no length of its own: it stands as high as the others do, in any units.
    constant = ~moved & (heights > 0)
    second[constant] *= (median_size(heights[moved]) or 1.0) / heights[constant]
    heights = loads * first * second
    # times the median of loads: no row is kept farther from its limit than that
    most = median_size(heights) / SIX_DIGITS
    second[heights > most] *= most / heights[heights > most]
    scales = first * second
    of_discs = scales[:n][rows.node][:, None]
    C, E = rows.c * of_discs, rows.e * of_discs
    gap_c, gap_e = rows.half_spaces.g * scales[n:], rows.half_spaces.d * scales[n:]
    changes = np.append(np.linalg.norm(E, axis=1), np.abs(gap_e))
    # a load that varies by round-off, or by its last printed digit, says nothing of the size of load factors
    vary = changes > SIX_DIGITS * (loads * scales)[np.append(rows.node, np.arange(n, len(loads)))]
    varying = median_size(changes[vary]) or median_size(changes)
    unit = median_size(np.append(np.linalg.norm(C, axis=1), np.abs(gap_c))) or varying or 1.0
    load_unit = unit / (varying or unit)
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
    )
    return ScaledDiscs(program, rows, origin, scales, unit, load_unit)


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
        if not np.abs(rest[:, 1:]).max() < NOTABLE * np.abs(before[:, 1:]).max():
            break
    near = replace(H, g=left(-H.coefficients, H.g))
    return rows.under(c=rest[rows.node] + (rows.c - mean[rows.node]), half_spaces=near), np.sum(parts, axis=0)


NEGATIVE = 10 * ROUND_OFF  # largest slack or multiplier below zero likewise
PROXIMITY = 100 * ROUND_OFF  # regularisation of slips left free by active limits, and of redundant limits


@dataclass(frozen=True, eq=False)
class _Active:
    """The limits that meet: linear rows, discs at their edge or apex, the bound of the length."""

    linear: NDArray[np.intp]
    edge: NDArray[np.intp]
    apex: NDArray[np.intp]
    norm: bool


def solve_scaled(scaled: ScaledDiscs, usable: float = USABLE, *, proves: bool = True) -> UnscaledSolution:
    """Solve a program, polish its optimum, in units of the joint; one less accurate than ``usable`` is none.

    Where its multipliers are to prove nothing, they balance as well as the interior points have left them.

    Raises
    ------
    SolverError
        If it comes to no end.
    """
    end = polished(scaled.program, solve_discs(scaled.program, usable), proves=proves)
    y, z = scaled.multipliers(end.multipliers)
    x, load_factor = scaled.slips(end.x), float(end.x[-1] * scaled.load_unit)
    if end.status == Status.UNBOUNDED:  # per load factor
        x, load_factor = scaled.changes(end.x) / load_factor, 1.0
    elif load_factor <= ROUND_OFF * scaled.load_unit:
        load_factor = 0.0
    if end.status == Status.INFEASIBLE:
        x, load_factor = np.full(len(x), np.nan), np.nan
        size = -float(np.vdot(y, scaled.rows.c) + z @ scaled.rows.half_spaces.g)
        y, z = y / size, z / size
    discs, others, _ = scaled.program.cones.parts(end.multipliers)
    weights, others = discs[:, 0], others[: len(z)]
    least = NEGLIGIBLE * max(weights.max(initial=0.0), others.max(initial=0.0))
    active = np.flatnonzero(weights > least), np.flatnonzero(others > least)
    return UnscaledSolution(end.status, x, load_factor, y, z, active, end.accuracy > NEGLIGIBLE, scaled, end)


@on_one_thread
def polished(program: DiscProgram, end: SelfDualSolution, *, proves: bool = True) -> SelfDualSolution:
    """An optimum to round-off; what was given where the limits that meet in it are not clear.

    Equations: every active limit holds with equality, the multipliers balance. A disc is active where
    its slack is smaller than its multiplier, at its apex where all of its slack is.
    """
    if end.status != Status.OPTIMAL or not end.path:
        return end
    best, left, last = end, _residual(program, end), end.path[-1]
    final = replace(end, slack=last.s / last.tau, multipliers=last.y / last.tau)
    # of the last iterate, which is nearer to the limits that meet, and of the best, with
    # ratios of slack to multiplier up to which a limit counts as active
    for near, alike in ((final, 1.0), (end, 1e2)):
        with np.errstate(all="ignore"):  # what is not finite is not taken
            found = _newton(program, end, _active(program, near, alike))
        rest = _residual(program, found) if found is not None else np.inf
        if found is not None and rest < left:
            best, left = replace(found, accuracy=min(end.accuracy, rest)), rest
        if left <= NEGATIVE:
            return best
    if best is end and proves:
        y = balanced_multipliers(program, end)
        return replace(end, multipliers=y) if program.cones.margin(y) > 0 else end
    return best


def _active(program: DiscProgram, end: SelfDualSolution, alike: float) -> _Active:
    (s, slack, _), (y, weight, _) = program.cones.parts(end.slack), program.cones.parts(end.multipliers)
    length_s, length_y = np.hypot(s[:, 1], s[:, 2]), np.hypot(y[:, 1], y[:, 2])
    active = s[:, 0] - length_s < alike * (y[:, 0] + length_y)
    apex = s[:, 0] + length_s < alike * (y[:, 0] - length_y)
    linear = np.flatnonzero(slack < alike * weight)
    norm = program.norm is not None and bool(np.any(end.x[: program.rank]))
    return _Active(linear, np.flatnonzero(active & ~apex), np.flatnonzero(apex), norm)


def _residual(program: DiscProgram, end: SelfDualSolution) -> float:
    """The largest of what is left of the balance, slacks and multipliers below zero, and the gap."""
    slack = program.limits - program.times(end.x)
    balance = np.abs(program.transposed(end.multipliers) + program.costs).max()
    outside = max(-program.cones.margin(slack), -program.cones.margin(end.multipliers), 0.0)
    gap = abs(float(slack @ end.multipliers)) / max(abs(float(program.costs @ end.x)), SIX_DIGITS)
    found = max(balance, outside, gap)
    return float(found) if np.isfinite(found) else np.inf


def _newton(program: DiscProgram, end: SelfDualSolution, active: _Active) -> SelfDualSolution | None:
    """The end from Newton's method on the equations; None where it does not converge."""
    x, (triples, others, tail) = end.x, program.cones.parts(end.multipliers)
    m = np.concatenate(
        [others[active.linear], triples[active.edge, 0], triples[active.apex].ravel(), tail[: active.norm]]
    )
    best, reached, solve = None, np.inf, None
    for _ in range(NEWTON_ROUNDS):
        found = _ended(program, end, active, x, m)
        balance = program.transposed(found.multipliers) + program.costs
        left = np.append(balance, _missing(program, active, found))
        size, before = float(np.abs(left).max()), reached
        if not np.isfinite(size) or size > 0.5 * before:
            break
        best, reached = found, size
        if size <= ROUND_OFF * 1e-2:
            break
        if solve is None or size > NOTABLE * before:  # else the last factor gains a digit once more
            solve = _factor(program, active, found, m)
        step = solve(left)
        x, m = x - step[: len(x)], m + step[len(x) :]
    return best


def _missing(program: DiscProgram, active: _Active, found: SelfDualSolution) -> FloatArray:
    """The slacks of the active limits."""
    s, linear, tail = program.cones.parts(found.slack)
    u, length = s[active.edge], np.linalg.norm(tail[1:])
    edges, norm = u[:, 0] - np.hypot(u[:, 1], u[:, 2]), (tail[:1] - length)[: active.norm]
    return np.concatenate([linear[active.linear], edges, s[active.apex].ravel(), norm])


def _factor(program: DiscProgram, active: _Active, found: SelfDualSolution, m: FloatArray) -> Solve:
    """What solves for a change of x and multipliers m: curvature and slopes of the active limits."""
    s, *_ = program.cones.parts(found.slack)
    weights, r, size = m[len(active.linear) :][: len(active.edge)], program.rank, len(found.x)
    slopes, bends = program.edges(active.edge, s[active.edge], weights)
    at_apex = program.columns(active.apex).reshape(-1, size)
    J = -np.vstack([np.hstack([program.rows, program.rows_extra])[active.linear], slopes, at_apex])
    matrix = np.diag(np.repeat([PROXIMITY, -PROXIMITY], [size, len(m)])).T
    matrix[:size, :size] += bends.T @ bends
    if active.norm and program.norm is not None:
        length = float(np.linalg.norm(found.x[:r]))
        towards = found.x[:r] / length
        matrix[:r, :r] += m[-1] / length * (np.eye(r) - np.outer(towards, towards))
        J = np.vstack([J, np.append(-towards, program.norm)])
    matrix[size:, :size], matrix[:size, size:] = J, J.T
    factor, pivots, _ = lapack.dgetrf(matrix, overwrite_a=1)
    return lambda right: np.asarray(lapack.dgetrs(factor, pivots, right)[0])


def _ended(
    program: DiscProgram, end: SelfDualSolution, active: _Active, x: FloatArray, m: FloatArray
) -> SelfDualSolution:
    slack, y = program.limits - program.times(x), np.zeros(len(program.limits))
    (s, *_), (triples, others, tail) = program.cones.parts(slack), program.cones.parts(y)
    a, b = len(active.linear), len(active.linear) + len(active.edge)
    c = b + CONE * len(active.apex)
    others[active.linear] = m[:a]
    normal = s[active.edge, 1:] / np.hypot(s[active.edge, 1], s[active.edge, 2])[:, None]
    triples[active.edge] = m[a:b, None] * np.column_stack([np.ones(len(normal)), -normal])
    triples[active.apex] = m[b:c].reshape(-1, CONE)
    if active.norm:
        towards = x[: program.rank] / np.linalg.norm(x[: program.rank])
        tail[:] = m[c] * np.append(1.0, -towards)
    return replace(end, x=x, slack=slack, multipliers=y)


@dataclass(frozen=True, eq=False)
class Safest:
    """The slip with most slack at one load factor.

    Attributes
    ----------
    x : (k,)
        It, at the unknowns of programs [length].
    margin
        The radius of a ball of slips around it, all of them safe [length]; negative where none is, −inf
        where a limit that no slip changes is broken.
    cap
        The largest margin that was looked for.
    active_limits
        The discs and half-spaces that limit it.
    reduced_accuracy
        Whether the interior points reached less than their tolerances.
    """

    x: FloatArray
    margin: float
    cap: float
    active_limits: Limits
    reduced_accuracy: bool


def safest(rows: DiscRows, load_factor: float, tolerances: Tolerances = DEFAULT) -> Safest:
    """max t: f p − |q| ≥ t (f |B_i| + |A_i|) at every node and load step, half-spaces likewise.

    A change δ of the slips changes f p − |q| by (f|B_i| + |A_i|) |δ| at most: slips up to t away are safe.
    Without discs this is a linear program; else the unknown is t + cap ≥ 0.
    """
    H = rows.half_spaces
    pressures, reactions = rows.stiffness[:, 0], rows.stiffness[:, 1:]
    slopes = np.linalg.norm(pressures, axis=1) + np.linalg.norm(reactions, axis=(1, 2), ord=2)
    other_slopes = np.linalg.norm(H.G if rows.in_plane else H.coefficients, axis=1)
    c, g = rows.c + load_factor * rows.e, H.g - load_factor * H.d
    reach = np.abs(rows.c).max(axis=1) + np.abs(load_factor * rows.e).max(axis=1)
    other_reach = np.abs(H.g) + np.abs(load_factor * H.d)
    steep, also = slopes[rows.node] > 0, other_slopes > 0
    distances = np.append(reach[steep] / slopes[rows.node][steep], other_reach[also] / other_slopes[also])
    cap = 2.0 * float(distances.max(initial=0.0)) or 1.0  # twice the largest bounded margin
    if rows.in_plane:
        found = chebyshev_centre(H.coefficients, other_slopes, g, cap=cap, tolerances=tolerances)
        active = rows.node, np.flatnonzero(found.multipliers)
        return Safest(found.x, found.margin, cap, active, found.reduced_accuracy)
    down = np.zeros_like(c)
    down[:, 0] = -slopes[rows.node]
    held = replace(H, g=g + cap * other_slopes, d=other_slopes)
    moved = rows.under(c=c - cap * down, e=down, half_spaces=held)
    end = solve_scaled(scaled_discs(moved, -1.0, 2.0 * cap), proves=False)
    margin = end.load_factor - cap if end.optimal else -np.inf
    return Safest(end.x, margin, cap, end.active_limits, end.reduced_accuracy)


def safe_under_mean_load(problem: Problem, tolerances: Tolerances) -> bool:
    """Whether some slip keeps every node within its limit under the mean load alone, to ``feasibility``.

    Raises
    ------
    SolverError
        If the program ends without an answer.
    """
    rows = disc_rows(problem)
    x = np.zeros(rows.stiffness.shape[-1])
    if rows.relative_excess(x, 0.0) > 0:
        x = safest(rows, 0.0).x
    return rows.relative_excess(x, 0.0) <= tolerances.feasibility
