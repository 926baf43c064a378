"""Successive load steps: for each, alternate sweeps and Newton's method until the law holds."""

import numpy as np

from shakedown.ground.named_state import borrowing, entered, inner
from shakedown.ground.round_off import SWEEPS
from shakedown.motion.space.newton_rounds import go, move, newton
from shakedown.motion.space.sweeps import contact_position, sweep
from shakedown.motion.space.swept_stiffness import MOST_UPDATES, exchange, product, shift

FIRST_SWEEPS = 3  # before Newton's method; twice as many after every stall


@borrowing
def load(tableau, r_w):  # type: ignore[no-untyped-def]
    """Apply new welded reactions: closed nodes keep their place, open ones stay free of reactions."""
    for i in range(len(tableau.is_open)):
        k = 3 * i
        if tableau.is_open[i]:
            shift(
                tableau,
                i,
                r_w[k] - tableau.r_w[k],
                r_w[k + 1] - tableau.r_w[k + 1],
                r_w[k + 2] - tableau.r_w[k + 2],
            )
    for a in range(len(r_w)):
        tableau.r_w[a] = r_w[a]


@borrowing
def displacements(tableau, u):  # type: ignore[no-untyped-def]
    """u (3n,) node by node."""
    for i in range(len(tableau.is_open)):
        for a in range(3 * i, 3 * i + 3):
            u[a] = tableau.out[a] if tableau.is_open[i] else tableau.given[a]


@inner
def renew(body, tableau):  # type: ignore[no-untyped-def]
    """Recompute N from κ with the same nodes open; False where nothing would hold one of them."""
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


@borrowing
def residual(body, tableau, contact, u, r):  # type: ignore[no-untyped-def]
    """Largest departure of the present state from the law [force], its reactions from κ alone; fills u and r.

    That of r from its projection on what the law allows: p from max(p − c w, 0), q from the disc at
    q − ρ s.
    """
    displacements(tableau, u)
    product(body.kappa, u, r)
    worst = 0.0
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
    """Where previously open nodes touch, at the present state."""
    work = np.empty((3, 3)), np.empty(3), np.empty(3)
    for i in range(len(body.f)):
        if start[3 * i + 2] > 0.0:
            contact_position(body, tableau, i, start, contact, work)


@inner
def aim(tableau, start, guess, share, work):  # type: ignore[no-untyped-def]
    """Move closed nodes to their start plus a share of the guessed slips; False if they are there already."""
    change, moved = work
    goes = False
    for i in range(len(tableau.is_open)):
        j, k = 2 * i, 3 * i
        change[j], change[j + 1] = 0.0, 0.0
        if not tableau.is_open[i]:
            change[j] = start[k] + share * guess[j] - tableau.given[k]
            change[j + 1] = start[k + 1] + share * guess[j + 1] - tableau.given[k + 1]
            goes = goes or change[j] != 0.0 or change[j + 1] != 0.0
    if goes:
        move(tableau, change, moved)
        go(tableau, change, moved, 1.0)
    return goes


@inner
def sweep_on(body, tableau, start, contact, settings, most, condense):  # type: ignore[no-untyped-def]
    """At most a number of sweeps, fewer once nothing changes; returns how many, and a node or −1."""
    close, tension = settings[0], settings[1]
    for count in range(1, most + 1):
        change, unsolved = sweep(body, tableau, start, contact, tension, condense)
        if change <= (0.1 * close if condense else close) and unsolved < 0:
            return count, unsolved
    return most, unsolved


