"""Exact evolution over one load step: constant rates from event to event.

Within a load step the welded reactions change linearly, and so do slips, gaps
and reactions between two events. An event is one of

    a stuck node reaches one of its limits,           f p − s q = 0,
    a slipping node comes to the apex,                p = 0,
    an open node closes,                              w = 0,

and its time follows in closed form from the rates. Rates after an event are
those of :mod:`shakedown.kernels.rate_search`. The reactions are computed afresh from v, w at every
event, and v, w of the moving nodes are corrected to satisfy their equations, so
that nothing accumulates. A limit that is overstepped before the end of the load
step by no more than round-off is touched, not reached.

Together with the motion its derivative with respect to the state at the start
of a cycle can be followed: between events it is constant, because the rates do
not depend on the state, and at an event at time τ it changes by (u̇⁻ − u̇⁺) ∂τ.
"""

from typing import Any

import numba
import numpy as np

from shakedown.kernels.active_set import (
    FRESH,
    add_product,
    factorize,
    largest_residual,
    solve,
)
from shakedown.kernels.gauss_seidel import OPEN, STICK
from shakedown.kernels.moving_state import (
    CLOSES,
    LOAD_STEP,
    OPENS,
    REACHES_BACKWARD_LIMIT,
    REACHES_FORWARD_LIMIT,
)
from shakedown.kernels.rate_problem import APEX, ON_BACKWARD, ON_FORWARD, locate
from shakedown.kernels.rate_search import SOLVED, solve_rates

DONE, NO_RATES, LIFTS_OFF, RECORD_FULL, TOO_MANY_EVENTS, NOT_SETTLED = range(6)
SIGNATURE_TIME = 1e-12  # share of a load step below which a passing state is not part of the signature


@numba.njit(cache=True)
def load_step(
    act: Any, rate: Any, mo: Any, rec: Any, r_from: Any, r_to: Any, step: int, separable: bool, eps: Any
) -> int:
    """Carry the state through one load step, from time ``mo.time[0]`` of it to its end, in place.

    ``r_from``, ``r_to`` (2n,) are the welded reactions at its two ends. Returns
    DONE, or why the motion stopped; it can be resumed.
    """
    rate.welded[:] = r_to - r_from
    node, kind = mo.counts[2], mo.counts[3]
    for _ in range(1000 + 200 * len(act.f)):
        if len(rec.time) > 0 and rec.rows[0] == len(rec.time):
            mo.counts[2], mo.counts[3] = node, kind
            return RECORD_FULL
        react(act, mo, r_from, rate.welded)
        locate(act, rate, mo.u, mo.r, eps.force, eps.length)
        place_event(rate, node, kind)
        status = solve_rates(act, rate, eps.rate)
        mo.counts[1] = leaving_node(act, rate, status)
        if not separable and mo.counts[1] >= 0:
            return LIFTS_OFF
        if status != SOLVED:
            mo.counts[2], mo.counts[3] = node, kind
            return NO_RATES
        if not settle(act, rate, mo, eps.settled):
            return NOT_SETTLED
        apply_delay(mo, rate.motion, -1.0)
        note(act, mo, rec, step, node, kind)
        duration, node, kind = next_event(act, rate, mo, eps)
        if duration > SIGNATURE_TIME:
            sign(act, mo, step)
        advance(act, rate, mo, duration)
        if kind == LOAD_STEP:
            mo.counts[2], mo.counts[3] = -1, LOAD_STEP
            return DONE
        follow_event(act, rate, mo, node, kind)
        mo.counts[0] += 1
    return TOO_MANY_EVENTS


@numba.njit(cache=True)
def load_steps(
    act: Any, rate: Any, mo: Any, rec: Any, path: Any, first: int, separable: bool, eps: Any
) -> int:
    """Carry the state along a path of welded reactions (s + 1, 2n); its first load step has number ``first``.

    Starts, or resumes, at load step ``mo.counts[4]``, time ``mo.time[0]`` of it.
    """
    while mo.counts[4] < len(path) - 1:
        k = mo.counts[4]
        status = load_step(act, rate, mo, rec, path[k], path[k + 1], first + k, separable, eps)
        if status != DONE:
            return status
        mo.counts[4], mo.time[0] = k + 1, 0.0
    return DONE


@numba.njit(cache=True)
def react(act: Any, mo: Any, r_from: Any, welded: Any) -> None:
    """Reactions from the displacements and the load at the present time."""
    time = mo.time[0]
    for k in range(len(mo.r)):
        mo.r[k] = r_from[k] + time * welded[k]
    add_product(act, mo.u, mo.r)


@numba.njit(cache=True)
def place_event(rate: Any, node: int, kind: int) -> None:
    """Put the node of the last event at the limit that it has reached, whatever round-off says."""
    if kind in (OPENS, CLOSES):
        rate.place[node] = APEX
    elif kind == REACHES_BACKWARD_LIMIT and rate.place[node] != APEX:
        rate.place[node] = ON_BACKWARD
    elif kind == REACHES_FORWARD_LIMIT and rate.place[node] != APEX:
        rate.place[node] = ON_FORWARD


@numba.njit(cache=True)
def leaving_node(act: Any, rate: Any, status: int) -> int:
    """An open node; where there are no rates, a node at its apex; or −1."""
    for i in range(len(act.f)):
        if act.state[i] == OPEN or (status != SOLVED and rate.place[i] == APEX):
            return i
    return -1


