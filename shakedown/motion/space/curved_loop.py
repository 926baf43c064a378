"""The motion in two tangential directions over one load step: along a smooth path from event to event.

Within a load step the welded reactions change linearly. Between two events the slips obey
v̇ = μ u, a smooth differential equation (:mod:`.speeds`), which steps of order 5, explicit ones or, near
the apex, Radau's, follow to a given accuracy; while nothing slips everything is linear. Events are found on
the polynomial of a step, and where that is not accurate enough the step is taken again, hardly beyond them.
The rates after an event are those of :mod:`.rate_choice`.

The error estimate is the sum of those of the steps. The difference of the two members of the pair is the
error of the lower order; that of the higher, which is followed, is taken to be smaller by the ratio by which
errors have fallen from order to order so far, (difference / slip)^(1/5), or ^(1/2) of Radau's, two orders
higher. Of the sum every step may use a
share in proportion to its length, and a small one besides; the lower order, that of the polynomial between
the ends of a step, may be in error by the whole of it.
"""

import numpy as np

from shakedown.ground.constants import ROUND_OFF, SEVEN_DIGITS
from shakedown.ground.named_state import entered, inner, summing
from shakedown.ground.status import OPEN, STICK
from shakedown.motion.course import HASH_PRIME, Course, EventKind, LoopEnd, code_of
from shakedown.motion.space.event_search import NEVER, end_of_step, expected, first_event
from shakedown.motion.space.rate_choice import choose_rates
from shakedown.motion.space.smooth_step import BETWEEN, explicit_step, stop_within, turning, turning_step
from shakedown.motion.space.space_run import (
    DEGREE,
    EXPLICIT,
    EXPLICIT_STEPS,
    RADAU,
    STAGES,
    CompiledJoint,
    Slipping,
    SpaceMotion,
    SpaceRates,
    SpaceRun,
    Step,
)
from shakedown.motion.space.speeds import MOST_EXCHANGES, arrange, compute_out, move

SAFETY, SHRINKS_TO = 0.9, 0.2  # bounds on the next step, relative to the last
GROWS_TO = 1.0 / SHRINKS_TO
ORDER = 1 / 6  # exponent of the step length as a function of the allowed error
BEYOND = 1.02  # length of a step taken again to meet an event, relative to the time of that …
SHORTER = 0.85  # … or at most so much of the step: below the 0.9 that goes on to the end of the load step
STABLE = 2.5  # rotation of a direction towards its limit in an explicit step; it becomes unstable from 3.3 on
HALF_WAY = 0.5  # share of the time to an apex at the present rate that explicit steps may take
GAIN = 5.0  # cost of such a step relative to an explicit one
GAUSS = 0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)  # shares of a step …
GAUSS_WEIGHTS = 5 / 18, 8 / 18, 5 / 18  # … at which speeds give a length


@entered
def follow_curve(run: SpaceRun, effort: int) -> int:
    """Carry the state along its course to its end.

    Ends with DONE, or with why the motion stopped; after RECORD_FULL and PAUSED, and where there were
    NO_RATES and the state has jumped, it can be entered again. Between two load steps it pauses, too, where
    the matrix of ``joint`` is to be made afresh.
    """
    joint, course, mo, st, rec = run.joint, run.course, run.motion, run.step, run.record
    st.effort, st.allowed, rec.rows, status = 0, effort, 0, LoopEnd.DONE
    while mo.step < course.steps and status == LoopEnd.DONE:
        status = load_step(run)
        wait = st.effort > st.allowed or joint.exchanges > MOST_EXCHANGES
        if status == LoopEnd.DONE and mo.step < course.steps and wait:
            status = LoopEnd.PAUSED
    if mo.step == course.steps:
        mo.passes = 1
    return status


@inner
def load_step(run: SpaceRun) -> int:
    """Carry the state from event to event to the end of its load step."""
    joint, course, mo, rates, st = run.joint, run.course, run.motion, run.rates, run.step
    N, status = 3 * joint.n, LoopEnd.AT_EVENT
    for k in range(N):
        rates.welded[k] = course.path[(mo.step + 1) * N + k] - course.path[mo.step * N + k]
    if not mo.entered:
        if not arrange(joint, mo):
            return LoopEnd.NOT_HELD
        if mo.step == 0 or mo.time > 0.0:  # elsewhere the last load step has ended with them
            compute_out(joint, course, mo, rates)
        for i in range(joint.n):
            mo.resting[i], rates.arrived[i] = 0, 0
        mo.entered = True
    while status == LoopEnd.AT_EVENT:
        if not mo.under_way and mo.time < 1.0:
            status = begin_path(run)
            if status != LoopEnd.AT_EVENT:
                return status
        status = smooth_path(run)
        mo.under_way = status in (LoopEnd.PAUSED, LoopEnd.RECORD_FULL)
        if status == LoopEnd.AT_EVENT and st.effort > st.allowed:
            return LoopEnd.PAUSED
    if status == LoopEnd.DONE:
        mo.step, mo.time, mo.events_in_step, mo.entered = mo.step + 1, 0.0, 0, False
        mo.kind, mo.node = EventKind.LOAD_STEP, -1
    return status


