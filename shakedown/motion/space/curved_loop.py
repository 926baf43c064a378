"""The motion in two tangential directions over one load step: along a smooth path from event to event.

Within a load step the welded reactions change linearly. Between two events the slips obey
v̇ = μ u, a smooth differential equation (:mod:`.speeds`), which steps of order 5, explicit ones or, near
the apex, Radau's, follow to a given accuracy; while nothing slips everything is linear. Events are found on
the polynomial of a step and the step is taken again up to them. The rates after an event are those of
:mod:`.rate_choice`.

The error estimate is the sum of those of the steps. The difference of the two members of the pair is the
error of the lower order; that of the higher, which is followed, is taken to be smaller by the ratio by which
errors have fallen from order to order so far, (difference / slip)^(1/5), or ^(1/2) of Radau's, two orders
higher. Of the sum every step may use a
share in proportion to its length, and a small one besides; the lower order, that of the polynomial between
the ends of a step, may be in error by the whole of it.
"""

import numpy as np

from shakedown.ground.contact_status import OPEN, STICK
from shakedown.ground.named_state import entered, inner, summing
from shakedown.motion.plane.moving_state import (
    CLOSES,
    DONE,
    LIFTS_OFF,
    LOAD_STEP,
    NO_RATES,
    NOT_SETTLED,
    PAUSED,
    RECORD_FULL,
    TOO_MANY_EVENTS,
)
from shakedown.motion.space.event_search import (
    NEVER,
    distance,
    distance_rate,
    end_of_step,
    expected,
    first_event,
    margin,
    step_out,
)
from shakedown.motion.space.exchange import MOST_EXCHANGES, arrange, compute_out, move
from shakedown.motion.space.explicit_step import BETWEEN, ENDS, explicit_step, find_curve, stop_within
from shakedown.motion.space.rate_choice import choose_rates
from shakedown.motion.space.sliding import (
    CURVES,
    DEGREE,
    EXPLICIT,
    RADAU,
    REACHES_LIMIT,
    STAGES,
    STOPS,
    CurveRecord,
    Sliding,
)
from shakedown.motion.space.turning_step import turning, turning_step

AT_EVENT = PAUSED + 1  # within a load step
AHEAD = 1.05  # how far to go, relative to the time at which the next event is expected
SHORTEST = 1e-13  # of a load step: steps that would have to be shorter have no rates before them
BESIDE = 0.002  # of the error of a passage, that a step may use whatever its length
SAFETY, LEAST, MOST = 0.9, 0.2, 5.0  # of the next step, relative to the last
ORDER = 1 / 6  # power with which a step grows with the error that it may have
MOST_REFINED = 8  # steps taken again up to one event
MET = 0.02  # distance from an event at which it is met, relative to that at which a node is at its limit
CLOSE = 1e-3  # share of a step by which an event may be missed to be met on the polynomial of the step
STABLE = 2.5  # angle towards where a direction tends, in an explicit step; from 3.3 on it would grow
HALF_WAY = 0.5  # of the time to an apex at the present rate, that explicit steps may take
NEARER = 0.4  # power with which the error of a step to an apex falls with its length, at least
PAST = 0.8  # share of a step of Radau's at which a pressure vanishes, and that it may be long
GAIN = 5.0  # what such a step costs, relative to an explicit one
TURNS, MANY = 1.5, 0.05  # angle in an explicit step, and its share of the rest, where it is tried
FINEST = (
    1e-7  # of the rest: where even such explicit steps turn too far their error alone says how long they are
)
PATIENCE, MOST_PATIENCE = 20, 320  # explicit steps after one that was refused
GAUSS = 0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)  # shares of a step …
GAUSS_WEIGHTS = 5 / 18, 8 / 18, 5 / 18  # … at which speeds tell a length
STOPPED = 1e-6  # speed, relative to the fastest, that is none at a stop


@entered
def follow_curve(sl: Sliding, rec: CurveRecord, effort: int) -> int:
    """Carry the state along its course to its end.

    Ends with DONE, or with why the motion stopped; after RECORD_FULL and PAUSED, and where there were
    NO_RATES and the state has jumped, it can be entered again.
    """
    sl.effort, sl.allowed, rec.rows, status = 0, effort, 0, DONE
    if sl.step == 0 and sl.time == 0.0 and not sl.entered:
        sl.h = 1.0
        if sl.exchanges > 0:
            sl.exchanges = MOST_EXCHANGES + 1
    while sl.step < sl.steps and status == DONE:
        status = load_step(sl, rec)
        if status == DONE and sl.step < sl.steps and sl.effort > sl.allowed:
            status = PAUSED
    if sl.step == sl.steps:
        sl.passes = 1
    return status


