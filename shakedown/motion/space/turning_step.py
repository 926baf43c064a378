"""One step of the slipping nodes where some of them turn fast: Radau's IIA method of order 5.

A slipping node turns at a rate in proportion to 1/|q|, so that near the apex explicit steps are
short though its path is smooth. Radau's steps are not (E. Hairer, G. Wanner, Solving Ordinary Differential
Equations II, IV.8). With rates q̇_l at the stages, their reactions are q_m = q + h Σ a_ml q̇_l; unknown are the
angles of the fast nodes, whose reactions lie in their directions of slip, q_m·u⊥ = 0, by Newton's method.
That holds at the apex, too, where a reaction vanishes. The others' directions follow the reactions.
"""

import numpy as np

from shakedown.ground.named_state import inner, summing
from shakedown.motion.space.explicit_step import FAILED, PLACES, lagrange, return_to_cones
from shakedown.motion.space.sliding import MOST_FAST, STAGES, Sliding
from shakedown.motion.space.speeds import (
    factor_few,
    find_directions,
    rates_along,
    substitute,
    substitute_few,
)

ROOT = np.sqrt(6.0)
INWARD = np.array(
    [
        [(88 - 7 * ROOT) / 360, (296 - 169 * ROOT) / 1800, (-2 + 3 * ROOT) / 225],
        [(296 + 169 * ROOT) / 1800, (88 + 7 * ROOT) / 360, (-2 - 3 * ROOT) / 225],
        [(16 - ROOT) / 36, (16 + ROOT) / 36, 1 / 9],
    ]
)
OF_ESTIMATE = (
    0.2748888295956773  # the reciprocal of the real eigenvalue of the inverse of INWARD, as Hairer's
)
FAST = 0.2  # angle, roughly, by which a node's direction is turned towards where it tends, in the step
ROUNDS = 15
MOST_TURN = 0.5  # of an angle in one round
LEFT = 0.01  # change of a slip by the last round, relative to the error that is allowed
SLOW = (
    0.3  # change by a round, relative to that by the one before it, after which the derivatives are renewed
)
BACK = lagrange(PLACES[1:])[:, 0]  # weights of the rates at the stages in their polynomial at the beginning


@inner
def turning(sl: Sliding, a: int, h: float) -> float:
    """How fast a node turns towards where it tends, at most, within the step."""
    s, i = sl.s, 2 * a
    x, y = sl.q[i], sl.q[i + 1]
    size = np.sqrt(x * x + y * y)
    dx, dy = x + h * sl.k_q[i], y + h * sl.k_q[i + 1]
    size = min(size, np.sqrt(dx * dx + dy * dy))
    row = 2 * a * 2 * s + 2 * a
    stiffness = max(sl.A[row], sl.A[row + 2 * s + 1])
    drive = sl.mu[a] * stiffness
    return drive / size if size > 0.0 else (np.inf if drive > 0.0 else 0.0)


@inner
def find_fast(sl: Sliding, h: float) -> int:
    """The fastest nodes: how many."""
    count, own, fast = 0, sl.turn, sl.fast
    for a in range(sl.s):
        rate = turning(sl, a, h)
        if not h * rate > FAST:
            continue
        at = count
        while at > 0 and own[at - 1] < rate:
            if at < MOST_FAST:
                own[at], fast[at] = own[at - 1], fast[at - 1]
            at -= 1
        if at < MOST_FAST:
            own[at], fast[at] = rate, a
            count = min(count + 1, MOST_FAST)
    return count


@inner
def begin_angles(sl: Sliding, h: float, count: int) -> None:
    """Let the rates at the stages be those at the beginning, and the fast nodes turn at them."""
    row, n = 2 * sl.n, sl.n
    for m in range(3):
        for c in range(2 * sl.s):
            sl.k[(m + 1) * row + c], sl.k_q[(m + 1) * row + c] = sl.k[c], sl.k_q[c]
        for a in range(sl.s):
            sl.mu[(m + 1) * n + a] = sl.mu[a]
    for t in range(count):
        a = sl.fast[t]
        x, y = sl.k[2 * a], sl.k[2 * a + 1]
        if sl.mu[a] <= 0.0:
            x, y = -sl.q[2 * a], -sl.q[2 * a + 1]
        first, size = np.arctan2(y, x), np.sqrt(sl.q[2 * a] ** 2 + sl.q[2 * a + 1] ** 2)
        turn = 0.0
        if size > sl.force:
            turn = -h * (np.cos(first) * sl.k_q[2 * a + 1] - np.sin(first) * sl.k_q[2 * a]) / size
        for m in range(3):
            sl.angle[m * MOST_FAST + t] = first + PLACES[m + 1] * max(-MOST_TURN, min(MOST_TURN, turn))