@inner
def begin_path(run: SpaceRun) -> int:
    """Choose the rates with which the path goes on: AT_EVENT, or why it does not."""
    joint, course, mo, rates, st = run.joint, run.course, run.motion, run.rates, run.step
    if mo.events_in_step > 1000 + 200 * joint.n:
        return LoopEnd.TOO_MANY_EVENTS
    found = choose_rates(run)
    leaving = leaving_node(joint, mo, rates, found)
    if not course.separable and leaving >= 0:
        mo.concerned = leaving
        return LoopEnd.LIFTS_OFF
    if not found:
        return LoopEnd.NO_RATES
    st.apex_ahead = np.inf
    return LoopEnd.AT_EVENT


@inner
def leaving_node(joint: CompiledJoint, mo: SpaceMotion, rates: SpaceRates, found: bool) -> int:
    """An open node; where there are no rates, a node at its apex; or −1."""
    for i in range(joint.n):
        if mo.contact[i] == OPEN or (not found and rates.apex[i] == 1):
            return i
    return -1


@inner
def smooth_path(run: SpaceRun) -> int:
    """Follow the smooth path to the next event or the end of the load step."""
    course, mo, sp, st, rec = run.course, run.motion, run.slipping, run.step, run.record
    while mo.time < 1.0:
        if rec.capacity > 0 and rec.rows == rec.capacity:
            return LoopEnd.RECORD_FULL
        rest = 1.0 - mo.time
        h = choose_step(run, rest)
        error = take_step(run, h)
        better = better_error(sp, st, error)
        used = max(better / allowed_error(course, st, h), error / (st.accuracy * st.length_scale))
        if not 0.0 <= used <= 1.0:
            shorten(run, h, used)
            if not st.h > ROUND_OFF:  # no step is short enough, so there are no rates
                return LoopEnd.NO_RATES
            continue
        share, node, kind = first_event(run, h)
        # share of a step from which on its polynomial is as accurate as its end
        if share * h > ROUND_OFF and share < 0.9 and error > allowed_error(course, st, share * h):
            try_next(st, min(BEYOND * share, SHORTER) * h)
            continue
        lengthen(st, h, used)
        if share < NEVER:
            meet_event(run, share, h, error, node, kind)
            return LoopEnd.AT_EVENT
        commit(run, h, 1.0, better)
        if h == rest:
            mo.time = 1.0
        keep_rates(sp, st)
        mo.kind, mo.node = EventKind.CURVES, -1
        if st.effort > st.allowed and mo.time < 1.0:
            return LoopEnd.PAUSED
    return LoopEnd.DONE


@inner
def shorten(run: SpaceRun, h: float, used: float) -> None:
    """Reduce the step after one with a given share of the allowed error, or one that failed."""
    joint, course, rates, sp, st = run.joint, run.course, run.rates, run.slipping, run.step
    try_next(st, h * (max(SHRINKS_TO, min(SAFETY, SAFETY * used**-ORDER)) if used > 0.0 else SHRINKS_TO))
    if st.method == RADAU:
        st.apex_ahead = HALF_WAY * min(h, time_to_apex(joint, course, rates, sp))
        st.wait = EXPLICIT_STEPS


@inner
def try_next(st: Step, h: float) -> None:
    """Choose the length of the next step by the method of the present one."""
    if st.method == RADAU:
        st.long = h
    else:
        st.h = h


@inner
def lengthen(st: Step, h: float, used: float) -> None:
    """Choose the next step length after one with a given share of the allowed error."""
    tried = st.long if st.method == RADAU else st.h
    longer = h * (min(GROWS_TO, max(SHRINKS_TO, SAFETY * used**-ORDER)) if used > 0.0 else GROWS_TO)
    if h < 0.99 * tried:  # it has ended earlier for another reason
        longer = max(longer, tried)
    try_next(st, longer)
    if st.method == RADAU:
        st.wait = 0
    else:
        st.long = max(st.long, st.h)
        if st.wait > 0:
            st.wait -= 1
            if st.wait == 0:
                st.long = max(st.long, 2.0 * GAIN * h)


@inner
def next_length(sp: Slipping, rest: float, free: float, event: float) -> float:
    """The step to try: not far beyond the next event, and without leaving a short remainder."""
    if sp.s == 0:
        return rest
    # length of a step relative to the expected time of the next event
    h = 1.05 * event
    if h < min(free, 0.9 * rest):
        return max(h, SHRINKS_TO * min(free, rest))
    if free > 0.9 * rest:
        return rest
    return 0.5 * rest if free > 0.5 * rest else free