@inner
def load_step(sl: Sliding, rec: CurveRecord) -> int:
    """Carry the state from event to event to the end of its load step."""
    N, status = 3 * sl.n, AT_EVENT
    for k in range(N):
        sl.welded[k] = sl.path[(sl.step + 1) * N + k] - sl.path[sl.step * N + k]
    if not sl.entered:
        if not arrange(sl):
            return NOT_SETTLED
        compute_out(sl)
        for i in range(sl.n):
            sl.resting[i], sl.arrived[i] = 0, 0
        sl.entered = True
    while status == AT_EVENT:
        if sl.crowd > 1000 + 200 * sl.n:
            return TOO_MANY_EVENTS
        found = choose_rates(sl)
        leaving = leaving_node(sl, found)
        if not sl.separable and leaving >= 0:
            sl.concerned = leaving
            return LIFTS_OFF
        if not found:
            return NO_RATES
        sl.effort += 2 * sl.s * sl.s * sl.s + 100
        sl.apex_ahead = np.inf
        status = smooth_path(sl, rec)
        if status == AT_EVENT and sl.effort > sl.allowed:
            return PAUSED
    if status == DONE:
        sl.step, sl.time, sl.crowd, sl.entered = sl.step + 1, 0.0, 0, False
        sl.kind, sl.event_node, sl.came_kind, sl.came_node = LOAD_STEP, -1, LOAD_STEP, -1
    return status


@inner
def leaving_node(sl: Sliding, found: bool) -> int:
    """An open node; where there are no rates, a node at its apex; or −1."""
    for i in range(sl.n):
        if sl.contact[i] == OPEN or (not found and sl.apex[i] == 1):
            return i
    return -1


@inner
def smooth_path(sl: Sliding, rec: CurveRecord) -> int:
    """Follow the smooth path to the next event or the end of the load step."""
    while sl.time < 1.0:
        if rec.room > 0 and rec.rows == rec.room:
            return RECORD_FULL
        rest = 1.0 - sl.time
        h = choose_step(sl, rest)
        error = take_step(sl, h)
        better = better_error(sl, error)
        used = max(better / allowed_error(sl, h), error / (sl.accuracy * sl.length_scale))
        if not 0.0 <= used <= 1.0:
            shorten(sl, h, used)
            if not sl.h > SHORTEST:
                return NO_RATES
            continue
        share = share_to_apex(sl)
        if share < (PAST if sl.method == RADAU else 1.0) and h * share > SHORTEST:
            if sl.method == RADAU:
                sl.long = h * share
            else:
                sl.h = h * share
            continue
        lengthen(sl, h, used, rest)
        share = first_event(sl, h)
        if share < NEVER:
            meet_event(sl, rec, share, h, error)
            return AT_EVENT
        if rec.room > 0:
            find_curve(sl, h)
        commit(sl, rec, h, better)
        if h == rest:
            sl.time = 1.0
        keep_rates(sl)
        sl.kind, sl.event_node, sl.came_kind, sl.came_node = CURVES, -1, CURVES, -1
        if sl.effort > sl.allowed and sl.time < 1.0:
            return PAUSED
    return DONE


@inner
def shorten(sl: Sliding, h: float, used: float) -> None:
    """What to try after a step with so much of the allowed error, or one that found no end."""
    share = max(LEAST, min(SAFETY, SAFETY * used**-ORDER)) if used > 0.0 else LEAST
    if sl.method == EXPLICIT:
        sl.h = h * share
    else:
        sl.long = h * share
        nearer = max(LEAST, min(HALF_WAY, used**-NEARER)) if used > 0.0 else LEAST
        sl.apex_ahead = nearer * min(h, time_to_apex(sl))
        sl.wait = sl.patience = min(2 * sl.patience, MOST_PATIENCE)


@inner
def lengthen(sl: Sliding, h: float, used: float, rest: float) -> None:
    """What to try after a step with so much of the allowed error."""
    change = min(MOST, max(LEAST, SAFETY * used**-ORDER)) if used > 0.0 else MOST
    if sl.method == RADAU:
        sl.long = max(h * change, sl.long) if h < 0.99 * sl.long else h * change
        sl.wait, sl.patience = 0, PATIENCE
    else:
        sl.h = max(h * change, sl.h) if h == rest or sl.capped else h * change
        sl.long = max(sl.long, sl.h)
        if sl.wait > 0:
            sl.wait -= 1
            if sl.wait == 0:
                sl.long = max(sl.long, 2.0 * GAIN * h)


