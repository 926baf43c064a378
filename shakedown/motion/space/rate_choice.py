"""Which nodes move at an instant, and how: a complementarity problem in the speeds, and choices at the apex.

Of a node on its cone the direction of slip is known, and either it slips, μ > 0, and stays on the cone,
or it sticks and the rate of its room is not negative: μ ⟂ M μ + z. As in the plane the problem is solved
by block pivoting with the least index as a safeguard, from the nodes that slipped before, and by
enumeration where that fails and there are few nodes. A solution counts only where it is stable,
det M > 0. A node at the apex, q = p = 0, sticks while |q̇| ≤ f ṗ, slips with q̇ = −f ṗ d along a direction
d that is an unknown of its own, or opens, ẇ ≥ 0; the first of those that fail changes its choice,
until none does.

A node that has come to rest on its cone has neither speed nor room, nor a rate of room: it stays out of
the problem until it has left the cone or is found outside.
"""

import numpy as np

from shakedown.ground.contact_status import OPEN, STICK
from shakedown.ground.named_state import inner, summing
from shakedown.motion.plane.moving_state import CLOSES, OPENS
from shakedown.motion.space.exchange import arrange, compute_base, compute_out, move
from shakedown.motion.space.sliding import SLIP, Sliding
from shakedown.motion.space.speeds import (
    factor,
    find_directions,
    find_matrix,
    pack,
    spread_rates,
    substitute,
)

ENUMERABLE = 10  # nodes on their cones up to which every choice of those that slip is tried
ANGLES = 64  # at which a direction at the apex is looked for
INSIDE = 1e-9  # share of a sector by which the search keeps off the directions without a speed
SAME_DIRECTION = 1e-10  # that a node at the apex slips in, and that the others' rates give it
ATTEMPTS = 60  # at the choices of each node at the apex
PATIENCE = 3


@inner
def room(sl: Sliding, i: int) -> float:
    """f p − |q| of a closed node [force]."""
    x, y = sl.out[2 * i], sl.out[2 * i + 1]
    return sl.friction[i] * sl.out[2 * sl.n + i] - np.sqrt(x * x + y * y)


@inner
def locate(sl: Sliding) -> int:
    """Find the nodes at the apex and on their cones (``candidate``); how many are at the apex."""
    n, near, count = sl.n, sl.near, 0
    for i in range(n):
        p, left = sl.out[2 * n + i], room(sl, i)
        sl.candidate[i], sl.apex[i], sl.before[i] = 0, 0, sl.contact[i]
        if sl.contact[i] == OPEN:
            sl.apex[i] = (
                1 if p <= sl.near * sl.length_scale / sl.force_scale else 0
            )  # the gap of an open node
        elif sl.friction[i] == 0.0:
            sl.apex[i] = 1 if p <= near else 0
        else:
            if left > near or sl.contact[i] == SLIP:
                sl.resting[i] = 0
            sl.apex[i] = 1 if p <= 2.0 * near else 0
            if sl.apex[i] == 0 and (sl.contact[i] == SLIP or left <= near) and sl.resting[i] == 0:
                sl.candidate[i] = 1
            if sl.apex[i] == 1:
                face_reaction(sl, i)
        if i == sl.event_node and (sl.kind == OPENS or sl.kind == CLOSES):
            sl.candidate[i], sl.apex[i] = 0, 1
            sl.contact[i] = OPEN if sl.kind == OPENS else SLIP if sl.friction[i] == 0.0 else STICK
        count += sl.apex[i]
    return count


@inner
def face_reaction(sl: Sliding, i: int) -> None:
    """Let a node near the apex slip against what there is of a reaction."""
    x, y = sl.out[2 * i], sl.out[2 * i + 1]
    size = np.sqrt(x * x + y * y)
    if size > sl.force:
        sl.direction[2 * i], sl.direction[2 * i + 1] = -x / size, -y / size