@inner
def time_to_apex(joint: CompiledJoint, course: Course, rates: SpaceRates, sp: Slipping) -> float:
    """When the first pressure of a slipping node vanishes at the present rates."""
    first = np.inf
    for a in range(sp.s):
        p, rate = sp.p[a], rates.rate[2 * joint.n + sp.node[a]]
        if p > course.residual and rate < 0.0:
            first = min(first, p / -rate)
    return first


@inner
def choose_step(run: SpaceRun, rest: float) -> float:
    """Choose method and length of the step; explicit ones only if no direction turns too far.

    Towards the apex a direction turns faster and faster: a Radau step ends there once
    that is accurate enough, explicit ones come half the way. Elsewhere Radau's are tried now and then where
    directions turn fast, and go on as long as they are longer by what they cost.
    """
    joint, course, rates, sp, st = run.joint, run.course, run.rates, run.slipping, run.step
    fastest, apex = 0.0, time_to_apex(joint, course, rates, sp)
    for a in range(sp.s):
        fastest = max(fastest, turning(sp, st, a, 0.0))
    event = expected(run)
    h, far = next_length(sp, rest, st.h, event), next_length(sp, rest, st.long, event)
    most = HALF_WAY * apex
    if fastest * SEVEN_DIGITS * rest < STABLE:  # even such fine steps may turn too far: errors limit them
        most = min(most, STABLE / fastest if fastest > 0.0 else np.inf)
    st.method = EXPLICIT
    short = min(h, most)
    jumps = far > HALF_WAY * apex and apex < st.apex_ahead
    # rotation in an explicit step from which on such a step is tried
    stiff = st.wait == 0 and far > GAIN * short and short * fastest > 1.5
    if jumps or stiff:
        st.method = RADAU
        return far
    return short


@inner
def take_step(run: SpaceRun, h: float) -> float:
    """A step from the present state, and the outputs at its end: the error of the lower order, or FAILED."""
    course, sp, st = run.course, run.slipping, run.step
    allowed = allowed_error(course, st, h)
    error = turning_step(run, h, allowed) if st.method == RADAU else explicit_step(run, h)
    if error >= 0.0:
        end_of_step(run, h)
    st.taken += 1
    st.effort += 120 * sp.s * sp.s + 12 * st.n * sp.s + 500
    return error


@inner
def allowed_error(course: Course, st: Step, h: float) -> float:
    """The error allowed for a step of this length [length]."""
    # share of the error of a passage that a step may use regardless of its length
    return st.accuracy * st.length_scale * (h / course.steps + 0.002)


@inner
def better_error(sp: Slipping, st: Step, error: float) -> float:
    """The error of the higher order from that of the lower, assuming a constant ratio between orders."""
    longest = 0.0
    for c in range(2 * sp.s):
        longest = max(longest, abs(st.slip[c]))
    if not 0.0 < error < longest:
        return error
    return error * (error / longest) ** (0.5 if st.method == RADAU else 0.2)


@inner
def meet_event(run: SpaceRun, share: float, far: float, error: float, i: int, kind: int) -> None:
    """Go to the event of a node at a share of the step just taken, of this length and error, and pass it.

    On the polynomial, which there is accurate enough: everywhere, or as near its end as this.
    """
    joint, course, mo, rates = run.joint, run.course, run.motion, run.rates
    sp, st = run.slipping, run.step
    h = share * far
    if h <= ROUND_OFF:
        stay(run)
    else:
        stop_within(course, mo, sp, st, far, share)
        end_of_step(run, h)
        commit(run, h, share, error if error <= allowed_error(course, st, h) else better_error(sp, st, error))
    mo.kind, mo.node = kind, i
    pass_event(joint, mo, rates, i, kind)


@inner
def stay(run: SpaceRun) -> None:
    """Record a state that an event leaves at once."""
    st = run.step
    for c in range(DEGREE * 2 * st.n):
        st.curve[c] = 0.0
    note(run, 0.0)


@inner
def pass_event(joint: CompiledJoint, mo: SpaceMotion, rates: SpaceRates, i: int, kind: int) -> None:
    """Put a node exactly at its event."""
    for j in range(joint.n):
        rates.arrived[j] = 0
    if kind == EventKind.REACHES_LIMIT:
        rates.arrived[i], mo.resting[i] = 1, 0
    elif kind == EventKind.STOPS:
        mo.contact[i], mo.resting[i] = STICK, 1
    mo.events += 1
    mo.events_in_step += 1


