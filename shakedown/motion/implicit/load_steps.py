"""Load steps one after the other, each of them in parts, as one call."""

import numpy as np

from shakedown.motion.implicit.one_step import load, solve_step
from shakedown.motion.kernels.named_state import entered


@entered
def follow(body, tableau, state, guess, loads, parts, settings, sweeps_only, path):  # type: ignore[no-untyped-def]
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
