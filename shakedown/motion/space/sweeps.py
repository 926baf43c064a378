"""Gauss–Seidel over the nodes of one load step: each takes its admissible state with its neighbours held.

Nodes that stick and stay so cost a comparison. With ``condense`` a node that opens is eliminated, and one
that closes is taken back; without, its gap is one more displacement (the thesis's §2.3.2 with discs).
"""

import math

import numpy as np

from shakedown.ground.named_state import borrowing, inner
from shakedown.ground.round_off import HALVINGS, NEWTON_ROUNDS
from shakedown.ground.size_limits import DIRECTIONS
from shakedown.ground.status import NO_STATE, OPEN, SLIP, STICK
from shakedown.motion.space.swept_stiffness import exchange, inverse, shift

CLOSE = 1e-15  # its residual, relative to the reactions


@inner
def along(A, b, f, q, p, angle):  # type: ignore[no-untyped-def]
    """For slip in a given direction: driving force, stiffness, residual of the transverse equation."""
    x, y = math.cos(angle), math.sin(angle)
    ahead = A[0] * x + A[1] * y, A[1] * x + A[2] * y
    holds = x * ahead[0] + y * ahead[1] + f * (b[0] * x + b[1] * y)
    drives = -(x * q[0] + y * q[1] + f * p)
    return drives, holds, (x * q[1] - y * q[0]) * holds + drives * (x * ahead[1] - y * ahead[0])


@inner
def slip_by_direction(A, b, f, q, p, tension, stable):  # type: ignore[no-untyped-def]
    """The slip of the admissible direction nearest to −q: whether there is one, and its components.

    ``stable``: only one that is held, so that a larger drive leads to more slip.
    """
    first = math.atan2(-q[1], -q[0])
    width = 2.0 * math.pi / DIRECTIONS
    for step in range(DIRECTIONS):
        k = (step + 1) // 2 if step % 2 else -(step // 2)
        low, high = first + (k - 0.5) * width, first + (k + 0.5) * width
        _, _, low_side = along(A, b, f, q, p, low)
        _, _, high_side = along(A, b, f, q, p, high)
        if low_side * high_side > 0.0:
            continue
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            _, _, side = along(A, b, f, q, p, middle)
            if side * low_side > 0.0:
                low = middle
            else:
                high = middle
        drives, holds, _ = along(A, b, f, q, p, high)
        if drives * holds > 0.0 and (holds > 0.0 or not stable):
            speed = drives / holds
            x, y = speed * math.cos(high), speed * math.sin(high)
            if p + b[0] * x + b[1] * y >= -tension:
                return True, x, y
    return False, 0.0, 0.0


@inner
def slip_by_newton(A, b, f, q, p, tension):  # type: ignore[no-untyped-def]
    """The slip from −q on: whether it was found, and its components."""
    weight = 0.5 * (A[0] + A[2])
    size = math.hypot(q[0], q[1])
    start = max(size - f * p, 0.0) / weight
    x, y = -start * q[0] / size, -start * q[1] / size
    for _ in range(NEWTON_ROUNDS):
        qx, qy = q[0] + A[0] * x + A[1] * y, q[1] + A[1] * x + A[2] * y
        limit = f * (p + b[0] * x + b[1] * y)
        ax, ay = qx - weight * x, qy - weight * y
        reach = math.hypot(ax, ay)
        if not (limit >= 0.0 and reach > 0.0):
            return False, 0.0, 0.0
        ax, ay, share = ax / reach, ay / reach, limit / reach
        Fx, Fy = qx - limit * ax, qy - limit * ay
        if abs(Fx) + abs(Fy) <= CLOSE * (size + f * abs(p)):
            break
        xx, xy, yy = share * ay * ay, -share * ax * ay, share * ax * ax
        J00 = (1.0 - xx) * A[0] - xy * A[1] - f * ax * b[0] + weight * xx
        J01 = (1.0 - xx) * A[1] - xy * A[2] - f * ax * b[1] + weight * xy
        J10 = -xy * A[0] + (1.0 - yy) * A[1] - f * ay * b[0] + weight * xy
        J11 = -xy * A[1] + (1.0 - yy) * A[2] - f * ay * b[1] + weight * yy
        det = J00 * J11 - J01 * J10
        if det == 0.0:
            return False, 0.0, 0.0
        x, y = x - (J11 * Fx - J01 * Fy) / det, y - (J00 * Fy - J10 * Fx) / det
    else:
        if not abs(Fx) + abs(Fy) <= 1e4 * CLOSE * (size + f * abs(p)):
            return False, 0.0, 0.0
    pressed = p + b[0] * x + b[1] * y >= -tension
    return pressed and x * qx + y * qy <= 0.0, x, y


