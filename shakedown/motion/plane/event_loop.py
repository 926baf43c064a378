"""Exact evolution over one load step: constant rates from event to event.

Within a load step the welded reactions change linearly, and so do slips, gaps
and reactions between two events. An event is one of

    a stuck node reaches one of its limits,           f p − s q = 0,
    a slipping node comes to the apex,                p = 0,
    an open node closes,                              w = 0,

and its time follows in closed form from the rates. Rates after an event are
those of :mod:`shakedown.motion.plane.rate_problem`. The reactions are computed afresh from v, w
after every few events, and v, w of the moving nodes are corrected at each to satisfy their
equations, so that nothing accumulates. A limit that is overstepped before the end of the load
step by no more than round-off is touched, not reached.

A load step is first tried as a quiet one (:mod:`shakedown.motion.plane.quiet_steps`);
only where something happens in it is it followed from event to event. The loops
return to Python after a stated amount of work, and can be entered again.

Together with the motion its derivative with respect to the state at the start
of a cycle can be followed: between events it is constant, because the rates do
not depend on the state, and at an event at time τ it changes by (u̇⁻ − u̇⁺) ∂τ.
"""

from functools import cache

import numpy as np
from numba import types

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import address_of, handed_on, inner
from shakedown.ground.round_off import ROUND_OFF
from shakedown.ground.status import OPEN, STICK
from shakedown.motion.course import (
    CLOSES,
    DONE,
    LIFTS_OFF,
    LOAD_STEP,
    NO_RATES,
    NOT_SETTLED,
    OPENS,
    PAUSED,
    REACHES_BACKWARD_LIMIT,
    REACHES_FORWARD_LIMIT,
    RECORD_FULL,
    TOO_MANY_EVENTS,
    Course,
)
from shakedown.motion.plane.active_set import (
    ActiveSet,
    add_product,
    correct,
    factorize,
    larger,
    largest_residual,
)
from shakedown.motion.plane.moving_state import PlaneMotion, Record
from shakedown.motion.plane.quiet_steps import (
    MOST_FOLLOWED,
    compute_elastic,
    has_capacity,
    note,
    quiet_steps,
    sign,
)
from shakedown.motion.plane.rate_problem import APEX, ON_BACKWARD, ON_FORWARD, Rates, locate, solve_rates
from shakedown.motion.plane.run import PlaneRun

# Number of load steps that an event counts as, since it adds more round-off to κ u.
EVENT = MOST_FOLLOWED // 8


@handed_on
def follow_straight(run: PlaneRun, passes: int, effort: int) -> int:
    """Carry the state along the course of a run until it has been passed so often since :func:`begin`.

    Starts, or resumes, at load step ``step``, time ``time`` of it. Ends with
    DONE, or with why the motion stopped; after RECORD_FULL and PAUSED, and where
    there were NO_RATES and states have been found or the state has jumped, it
    can be entered again. Every call gets one event or load step further at least.
    """
    act, rate, mo, rec, course = run.active, run.rates, run.motion, run.record, run.course
    act.effort, act.allowed, rec.rows, status = 0, effort, 0, DONE
    compute_elastic(act, mo)
    while mo.passes < passes and status == DONE:
        if mo.time == 0.0 and mo.kind == LOAD_STEP:
            quiet_steps(act, rate, mo, rec, course)
        if mo.step < course.steps:
            status = load_step(act, rate, mo, rec, course)
        if mo.step == course.steps:
            mo.passes += 1
            mo.step = 0
            compute_elastic(act, mo)
        if status == DONE and mo.passes < passes and act.effort > act.allowed:
            status = PAUSED
    return status


@cache
def address_of_loop() -> int:
    """The address of :func:`follow_straight`, which is compiled once for all its callers."""
    return address_of(follow_straight, PlaneRun.compiled, types.int64, types.int64)


