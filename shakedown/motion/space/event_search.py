"""The first event within a step: a stuck node reaches its cone, a speed or a pressure vanishes, a gap closes.

Events are looked for on the polynomial between the ends of the step. What is followed is a distance that
is positive at the beginning of the step: of a node that begins at its limit the distance to a little
behind it, so that one that leaves its limit and returns within the step is seen where it returns. Where a
node stops it is its speed.
"""

import numpy as np

from shakedown.ground.constants import HALVINGS, FloatArray
from shakedown.ground.named_state import inner, summing
from shakedown.ground.status import OPEN, STICK
from shakedown.motion.course import EventKind
from shakedown.motion.space.smooth_step import find_curve
from shakedown.motion.space.space_run import DEGREE, SpaceMotion, SpaceRun
from shakedown.motion.space.speeds import move

SAMPLES = 8  # samples of a distance within a step
NEVER = 2.0  # as a share of a step


@inner
def end_of_step(run: SpaceRun, h: float) -> None:
    """Outputs and their rates at the end of the step."""
    mo, rates, st = run.motion, run.rates, run.step
    move(run.joint, run.slipping, st.slip, 0, st.next_out)
    move(run.joint, run.slipping, st.k, 6 * 2 * st.n, st.next_rate)
    for i in range(3 * st.n):
        st.next_out[i] += mo.out[i] + h * rates.base[i]
        st.next_rate[i] += rates.base[i]


@inner
def kind_of(mo: SpaceMotion, i: int) -> int:
    """The possible next event of a node, other than a stop."""
    if mo.contact[i] == OPEN:
        return EventKind.CLOSES
    if mo.contact[i] == STICK:
        return EventKind.REACHES_LIMIT
    return EventKind.OPENS


@inner
def distance_at(run: SpaceRun, i: int, kind: int, x: float, y: float, p: float) -> float:
    """The distance of a node from its possible event, from its three outputs."""
    if kind == EventKind.REACHES_LIMIT:
        return run.joint.friction[i] * p - np.sqrt(x * x + y * y)
    if kind == EventKind.OPENS:
        return p - run.course.residual
    return p


@inner
def distance(run: SpaceRun, i: int, kind: int, out: FloatArray) -> float:
    """The distance of a node from its possible event, from all outputs."""
    return distance_at(run, i, kind, out[2 * i], out[2 * i + 1], out[2 * run.joint.n + i])


@inner
def distance_rate(run: SpaceRun, i: int, kind: int, out: FloatArray, rate: FloatArray) -> float:
    """Rate of a distance, from all outputs and their rates."""
    x, y, p = 2 * i, 2 * i + 1, 2 * run.joint.n + i
    if kind != EventKind.REACHES_LIMIT:
        return rate[p]
    size = np.sqrt(out[x] * out[x] + out[y] * out[y])
    along = (out[x] * rate[x] + out[y] * rate[y]) / size if size > 0.0 else 0.0
    return run.joint.friction[i] * rate[p] - along


@inner
def near_event(run: SpaceRun, kind: int) -> float:
    """The distance from an event at which a node is there: a force, a length where a gap closes."""
    near = run.course.residual
    return near * run.step.length_scale / run.step.force_scale if kind == EventKind.CLOSES else near


@inner
def margin(run: SpaceRun, kind: int, at_start: float) -> float:
    """The offset that makes a distance positive at the beginning of the step."""
    near = near_event(run, kind)
    return 2.0 * near - min(at_start, 0.0) if at_start <= near else 0.0