@inner
def face(sl: Sliding, count: int, m: int) -> None:
    """Give the fast nodes their directions at a stage; beyond the apex their reactions are negative."""
    for t in range(count):
        at, angle = 2 * sl.fast[t], sl.angle[m * MOST_FAST + t]
        sl.unit[at], sl.unit[at + 1] = np.cos(angle), np.sin(angle)
        sl.size[sl.fast[t]] = -sl.unit[at] * sl.stage_q[at] - sl.unit[at + 1] * sl.stage_q[at + 1]


@summing
def derivatives(sl: Sliding, m: int, count: int) -> None:
    """How the rates of the fast nodes' reactions across their directions at a stage follow the angles."""
    s, row = sl.s, 2 * sl.n
    start, dmu = (m + 1) * row, sl.correction
    for t in range(count):
        j = sl.fast[t]
        x, y = -sl.unit[2 * j + 1], sl.unit[2 * j]
        mu = sl.mu[(m + 1) * sl.n + j]
        for a in range(s):
            ux, uy, first, last = sl.unit[2 * a], sl.unit[2 * a + 1], 4 * a * s + 2 * j, 2 * a * s + 2 * j
            along = ux * sl.A[first] + uy * sl.A[first + 2 * s] + sl.f[a] * sl.B[last]
            side = ux * sl.A[first + 1] + uy * sl.A[first + 2 * s + 1] + sl.f[a] * sl.B[last + 1]
            dmu[a] = -mu * (along * x + side * y)
        dmu[j] -= x * sl.k_q[start + 2 * j] + y * sl.k_q[start + 2 * j + 1]
        substitute(sl, s, dmu)
        for r in range(count):
            i = sl.fast[r]
            first, ex, ey = 4 * i * s, -sl.unit[2 * i + 1], sl.unit[2 * i]
            total = 0.0
            for b in range(s):
                ax = ex * sl.A[first + 2 * b] + ey * sl.A[first + 2 * s + 2 * b]
                ay = ex * sl.A[first + 2 * b + 1] + ey * sl.A[first + 2 * s + 2 * b + 1]
                total += (ax * sl.unit[2 * b] + ay * sl.unit[2 * b + 1]) * dmu[b]
                if b == j:
                    total += mu * (ax * x + ay * y)
            sl.bends[(m * MOST_FAST + r) * MOST_FAST + t] = total


@inner
def turn_on(sl: Sliding, h: float, count: int) -> bool:
    """A round of Newton's method on the angles; False where its equations are singular."""
    size, row, W, right = 3 * count, 2 * sl.n, sl.equations, sl.turn
    for m in range(3):
        for r in range(count):
            i, at, angle = sl.fast[r], m * count + r, sl.angle[m * MOST_FAST + r]
            x, y = np.cos(angle), np.sin(angle)
            qx, qy = sl.reactions[m * row + 2 * i], sl.reactions[m * row + 2 * i + 1]
            right[at] = -(qy * x - qx * y)
            for k in range(3):
                for t in range(count):
                    bend = sl.bends[(k * MOST_FAST + r) * MOST_FAST + t]
                    W[at * size + k * count + t] = h * INWARD[m, k] * bend
            W[at * size + at] -= qx * x + qy * y
    if factor_few(W, sl.turn_order, size) == 0:
        return False
    substitute_few(W, sl.turn_order, size, right)
    for m in range(3):
        for r in range(count):
            sl.angle[m * MOST_FAST + r] += max(-MOST_TURN, min(MOST_TURN, right[m * count + r]))
    return True