@inner
def choose_rates(sl: Sliding) -> bool:
    """Contact states and rates from this instant on, after the event that has led to it.

    False, and the states before it, where none are found.
    """
    n = sl.n
    apexes = locate(sl)
    for k in range(3 * n):
        sl.held[k] = sl.u[k]
    found = False
    for _ in range(1 + ATTEMPTS * apexes):
        if not find_all_rates(sl):
            break
        if apexes == 0 or not change_apex(sl):
            found = True
            break
    for i in range(n):
        if not found and sl.apex[i] == 1 and sl.friction[i] > 0.0:
            found = search_apex(sl, i)
    if found:
        leave_apex(sl)
    else:
        for i in range(n):
            sl.contact[i] = sl.before[i]
        take_contact(sl)
    return found


@inner
def find_all_rates(sl: Sliding) -> bool:
    """Rates with the nodes at the apex as they are; False where there are none."""
    if not (take_contact(sl) and choose_slipping(sl)):
        return False
    move(sl, sl.k, 0, sl.rate)
    for i in range(3 * sl.n):
        sl.rate[i] += sl.base[i]
    return True


@inner
def search_apex(sl: Sliding, i: int) -> bool:
    """Find the direction in which a node at the apex slips, all others following, where one by one fails."""
    width = 2.0 * np.pi / ANGLES
    before = np.nan
    for part in range(ANGLES + 1):
        low, high = (part - 1) * width, part * width
        now = across_all(sl, i, high)
        if before * now <= 0.0:
            for _ in range(50):
                middle = 0.5 * (low + high)
                if across_all(sl, i, middle) * before > 0.0:
                    low = middle
                else:
                    high = middle
            if not np.isnan(across_all(sl, i, high)) and not change_apex(sl):
                return True
        before = now
    return False


@inner
def across_all(sl: Sliding, i: int, angle: float) -> float:
    """Rate of the reaction of a node at the apex across a direction of slip, all others following."""
    sl.contact[i] = SLIP
    sl.direction[2 * i], sl.direction[2 * i + 1] = np.cos(angle), np.sin(angle)
    if not find_all_rates(sl):
        return np.nan
    a = 0
    while sl.node[a] != i:
        a += 1
    if sl.mu[a] <= 0.0 or sl.rate[2 * sl.n + i] < 0.0:
        return np.nan
    return sl.rate[2 * i + 1] * sl.direction[2 * i] - sl.rate[2 * i] * sl.direction[2 * i + 1]


@inner
def leave_apex(sl: Sliding) -> None:
    """Put the reactions of nodes that slip away from the apex on their cones: they are round-off there."""
    n = sl.n
    for a in range(sl.s):
        i = sl.node[a]
        if sl.apex[i] == 1:
            sl.p[a] = max(sl.p[a], 0.0)
            sl.out[2 * n + i] = sl.p[a]
            sl.out[2 * i], sl.out[2 * i + 1] = sl.q[2 * a], sl.q[2 * a + 1]


@inner
def take_contact(sl: Sliding) -> bool:
    """Put displacements, reactions and equations into the contact states; False where one is loose."""
    before = sl.exchanges
    if not arrange(sl):
        return False
    if sl.exchanges != before:
        for k in range(3 * sl.n):
            if sl.free[k] == 0:
                sl.u[k] = sl.held[k] if k < 2 * sl.n else 0.0
        compute_out(sl)
    return True


@inner
def choose_slipping(sl: Sliding) -> bool:
    """Solve the problem of the nodes on their cones, those at the apex as they are, and find all rates."""
    n = sl.n
    compute_base(sl)
    for i in range(n):
        at_apex = sl.apex[i] == 1 and sl.contact[i] == SLIP and sl.friction[i] > 0.0
        sl.chosen[i] = 1 if sl.candidate[i] == 1 or at_apex else 0
    pack(sl)
    find_directions(sl, sl.q)
    find_matrix(sl, sl.limits)
    c, largest = sl.s, 0.0
    for i in range(3 * n):
        if sl.free[i] == 0:
            largest = max(largest, max(abs(sl.base[i]), abs(sl.welded[i])))
    for a in range(c):
        i = sl.node[a]
        sl.room_rate[a] = -sl.drive[a]
        sl.active[a] = 1 if sl.contact[i] == SLIP or sl.arrived[i] == 1 else 0
    if not (pivot(sl, c, largest) or (c <= ENUMERABLE and enumerate_choices(sl, c, largest))):
        return False
    for a in range(c):
        i = sl.node[a]
        sl.chosen[i] = sl.active[a]
        if sl.candidate[i] == 1:
            sl.contact[i] = SLIP if sl.active[a] == 1 else STICK
            sl.resting[i] = sl.at_zero[a]
    pack(sl)
    sl.factored = True  # by the last solution of the problem, whose active nodes these are, in the same order
    find_directions(sl, sl.q)
    spread_rates(sl, 0)
    return True