@inner
def load_step(act: ActiveSet, rate: Rates, mo: PlaneMotion, rec: Record, course: Course) -> int:
    """Carry the state from event to event to the end of its load step."""
    path, step, welded, m, known = course.path, mo.step, rate.welded, 2 * act.n, False
    for j in range(m):
        welded[j] = path[(step + 1) * m + j] - path[step * m + j]
    while mo.crowd < 1000 + 100 * m:
        if not has_capacity(rec):
            return RECORD_FULL
        react(act, rate, mo, course)
        locate(act, rate, mo.u, mo.r, course.force, course.length)
        place_event(rate, mo.node, mo.kind)
        solved = solve_rates(act, rate, course.rate, known)
        known = True  # up to the next event
        mo.concerned = leaving_node(act, rate, solved)
        if not course.separable and mo.concerned >= 0:
            return LIFTS_OFF
        if not solved:
            note(act, mo, rec, course.first)
            return NO_RATES
        if not settle(act, rate, mo, course.settled) and (
            act.updates == 0 or factorize(act) == 0 or not settle(act, rate, mo, course.settled)
        ):
            return NOT_SETTLED
        apply_delay(mo, rate.motion, -1.0)
        note(act, mo, rec, course.first)
        duration, node, kind = next_event(act, rate, mo, course)
        mo.signed = False
        if duration > ROUND_OFF:  # shorter intervals are not part of the signature
            sign(act, mo, course.first + step)
        advance(act, rate, mo, duration)
        mo.node, mo.kind = node, kind
        if kind == LOAD_STEP:
            mo.step, mo.time, mo.crowd = step + 1, 0.0, 0
            return DONE
        follow_event(act, rate, mo, node, kind)
        mo.events += 1
        mo.crowd += 1
        if act.effort > act.allowed:
            return PAUSED
    return TOO_MANY_EVENTS


@inner
def react(act: ActiveSet, rate: Rates, mo: PlaneMotion, course: Course) -> None:
    """Reactions from the displacements and the load at the present time."""
    mo.followed += EVENT
    if mo.followed > MOST_FOLLOWED:
        compute_elastic(act, mo)
    time, start, r, welded = mo.time, mo.step * 2 * act.n, mo.r, rate.welded
    for k in range(2 * act.n):
        r[k] = course.path[start + k] + time * welded[k] + mo.elastic[k]


@inner
def place_event(rate: Rates, node: int, kind: int) -> None:
    """Put the node of the last event exactly at its limit, regardless of round-off."""
    if kind in (OPENS, CLOSES):
        rate.place[node] = APEX
    elif kind == REACHES_BACKWARD_LIMIT and rate.place[node] != APEX:
        rate.place[node] = ON_BACKWARD
    elif kind == REACHES_FORWARD_LIMIT and rate.place[node] != APEX:
        rate.place[node] = ON_FORWARD


@inner
def leaving_node(act: ActiveSet, rate: Rates, solved: bool) -> int:
    """An open node; where there are no rates, a node at its apex; or −1."""
    states, places = act.state, rate.place
    for i in range(act.n):
        if states[i] == OPEN or (not solved and places[i] == APEX):
            return i
    return -1


@inner
def settle(act: ActiveSet, rate: Rates, mo: PlaneMotion, settled: float) -> bool:
    """Correct u and r of the moving nodes to satisfy their equations to round-off."""
    u, r, elastic, change = mo.u, mo.r, mo.elastic, rate.change
    residual = largest_residual(act, r)
    for _ in range(3):
        if residual <= settled:
            return True
        correct(act, r, change)
        mo.correction = larger(mo.correction, residual)
        for k in range(2 * act.n):
            u[k] += change[k]
        for k in range(2 * act.n):
            elastic[k] -= r[k]
        add_product(act, change, r)
        for k in range(2 * act.n):
            elastic[k] += r[k]
        residual = largest_residual(act, r)
    return residual <= 1e3 * settled


