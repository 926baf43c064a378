"""The first event within a step: a stuck node reaches its cone, a speed or a pressure vanishes, a gap closes.

Events are looked for on the polynomial between the ends of the step. What is followed is a distance that
is positive at the beginning of the step: of a node that begins at its limit the distance to a little
behind it, so that one that leaves its limit and returns within the step is seen where it returns.
"""

import numpy as np

from shakedown.ground.contact_status import OPEN, STICK
from shakedown.ground.named_state import inner, summing
from shakedown.motion.plane.moving_state import CLOSES, OPENS
from shakedown.motion.space.exchange import move, move_twice
from shakedown.motion.space.explicit_step import find_curve
from shakedown.motion.space.sliding import DEGREE, RADAU, REACHES_LIMIT, STOPS, Sliding

SAMPLES = 8  # of a distance within a step
NEVER = 2.0  # in shares of a step


@inner
def step_out(sl: Sliding, h: float) -> None:
    """Outputs at the end of the step."""
    move(sl, sl.slip, 0, sl.next_out)
    for i in range(3 * sl.n):
        sl.next_out[i] += sl.out[i] + h * sl.base[i]


@inner
def end_of_step(sl: Sliding, h: float) -> None:
    """Outputs and their rates at the end of the step."""
    move_twice(sl, sl.slip, sl.next_out, sl.k, 6 * 2 * sl.n, sl.next_rate)
    for i in range(3 * sl.n):
        sl.next_out[i] += sl.out[i] + h * sl.base[i]
        sl.next_rate[i] += sl.base[i]


@inner
def kind_of(sl: Sliding, i: int) -> int:
    """What may happen to a node, its stop apart."""
    if sl.contact[i] == OPEN:
        return CLOSES
    if sl.contact[i] == STICK:
        return REACHES_LIMIT
    return OPENS


@inner
def distance(sl: Sliding, i: int, kind: int, x: float, y: float, p: float) -> float:
    """How far a node is from what may happen to it, by its outputs."""
    if kind == REACHES_LIMIT:
        return sl.friction[i] * p - np.sqrt(x * x + y * y)
    if kind == OPENS:
        return p - sl.near
    return p


@inner
def margin(sl: Sliding, kind: int, at_start: float) -> float:
    """What is added to a distance so that it is positive at the beginning of the step."""
    near = sl.near * sl.length_scale / sl.force_scale if kind == CLOSES else sl.near
    return 2.0 * near - min(at_start, 0.0) if at_start <= near else 0.0


@inner
def first_event(sl: Sliding, h: float) -> float:
    """When, as a share of the step; sets ``event_node`` and ``kind``. NEVER where nothing happens."""
    n, out, end, first, curved = sl.n, sl.out, sl.next_out, NEVER, False
    for i in range(n):
        kind = kind_of(sl, i)
        x, y, p = 2 * i, 2 * i + 1, 2 * n + i
        start = distance(sl, i, kind, out[x], out[y], out[p])
        add = margin(sl, kind, start)
        if kind == OPENS and sl.rate[p] < 0.0:
            add = 0.0  # it is on its way to the apex, beyond which a direction means nothing
        if distance(sl, i, kind, end[x], end[y], end[p]) + add > 0.0 and not may_dip(sl, i, kind, h, add):
            continue
        if not curved:
            find_curve(sl, h)
            curved = True
        find_bend(sl, i, h)
        share = first_share(sl, i, kind, add, first)
        if share < first:
            first, sl.event_node, sl.kind = share, i, kind
    for a in range(sl.s):
        if sl.mu[6 * n + a] <= 0.0 or slows_within(sl, a):
            if not curved:
                find_curve(sl, h)
                curved = True
            share = share_of_stop(sl, a, first)
            if share < first:
                first, sl.event_node, sl.kind = share, sl.node[a], STOPS
    return first


@inner
def expected(sl: Sliding) -> float:
    """When the first event happens at the present rates, speeds apart; infinite where none does."""
    first = np.inf
    for i in range(sl.n):
        kind = kind_of(sl, i)
        left = distance(sl, i, kind, sl.out[2 * i], sl.out[2 * i + 1], sl.out[2 * sl.n + i])
        rate = distance_rate(sl, i, kind, 0)
        if left > sl.near and rate < 0.0:
            first = min(first, left / -rate)
    return first


@inner
def may_dip(sl: Sliding, i: int, kind: int, h: float, add: float) -> bool:
    """Whether a distance that is left at both ends of a step may be used up within: on the cubics there."""
    x, y, p, worst = 2 * i, 2 * i + 1, 2 * sl.n + i, np.inf
    falls = distance_rate(sl, i, kind, 0) < 0.0 and distance_rate(sl, i, kind, 1) > 0.0
    if not falls:
        return False
    for part in range(1, SAMPLES):
        at = part / SAMPLES
        worst = min(
            worst,
            distance(sl, i, kind, cubic(sl, x, h, at), cubic(sl, y, h, at), cubic(sl, p, h, at)),
        )
    return worst + add <= 0.0