@inner
def broken(sl: Sliding, c: int, largest: float) -> int:
    """Solve for the speeds of the active nodes and set ``wanted``: how many break their conditions.

    −1 where the equations are singular, −2 where nothing is broken but the motion is not stable.
    """
    size, row, count, sign, fastest = 0, 0, 0, 1, 0.0
    for a in range(c):
        size += sl.active[a]
    for a in range(c):
        if sl.active[a] == 1:
            t = row * size
            for b in range(c):
                if sl.active[b] == 1:
                    sl.M[t] = sl.limits[a * c + b]
                    t += 1
            sl.speed[row] = -sl.room_rate[a]
            row += 1
    if size > 0:
        sign = factor(sl, size)
        if sign == 0:
            return -1
        substitute(sl, size, sl.speed)
    for a in range(size):
        fastest = max(fastest, abs(sl.speed[a]))
    row = 0
    for a in range(c):
        sl.wanted[a], sl.at_zero[a] = sl.active[a], 0
        if sl.active[a] == 1:
            if sl.candidate[sl.node[a]] == 1 and sl.speed[row] < -sl.rate_zero * fastest:
                sl.wanted[a] = 0
                count += 1
            row += 1
        else:
            rate, t, terms = sl.room_rate[a], 0, largest
            for b in range(c):
                if sl.active[b] == 1:
                    x = sl.limits[a * c + b] * sl.speed[t]
                    rate += x
                    terms = max(terms, abs(x))
                    t += 1
            if rate < -sl.rate_zero * terms:
                sl.wanted[a] = 1
                count += 1
            elif rate <= sl.rate_zero * terms:
                sl.at_zero[a] = 1
    return -2 if count == 0 and sign < 0 else count


@inner
def pivot(sl: Sliding, c: int, largest: float) -> bool:
    """Find the active nodes by block pivoting; those that have hardly a speed rest."""
    fewest, patience = c + 1, PATIENCE
    for _ in range(20 + 10 * c):
        count = broken(sl, c, largest)
        if count == 0:
            return True
        if count < 0:
            return False
        if count < fewest:
            fewest, patience = count, PATIENCE
        else:
            patience -= 1
        for a in range(c):
            if sl.wanted[a] != sl.active[a]:
                sl.active[a] = sl.wanted[a]
                if patience < 0:
                    break
    return False


@inner
def enumerate_choices(sl: Sliding, c: int, largest: float) -> bool:
    """Take the first stable solution among all choices of the active nodes."""
    for code in range(1 << c):
        rest, allowed = code, True
        for a in range(c):
            sl.active[a] = rest % 2
            rest //= 2
            allowed = allowed and (sl.active[a] == 1 or sl.candidate[sl.node[a]] == 1)
        if allowed and broken(sl, c, largest) == 0:
            return True
    return False


@inner
def change_apex(sl: Sliding) -> bool:
    """Change the choice of the first node at the apex that breaks its conditions; False where none does."""
    n = sl.n
    largest, fastest = 0.0, 0.0
    for i in range(3 * n):
        if sl.free[i] == 0:
            largest = max(largest, max(abs(sl.rate[i]), abs(sl.welded[i])))
        else:
            fastest = max(fastest, abs(sl.rate[i]))
    for a in range(sl.s):
        fastest = max(fastest, abs(sl.mu[a]))
    for i in range(n):
        if sl.apex[i] == 1 and apex_breaks(sl, i, sl.rate_zero * largest, sl.rate_zero * fastest):
            return True
    return False


