"""The first event within a step: a stuck node reaches its cone, a speed or a pressure vanishes, a gap closes.

Events are looked for on the polynomial between the ends of the step. What is followed is a distance that
is positive at the beginning of the step: of a node that begins at its limit the distance to a little
behind it, so that one that leaves its limit and returns within the step is seen where it returns.
"""

import numpy as np

from shakedown.ground.named_state import inner, summing
from shakedown.ground.status import OPEN, STICK
from shakedown.motion.course import CLOSES, OPENS, Course
from shakedown.motion.space.exchange import move, move_twice
from shakedown.motion.space.explicit_step import find_curve
from shakedown.motion.space.moving_state import DEGREE, REACHES_LIMIT, STOPS, CompiledJoint, SpaceMotion
from shakedown.motion.space.space_run import SpaceRun
from shakedown.motion.space.step_state import RADAU, Slipping, SpaceRates, Step, StepControl

SAMPLES = 8  # samples of a distance within a step
NEVER = 2.0  # as a share of a step


@inner
def step_out(run: SpaceRun, h: float) -> None:
    """Outputs at the end of the step."""
    joint, mo, rates, sp, st = run.joint, run.motion, run.rates, run.slipping, run.step
    move(joint, sp, st.slip, 0, st.next_out)
    for i in range(3 * joint.n):
        st.next_out[i] += mo.out[i] + h * rates.base[i]


@inner
def end_of_step(run: SpaceRun, h: float) -> None:
    """Outputs and their rates at the end of the step."""
    joint, mo, rates, sp, st = run.joint, run.motion, run.rates, run.slipping, run.step
    move_twice(joint, sp, st.slip, st.next_out, st.k, 6 * 2 * joint.n, st.next_rate)
    for i in range(3 * joint.n):
        st.next_out[i] += mo.out[i] + h * rates.base[i]
        st.next_rate[i] += rates.base[i]


@inner
def kind_of(mo: SpaceMotion, i: int) -> int:
    """The possible next event of a node, other than a stop."""
    if mo.contact[i] == OPEN:
        return CLOSES
    if mo.contact[i] == STICK:
        return REACHES_LIMIT
    return OPENS


@inner
def distance(joint: CompiledJoint, course: Course, i: int, kind: int, x: float, y: float, p: float) -> float:
    """The distance of a node from its possible event, from its outputs."""
    if kind == REACHES_LIMIT:
        return joint.friction[i] * p - np.sqrt(x * x + y * y)
    if kind == OPENS:
        return p - course.settled
    return p


@inner
def as_distance(ct: StepControl, kind: int, force: float) -> float:
    """What a force is among the distances of a kind of event: a length where a gap closes."""
    return force * ct.length_scale / ct.force_scale if kind == CLOSES else force


@inner
def margin(course: Course, ct: StepControl, kind: int, at_start: float) -> float:
    """The offset that makes a distance positive at the beginning of the step."""
    near = as_distance(ct, kind, course.settled)
    return 2.0 * near - min(at_start, 0.0) if at_start <= near else 0.0


@inner
def first_event(run: SpaceRun, h: float) -> float:
    """The time of the first event, as a share of the step, or NEVER; sets ``event_node`` and ``kind``."""
    joint, course, mo, rates = run.joint, run.course, run.motion, run.rates
    sp, st, ct = run.slipping, run.step, run.control
    n, out, end, first, curved = joint.n, mo.out, st.next_out, NEVER, False
    for i in range(n):
        kind = kind_of(mo, i)
        x, y, p = 2 * i, 2 * i + 1, 2 * n + i
        start = distance(joint, course, i, kind, out[x], out[y], out[p])
        if kind == REACHES_LIMIT and start < -course.settled and goes_out(run, i):
            mo.node, mo.kind = i, kind  # every step would allow for a little more
            return 0.0
        add = margin(course, ct, kind, start)
        if kind == OPENS and rates.rate[p] < 0.0:
            add = 0.0  # moving to the apex, beyond which a direction has no meaning
        left = distance(joint, course, i, kind, end[x], end[y], end[p]) + add
        if left > 0.0 and not may_dip(joint, course, mo, rates, st, i, kind, h, add):
            continue
        if not curved:
            find_curve(sp, st, h)
            curved = True
        find_bend(joint, rates, sp, st, i, h)
        met = 0.1 * as_distance(ct, kind, course.force)
        share = first_share(joint, course, mo, st, i, kind, add, first, met)
        if share < first:
            first, mo.node, mo.kind = share, i, kind
    for a in range(sp.s):
        if st.mu[6 * n + a] <= 0.0 or slows_within(st, a):
            if not curved:
                find_curve(sp, st, h)
                curved = True
            share = share_of_stop(course, mo, sp, st, a, first)
            if share < first:
                first, mo.node, mo.kind = share, sp.node[a], STOPS
    return first