@inner
def distance_rate(sl: Sliding, i: int, kind: int, end: int) -> float:
    """Rate of a distance at the beginning (0) or the end (1) of the step."""
    x, y, p = 2 * i, 2 * i + 1, 2 * sl.n + i
    out, rate = (sl.next_out, sl.next_rate) if end == 1 else (sl.out, sl.rate)
    if kind != REACHES_LIMIT:
        return rate[p]
    size = np.sqrt(out[x] * out[x] + out[y] * out[y])
    along = (out[x] * rate[x] + out[y] * rate[y]) / size if size > 0.0 else 0.0
    return sl.friction[i] * rate[p] - along


@inner
def cubic(sl: Sliding, j: int, h: float, at: float) -> float:
    """An output within the step, from its values and rates at both ends."""
    a, b, c, d = sl.out[j], sl.next_out[j], h * sl.rate[j], h * sl.next_rate[j]
    rest = 1.0 - at
    return rest * rest * ((1.0 + 2.0 * at) * a + at * c) + at * at * ((1.0 + 2.0 * rest) * b - rest * d)


@summing
def find_bend(sl: Sliding, i: int, h: float) -> None:
    """The outputs of one node within the step as a polynomial."""
    N, row = 3 * sl.n, 2 * sl.n
    for c in range(3):
        place = 2 * i + c if c < 2 else 2 * sl.n + i
        for m in range(DEGREE):
            total = 0.0
            for a in range(sl.s):
                start = place * N + 2 * sl.node[a]
                total += sl.exchanged[start] * sl.curve[m * row + 2 * a]
                total += sl.exchanged[start + 1] * sl.curve[m * row + 2 * a + 1]
            sl.bend[c * DEGREE + m] = total
        sl.bend[c * DEGREE] += h * sl.base[place]


@inner
def bent(sl: Sliding, i: int, kind: int, at: float) -> float:
    """The distance of a node within the step."""
    x, y, p, power = sl.out[2 * i], sl.out[2 * i + 1], sl.out[2 * sl.n + i], 1.0
    for m in range(DEGREE):
        power *= at
        x += power * sl.bend[m]
        y += power * sl.bend[DEGREE + m]
        p += power * sl.bend[2 * DEGREE + m]
    return distance(sl, i, kind, x, y, p)


@inner
def first_share(sl: Sliding, i: int, kind: int, add: float, latest: float) -> float:
    """When a distance is first used up, as a share of the step; NEVER where not before ``latest``."""
    low, at_low = 0.0, bent(sl, i, kind, 0.0) + add
    if at_low <= 0.0:
        return 0.0
    for part in range(1, SAMPLES + 1):
        high = part / SAMPLES
        at_high = bent(sl, i, kind, high) + add
        if at_high <= 0.0:
            return root_between(sl, i, kind, add, low, high, at_low, at_high)
        low, at_low = high, at_high
        if low > latest:
            break
    return NEVER


@inner
def root_between(
    sl: Sliding, i: int, kind: int, add: float, low: float, high: float, at_low: float, at_high: float
) -> float:
    """Where a distance vanishes between two shares, the end on its far side, by false position (Illinois)."""
    side = 0
    for _ in range(60):
        if high - low <= 1e-15 or at_high == 0.0:
            break
        at = (low * at_high - high * at_low) / (at_high - at_low)
        if not low < at < high:
            at = 0.5 * (low + high)
        value = bent(sl, i, kind, at) + add
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
        if abs(value) <= 0.1 * sl.force:
            return at
    return high


@inner
def slows_within(sl: Sliding, a: int) -> bool:
    """Whether the speed of a node is negative at a stage."""
    least = 0.0
    for j in range(1, 4 if sl.method == RADAU else 6):
        least = min(least, sl.mu[j * sl.n + a])
    return least < 0.0


@inner
def speed_at(sl: Sliding, a: int, at: float) -> float:
    """The speed of a packed node within the step, along its directions at both ends."""
    n, power, x, y = sl.n, 1.0, 0.0, 0.0
    for m in range(DEGREE):
        x += (m + 1) * power * sl.curve[m * 2 * n + 2 * a]
        y += (m + 1) * power * sl.curve[m * 2 * n + 2 * a + 1]
        power *= at
    i = sl.node[a]
    first_x, first_y = sl.q[2 * a], sl.q[2 * a + 1]
    if first_x * first_x + first_y * first_y <= sl.force * sl.force:
        first_x, first_y = -sl.direction[2 * i], -sl.direction[2 * i + 1]
    size = np.sqrt(first_x * first_x + first_y * first_y)
    ux = -(1.0 - at) * first_x / size + at * sl.unit[2 * a]
    uy = -(1.0 - at) * first_y / size + at * sl.unit[2 * a + 1]
    return x * ux + y * uy


@inner
def share_of_stop(sl: Sliding, a: int, latest: float) -> float:
    """When the speed of a packed node first vanishes, as a share of the step; NEVER where it does not."""
    low = 0.0
    for part in range(1, SAMPLES + 1):
        high = part / SAMPLES
        if speed_at(sl, a, high) <= 0.0:
            for _ in range(45):
                middle = 0.5 * (low + high)
                if speed_at(sl, a, middle) > 0.0:
                    low = middle
                else:
                    high = middle
            return high
        low = high
        if low > latest:
            break
    return 1.0 if sl.mu[6 * sl.n + a] <= 0.0 else NEVER