@inner
def apex_breaks(sl: Sliding, i: int, zero_rate: float, zero_speed: float) -> bool:
    """Whether a node at the apex breaks its conditions; it then has another choice."""
    n, f, state = sl.n, sl.friction[i], sl.contact[i]
    x, y, p = sl.rate[2 * i], sl.rate[2 * i + 1], sl.rate[2 * n + i]
    if state == OPEN:
        if p >= -zero_speed:  # of an open node this is the rate of the gap
            return False
        sl.contact[i] = STICK if f > 0.0 else SLIP
        return True
    if f == 0.0:
        if p >= -zero_rate:
            return False
        sl.contact[i] = OPEN
        return True
    if state == STICK:
        if np.sqrt(x * x + y * y) <= f * p + zero_rate:
            return False
        sl.contact[i] = SLIP if find_apex_direction(sl, i, x, y, p) else OPEN
        return True
    a = 0
    while sl.node[a] != i:
        a += 1
    mu, N, S = sl.mu[a], 3 * n, sl.exchanged
    dx, dy = sl.direction[2 * i], sl.direction[2 * i + 1]
    if mu > 0.0 and p >= -zero_rate and abs(dx * y - dy * x) <= SAME_DIRECTION * max(abs(x), abs(y)):
        return False
    ax = x - mu * (S[2 * i * N + 2 * i] * dx + S[2 * i * N + 2 * i + 1] * dy)
    ay = y - mu * (S[(2 * i + 1) * N + 2 * i] * dx + S[(2 * i + 1) * N + 2 * i + 1] * dy)
    b = p - mu * (S[(2 * n + i) * N + 2 * i] * dx + S[(2 * n + i) * N + 2 * i + 1] * dy)
    if np.sqrt(ax * ax + ay * ay) <= f * b:
        sl.contact[i] = STICK
    elif not find_apex_direction(sl, i, ax, ay, b):
        sl.contact[i] = OPEN
    return True


@summing
def across(sl: Sliding, i: int, angle: float, x: float, y: float, p: float) -> float:
    """Rate of the reaction across a direction of slip, at the speed that keeps to the cone; NaN if none."""
    n, N, S, f = sl.n, 3 * sl.n, sl.exchanged, sl.friction[i]
    dx, dy = np.cos(angle), np.sin(angle)
    ax = S[2 * i * N + 2 * i] * dx + S[2 * i * N + 2 * i + 1] * dy
    ay = S[(2 * i + 1) * N + 2 * i] * dx + S[(2 * i + 1) * N + 2 * i + 1] * dy
    b = S[(2 * n + i) * N + 2 * i] * dx + S[(2 * n + i) * N + 2 * i + 1] * dy
    stiffness, drive = ax * dx + ay * dy + f * b, -(x * dx + y * dy + f * p)
    if stiffness <= 0.0 or drive <= 0.0 or p + drive / stiffness * b < 0.0:
        return np.nan
    mu = drive / stiffness
    return (y + mu * ay) * dx - (x + mu * ax) * dy


@inner
def find_apex_direction(sl: Sliding, i: int, x: float, y: float, p: float) -> bool:
    """Direction in which a node at the apex slips, the others at their rates; False where there is none.

    x, y, p are the rates of its reactions while it sticks.
    """
    size = np.sqrt(x * x + y * y)
    least = sl.friction[i] * p / size if size > 0.0 else 1.0  # below that cosine to −q̇ there is no speed
    if least >= 1.0:
        return False
    reach = np.arccos(max(least, -1.0))
    middle_way, width = np.arctan2(-y, -x), 2.0 * reach / ANGLES
    for part in range(ANGLES):
        low, high = middle_way - reach + part * width, middle_way - reach + (part + 1) * width
        if part == 0:
            low += INSIDE * width
        if part == ANGLES - 1:
            high -= INSIDE * width
        at_low, at_high = across(sl, i, low, x, y, p), across(sl, i, high, x, y, p)
        if at_low * at_high <= 0.0 and at_low != at_high:
            for _ in range(60):
                middle = 0.5 * (low + high)
                if across(sl, i, middle, x, y, p) * at_low > 0.0:
                    low = middle
                else:
                    high = middle
            sl.direction[2 * i], sl.direction[2 * i + 1] = np.cos(high), np.sin(high)
            return True
    return False
