"""Exact evolution over one load step: constant rates from event to event.

Within a load step the welded reactions change linearly, and so do slips, gaps
and reactions between two events. An event is one of

    a stuck node reaches one of its limits,           f p − s q = 0,
    a slipping node comes to the apex,                p = 0,
    an open node closes,                              w = 0,

and its time follows in closed form from the rates. Rates after an event are
those of :mod:`shakedown.motion.plane.active_set`. The reactions are computed afresh from v, w
after every few events, and v, w of the moving nodes are corrected at each to satisfy their
equations, so that nothing accumulates. A limit that is overstepped before the end of the load
step by no more than round-off is touched, not reached.

A load step is first tried as a quiet one (:func:`quiet_steps`);
only where something happens in it is it followed from event to event. The loops
return to Python after a stated amount of work, and can be entered again. Where
pivoting finds no rates, contact states are enumerated from Python.

Together with the motion its derivative with respect to the state at the start
of a cycle can be followed: between events it is constant, because the rates do
not depend on the state, and at an event at time τ it changes by (u̇⁻ − u̇⁺) ∂τ.

Quiet load steps
----------------
While the contact states stay as they are, displacements and reactions are linear
in the load, so that a condition that holds at both ends of a load step holds
within it. A whole load step is passed at once where

    stuck nodes      |q| ≤ f p       at its end,
    slipping nodes   p ≥ 0           at its end, and Δv in their direction,
    open nodes       w ≥ 0           at its end,

and the motion is stable (positive determinant). No event lies within it then,
and the states hold at its beginning: the event loop would have found the same.
Everything else is left to the event loop, untouched.

With all nodes stuck nothing moves, and a load step costs the comparison of its
reactions with the limits.
"""

from functools import cache
from itertools import product
from math import prod

import numpy as np
from numba import types

from shakedown.ground.constants import ROUND_OFF, FloatArray
from shakedown.ground.named_state import address_of, entered, handed_on, inner
from shakedown.ground.status import BACKWARD_SLIP, FORWARD_SLIP, OPEN, STICK
from shakedown.motion.course import ENUMERABLE, HASH_PRIME, Course, EventKind, LoopEnd, code_of
from shakedown.motion.plane import active_set
from shakedown.motion.plane.active_set import (
    AIR,
    APEX,
    FRICTIONLESS,
    ON_BACKWARD,
    ON_FORWARD,
    ActiveSet,
    Rates,
)
from shakedown.motion.plane.moving_state import PlaneMotion, PlaneRun, Record

MOST_FOLLOWED = 64  # load steps after which κ u is recomputed, so that round-off does not accumulate


@inner
def quiet_steps(act: ActiveSet, rate: Rates, mo: PlaneMotion, rec: Record, course: Course) -> None:
    """Pass load steps as long as nothing happens in them, or until there is no capacity to record more."""
    n, path, elastic, friction, small = act.n, course.path, mo.elastic, act.f, course.force
    while mo.step < course.steps and has_capacity(rec) and act.sign > 0 and act.effort <= act.allowed:
        if act.size > 0:
            if not moving_step(act, rate, mo, rec, course):
                return
        else:
            end = (mo.step + 1) * 2 * n
            for i in range(n):
                q, p = path[end + i] + elastic[i], path[end + n + i] + elastic[n + i]
                if not abs(q) <= friction[i] * p + small:
                    return
            pass_step(act, mo, rec, course)
            act.effort += n


@inner
def moving_step(act: ActiveSet, rate: Rates, mo: PlaneMotion, rec: Record, course: Course) -> bool:
    """Pass one load step in the present states; False, and nothing changed, where a condition breaks."""
    m, path, u, elastic = 2 * act.n, course.path, mo.u, mo.elastic
    change, reaction, end = rate.change, rate.reaction, (mo.step + 1) * m
    for j in range(m):
        reaction[j] = path[end + j] + elastic[j]
    solved = active_set.move(act, reaction, change, act.row, course.residual, 0.0)
    if not (solved and states_hold(act, rate, mo, course)):
        return False
    pass_step(act, mo, rec, course)
    count_slip(act, rate, mo, course)
    for j in range(m):
        u[j] += change[j]
        elastic[j] = reaction[j] - path[end + j]
    mo.followed += 1
    if mo.followed > MOST_FOLLOWED:
        compute_elastic(act, mo)
    return True


