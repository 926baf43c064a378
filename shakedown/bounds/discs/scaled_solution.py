"""The solution of a program: interior points, Newton's method on the discs that meet there, and a proof."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve

from shakedown.bounds.discs.scaled_discs import ScaledDiscs, UnscaledSolution, in_units
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEWTON_ROUNDS, ROUND_OFF
from shakedown.ground.size_limits import CONE
from shakedown.ground.status import Status
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.disc_solver import solve_discs
from shakedown.programs.self_dual import (
    USABLE,
    Point,
    Points,
    SelfDualSolution,
    balanced_multipliers,
)

NEGATIVE = 10 * ROUND_OFF  # largest slack or multiplier below zero likewise
ALIKE = (1.0, 1e2)  # ratios of slack to multiplier up to which a limit counts as active
PROXIMITY = 100 * ROUND_OFF  # regularisation of slips left free by active limits, and of redundant limits

Mask = NDArray[np.bool_]


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
    return in_units(scaled, polished(scaled.program, solve_discs(scaled.program, usable), proves=proves))


def polished(program: DiscProgram, end: SelfDualSolution, *, proves: bool = True) -> SelfDualSolution:
    """An optimum to round-off; what was given where the limits that meet in it are not clear.

    Equations: every active limit holds with equality, the multipliers balance. A disc is active where
    its slack is smaller than its multiplier, at its apex where all of its slack is.
    """
    if end.status != Status.OPTIMAL:
        return end
    best, left = end, _left(program, end)
    for alike in ALIKE:
        with np.errstate(all="ignore"):  # what is not finite is not taken
            found = _newton(program, end, _active(program, end, alike))
        rest = _left(program, found) if found is not None else np.inf
        if found is not None and rest < left:
            best, left = replace(found, accuracy=min(end.accuracy, rest)), rest
        if left <= NEGATIVE:
            return best
    return _balanced(program, end) if best is end and proves else best


def _balanced(program: DiscProgram, end: SelfDualSolution) -> SelfDualSolution:
    """The end with multipliers that balance to round-off, where they stay in their cones."""
    y = balanced_multipliers(program, Point(end.x, end.slack, end.multipliers, 1.0, 0.0))
    return replace(end, multipliers=y) if program.cones.margin(y) > 0 else end


def _active(program: DiscProgram, end: SelfDualSolution, alike: float) -> _Active:
    (s, slack, _), (y, weight, _) = program.parts(end.slack), program.parts(end.multipliers)
    length_s, length_y = np.hypot(s[:, 1], s[:, 2]), np.hypot(y[:, 1], y[:, 2])
    active = s[:, 0] - length_s < alike * (y[:, 0] + length_y)
    apex = s[:, 0] + length_s < alike * (y[:, 0] - length_y)
    linear = np.flatnonzero(slack < alike * weight)
    norm = program.norm is not None and bool(np.any(end.x[: program.rank]))
    return _Active(linear, np.flatnonzero(active & ~apex), np.flatnonzero(apex), norm)


def _left(program: DiscProgram, end: SelfDualSolution) -> float:
    """The largest of what is left of the balance, slacks and multipliers below zero, and the gap."""
    slack = program.limits - program.times(end.x)
    balance = np.abs(program.transposed(end.multipliers) + program.costs).max()
    outside = max(-program.cones.margin(slack), -program.cones.margin(end.multipliers), 0.0)
    gap = abs(float(slack @ end.multipliers)) / max(abs(float(program.costs @ end.x)), 1e-300)
    found = max(balance, outside, gap)
    return float(found) if np.isfinite(found) else np.inf


def _newton(program: DiscProgram, end: SelfDualSolution, active: _Active) -> SelfDualSolution | None:
    """The end from Newton's method on the equations; None where it does not settle."""
    triples, weights, tail = program.parts(end.multipliers)
    x = end.x
    m = np.concatenate(
        [weights[active.linear], triples[active.edge, 0], triples[active.apex].ravel(), tail[: active.norm]]
    )
    best, reached = None, np.inf
    for _ in range(NEWTON_ROUNDS):
        gradient, missing, H, J = _equations(program, active, x, m)
        size = max(float(np.abs(gradient).max()), float(np.abs(missing).max(initial=0.0)))
        if not np.isfinite(size) or size > 0.5 * reached:
            break
        best, reached = (x, m), size
        if size <= ROUND_OFF * 1e-2:
            break
        step = _step(gradient, missing, H, J)
        x, m = x + step[: len(x)], m - step[len(x) :]
    return _ended(program, end, active, *best) if best is not None else None