@inner
def next_length(sl: Sliding, rest: float, free: float, event: float) -> float:
    """The step to try: not far beyond the next event, and so that no short one is left."""
    if sl.s == 0:
        return rest
    h = AHEAD * event
    if h < min(free, 0.9 * rest):
        return max(h, LEAST * min(free, rest))
    if free > 0.9 * rest:
        return rest
    return 0.5 * rest if free > 0.5 * rest else free


@inner
def time_to_apex(sl: Sliding) -> float:
    """When the first pressure of a slipping node vanishes at the present rates."""
    first = np.inf
    for a in range(sl.s):
        p, rate = sl.p[a], sl.rate[2 * sl.n + sl.node[a]]
        if p > sl.near and rate < 0.0:
            first = min(first, p / -rate)
    return first


@inner
def choose_step(sl: Sliding, rest: float) -> float:
    """Which step is to be taken, and how long it is: no explicit one in which a direction turns too far.

    On the way to the apex a direction turns the faster the nearer it is: a step of Radau's ends there once
    that is accurate enough, explicit ones come half the way. Elsewhere Radau's are tried now and then where
    directions turn fast, and go on as long as they are longer by what they cost.
    """
    fastest, apex = 0.0, time_to_apex(sl)
    for a in range(sl.s):
        fastest = max(fastest, turning(sl, a, 0.0))
    event = expected(sl)
    h, far = next_length(sl, rest, sl.h, event), next_length(sl, rest, sl.long, event)
    most = HALF_WAY * apex
    if fastest * FINEST * rest < STABLE:
        most = min(most, STABLE / fastest if fastest > 0.0 else np.inf)
    sl.method, sl.capped = EXPLICIT, h > most
    short = min(h, most)
    jumps = far > HALF_WAY * apex and apex < sl.apex_ahead
    stiff = sl.wait == 0 and short < MANY * rest and short * fastest > TURNS and far > GAIN * short
    if jumps or stiff:
        sl.method = RADAU
        return far
    return short


@inner
def take_step(sl: Sliding, h: float) -> float:
    """A step from the present state, and the outputs at its end: the error of the lower order, or FAILED."""
    allowed = allowed_error(sl, h)
    error = turning_step(sl, h, allowed) if sl.method == RADAU else explicit_step(sl, h, allowed)
    if error >= 0.0:
        end_of_step(sl, h)
    sl.taken += 1
    sl.effort += 6 * (sl.s * sl.s * sl.s + 20 * sl.s * sl.s) + 12 * sl.n * sl.s + 500
    return error


@inner
def allowed_error(sl: Sliding, h: float) -> float:
    """The error that a step of this length may have [length]."""
    return sl.accuracy * sl.length_scale * (h / sl.steps + BESIDE)


@inner
def better_error(sl: Sliding, error: float) -> float:
    """The error of the higher order from that of the lower: errors fall from order to order by one ratio."""
    longest = 0.0
    for c in range(2 * sl.s):
        longest = max(longest, abs(sl.slip[c]))
    if not 0.0 < error < longest:
        return error
    return error * (error / longest) ** (0.5 if sl.method == RADAU else 0.2)


@inner
def share_to_apex(sl: Sliding) -> float:
    """Share of the step, roughly, up to which no pressure of a slipping node passes zero."""
    share = 1.0
    for a in range(sl.s):
        place = 2 * sl.n + sl.node[a]
        p, end = sl.out[place], sl.next_out[place]
        if end < -sl.near and p > sl.near:
            share = min(share, p / (p - end))
    return share


@inner
def beyond(sl: Sliding) -> float:
    """How far the end of the step is from the event [force, length; at a stop relative to the fastest]."""
    i, kind, n = sl.event_node, sl.kind, sl.n
    if kind == STOPS:
        fastest, own = 0.0, 0.0
        for a in range(sl.s):
            mu = sl.mu[6 * n + a]
            fastest = max(fastest, abs(mu))
            if sl.node[a] == i:
                own = mu
        return own / fastest if fastest > 0.0 else 0.0
    x, y, p = 2 * i, 2 * i + 1, 2 * n + i
    start = distance(sl, i, kind, sl.out[x], sl.out[y], sl.out[p])
    end = distance(sl, i, kind, sl.next_out[x], sl.next_out[y], sl.next_out[p])
    return end + margin(sl, kind, start)