@inner
def solve_step(body, tableau, start, contact, guess, found, settings, sweeps_only):  # type: ignore[no-untyped-def]
    """Solve one load step; returns (residual, sweeps, Newton steps, node without a state or −1).

    ``start`` (3n,) is the state before, ``guess`` (2n,) the slips in the step before, which Newton's
    method begins from if it can; ``contact`` (2n,) is filled with where each node touches, ``found``
    (u, r) (3n,) with the state after it. It is solved where the residual is at most 2 ``close`` [force].
    ``sweeps_only``: solve it by at most so many sweeps, gaps and slips of open nodes among them.
    """
    for i in range(len(body.f)):
        contact[2 * i], contact[2 * i + 1] = start[3 * i], start[3 * i + 1]
    close, _, turns, factors = settings
    u, r = found
    work = np.empty(len(guess)), np.empty(len(start))
    sweeps, steps, ahead, unsolved = 0, 0, FIRST_SWEEPS, -1
    for turn in range(0 if sweeps_only > 0 else -1, turns):
        if turn < 0 and not aim(tableau, start, guess, 1.0, work):
            continue
        if turn >= 0:
            most = sweeps_only if sweeps_only > 0 else ahead
            count, unsolved = sweep_on(body, tableau, start, contact, settings, most, sweeps_only == 0)
            sweeps += count
        if sweeps_only > 0:
            break
        done, used = newton(body, tableau, start, contact, close, factors)
        steps += used
        if not done:
            ahead = ahead if turn < 0 else min(2 * ahead, SWEEPS)
            if turn < 0:
                aim(tableau, start, guess, 0.0, work)
            continue
        if tableau.updates[0] > MOST_UPDATES:
            renew(body, tableau)
        touch(body, tableau, start, contact)
        missed = residual(body, tableau, contact, u, r)
        if missed <= 2.0 * close:
            return missed, sweeps, steps, -1
        product(tableau.N, tableau.given, tableau.out)
    touch(body, tableau, start, contact)
    return residual(body, tableau, contact, u, r), sweeps, steps, unsolved


@entered
def follow_load_steps(body, tableau, state, guess, loads, parts, settings, sweeps_only, path):  # type: ignore[no-untyped-def]
    """Carry a state (3n,) and the slips of its last step (2n,) through load steps (k, 3n), each in ``parts``.

    settings: (close [force], tension [force], turns at most, :class:`Factors`). sweeps_only: at
    most so many, by themselves, or 0 where Newton's method goes on from a few. path: what is filled row
    by row for the load steps, (u (k, 3n), slip in the last part (k, 2n), length of slip (k, n), work
    (k, n)). Returns (load step that was not solved or −1, its node or −1, the largest residual, sweeps,
    Newton steps).
    """
    close, n = settings[0], len(body.f)
    states, slips, lengths, works = path
    contact, u, r = np.empty(2 * n), np.empty(3 * n), np.empty(3 * n)
    worst, sweeps, steps = 0.0, 0, 0
    before = tableau.r_w.copy()
    for k in range(len(loads)):
        for i in range(n):
            lengths[k, i], works[k, i] = 0.0, 0.0
        for part in range(parts):
            share = (part + 1) / parts
            for a in range(3 * n):
                r[a] = before[a] + share * (loads[k, a] - before[a]) if part + 1 < parts else loads[k, a]
            load(tableau, r)
            missed, more, used, node = solve_step(
                body, tableau, state, contact, guess, (u, r), settings, sweeps_only
            )
            worst, sweeps, steps = max(worst, missed), sweeps + more, steps + used
            for a in range(3 * n):
                state[a], states[k, a] = u[a], u[a]
            for i in range(n):
                x, y = u[3 * i] - contact[2 * i], u[3 * i + 1] - contact[2 * i + 1]
                if u[3 * i + 2] > 0.0:
                    x, y = 0.0, 0.0
                slips[k, 2 * i], slips[k, 2 * i + 1] = x, y
                guess[2 * i], guess[2 * i + 1] = x, y
                lengths[k, i] += np.sqrt(x * x + y * y)
                works[k, i] -= r[3 * i] * x + r[3 * i + 1] * y
            if not missed <= 2.0 * close:
                return k, node, missed, sweeps, steps
        for a in range(3 * n):
            before[a] = loads[k, a]
    return -1, -1, worst, sweeps, steps