@inner
def next_event(act: ActiveSet, rate: Rates, mo: PlaneMotion, course: Course) -> tuple[float, int, int]:
    """Duration to the next event, its node and its kind.

    A guard that a node has just reached does not count again: the rates have
    been chosen so that it is not overstepped.
    """
    n, rest, states, places, friction = act.n, 1.0 - mo.time, act.state, rate.place, act.f
    u, r, motion, reaction = mo.u, mo.r, rate.motion, rate.reaction
    first, node, kind = rest, -1, LOAD_STEP
    for i in range(n):
        state, place, f = states[i], places[i], friction[i]
        if place == APEX and (state in (STICK, OPEN)):
            continue
        if state == STICK:
            if place != ON_BACKWARD:
                distance, approach = f * r[n + i] - r[i], f * reaction[n + i] - reaction[i]
                until = time_to_zero(distance, approach, rest, course.force)
                if until < first:
                    first, node, kind = until, i, REACHES_BACKWARD_LIMIT
            if place != ON_FORWARD:
                distance, approach = f * r[n + i] + r[i], f * reaction[n + i] + reaction[i]
                until = time_to_zero(distance, approach, rest, course.force)
                if until < first:
                    first, node, kind = until, i, REACHES_FORWARD_LIMIT
        elif state == OPEN:
            until = time_to_zero(u[n + i], motion[n + i], rest, course.length)
            if until < first:
                first, node, kind = until, i, CLOSES
        elif place != APEX:
            until = time_to_zero(r[n + i], reaction[n + i], rest, course.force)
            if until < first:
                first, node, kind = until, i, OPENS
    return first, node, kind


@inner
def time_to_zero(distance: float, rate: float, rest: float, small: float) -> float:
    """Time until a decreasing distance vanishes, infinite where that does not happen within ``rest``."""
    if rate >= 0.0 or distance + rate * rest >= -small:
        return np.inf
    return distance / -rate if distance > 0.0 else 0.0


@inner
def advance(act: ActiveSet, rate: Rates, mo: PlaneMotion, duration: float) -> None:
    """Move on at constant rates; count slip in contact and dissipation."""
    states, slip, work, u, r, elastic = act.state, mo.slip, mo.work, mo.u, mo.r, mo.elastic
    motion, reaction, welded = rate.motion, rate.reaction, rate.welded
    for i in range(act.n):
        if states[i] == OPEN:
            mo.opened[i] = 1
        elif states[i] != STICK:
            change = motion[i] * duration
            taken = change * (r[i] + 0.5 * duration * reaction[i])
            slip[i] += abs(change)
            work[i] -= taken
            mo.dissipation -= taken
    for k in range(2 * act.n):
        u[k] += duration * motion[k]
        elastic[k] += duration * (reaction[k] - welded[k])
    mo.time += duration
    if mo.time > 1.0:
        mo.time = 1.0


@inner
def follow_event(act: ActiveSet, rate: Rates, mo: PlaneMotion, node: int, kind: int) -> None:
    """Close a gap exactly; derivative of the event's time, and its part in the derivative of the state."""
    n, t, tangent, delay, kappa = act.n, mo.parameters, mo.tangent, mo.delay, act.kappa
    if kind == CLOSES:
        mo.u[n + node] = 0.0
        mo.followed = MOST_FOLLOWED
    if t == 0:
        return
    for c in range(t):
        delay[c] = 0.0
    if kind == CLOSES:
        for c in range(t):
            delay[c] = -tangent[(n + node) * t + c] / rate.motion[n + node]
    else:
        side, f = 0.0, 1.0
        if kind != OPENS:
            side, f = (1.0 if kind == REACHES_BACKWARD_LIMIT else -1.0), act.f[node]
        guard_rate = f * rate.reaction[n + node] - side * rate.reaction[node]
        for j in range(2 * n):
            if j >= n and act.state[j - n] != OPEN:
                continue  # its gap stays closed
            x = (f * kappa[(n + node) * 2 * n + j] - side * kappa[node * 2 * n + j]) / guard_rate
            for c in range(t):
                delay[c] -= x * tangent[j * t + c]
    mo.delayed = True
    apply_delay(mo, rate.motion, 1.0)


@inner
def apply_delay(mo: PlaneMotion, rates: FloatArray, sign: float) -> None:
    """Add ± u̇ ∂τ to the derivative: + with the rates before an event, − with those after it."""
    if mo.delayed:
        tangent, delay, t = mo.tangent, mo.delay, mo.parameters
        for k in range(2 * mo.n):
            x = sign * rates[k]
            if x != 0.0:
                for c in range(t):
                    tangent[k * t + c] += x * delay[c]
        if sign < 0.0:
            mo.delayed = False