@inner
def meet_event(sl: Sliding, rec: CurveRecord, share: float, far: float, error: float) -> None:
    """Go to the event at a share of the step just taken, of this length and error, and pass it.

    On the polynomial where that is accurate enough; else the step is taken again, as often as it takes.
    """
    kind, i, h = sl.kind, sl.event_node, share * far
    if h <= SHORTEST:
        stay(sl, rec)
    elif error <= allowed_error(sl, h):
        stop_within(sl, far, share)
        step_out(sl, h)
        commit_within(sl, rec, h, share, error)
    else:
        h, error, share = refined_length(sl, h, far)
        if h <= SHORTEST:
            stay(sl, rec)
        elif share == 1.0:
            commit(sl, rec, h, max(error, 0.0))
        else:
            commit_within(sl, rec, h, share, max(error, 0.0))
    sl.kind, sl.event_node, sl.came_kind, sl.came_node = kind, i, kind, i
    pass_event(sl, i, kind)


@inner
def stay(sl: Sliding, rec: CurveRecord) -> None:
    """Record a state that an event leaves at once."""
    for c in range(DEGREE * 2 * sl.n):
        sl.curve[c] = 0.0
    note(sl, rec, 0.0)


@inner
def refined_length(sl: Sliding, guess: float, far: float) -> tuple[float, float, float]:
    """Length of a step to the event, its error, and the share of the step last taken at which it ends.

    A step that comes close ends on its polynomial a little before its end, or beyond.
    """
    kind = sl.kind
    near = sl.near * sl.length_scale / sl.force_scale if kind == CLOSES else sl.near
    met = STOPPED if kind == STOPS else MET * near
    low, at_low, high, at_high, h, error = 0.0, 0.0, far, 0.0, guess, 0.0
    known_low, known_high = False, False
    for _ in range(MOST_REFINED):
        if h <= SHORTEST:
            break
        error = take_step(sl, h)
        value = beyond(sl)
        if abs(value) <= met:
            break
        rate = 0.0 if kind == STOPS else distance_rate(sl, sl.event_node, kind, 1)
        if rate < 0.0 and abs(value) < -CLOSE * h * rate and h - value / rate < far:
            share = 1.0 - value / (rate * h)
            find_curve(sl, h)
            stop_within(sl, h, share)
            step_out(sl, share * h)
            return share * h, better_error(sl, error), share
        if value > 0.0:
            low, at_low, known_low = h, value, True
        else:
            high, at_high, known_high = h, value, True
        if known_low and known_high:
            h = low + (high - low) * at_low / (at_low - at_high)
        else:
            h = h - value / rate if rate < 0.0 else 0.5 * (low + high)
        if not low < h < high:
            h = 0.5 * (low + high)
    if h > SHORTEST:
        find_curve(sl, h)
    return h, better_error(sl, error), 1.0


@inner
def pass_event(sl: Sliding, i: int, kind: int) -> None:
    """Put a node at its event where it then is."""
    for j in range(sl.n):
        sl.arrived[j] = 0
    if kind == REACHES_LIMIT:
        sl.arrived[i], sl.resting[i] = 1, 0
    elif kind == STOPS:
        sl.contact[i], sl.resting[i] = STICK, 1
    sl.events += 1
    sl.crowd += 1


@summing
def commit(sl: Sliding, rec: CurveRecord, h: float, error: float) -> None:
    """Take the whole step: what is counted, and then the state."""
    n = sl.n
    for a in range(sl.s):
        way, work = 0.0, 0.0
        for j in range(STAGES):
            way += ENDS[sl.method, j] * sl.mu[j * n + a]
            work += ENDS[sl.method, j] * sl.heat[j * n + a]
        sl.slipped[sl.node[a]] += h * way
        sl.work[sl.node[a]] += h * work
    pass_on(sl, rec, h, error)


@summing
def commit_within(sl: Sliding, rec: CurveRecord, h: float, share: float, error: float) -> None:
    """Take the step up to a share of it, where it now ends: what is counted, and then the state."""
    n, far = sl.n, h / share
    for a in range(sl.s):
        way, work = 0.0, 0.0
        for j in range(STAGES):
            weight, power = 0.0, 1.0
            for m in range(DEGREE):
                power *= share
                weight += power * BETWEEN[sl.method, j, m]
            way += weight * sl.mu[j * n + a]
            work += weight * sl.heat[j * n + a]
        sl.slipped[sl.node[a]] += far * way
        sl.work[sl.node[a]] += far * work
    pass_on(sl, rec, h, error)