@inner
def states_hold(act: ActiveSet, rate: Rates, mo: PlaneMotion, course: Course) -> bool:
    """Whether all nodes keep their states over a load step with these changes and final reactions."""
    n, states, friction, path, start = act.n, act.state, act.f, course.path, mo.step * 2 * act.n
    change, reaction, small = rate.change, rate.reaction, course.force
    zero_motion = course.rate * active_set.largest(change, 2 * n)
    for i in range(n):
        if states[i] == STICK:
            if not abs(reaction[i]) <= friction[i] * reaction[n + i] + small:
                return False
        elif states[i] == OPEN:
            gap = mo.u[n + i]
            if gap <= course.length or not gap + change[n + i] >= -course.length:
                return False
        else:
            if path[start + n + i] + mo.elastic[n + i] <= small or not reaction[n + i] >= -small:
                return False
            if friction[i] > 0.0 and not states[i] * change[i] <= zero_motion:
                return False
    return True


@inner
def count_slip(act: ActiveSet, rate: Rates, mo: PlaneMotion, course: Course) -> None:
    """Add up slip in contact, dissipation, and which nodes are open over the load step just passed."""
    states, change, reaction, start = act.state, rate.change, rate.reaction, (mo.step - 1) * 2 * act.n
    for i in range(act.n):
        if states[i] == OPEN:
            mo.opened[i] = 1
        elif states[i] != STICK:
            taken = 0.5 * change[i] * (course.path[start + i] + mo.elastic[i] + reaction[i])
            mo.slip[i] += abs(change[i])
            mo.work[i] -= taken
            mo.dissipation -= taken


@inner
def pass_step(act: ActiveSet, mo: PlaneMotion, rec: Record, course: Course) -> None:
    """Record the state at the beginning of a load step, and count the step."""
    if not mo.signed:
        sign(act, mo, course.first + mo.step)
    if rec.capacity > 0:
        start = mo.step * 2 * act.n
        for j in range(2 * act.n):
            mo.r[j] = course.path[start + j] + mo.elastic[j]
        note(act, mo, rec, course.first)
    mo.step += 1


@inner
def compute_elastic(act: ActiveSet, mo: PlaneMotion) -> None:
    """κ u afresh."""
    elastic = mo.elastic
    for j in range(2 * act.n):
        elastic[j] = 0.0
    active_set.add_product(act, mo.u, elastic)
    mo.followed = 0


@inner
def has_capacity(rec: Record) -> bool:
    """Whether a state can be recorded, or none is to be."""
    return rec.capacity == 0 or rec.rows < rec.capacity


@inner
def note(act: ActiveSet, mo: PlaneMotion, rec: Record, first: int) -> None:
    """Record the present state and what led to it, where there is capacity."""
    if rec.capacity > 0:
        row, n, u, r, states = rec.rows, act.n, rec.u, rec.r, rec.state
        for j in range(2 * n):
            u[row * 2 * n + j], r[row * 2 * n + j] = mo.u[j], mo.r[j]
        for i in range(n):
            states[row * n + i] = act.state[i]
        rec.time[row], rec.node[row], rec.kind[row] = first + mo.step + mo.time, mo.node, mo.kind
        rec.rows = row + 1


