"""Gauss–Seidel over the nodes of one load step: each takes the state that the law wants, its neighbours held.

Nodes that stick and stay so cost a comparison. With ``condense`` a node that opens is eliminated, and one
that closes is taken back; without, its gap is one more displacement (the thesis's §2.3.2 with discs).
"""

import numpy as np

from shakedown.ground.contact_status import NO_STATE, OPEN
from shakedown.ground.named_state import borrowing, inner
from shakedown.motion.implicit.node_alone import state_alone
from shakedown.motion.implicit.swept_stiffness import exchange, inverse, shift


@borrowing
def contact_position(body, tableau, i, start, contact, work):  # type: ignore[no-untyped-def]
    """Where a node touches that was open: its slip when the gap closes.

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
    """Node i, open with an overlap, is put to where it touches."""
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