def _step(gradient: FloatArray, missing: FloatArray, H: FloatArray, J: FloatArray) -> FloatArray:
    size, count = len(gradient), len(missing)
    matrix = np.zeros((size + count, size + count))
    matrix[:size, :size], matrix[:size, size:], matrix[size:, :size] = H, J.T, J
    near = np.concatenate([np.full(size, PROXIMITY), np.full(count, -PROXIMITY)])
    matrix[np.diag_indices(size + count)] += near
    return np.asarray(lu_solve(lu_factor(matrix, check_finite=False), -np.append(gradient, missing)))


def _equations(
    program: DiscProgram, active: _Active, x: FloatArray, m: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Balance of the multipliers, slack of the active limits, curvature, slopes of the active limits."""
    s, linear, _ = program.parts(program.limits - program.times(x))
    a, b = len(active.linear), len(active.linear) + len(active.edge)
    edges = program.edges(active.edge, x, m[a:b])
    at_apex = program.columns(active.apex).reshape(-1, len(x))
    J = -np.vstack([_rows(program, active.linear), edges.slopes, at_apex])
    missing = np.concatenate([linear[active.linear], -edges.excess, s[active.apex].ravel()])
    H = edges.bends.T @ edges.bends
    if active.norm and program.norm is not None:
        r, length = program.rank, float(np.linalg.norm(x[: program.rank]))
        towards = x[:r] / length
        J = np.vstack([J, np.append(-towards, program.norm)])
        missing = np.append(missing, program.norm @ x[r:] - program.offset - length)
        H[:r, :r] += m[-1] / length * (np.eye(r) - np.outer(towards, towards))
    return program.costs - m @ J, missing, H, J


def _rows(program: DiscProgram, rows: NDArray[np.intp]) -> FloatArray:
    """The coefficients of (ξ, λ) in some linear rows."""
    return np.hstack([program.rows[rows], program.rows_extra[rows]])


def _ended(
    program: DiscProgram, end: SelfDualSolution, active: _Active, x: FloatArray, m: FloatArray
) -> SelfDualSolution:
    slack, y = program.limits - program.times(x), np.zeros(len(program.limits))
    (s, *_), (triples, weights, tail) = program.parts(slack), program.parts(y)
    a, b = len(active.linear), len(active.linear) + len(active.edge)
    c = b + CONE * len(active.apex)
    weights[active.linear] = m[:a]
    normal = s[active.edge, 1:] / np.hypot(s[active.edge, 1], s[active.edge, 2])[:, None]
    triples[active.edge] = m[a:b, None] * np.column_stack([np.ones(len(normal)), -normal])
    triples[active.apex] = m[b:c].reshape(-1, CONE)
    if active.norm:
        towards = x[: program.rank] / np.linalg.norm(x[: program.rank])
        tail[:] = m[c] * np.append(1.0, -towards)
    return replace(end, x=x, slack=slack, multipliers=y)


@dataclass(frozen=True)
class ProvedSolution:
    """The end of max w_last over a :class:`DiscProgram`.

    Attributes
    ----------
    status
        How it ended.
    y, w : (r,), (p,)
        The solution.
    discs, rows : (K, 3), (k,)
        Multipliers; of an infeasible program those that prove it.
    proved
        What the multipliers prove w_last not to exceed.
    path
        The points on the way.
    """

    status: Status
    y: FloatArray
    w: FloatArray
    discs: FloatArray
    rows: FloatArray
    proved: float = np.nan
    path: Points = ()

    @property
    def value(self) -> float:
        """The largest w_last."""
        return float(self.w[-1])


def balance(program: DiscProgram, discs: FloatArray, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What multipliers of discs and rows add up to in the columns y and w."""
    tail = np.zeros(0 if program.norm is None else program.rank + 1)
    whole = program.transposed(np.concatenate([discs.ravel(), rows, tail]))
    return whole[: program.rank], whole[program.rank :]


def proved(program: DiscProgram, end: ProvedSolution) -> float:
    """The value that multipliers prove not to be exceeded at any y up to twice as far as that of the end.

    Weak duality, with what is left of the balance at its worst there.
    """
    of_y, of_w = balance(program, end.discs, end.rows)
    right = float(np.einsum("ij,ij", end.discs, program.right) + end.rows @ program.rows_right)
    length = float(np.linalg.norm(of_y))
    if program.norm is None:
        return (right + 2 * float(np.linalg.norm(end.y)) * length) / _pull(of_w)
    # of_w = pull · target + weight · norm, and the length of y may weigh as much as `weight`
    norm, pull = program.norm, of_w
    weight = float(of_w[0] / norm[0])
    pull = of_w - weight * norm
    short = max(length - weight, 0.0)
    value = right - weight * program.offset + 2 * float(np.linalg.norm(end.y)) * short
    return value / _pull(pull)


def _pull(of_w: FloatArray) -> float:
    return float(of_w[-1]) if of_w[-1] > 0 else np.nan