@summing
def stage_reactions(sl: Sliding, h: float) -> None:
    """Packed reactions at the stages from the rates at all."""
    row = 2 * sl.n
    for m in range(3):
        for c in range(2 * sl.s):
            total = 0.0
            for k in range(3):
                total += INWARD[m, k] * sl.k_q[(k + 1) * row + c]
            sl.reactions[m * row + c] = sl.q[c] + h * total


@inner
def stage_rates(sl: Sliding, m: int, count: int) -> float:
    """Rates at a stage, the fast nodes in their directions: the largest change, or FAILED."""
    row = 2 * sl.n
    for c in range(2 * sl.s):
        sl.slip[c], sl.stage_q[c] = sl.k[(m + 1) * row + c], sl.reactions[m * row + c]
    for a in range(sl.s):
        sl.speed[a] = sl.mu[(m + 1) * sl.n + a]
    find_directions(sl, sl.stage_q)
    face(sl, count, m)
    if not rates_along(sl, m + 1):
        return FAILED
    change = 0.0
    for c in range(2 * sl.s):
        change = max(change, abs(sl.k[(m + 1) * row + c] - sl.slip[c]))
    return change


@inner
def solve_stages(sl: Sliding, h: float, allowed: float, count: int) -> bool:
    """Find the rates at the stages; False where they do not settle."""
    last, renewed = np.inf, True
    for turn in range(ROUNDS):
        stage_reactions(sl, h)
        if turn > 0 and count > 0 and not turn_on(sl, h, count):
            return False
        change = 0.0
        for m in range(3):
            moved = stage_rates(sl, m, count)
            if moved < 0.0:
                return False
            change = max(change, h * moved)
            if renewed:
                derivatives(sl, m, count)
        if change <= LEFT * allowed:
            return True
        if turn > 3 and not change < last:
            return False
        renewed = turn == 0 or change > SLOW * last
        last = change
    return False


@inner
def turning_step(sl: Sliding, h: float, allowed: float) -> float:
    """A step of this length from the packed state: estimate of its error [length], or infinite, or FAILED."""
    s, n, row = sl.s, sl.n, 2 * sl.n
    count = find_fast(sl, h)
    begin_angles(sl, h, count)
    if not solve_stages(sl, h, allowed, count):
        return np.inf
    for c in range(2 * s):
        total, change = 0.0, 0.0
        for m in range(3):
            total += INWARD[2, m] * sl.k[(m + 1) * row + c]
            change += INWARD[2, m] * sl.k_q[(m + 1) * row + c]
        sl.slip[c], sl.stage_q[c] = h * total, sl.q[c] + h * change
    if least_pressure(sl, h, count) > 10.0 * sl.near:
        face(sl, count, 2)
        if return_to_cones(sl, h) > sl.near:
            return np.inf
    find_directions(sl, sl.stage_q)
    face(sl, count, 2)
    for a in range(s):
        sl.speed[a] = sl.mu[3 * n + a]
    if not rates_along(sl, STAGES - 1):
        return FAILED
    return estimate(sl, h)


@summing
def least_pressure(sl: Sliding, h: float, count: int) -> float:
    """The least pressure of the fast nodes at the end."""
    s, least = sl.s, np.inf
    for t in range(count):
        a = sl.fast[t]
        p = sl.p[a] + h * sl.load_p[a]
        for c in range(2 * s):
            p += sl.B[a * 2 * s + c] * sl.slip[c]
        least = min(least, p)
    return least


@inner
def estimate(sl: Sliding, h: float) -> float:
    """By how much the rates at the beginning are off those that the stages give there, as an error."""
    s, row, error = sl.s, 2 * sl.n, 0.0
    for a in range(s):
        x, y = sl.k[2 * a], sl.k[2 * a + 1]
        for m in range(3):
            x -= BACK[m] * sl.k[(m + 1) * row + 2 * a]
            y -= BACK[m] * sl.k[(m + 1) * row + 2 * a + 1]
        stiffness = max(sl.A[2 * a * (2 * s + 1)], sl.A[(2 * a + 1) * (2 * s + 1)])
        weight = max(1.0, stiffness * sl.length_scale / sl.force_scale)
        error = max(error, (x * x + y * y) * weight * weight)
    return OF_ESTIMATE * h * np.sqrt(error)