@inner
def state_alone(K, P, f, separable, r, tension):  # type: ignore[no-untyped-def]
    """State and displacement of a node from where it touches, where its reaction is r = (q, p).

    K is its own stiffness (3, 3) and P the inverse (read where it may separate).
    """
    q, p = (r[0], r[1]), r[2]
    if p >= -tension and math.hypot(q[0], q[1]) <= f * p:
        return STICK, 0.0, 0.0, 0.0
    A, b = (K[0, 0], K[0, 1], K[1, 1]), (K[2, 0], K[2, 1])
    if A[0] + A[2] > 0.0 and (q[0] != 0.0 or q[1] != 0.0):
        if p > 0.0:
            found, x, y = slip_by_newton(A, b, f, q, p, tension)
            if found:
                return SLIP, x, y, 0.0
        found, x, y = slip_by_direction(A, b, f, q, p, tension, True)
        if found:
            return SLIP, x, y, 0.0
    if separable:
        gap = -(P[2, 0] * r[0] + P[2, 1] * r[1] + P[2, 2] * r[2])
        if gap > 0.0:
            x = -(P[0, 0] * r[0] + P[0, 1] * r[1] + P[0, 2] * r[2])
            y = -(P[1, 0] * r[0] + P[1, 1] * r[1] + P[1, 2] * r[2])
            return OPEN, x, y, gap
    found, x, y = slip_by_direction(A, b, f, q, p, tension, False)
    if found:
        return SLIP, x, y, 0.0
    return NO_STATE, 0.0, 0.0, 0.0


@borrowing
def contact_position(body, tableau, i, start, contact, work):  # type: ignore[no-untyped-def]
    """Where an open node touches: its slip when the gap closes.

    The gap of an open node is taken to close linearly between its old position and the one that it would
    reach free of reactions.
    """
    k, old = 3 * i, start[3 * i + 2]
    P, u, r = work
    inverse(body.kappa, k, P)
    is_open = tableau.is_open[i]
    for a in range(3):
        u[a] = tableau.out[k + a] if is_open else tableau.given[k + a]
        r[a] = tableau.r_w[k + a] + (-tableau.given[k + a] if is_open else tableau.out[k + a])
    gap = u[2] - (P[2, 0] * r[0] + P[2, 1] * r[1] + P[2, 2] * r[2])
    share = 1.0 if gap >= 0.0 else old / (old - gap)
    for a in range(2):
        free = u[a] - (P[a, 0] * r[0] + P[a, 1] * r[1] + P[a, 2] * r[2])
        contact[2 * i + a] = start[k + a] + share * (free - start[k + a])


@inner
def close(body, tableau, i, contact):  # type: ignore[no-untyped-def]
    """Move node i, open with an overlap, to where it touches."""
    k = 3 * i
    exchange(body, tableau, i)
    u = tableau.given
    shift(tableau, i, contact[2 * i] - u[k], contact[2 * i + 1] - u[k + 1], -u[k + 2])


@inner
def sweep(body, tableau, start, contact, tension, condense):  # type: ignore[no-untyped-def]
    """One sweep; returns the largest change of a reaction by a change of its own node, and a node or −1.

    That node has no admissible state while its neighbours are held.
    """
    given, out, r_w, N = tableau.given, tableau.out, tableau.r_w, tableau.N
    P, K, u, r, change, unsolved = np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty(3), 0.0, -1
    for i in range(len(body.f)):
        k = 3 * i
        if start[k + 2] > 0.0:
            contact_position(body, tableau, i, start, contact, (P, u, r))
        if tableau.is_open[i]:
            if out[k + 2] >= 0.0:
                continue
            close(body, tableau, i, contact)
        x, y, z = contact[2 * i] - given[k], contact[2 * i + 1] - given[k + 1], -given[k + 2]
        for a in range(k, k + 3):
            r[a - k] = r_w[a] + out[a] + x * N[a, k] + y * N[a, k + 1] + z * N[a, k + 2]
        stays = x == 0.0 and y == 0.0 and z == 0.0
        if stays and r[2] >= 0.0 and r[0] * r[0] + r[1] * r[1] <= (body.f[i] * r[2]) ** 2:
            continue
        for a in range(3):
            for b in range(3):
                K[a, b] = N[k + a, k + b]
        if body.separable:
            inverse(N, k, P)
        state, dx, dy, dz = state_alone(K, P, body.f[i], body.separable, r, tension)
        if state == NO_STATE:
            unsolved = i
        x, y, z = x + dx, y + dy, z + dz
        for a in range(k, k + 3):
            change = max(change, abs(N[a, k] * x + N[a, k + 1] * y + N[a, k + 2] * z))
        if state == OPEN and condense and exchange(body, tableau, i):
            shift(tableau, i, r_w[k] - given[k], r_w[k + 1] - given[k + 1], r_w[k + 2] - given[k + 2])
        elif x != 0.0 or y != 0.0 or z != 0.0:
            shift(tableau, i, x, y, z)
    return change, unsolved