@inner
def sign(act: ActiveSet, mo: PlaneMotion, step: int) -> None:
    """Enter the present states and the load step that they begin in into the signature."""
    code = code_of(act.state, 0, act.n)
    for i in range(act.n):
        if act.state[i] != OPEN:
            mo.closed[i] = 1
    if code != mo.last_states:
        mo.signature = ((mo.signature ^ code) * HASH_PRIME ^ np.uint64(step + 2)) * HASH_PRIME
        mo.last_states = code
    mo.signed = True


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
    act.effort, act.allowed, rec.rows, status = 0, effort, 0, LoopEnd.DONE
    compute_elastic(act, mo)
    while mo.passes < passes and status == LoopEnd.DONE:
        if mo.time == 0.0 and mo.kind == EventKind.LOAD_STEP:
            quiet_steps(act, rate, mo, rec, course)
        if mo.step < course.steps:
            status = load_step(act, rate, mo, rec, course)
        if mo.step == course.steps:
            mo.passes += 1
            mo.step = 0
            compute_elastic(act, mo)
        if status == LoopEnd.DONE and mo.passes < passes and act.effort > act.allowed:
            status = LoopEnd.PAUSED
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
    while mo.events_in_step < 1000 + 100 * m:
        if not has_capacity(rec):
            return LoopEnd.RECORD_FULL
        react(act, rate, mo, course)
        active_set.locate(act, rate, mo.u, mo.r, course.force, course.length)
        place_event(rate, mo.node, mo.kind)
        solved = active_set.solve_rates(act, rate, course.rate, known)
        known = True  # up to the next event
        mo.concerned = leaving_node(act, rate, solved)
        if not course.separable and mo.concerned >= 0:
            return LoopEnd.LIFTS_OFF
        if not solved:
            note(act, mo, rec, course.first)
            return LoopEnd.NO_RATES
        if not refine(act, rate, mo, course.residual) and (
            act.updates == 0 or active_set.factorize(act) == 0 or not refine(act, rate, mo, course.residual)
        ):
            return LoopEnd.NOT_HELD
        apply_delay(mo, rate.motion, -1.0)
        note(act, mo, rec, course.first)
        duration, node, kind = next_event(act, rate, mo, course)
        mo.signed = False
        if duration > ROUND_OFF:  # shorter intervals are not part of the signature
            sign(act, mo, course.first + step)
        advance(act, rate, mo, duration)
        mo.node, mo.kind = node, kind
        if kind == EventKind.LOAD_STEP:
            mo.step, mo.time, mo.events_in_step = step + 1, 0.0, 0
            return LoopEnd.DONE
        follow_event(act, rate, mo, node, kind)
        mo.events += 1
        mo.events_in_step += 1
        if act.effort > act.allowed:
            return LoopEnd.PAUSED
    return LoopEnd.TOO_MANY_EVENTS


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
    if kind in (EventKind.OPENS, EventKind.CLOSES):
        rate.place[node] = APEX
    elif kind == EventKind.REACHES_BACKWARD_LIMIT and rate.place[node] != APEX:
        rate.place[node] = ON_BACKWARD
    elif kind == EventKind.REACHES_FORWARD_LIMIT and rate.place[node] != APEX:
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
def refine(act: ActiveSet, rate: Rates, mo: PlaneMotion, residual: float) -> bool:
    """Correct u and r of the moving nodes to satisfy their equations to round-off."""
    u, r, elastic, change = mo.u, mo.r, mo.elastic, rate.change
    if active_set.largest_residual(act, r) <= residual:
        return True
    for k in range(2 * act.n):
        elastic[k] -= r[k]
    active_set.move(act, r, change, act.row, residual, 0.0)
    for k in range(2 * act.n):
        elastic[k] += r[k]
        u[k] += change[k]
    return active_set.largest_residual(act, r) <= 1e3 * residual