@numba.njit(cache=True)
def settle(act: Any, rate: Any, mo: Any, settled: float) -> bool:
    """Correct u and r of the moving nodes to satisfy their equations to round-off."""
    residual = largest_residual(act, mo.r)
    for attempt in range(4):
        if residual <= settled:
            return True
        if attempt == 2 and act.meta[FRESH] > 0 and not factorize(act):
            return False
        solve(act, mo.r, rate.change)
        mo.work[1] = max(mo.work[1], residual)
        for k in range(len(mo.u)):
            mo.u[k] += rate.change[k]
        add_product(act, rate.change, mo.r)
        residual = largest_residual(act, mo.r)
    return residual <= 1e3 * settled


@numba.njit(cache=True)
def next_event(act: Any, rate: Any, mo: Any, eps: Any) -> Any:
    """When, where and what: duration to the next event, its node and its kind.

    A guard that a node has just reached does not count again: the rates have
    been chosen so that it is not overstepped.
    """
    n, rest = len(act.f), 1.0 - mo.time[0]
    first, node, kind = rest, -1, LOAD_STEP
    for i in range(n):
        state, place, f = act.state[i], rate.place[i], act.f[i]
        if place == APEX and state in (STICK, OPEN):
            continue
        if state == STICK:
            q, p, q_rate, p_rate = mo.r[i], mo.r[n + i], rate.reaction[i], rate.reaction[n + i]
            if place != ON_BACKWARD:
                until = time_to_zero(f * p - q, f * p_rate - q_rate, rest, eps.force)
                if until < first:
                    first, node, kind = until, i, REACHES_BACKWARD_LIMIT
            if place != ON_FORWARD:
                until = time_to_zero(f * p + q, f * p_rate + q_rate, rest, eps.force)
                if until < first:
                    first, node, kind = until, i, REACHES_FORWARD_LIMIT
        elif state == OPEN:
            until = time_to_zero(mo.u[n + i], rate.motion[n + i], rest, eps.length)
            if until < first:
                first, node, kind = until, i, CLOSES
        elif place != APEX:
            until = time_to_zero(mo.r[n + i], rate.reaction[n + i], rest, eps.force)
            if until < first:
                first, node, kind = until, i, OPENS
    return first, node, kind


@numba.njit(cache=True)
def time_to_zero(distance: float, rate: float, rest: float, small: float) -> float:
    """Time until a falling distance is used up, infinite where it is not overstepped within ``rest``."""
    if rate >= 0.0 or distance + rate * rest >= -small:
        return np.inf
    return max(distance, 0.0) / -rate


@numba.njit(cache=True)
def advance(act: Any, rate: Any, mo: Any, duration: float) -> None:
    """Move on at constant rates; count slip in contact and dissipation."""
    for i in range(len(act.f)):
        if act.state[i] == OPEN:
            mo.opened[i] = True
        elif act.state[i] != STICK:
            slip = rate.motion[i] * duration
            mo.slip[i] += abs(slip)
            mo.work[0] -= slip * (mo.r[i] + 0.5 * duration * rate.reaction[i])
    for k in range(len(mo.u)):
        mo.u[k] += duration * rate.motion[k]
    mo.time[0] = min(mo.time[0] + duration, 1.0)


@numba.njit(cache=True)
def follow_event(act: Any, rate: Any, mo: Any, node: int, kind: int) -> None:
    """Close a gap exactly; derivative of the event's time, and its part in the derivative of the state."""
    n, t = len(act.f), mo.tangent.shape[1]
    if kind == CLOSES:
        guard_rate = rate.motion[n + node]
        mo.u[n + node] = 0.0
        for c in range(t):
            mo.delay[c] = -mo.tangent[n + node, c] / guard_rate
    elif t > 0:
        side, f = 0.0, 1.0
        if kind != OPENS:
            side, f = (1.0 if kind == REACHES_BACKWARD_LIMIT else -1.0), act.f[node]
        guard_rate = f * rate.reaction[n + node] - side * rate.reaction[node]
        mo.delay[:] = 0.0
        for j in range(2 * n):
            x = (f * act.kappa[n + node, j] - side * act.kappa[node, j]) / guard_rate
            if x != 0.0:
                for c in range(t):
                    mo.delay[c] -= x * mo.tangent[j, c]
    mo.time[1] = 1.0
    apply_delay(mo, rate.motion, 1.0)


@numba.njit(cache=True)
def apply_delay(mo: Any, rates: Any, sign: float) -> None:
    """Add ± u̇ ∂τ to the derivative: + with the rates before an event, − with those after it."""
    if mo.time[1] != 0.0:
        for k in range(len(rates)):
            x = sign * rates[k]
            if x != 0.0:
                for c in range(len(mo.delay)):
                    mo.tangent[k, c] += x * mo.delay[c]
        if sign < 0.0:
            mo.time[1] = 0.0


@numba.njit(cache=True)
def sign(act: Any, mo: Any, step: int) -> None:
    """Enter the present states into the signature, once for as long as they last."""
    code = np.uint64(step + 1)
    for i in range(len(act.f)):
        code = (code ^ np.uint64(act.state[i] + 2)) * np.uint64(1099511628211)
    if code != mo.signature[1]:
        mo.signature[0] = (mo.signature[0] ^ code) * np.uint64(1099511628211)
        mo.signature[1] = code


@numba.njit(cache=True)
def note(act: Any, mo: Any, rec: Any, step: int, node: int, kind: int) -> None:
    """Record the present state and what led to it, where there is room."""
    if len(rec.time) > 0:
        row = rec.rows[0]
        rec.time[row] = step + mo.time[0]
        rec.u[row], rec.r[row], rec.state[row] = mo.u, mo.r, act.state
        rec.node[row], rec.kind[row] = node, kind
        rec.rows[0] = row + 1
