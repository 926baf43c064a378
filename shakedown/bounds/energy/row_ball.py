"""The energy balls of a joint in the plane: a linear program over the rows of its zone, or a cone program."""

from dataclasses import replace
from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.energy.cone_rows import margin_rows
from shakedown.bounds.energy.energy_results import (
    ALL_ADMISSIBLE,
    NO_SAFE_SLIP,
    NO_SLACK,
    NOT_HELD,
    WEDGED,
    EnergyBall,
)
from shakedown.bounds.energy.energy_rows import EnergyRows, check_resolved, without_margin, zone_rows
from shakedown.bounds.energy.row_solution import row_solution
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.contact_zone import Zone
from shakedown.programs.program import INF, Program, Solution
from shakedown.programs.scaling import typical_size
from shakedown.programs.solver import solve, widest


def energy_ball(
    zone: Zone,
    load_factor: float,
    state: FloatArray | None,
    tolerances: Tolerances,
    *,
    transient: bool,
    split: bool,
    best: bool = True,
) -> EnergyBall:
    """The largest ball of the closed nodes, or the one that holds a state best."""
    rows = zone_rows(zone, transient=transient, tolerances=tolerances)
    if reason := without_margin(zone.problem, rows):
        return _nothing(rows, load_factor, reason)
    if state is None:
        return largest_ball(rows, load_factor, tolerances)
    held = rows.rigid.relative(state)
    check_resolved(rows, held, 0.0, tolerances)
    return ball_around(rows, load_factor, held, tolerances)


def no_ball_holds(zone: Zone, load_factor: float, state: FloatArray, tolerances: Tolerances) -> bool:
    """False: with nothing to be shared λ_E is one program, and says so itself."""
    return False


def largest_ball(rows: EnergyRows, load_factor: float, tolerances: Tolerances = DEFAULT) -> EnergyBall:
    """The largest ball that keeps its slack at every row, of whatever kind the rows are."""
    right = rows.g - load_factor * rows.d
    if not rows.spread.any():
        return _whole_space(rows, load_factor, tolerances)
    found = _widest_ball(rows, right, INF, tolerances)
    if found.status == "infeasible":
        return _nothing(rows, load_factor, NO_SAFE_SLIP)
    status = Status.OPTIMAL
    if not found.optimal:
        wide = rows.spread > 0
        cap = typical_size(np.abs(right[wide]) / rows.spread[wide])
        found, status = _widest_ball(rows, right, cap, tolerances), Status.UNBOUNDED
    active = np.flatnonzero(found.multipliers)
    ball = _ball(rows, load_factor, found.x[:-1], float(found.x[-1]), active, tolerances)
    if status == Status.UNBOUNDED and ball.status == Status.OPTIMAL:
        return replace(ball, status=status, reason=WEDGED)
    return ball


def ball_around(
    rows: EnergyRows, load_factor: float, state: FloatArray, tolerances: Tolerances = DEFAULT
) -> EnergyBall:
    """The ball in which a state has the largest margin, whatever the rows are."""
    if not rows.spread.any():
        return _whole_space(rows, load_factor, tolerances)
    about = margin_rows(rows, load_factor, state)
    end = row_solution(about, tolerances)
    if end.status != Status.OPTIMAL:
        return _nothing(rows, load_factor, NOT_HELD)
    slip = state + rows.metric.inverse @ end.y * about.length
    relative = (float(np.linalg.norm(end.y)) + end.load_factor) * about.length
    return _ball(rows, load_factor, slip, relative, about.carrying(end.multipliers), tolerances)


def _ball(
    rows: EnergyRows,
    load_factor: float,
    slip: FloatArray,
    relative: float,
    active: NDArray[np.intp],
    tolerances: Tolerances,
) -> EnergyBall:
    """The ball about a centre, with its radius reduced to what the rows allow in floats."""
    relative = max(_ratio(rows, slip, load_factor, relative), 0.0)
    if not _leaves_margins(rows, slip, load_factor, tolerances):
        return _nothing(rows, load_factor, NO_SLACK)
    radius = relative * rows.metric.unit
    excess = -rows.slack(slip, load_factor, relative) / rows.sizes(slip, load_factor, relative)
    return EnergyBall(
        status=Status.OPTIMAL,
        load_factor=load_factor,
        radius=radius,
        slip=slip,
        active=rows.names(active),
        residual=float(excess.max()),
        reason="",
        metric=rows.metric,
        inner_radius=radius * (1.0 - tolerances.feasibility),
    )


def _widest_ball(rows: EnergyRows, right: FloatArray, cap: float, tolerances: Tolerances) -> Solution:
    """Maximise R in 0 ≤ R ≤ cap over the columns (v, R)."""
    n = rows.n
    return solve(
        Program(
            np.column_stack([rows.coefficients, rows.spread]),
            right,
            cost=np.append(np.zeros(n), -1.0),
            lower=np.append(np.full(n, -INF), 0.0),
            upper=np.append(np.full(n, INF), cap),
            tolerances=tolerances,
        )
    )


def _ratio(rows: EnergyRows, slip: FloatArray, load_factor: float, relative: float) -> float:
    """The largest radius, up to the one found, that the rows allow about a slip in floats."""
    wide = rows.spread > 0
    return min(relative, float(np.min(rows.slack(slip, load_factor)[wide] / rows.spread[wide])))


def _leaves_margins(rows: EnergyRows, slip: FloatArray, load_factor: float, tolerances: Tolerances) -> bool:
    """Whether some slip has a margin > 0 to every row: then so has one next to every centre.

    The ball needs no slack at a row with spread 0, but the proof needs a margin there too.
    """
    tight = rows.slack(slip, load_factor) <= tolerances.feasibility * rows.sizes(slip, load_factor)
    if not tight.any():
        return True
    return _widest_margin(rows, load_factor, tolerances)[1]


def _widest_margin(rows: EnergyRows, load_factor: float, tolerances: Tolerances) -> tuple[FloatArray, bool]:
    """The slip with the largest margin to the rows, and whether that is one."""
    sizes = np.ldexp(1.0, np.frexp(np.abs(rows.G).max(axis=1))[1])
    norms = np.linalg.norm(rows.G / sizes[:, None], axis=1)
    norms = np.where(norms > 0, norms, 1.0) * sizes
    right = rows.g - load_factor * rows.d
    cap = typical_size(np.abs(right) / norms)
    found = widest(rows.coefficients, norms, right, cap=cap, tolerances=tolerances)
    sizes = rows.sizes(found.x, load_factor)
    return found.x, bool(np.all(rows.slack(found.x, load_factor) > tolerances.feasibility * sizes))


def _whole_space(rows: EnergyRows, load_factor: float, tolerances: Tolerances) -> EnergyBall:
    """No row needs slack for the ball: its radius is infinite where a slip has margins at all."""
    slip, safe = _widest_margin(rows, load_factor, tolerances)
    if not safe:
        return _nothing(rows, load_factor, NO_SLACK)
    excess = -rows.slack(slip, load_factor) / rows.sizes(slip, load_factor)
    return EnergyBall(
        Status.UNBOUNDED, load_factor, inf, slip, (), float(excess.max()), ALL_ADMISSIBLE, rows.metric, inf
    )


def _nothing(rows: EnergyRows, load_factor: float, reason: str) -> EnergyBall:
    nowhere = np.full(rows.n, nan)
    return EnergyBall(Status.INFEASIBLE, load_factor, 0.0, nowhere, (), nan, reason, rows.metric, 0.0)