@inner
def pass_on(sl: Sliding, rec: CurveRecord, h: float, error: float) -> None:
    """Record the step and go to its end."""
    n = sl.n
    note(sl, rec, h)
    for i in range(n):
        if sl.friction[i] == 0.0 and sl.contact[i] != OPEN:
            sl.slipped[i] += way_without_friction(sl, i, h)
    for a in range(sl.s):
        i = sl.node[a]
        for c in range(2):
            sl.u[2 * i + c] += sl.slip[2 * a + c]
            sl.q[2 * a + c] = sl.stage_q[2 * a + c]
        sl.p[a] = sl.next_out[2 * n + i]
    for k in range(3 * n):
        sl.out[k], sl.rate[k] = sl.next_out[k], sl.next_rate[k]
        if sl.free[k] == 1:
            sl.u[k] = sl.out[k]
    for i in range(n):
        if sl.contact[i] != OPEN:
            sl.closed[i] = 1
        elif sl.u[2 * n + i] > sl.length:  # not where the pressure but touches zero
            sl.opened[i] = 1
    sl.time += h
    sl.error += error
    sign(sl)


@inner
def way_without_friction(sl: Sliding, i: int, h: float) -> float:
    """How far a frictionless node goes in the step, along the cubic through both its ends [length]."""
    x, y, way = 2 * i, 2 * i + 1, 0.0
    for j in range(len(GAUSS)):
        at = GAUSS[j]
        chord, begin, end = (
            6.0 * at * (1.0 - at),
            (1.0 - at) * (1.0 - 3.0 * at) * h,
            at * (3.0 * at - 2.0) * h,
        )
        vx = chord * (sl.next_out[x] - sl.u[x]) + begin * sl.rate[x] + end * sl.next_rate[x]
        vy = chord * (sl.next_out[y] - sl.u[y]) + begin * sl.rate[y] + end * sl.next_rate[y]
        way += GAUSS_WEIGHTS[j] * np.sqrt(vx * vx + vy * vy)
    return way


@inner
def keep_rates(sl: Sliding) -> None:
    """The rates at the end of a step are those at the beginning of the next."""
    row, last = 2 * sl.n, STAGES - 1
    for c in range(2 * sl.s):
        sl.k[c], sl.k_q[c] = sl.k[last * row + c], sl.k_q[last * row + c]
    for a in range(sl.s):
        sl.mu[a], sl.heat[a] = sl.mu[last * sl.n + a], sl.heat[last * sl.n + a]


@inner
def note(sl: Sliding, rec: CurveRecord, h: float) -> None:
    """Record the step that begins at the present state, where there is room."""
    if rec.room == 0 or rec.rows == rec.room:
        return
    n, N, row = sl.n, 3 * sl.n, rec.rows
    for k in range(N):
        rec.u[row * N + k] = sl.u[k]
    for i in range(n):
        rec.contact[row * n + i] = sl.contact[i]
    for m in range(DEGREE):
        start = (row * DEGREE + m) * N
        if h > 0.0:
            move(sl, sl.curve, m * 2 * n, sl.scratch)
        for k in range(N):
            linear = h * sl.base[k] if m == 0 else 0.0
            rec.curve[start + k] = sl.scratch[k] + linear if sl.free[k] == 1 and h > 0.0 else 0.0
        for a in range(sl.s):
            for c in range(2):
                if h > 0.0:
                    rec.curve[start + 2 * sl.node[a] + c] = sl.curve[m * 2 * n + 2 * a + c]
    rec.time[row], rec.duration[row] = sl.first + sl.step + sl.time, h
    rec.node[row], rec.kind[row] = sl.came_node, sl.came_kind
    rec.rows = row + 1


@inner
def sign(sl: Sliding) -> None:
    """Enter the present contact states and the load step that they begin in into the signature."""
    prime, code = np.uint64(1099511628211), np.uint64(14695981039346656037)
    for i in range(sl.n):
        code = (code ^ np.uint64(sl.contact[i] + 2)) * prime
    if code != sl.last_states:
        sl.signature = ((sl.signature ^ code) * prime ^ np.uint64(sl.first + sl.step + 2)) * prime
        sl.last_states = code
