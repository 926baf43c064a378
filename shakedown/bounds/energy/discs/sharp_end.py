"""The end of a program over discs: interior points, then Newton's method on what is active."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgWarning, solve

from shakedown.bounds.energy.discs.ball_limits import CONE, Places
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT
from shakedown.programs.disc_solver import DiscSolution, solved
from shakedown.programs.interior.disc_program import DiscProgram
from shakedown.programs.interior.self_dual import USABLE

NEWTON_STEPS = 6
CHANGES = 8  # of what is active
BROKEN = 1e-12  # violation of a disc, in the numbers of the program, that is one
ROUND_OFF = 4 * np.finfo(float).eps
PULLING, NEAR = 1e-7, 1e-4  # active discs have larger multipliers and smaller slacks, relatively
APEX = 1e-6  # a reaction this small, relative to the numbers of the program, may be none at all
SHARP = 1e-13  # what is left between the value and its proof, relatively, where nothing is to be gained
SMALL = 400  # unknowns up to which the shortest step is taken where the equations are singular
SINGULAR = 1e-11  # relative singular value that counts as zero there

Value = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class SharpEnd:
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
    """

    status: Status
    y: FloatArray
    w: FloatArray
    discs: FloatArray
    rows: FloatArray
    proved: float = np.nan

    @property
    def value(self) -> float:
        """The largest w_last."""
        return float(self.w[-1])

    @property
    def open(self) -> float:
        """What is left between the value and its proof."""
        return abs(self.proved - self.value)


def sharp_end(program: DiscProgram, value: Value, usable: float = USABLE) -> SharpEnd:
    """The end of a program, sharpened where Newton's method gains.

    Parameters
    ----------
    program
        Maximise w_last.
    value
        The w that the discs allow at a given y in floats, with the largest w_last.
    usable
        Accuracy of the interior points that is enough to begin with.

    Raises
    ------
    SolverError
        If no road comes to an end.
    """
    end = solved(program, DEFAULT, usable)
    best = SharpEnd(end.status, end.y, end.w, end.discs, end.rows)
    if end.status != Status.OPTIMAL:
        return best
    w = value(best.y)
    best = replace(best, w=w if np.all(np.isfinite(w)) else best.w)
    best = replace(best, proved=proved(program, best))
    candidate = _newton(program, end) if _away(program, end) else _centred(program, end, value)
    if candidate is None:
        return best
    sharper = replace(candidate, w=value(candidate.y))
    sharper = replace(sharper, proved=proved(program, sharper))
    return sharper if np.isfinite(sharper.value) and sharper.open < best.open else best