@summing
def commit(run: SpaceRun, h: float, share: float, error: float) -> None:
    """Accept the step up to a share of it, where it ends: sums first, then the state."""
    mo, sp, st = run.motion, run.slipping, run.step
    n, far = st.n, h / share
    for a in range(sp.s):
        way, work = 0.0, 0.0
        for j in range(STAGES):
            weight, power = 0.0, 1.0
            for m in range(DEGREE):
                power *= share
                weight += power * BETWEEN[st.method, j, m]
            way += weight * st.mu[j * n + a]
            work += weight * st.dissipation[j * n + a]
        mo.slip[sp.node[a]] += far * way
        mo.work[sp.node[a]] += far * work
    pass_on(run, h, error)


@inner
def pass_on(run: SpaceRun, h: float, error: float) -> None:
    """Record the step and go to its end."""
    joint, course, mo, rates, sp, st = run.joint, run.course, run.motion, run.rates, run.slipping, run.step
    n = joint.n
    note(run, h)
    for i in range(n):
        if joint.friction[i] == 0.0 and mo.contact[i] != OPEN:
            mo.slip[i] += way_without_friction(mo, rates, st, i, h)
    for a in range(sp.s):
        i = sp.node[a]
        for c in range(2):
            mo.u[2 * i + c] += st.slip[2 * a + c]
            sp.q[2 * a + c] = st.stage_q[2 * a + c]
        sp.p[a] = st.next_out[2 * n + i]
    for k in range(3 * n):
        mo.out[k], rates.rate[k] = st.next_out[k], st.next_rate[k]
        if joint.free[k] == 1:
            mo.u[k] = mo.out[k]
    for i in range(n):
        if mo.contact[i] != OPEN:
            mo.closed[i] = 1
        elif mo.u[2 * n + i] > course.length:  # not where the pressure only touches zero
            mo.opened[i] = 1
    mo.time += h
    mo.error += error
    sign(joint, course, mo)


@inner
def way_without_friction(mo: SpaceMotion, rates: SpaceRates, st: Step, i: int, h: float) -> float:
    """The path length of a frictionless node in the step, along the cubic through both ends [length]."""
    x, y, way = 2 * i, 2 * i + 1, 0.0
    for j in range(len(GAUSS)):
        at = GAUSS[j]
        chord, begin, end = (
            6.0 * at * (1.0 - at),
            (1.0 - at) * (1.0 - 3.0 * at) * h,
            at * (3.0 * at - 2.0) * h,
        )
        vx = chord * (st.next_out[x] - mo.u[x]) + begin * rates.rate[x] + end * st.next_rate[x]
        vy = chord * (st.next_out[y] - mo.u[y]) + begin * rates.rate[y] + end * st.next_rate[y]
        way += GAUSS_WEIGHTS[j] * np.sqrt(vx * vx + vy * vy)
    return way


@inner
def keep_rates(sp: Slipping, st: Step) -> None:
    """Use the rates at the end of a step at the beginning of the next."""
    row, last = 2 * st.n, STAGES - 1
    for c in range(2 * sp.s):
        st.k[c], st.k_q[c] = st.k[last * row + c], st.k_q[last * row + c]
    for a in range(sp.s):
        st.mu[a], st.dissipation[a] = st.mu[last * st.n + a], st.dissipation[last * st.n + a]


@inner
def note(run: SpaceRun, h: float) -> None:
    """Record the step that begins at the present state, where there is capacity."""
    joint, course, mo, rates = run.joint, run.course, run.motion, run.rates
    sp, st, rec = run.slipping, run.step, run.record
    if rec.capacity == 0 or rec.rows == rec.capacity:
        return
    n, N, row = joint.n, 3 * joint.n, rec.rows
    for k in range(N):
        rec.u[row * N + k] = mo.u[k]
    for i in range(n):
        rec.contact[row * n + i] = mo.contact[i]
    for m in range(DEGREE):
        start = (row * DEGREE + m) * N
        move(joint, sp, st.curve, m * 2 * n, st.scratch)
        for k in range(N):
            linear = h * rates.base[k] if m == 0 else 0.0
            rec.curve[start + k] = st.scratch[k] + linear if joint.free[k] == 1 else 0.0
        for a in range(sp.s):
            for c in range(2):
                rec.curve[start + 2 * sp.node[a] + c] = st.curve[m * 2 * n + 2 * a + c]
    rec.time[row], rec.duration[row] = course.first + mo.step + mo.time, h
    rec.node[row], rec.kind[row] = mo.node, mo.kind
    rec.rows = row + 1


@inner
def sign(joint: CompiledJoint, course: Course, mo: SpaceMotion) -> None:
    """Enter the present contact states and the load step that they begin in into the signature."""
    code = code_of(mo.contact, 0, joint.n)
    if code != mo.last_states:
        step = np.uint64(course.first + mo.step + 2)
        mo.signature = ((mo.signature ^ code) * HASH_PRIME ^ step) * HASH_PRIME
        mo.last_states = code