@inner
def goes_out(run: SpaceRun, i: int) -> bool:
    """Whether the reaction of a node that sticks leaves its cone further in what is left of the load step."""
    rate = distance_rate(run.joint, run.motion, run.rates, run.step, i, REACHES_LIMIT, 0)
    return rate * (1.0 - run.motion.time) < -run.course.settled


@inner
def expected(run: SpaceRun) -> float:
    """The time of the first event at the present rates, ignoring speeds; infinite where there is none."""
    joint, course, mo, rates, st, ct = run.joint, run.course, run.motion, run.rates, run.step, run.control
    first = np.inf
    for i in range(joint.n):
        kind = kind_of(mo, i)
        left = distance(joint, course, i, kind, mo.out[2 * i], mo.out[2 * i + 1], mo.out[2 * joint.n + i])
        rate = distance_rate(joint, mo, rates, st, i, kind, 0)
        if left > as_distance(ct, kind, course.settled) and rate < 0.0:
            first = min(first, left / -rate)
    return first


@inner
def may_dip(
    joint: CompiledJoint,
    course: Course,
    mo: SpaceMotion,
    rates: SpaceRates,
    st: Step,
    i: int,
    kind: int,
    h: float,
    add: float,
) -> bool:
    """Whether a distance positive at both ends of a step may vanish within it, judged on cubics."""
    x, y, p, worst = 2 * i, 2 * i + 1, 2 * joint.n + i, np.inf
    falls = (
        distance_rate(joint, mo, rates, st, i, kind, 0) < 0.0
        and distance_rate(joint, mo, rates, st, i, kind, 1) > 0.0
    )
    if not falls:
        return False
    for part in range(1, SAMPLES):
        at = part / SAMPLES
        there = cubic(mo, rates, st, x, h, at), cubic(mo, rates, st, y, h, at), cubic(mo, rates, st, p, h, at)
        worst = min(worst, distance(joint, course, i, kind, there[0], there[1], there[2]))
    return worst + add <= 0.0


@inner
def distance_rate(
    joint: CompiledJoint, mo: SpaceMotion, rates: SpaceRates, st: Step, i: int, kind: int, end: int
) -> float:
    """Rate of a distance at the beginning (0) or the end (1) of the step."""
    x, y, p = 2 * i, 2 * i + 1, 2 * joint.n + i
    out, rate = (st.next_out, st.next_rate) if end == 1 else (mo.out, rates.rate)
    if kind != REACHES_LIMIT:
        return rate[p]
    size = np.sqrt(out[x] * out[x] + out[y] * out[y])
    along = (out[x] * rate[x] + out[y] * rate[y]) / size if size > 0.0 else 0.0
    return joint.friction[i] * rate[p] - along


@inner
def cubic(mo: SpaceMotion, rates: SpaceRates, st: Step, j: int, h: float, at: float) -> float:
    """An output within the step, from its values and rates at both ends."""
    a, b, c, d = mo.out[j], st.next_out[j], h * rates.rate[j], h * st.next_rate[j]
    rest = 1.0 - at
    return rest * rest * ((1.0 + 2.0 * at) * a + at * c) + at * at * ((1.0 + 2.0 * rest) * b - rest * d)


@summing
def find_bend(joint: CompiledJoint, rates: SpaceRates, sp: Slipping, st: Step, i: int, h: float) -> None:
    """The outputs of one node within the step as a polynomial."""
    N, row = 3 * joint.n, 2 * joint.n
    for c in range(3):
        place = 2 * i + c if c < 2 else 2 * joint.n + i
        for m in range(DEGREE):
            total = 0.0
            for a in range(sp.s):
                start = place * N + 2 * sp.node[a]
                total += joint.exchanged[start] * st.curve[m * row + 2 * a]
                total += joint.exchanged[start + 1] * st.curve[m * row + 2 * a + 1]
            st.bend[c * DEGREE + m] = total
        st.bend[c * DEGREE] += h * rates.base[place]