@inner
def first_event(run: SpaceRun, h: float) -> tuple[float, int, int]:
    """The time of the first event, as a share of the step, or NEVER; its node and its kind."""
    mo, rates, sp, st = run.motion, run.rates, run.slipping, run.step
    n, first, node, next_kind = st.n, NEVER, -1, EventKind.CURVES
    find_curve(sp, st, h)
    for i in range(n):
        kind = kind_of(mo, i)
        start = distance(run, i, kind, mo.out)
        begins = distance_rate(run, i, kind, mo.out, rates.rate)
        add = margin(run, kind, start)
        if kind == EventKind.OPENS and begins < 0.0:
            add = 0.0  # moving to the apex, beyond which a direction has no meaning
        ends = distance_rate(run, i, kind, st.next_out, st.next_rate)
        dips = begins < 0.0 < ends
        if distance(run, i, kind, st.next_out) + add > 0.0 and not dips:
            continue
        find_bend(run, i, h)
        share = first_share(run, i, kind, add, first)
        if share < first:
            first, node, next_kind = share, i, kind
    for a in range(sp.s):
        if st.mu[6 * n + a] <= 0.0:
            share = first_share(run, a, EventKind.STOPS, 0.0, first)
            if share == NEVER:
                share = 1.0
            if share < first:
                first, node, next_kind = share, sp.node[a], EventKind.STOPS
    return first, node, next_kind


@inner
def expected(run: SpaceRun) -> float:
    """The time of the first event at the present rates, ignoring speeds; infinite where there is none."""
    mo, first = run.motion, np.inf
    for i in range(run.joint.n):
        kind = kind_of(mo, i)
        left = distance(run, i, kind, mo.out)
        rate = distance_rate(run, i, kind, mo.out, run.rates.rate)
        if left > near_event(run, kind) and rate < 0.0:
            first = min(first, left / -rate)
    return first


@summing
def find_bend(run: SpaceRun, i: int, h: float) -> None:
    """The outputs of one node within the step as a polynomial."""
    joint, rates, sp, st = run.joint, run.rates, run.slipping, run.step
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
def bent(run: SpaceRun, i: int, kind: int, at: float) -> float:
    """The distance of a node within the step."""
    mo, st, power = run.motion, run.step, 1.0
    x, y, p = mo.out[2 * i], mo.out[2 * i + 1], mo.out[2 * st.n + i]
    for m in range(DEGREE):
        power *= at
        x += power * st.bend[m]
        y += power * st.bend[DEGREE + m]
        p += power * st.bend[2 * DEGREE + m]
    return distance_at(run, i, kind, x, y, p)


@inner
def first_share(run: SpaceRun, i: int, kind: int, add: float, latest: float) -> float:
    """Where a distance, of a packed node its speed, first vanishes, as a share of the step.

    NEVER where not before ``latest``.
    """
    low = 0.0
    for part in range(1 if kind == EventKind.STOPS else 0, SAMPLES + 1):
        high = part / SAMPLES
        if followed(run, i, kind, high) + add <= 0.0:
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                if followed(run, i, kind, middle) + add > 0.0:
                    low = middle
                else:
                    high = middle
            return high
        low = high
        if low > latest:
            break
    return NEVER


@inner
def followed(run: SpaceRun, i: int, kind: int, at: float) -> float:
    """The distance of a node, or the speed of a packed one, within the step."""
    return speed_at(run, i, at) if kind == EventKind.STOPS else bent(run, i, kind, at)


@inner
def speed_at(run: SpaceRun, a: int, at: float) -> float:
    """The speed of a packed node within the step, along its directions at both ends."""
    mo, sp, st, power, x, y = run.motion, run.slipping, run.step, 1.0, 0.0, 0.0
    for m in range(DEGREE):
        x += (m + 1) * power * st.curve[m * 2 * st.n + 2 * a]
        y += (m + 1) * power * st.curve[m * 2 * st.n + 2 * a + 1]
        power *= at
    i = sp.node[a]
    first_x, first_y = sp.q[2 * a], sp.q[2 * a + 1]
    if first_x * first_x + first_y * first_y <= run.course.force * run.course.force:
        first_x, first_y = -mo.direction[2 * i], -mo.direction[2 * i + 1]
    size = np.sqrt(first_x * first_x + first_y * first_y)
    ux = -(1.0 - at) * first_x / size + at * sp.unit[2 * a]
    uy = -(1.0 - at) * first_y / size + at * sp.unit[2 * a + 1]
    return x * ux + y * uy
