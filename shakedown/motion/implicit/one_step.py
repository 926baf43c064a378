"""One load step: sweeps, then Newton's method, in turns until the law holds with the given stiffness."""

import numpy as np

from shakedown.motion.implicit.newton_rounds import newton
from shakedown.motion.implicit.sweeps import contact_position, sweep
from shakedown.motion.implicit.swept_stiffness import MOST_UPDATES, exchange, product
from shakedown.motion.kernels.named_state import inner

FIRST_SWEEPS, MOST_SWEEPS = 3, 400  # before Newton's method; twice as many after every stall


@inner
def load(tableau, r_w):  # type: ignore[no-untyped-def]
    """Put new welded reactions on: closed nodes stay, open ones stay free of reactions."""
    for i in range(len(tableau.is_open)):
        if tableau.is_open[i]:
            for a in range(3 * i, 3 * i + 3):
                tableau.given[a] += r_w[a] - tableau.r_w[a]
    for a in range(len(r_w)):
        tableau.r_w[a] = r_w[a]
    product(tableau.N, tableau.given, tableau.out)


@inner
def displacements(tableau, u):  # type: ignore[no-untyped-def]
    """u (3n,) node by node."""
    for i in range(len(tableau.is_open)):
        for a in range(3 * i, 3 * i + 3):
            u[a] = tableau.out[a] if tableau.is_open[i] else tableau.given[a]


@inner
def renew(body, tableau):  # type: ignore[no-untyped-def]
    """Make N anew from κ, the same nodes open; False where nothing would hold one of them."""
    n, held = len(tableau.is_open), True
    u, was_open = np.empty(3 * n), np.empty(n, dtype=np.bool_)
    displacements(tableau, u)
    for i in range(n):
        was_open[i], tableau.is_open[i] = tableau.is_open[i], False
    for a in range(3 * n):
        tableau.given[a] = u[a]
        for b in range(3 * n):
            tableau.N[a, b] = body.kappa[a, b]
    for i in range(n):
        if was_open[i] and not exchange(body, tableau, i):
            held = False
        if tableau.is_open[i]:
            for a in range(3 * i, 3 * i + 3):
                tableau.given[a] = tableau.r_w[a]
    product(tableau.N, tableau.given, tableau.out)
    tableau.updates[0] = 0
    return held


@inner
def residual(body, tableau, u, contact):  # type: ignore[no-untyped-def]
    """Largest departure of a state u from the law [force], its reactions from κ alone.

    That of r from its projection on what the law allows: p from max(p − c w, 0), q from the disc at
    q − ρ s.
    """
    r, worst = np.empty(len(u)), 0.0
    product(body.kappa, u, r)
    for i in range(len(body.f)):
        j, k = 2 * i, 3 * i
        for a in range(k, k + 3):
            r[a] += tableau.r_w[a]
        pressed = max(r[k + 2] - body.normal[i] * u[k + 2], 0.0)
        x = r[k] - body.tangential[i] * (u[k] - contact[j])
        y = r[k + 1] - body.tangential[i] * (u[k + 1] - contact[j + 1])
        limit, size = body.f[i] * pressed, np.sqrt(x * x + y * y)
        share = limit / size if size > limit else 1.0
        apart = max(abs(r[k] - share * x), abs(r[k + 1] - share * y), abs(r[k + 2] - pressed))
        if not apart <= worst:
            worst = apart
    return worst


@inner
def touch(body, tableau, start, contact):  # type: ignore[no-untyped-def]
    """Where the nodes touch that were open before, at the present state."""
    room = np.empty((3, 3)), np.empty(3), np.empty(3)
    for i in range(len(body.f)):
        contact_position(body, tableau, i, start, contact, room)


@inner
def solve_step(body, tableau, start, contact, u, settings):  # type: ignore[no-untyped-def]
    """Solve one load step; returns (residual, sweeps, Newton steps, node without a state or −1).

    ``start`` (3n,) is the state before; ``contact`` (2n,) is filled with where each node touches, ``u``
    (3n,) with the state after it. It is solved where the residual is at most 2 ``close`` [force].
    """
    for i in range(len(body.f)):
        contact[2 * i], contact[2 * i + 1] = start[3 * i], start[3 * i + 1]
    sweeps, steps, ahead, unsolved, missed = 0, 0, FIRST_SWEEPS, -1, np.inf
    close, tension, turns, solver = settings
    for _ in range(turns):
        for _ in range(ahead):
            change, unsolved = sweep(body, tableau, start, contact, tension, True)
            sweeps += 1
            if change <= 0.1 * close and unsolved < 0:
                break
        done, used = newton(body, tableau, contact, close, solver)
        steps += used
        if done:
            if tableau.updates[0] > MOST_UPDATES:
                renew(body, tableau)
            touch(body, tableau, start, contact)
            displacements(tableau, u)
            missed = residual(body, tableau, u, contact)
            if missed <= 2.0 * close:
                return missed, sweeps, steps, -1
        else:
            ahead = min(2 * ahead, MOST_SWEEPS)
    displacements(tableau, u)
    return residual(body, tableau, u, contact), sweeps, steps, unsolved


@inner
def sweep_step(body, tableau, start, contact, u, close, tension, most):  # type: ignore[no-untyped-def]
    """As :func:`solve_step`, by sweeps alone, gaps and slips of open nodes among them."""
    for i in range(len(body.f)):
        contact[2 * i], contact[2 * i + 1] = start[3 * i], start[3 * i + 1]
    unsolved, count = -1, 0
    while count < most:
        count += 1
        change, unsolved = sweep(body, tableau, start, contact, tension, False)
        if change <= close and unsolved < 0:
            break
    touch(body, tableau, start, contact)
    displacements(tableau, u)
    return residual(body, tableau, u, contact), count, 0, unsolved