@inner
def next_event(act: ActiveSet, rate: Rates, mo: PlaneMotion, course: Course) -> tuple[float, int, int]:
    """Duration to the next event, its node and its kind.

    A guard that a node has just reached does not count again: the rates have
    been chosen so that it is not overstepped.
    """
    n, rest, states, places, friction = act.n, 1.0 - mo.time, act.state, rate.place, act.f
    u, r, motion, reaction = mo.u, mo.r, rate.motion, rate.reaction
    first, node, kind = rest, -1, EventKind.LOAD_STEP
    for i in range(n):
        state, place, f = states[i], places[i], friction[i]
        if place == APEX and (state in (STICK, OPEN)):
            continue
        if state == STICK:
            if place != ON_BACKWARD:
                distance, approach = f * r[n + i] - r[i], f * reaction[n + i] - reaction[i]
                until = time_to_zero(distance, approach, rest, course.force)
                if until < first:
                    first, node, kind = until, i, EventKind.REACHES_BACKWARD_LIMIT
            if place != ON_FORWARD:
                distance, approach = f * r[n + i] + r[i], f * reaction[n + i] + reaction[i]
                until = time_to_zero(distance, approach, rest, course.force)
                if until < first:
                    first, node, kind = until, i, EventKind.REACHES_FORWARD_LIMIT
        elif state == OPEN:
            until = time_to_zero(u[n + i], motion[n + i], rest, course.length)
            if until < first:
                first, node, kind = until, i, EventKind.CLOSES
        elif place != APEX:
            until = time_to_zero(r[n + i], reaction[n + i], rest, course.force)
            if until < first:
                first, node, kind = until, i, EventKind.OPENS
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
    if kind == EventKind.CLOSES:
        mo.u[n + node] = 0.0
        mo.followed = MOST_FOLLOWED
    if t == 0:
        return
    for c in range(t):
        delay[c] = 0.0
    if kind == EventKind.CLOSES:
        for c in range(t):
            delay[c] = -tangent[(n + node) * t + c] / rate.motion[n + node]
    else:
        side, f = 0.0, 1.0
        if kind != EventKind.OPENS:
            side, f = (1.0 if kind == EventKind.REACHES_BACKWARD_LIMIT else -1.0), act.f[node]
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


def choices(place: int, f: float) -> tuple[int, ...]:
    """States that a place leaves open."""
    if place == APEX:
        return (STICK, BACKWARD_SLIP, FORWARD_SLIP, OPEN) if f > 0.0 else (BACKWARD_SLIP, OPEN)
    if place in (ON_BACKWARD, ON_FORWARD):
        return (STICK, place)
    return {AIR: (OPEN,), FRICTIONLESS: (BACKWARD_SLIP,)}.get(place, (STICK,))


def enumerate_states(act: ActiveSet, rate: Rates, rate_tol: float) -> bool:
    """Take the first combination of states that is a stable solution; False, and nothing changed, if none is.

    Places and rates of the load are those at which pivoting has failed. None is
    tried where there are more than 2 ** ``ENUMERABLE`` combinations.
    """
    before = act.state.copy()
    open_to = [choices(int(place), float(f)) for place, f in zip(rate.place, act.f, strict=True)]
    few = prod(len(states) for states in open_to) <= 1 << ENUMERABLE
    for states in product(*reversed(open_to)) if few else ():  # the first node's changes first
        rate.wanted[:] = states[::-1]
        if try_wanted(act, rate, rate_tol):
            return True
    rate.wanted[:] = before
    take_wanted(act, rate)
    return False


@entered
def try_wanted(act: ActiveSet, rate: Rates, rate_tol: float) -> bool:
    """Take the wanted states: whether the motion in them satisfies its conditions and is stable."""
    if not active_set.reach_states(act, rate.wanted):
        return False
    if not active_set.compute_rates(act, rate) and active_set.factorize(act) != 0:
        active_set.compute_rates(act, rate)
    return act.sign > 0 and active_set.count_broken(act, rate, rate_tol) == 0


@entered
def take_wanted(act: ActiveSet, rate: Rates) -> bool:
    """Take the wanted states; False where the matrix of their equations is singular."""
    return active_set.reach_states(act, rate.wanted)