@inner
def bent(
    joint: CompiledJoint, course: Course, mo: SpaceMotion, st: Step, i: int, kind: int, at: float
) -> float:
    """The distance of a node within the step."""
    x, y, p, power = mo.out[2 * i], mo.out[2 * i + 1], mo.out[2 * joint.n + i], 1.0
    for m in range(DEGREE):
        power *= at
        x += power * st.bend[m]
        y += power * st.bend[DEGREE + m]
        p += power * st.bend[2 * DEGREE + m]
    return distance(joint, course, i, kind, x, y, p)


@inner
def first_share(
    joint: CompiledJoint,
    course: Course,
    mo: SpaceMotion,
    st: Step,
    i: int,
    kind: int,
    add: float,
    latest: float,
    met: float,
) -> float:
    """Where a distance first vanishes, as a share of the step; NEVER where not before ``latest``."""
    low, at_low = 0.0, bent(joint, course, mo, st, i, kind, 0.0) + add
    if at_low <= 0.0:
        return 0.0
    for part in range(1, SAMPLES + 1):
        high = part / SAMPLES
        at_high = bent(joint, course, mo, st, i, kind, high) + add
        if at_high <= 0.0:
            return root_between(joint, course, mo, st, i, kind, add, low, high, at_low, at_high, met)
        low, at_low = high, at_high
        if low > latest:
            break
    return NEVER


@inner
def root_between(
    joint: CompiledJoint,
    course: Course,
    mo: SpaceMotion,
    st: Step,
    i: int,
    kind: int,
    add: float,
    low: float,
    high: float,
    at_low: float,
    at_high: float,
    met: float,
) -> float:
    """Where a distance vanishes between two shares, the end on its far side, by false position (Illinois)."""
    side = 0
    for _ in range(60):
        if high - low <= 1e-15 or at_high == 0.0:
            break
        at = (low * at_high - high * at_low) / (at_high - at_low)
        if not low < at < high:
            at = 0.5 * (low + high)
        value = bent(joint, course, mo, st, i, kind, at) + add
        if value > 0.0:
            low, at_low = at, value
            if side == 1:
                at_high *= 0.5
            side = 1
        else:
            high, at_high = at, value
            if side == -1:
                at_low *= 0.5
            side = -1
        if abs(value) <= met:
            return at
    return high


@inner
def slows_within(st: Step, a: int) -> bool:
    """Whether the speed of a node is negative at a stage."""
    least = 0.0
    for j in range(1, 4 if st.method == RADAU else 6):
        least = min(least, st.mu[j * st.n + a])
    return least < 0.0


@inner
def speed_at(course: Course, mo: SpaceMotion, sp: Slipping, st: Step, a: int, at: float) -> float:
    """The speed of a packed node within the step, along its directions at both ends."""
    n, power, x, y = st.n, 1.0, 0.0, 0.0
    for m in range(DEGREE):
        x += (m + 1) * power * st.curve[m * 2 * n + 2 * a]
        y += (m + 1) * power * st.curve[m * 2 * n + 2 * a + 1]
        power *= at
    i = sp.node[a]
    first_x, first_y = sp.q[2 * a], sp.q[2 * a + 1]
    if first_x * first_x + first_y * first_y <= course.force * course.force:
        first_x, first_y = -mo.direction[2 * i], -mo.direction[2 * i + 1]
    size = np.sqrt(first_x * first_x + first_y * first_y)
    ux = -(1.0 - at) * first_x / size + at * sp.unit[2 * a]
    uy = -(1.0 - at) * first_y / size + at * sp.unit[2 * a + 1]
    return x * ux + y * uy


@inner
def share_of_stop(course: Course, mo: SpaceMotion, sp: Slipping, st: Step, a: int, latest: float) -> float:
    """Where the speed of a packed node first vanishes, as a share of the step; NEVER where it does not."""
    low = 0.0
    for part in range(1, SAMPLES + 1):
        high = part / SAMPLES
        if speed_at(course, mo, sp, st, a, high) <= 0.0:
            for _ in range(45):
                middle = 0.5 * (low + high)
                if speed_at(course, mo, sp, st, a, middle) > 0.0:
                    low = middle
                else:
                    high = middle
            return high
        low = high
        if low > latest:
            break
    return 1.0 if st.mu[6 * st.n + a] <= 0.0 else NEVER