def balance(program: DiscProgram, discs: FloatArray, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What multipliers of discs and rows add up to in the columns y and w."""
    tail = np.zeros(0 if program.norm is None else program.rank + 1)
    whole = program.transposed(np.concatenate([discs.ravel(), rows, tail]))
    return whole[: program.rank], whole[program.rank :]


def proved(program: DiscProgram, end: SharpEnd) -> float:
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


class _Active(NamedTuple):
    """What holds at a solution: discs at their limits, discs at their apex, rows."""

    discs: Places
    apexes: Places
    rows: Places


class _Stationary(NamedTuple):
    """(y, w), multipliers of discs, apexes and rows, and that of the bound of the length of y."""

    y: FloatArray
    w: FloatArray
    mu: FloatArray
    tips: FloatArray
    nu: FloatArray
    weight: float


def _newton(program: DiscProgram, end: DiscSolution) -> SharpEnd | None:
    """What is active at an optimum, solved as equations; None where they come to no end.

    What turns out to push the wrong way is let go, and what turns out to be broken is taken in.
    """
    active = _active(program, end)
    for _ in range(CHANGES):
        found = _stationary(program, end, active)
        if found is None:
            return None
        other = _corrected(program, active, found)
        if other is None:
            return _ended(program, active, found, end)
        active = other
    return None


def _away(program: DiscProgram, end: DiscSolution) -> bool:
    """Whether an end is elsewhere than at y = 0, where the bound of the length has no slope."""
    return program.norm is None or float(np.linalg.norm(end.y)) > APEX


def _centred(program: DiscProgram, end: DiscSolution, value: Value) -> SharpEnd | None:
    """The end at y = 0: of the multipliers found there, those of what is active, in its directions."""
    y = np.zeros(program.rank)
    w = value(y)
    if program.norm is None or not np.all(np.isfinite(w)):
        return None
    u = _discs_at(program, y, w, np.arange(len(program.node)))
    lengths = np.hypot(u[:, 1], u[:, 2])
    carrying = (u[:, 0] - lengths < SHARP) & (lengths > 0)
    normal = u[:, 1:] / np.where(lengths > 0, lengths, 1.0)[:, None]
    discs = (carrying * end.discs[:, 0])[:, None] * np.column_stack([np.ones(len(u)), -normal])
    rows = np.where(program.rows_right - program.rows_extra @ w < SHARP, end.rows, 0.0)
    of_w = balance(program, discs, rows)[1]
    pull = float((of_w - of_w[0] / program.norm[0] * program.norm)[-1])
    if not pull > 0:
        return None
    return SharpEnd(Status.OPTIMAL, y, w, discs / pull, rows / pull)


def _stationary(program: DiscProgram, end: DiscSolution, active: _Active) -> _Stationary | None:
    """The point at which what is active is stationary, next to an end; None where none is found."""
    weight = 0.0
    if program.norm is not None:
        weight = float(balance(program, end.discs, end.rows)[1][0] / program.norm[0])
    mu, tips, nu = (
        part.ravel() for part in (end.discs[active.discs, 0], end.discs[active.apexes], end.rows[active.rows])
    )
    at = _Stationary(end.y, end.w, mu, tips, nu, weight)
    ends = np.cumsum([len(part) for part in at[:-1]])
    for _ in range(NEWTON_STEPS):
        if program.norm is not None and not np.linalg.norm(at.y) > 0:
            return None
        step = _step(*_equations(program, active, at))
        if step is None or not np.all(np.isfinite(step)):
            return None
        parts = np.split(step, ends)
        y, w, mu, tips, nu = (old + new for old, new in zip(at[:-1], parts, strict=False))
        at = _Stationary(y, w, mu, tips, nu, at.weight + float(parts[-1].sum()))
        if np.linalg.norm(step) <= ROUND_OFF * np.linalg.norm(np.concatenate(at[:-1])):
            break
    return at


def _corrected(program: DiscProgram, active: _Active, at: _Stationary) -> _Active | None:
    """What is active without what pushes the wrong way, with what is broken; None where nothing changes."""
    u = _discs_at(program, at.y, at.w, np.arange(len(program.node)))
    broken = np.hypot(u[:, 1], u[:, 2]) - u[:, 0] > BROKEN
    broken[np.append(active.discs, active.apexes)] = False
    slack = program.rows_right - program.rows @ at.y - program.rows_extra @ at.w
    low = slack < -BROKEN
    low[active.rows] = False
    pushing, holding = at.mu >= 0, at.nu >= 0
    if pushing.all() and holding.all() and not broken.any() and not low.any():
        return None
    return _Active(
        np.union1d(active.discs[pushing], np.flatnonzero(broken)),
        active.apexes,
        np.union1d(active.rows[holding], np.flatnonzero(low)),
    )


def _ended(program: DiscProgram, active: _Active, at: _Stationary, end: DiscSolution) -> SharpEnd | None:
    """A stationary point as an end, its multipliers in the cones; None where they are in none."""
    tips = at.tips.reshape(-1, CONE)
    u = _discs_at(program, at.y, at.w, active.discs)
    lengths = np.hypot(u[:, 1], u[:, 2])
    if np.any(lengths == 0) or np.any(np.hypot(tips[:, 1], tips[:, 2]) > tips[:, 0] * (1.0 + SHARP)):
        return None
    discs, rows = np.zeros_like(end.discs), np.zeros_like(end.rows)
    discs[active.discs] = at.mu[:, None] * np.column_stack([np.ones(len(u)), -u[:, 1:] / lengths[:, None]])
    discs[active.apexes], rows[active.rows] = tips, at.nu
    return SharpEnd(Status.OPTIMAL, at.y, at.w, discs, rows)


def _discs_at(program: DiscProgram, y: FloatArray, w: FloatArray, which: Places) -> FloatArray:
    node = program.node[which]
    return program.right[which] - (program.blocks @ y)[node] - program.extra[which] @ w


def _active(program: DiscProgram, end: DiscSolution) -> _Active:
    every = np.arange(len(program.node))
    u = _discs_at(program, end.y, end.w, every)
    slack = u[:, 0] - np.hypot(u[:, 1], u[:, 2])
    share = end.discs[:, 0]
    largest = max(float(share.max(initial=0.0)), float(end.rows.max(initial=0.0)))
    pulling = (share > PULLING * largest) & (slack < NEAR)
    inner = np.hypot(end.discs[:, 1], end.discs[:, 2]) < (1.0 - APEX) * share
    apex = pulling & (u[:, 0] < APEX) & inner
    rest = program.rows_right - program.rows @ end.y - program.rows_extra @ end.w
    rows = (end.rows > PULLING * largest) & (rest < NEAR)
    return _Active(*(np.flatnonzero(chosen) for chosen in (pulling & ~apex, apex, rows)))


def _step(matrix: FloatArray, value: FloatArray) -> FloatArray | None:
    """The Newton step; where few equations are singular the shortest one."""
    if len(matrix) <= SMALL:
        return np.asarray(np.linalg.lstsq(matrix, -value, rcond=SINGULAR)[0])
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter(
                "ignore", LinAlgWarning
            )  # a step that leads nowhere is seen by its residual
            return np.asarray(solve(matrix, -value, check_finite=False))
    except (np.linalg.LinAlgError, ValueError):
        return None


def _equations(program: DiscProgram, active: _Active, at: _Stationary) -> tuple[FloatArray, FloatArray]:
    """Matrix and value of the conditions of an optimum."""
    y, w, mu, tips, nu, weight = at
    r, p = len(y), len(w)
    edges = program.edges(active.discs, np.append(y, w), mu)
    points = program.columns(active.apexes).reshape(-1, r + p)
    rows = np.column_stack([program.rows[active.rows], program.rows_extra[active.rows]])
    held = [edges.slopes, points, rows]
    values = [
        edges.excess,
        -_discs_at(program, y, w, active.apexes).ravel(),
        rows @ np.append(y, w) - program.rows_right[active.rows],
    ]
    square = edges.bends.T @ edges.bends
    multipliers = np.concatenate([mu, tips, nu])
    if program.norm is not None:
        length = float(np.linalg.norm(y))
        towards = y / length
        held.append(np.append(towards, -program.norm)[None])
        values.append(np.array([length + program.offset - program.norm @ w]))
        square[:r, :r] += weight / length * (np.eye(r) - np.outer(towards, towards))
        multipliers = np.append(multipliers, weight)
    A = np.vstack(held)
    balance_left = A.T @ multipliers + np.append(np.zeros(r), program.cost)
    matrix = np.block([[square, A.T], [A, np.zeros((len(A), len(A)))]])
    return matrix, np.concatenate([balance_left, *values])
