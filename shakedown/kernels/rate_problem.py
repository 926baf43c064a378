"""Rates of slip and gap at one instant: which nodes at their limits move, and how.

Between samples the loading is linear in time, so that the evolution is
piecewise linear and is known as soon as the rates after every event are. Given
the rates ṙ_w of the welded reactions, each node has, by its *place* at the
instant, these choices (s = +1 backward, −1 forward):

    inside its limits        stick
    on one limit, s q = f p  stick, with s q̇ ≤ f ṗ; or slip, with s v̇ ≤ 0, s q̇ = f ṗ
    apex, p = q = 0, w = 0   stick, |q̇| ≤ f ṗ; slip, s v̇ ≤ 0, s q̇ = f ṗ ≥ 0; open, ẇ ≥ 0, q̇ = ṗ = 0
    frictionless, p > 0      slip, q̇ = 0
    in the air, w > 0        open

**The rule for events.** Whatever happens at an instant, one event or several,
a corner, a load reversal, an apex, is decided by this one problem for all nodes
at their limits together. It starts from the states held before. Every node that
breaks its conditions takes the next state by the sign of what is broken, all of
them at once as long as their number falls (block pivoting), else the one of
lowest index alone (Murty's least-index rule, finite where every principal minor
of A ± f B is positive). Should this not end, or end in a motion that is
unstable (determinant of the moving nodes' equations negative), the problem is
handed to complete enumeration where it is small and to Lemke's method with the
lexicographic rule where it is not (:mod:`shakedown.kernels.rate_search`). If they too
find nothing there are no rates: the state must jump.

A node counts as being at a limit from round-off on (relative to the
largest reaction), so that simultaneous events are one event, and a rate counts
as zero up to round-off (relative to the largest rate), so that a limit
touched tangentially is no slip.
"""

from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from shakedown.kernels.active_set import (
    FRESH,
    SIGN,
    add_product,
    change_states,
    factorize,
    largest_residual,
    solve,
)
from shakedown.kernels.gauss_seidel import BACKWARD_SLIP, FORWARD_SLIP, OPEN, STICK
from shakedown.model.problem import FloatArray

REFINED = 1e-13  # residual of the rates, relative to the largest, above which they are refined
INSIDE, ON_BACKWARD, ON_FORWARD, APEX, FRICTIONLESS, AIR = 0, 1, -1, 2, 3, 4


class Rates(NamedTuple):
    """Places of the nodes at an instant and the rates that hold after it, per unit of time."""

    place: NDArray[np.int64]  # (n,)
    wanted: NDArray[np.int64]  # (n,) states, scratch
    motion: FloatArray  # (2n,) rates of v, w
    reaction: FloatArray  # (2n,) rates of q, p
    welded: FloatArray  # (2n,) rates of q_w, p_w
    change: FloatArray  # (2n,) scratch
    pivots: NDArray[np.int64]  # solutions of linear systems; enumerations or Lemke calls


def rates(n: int) -> Rates:
    """Room for the rates of n nodes."""
    return Rates(
        place=np.zeros(n, dtype=np.int64),
        wanted=np.zeros(n, dtype=np.int64),
        motion=np.zeros(2 * n),
        reaction=np.zeros(2 * n),
        welded=np.zeros(2 * n),
        change=np.zeros(2 * n),
        pivots=np.zeros(2, dtype=np.int64),
    )


@numba.njit(cache=True)
def locate(act: Any, rate: Any, motion: Any, reaction: Any, near_force: float, near_length: float) -> None:
    """Set the place of every node from its state, gap and reactions (u, r, each (2n,))."""
    n = len(act.f)
    for i in range(n):
        q, p, f = reaction[i], reaction[n + i], act.f[i]
        place = INSIDE
        if act.state[i] == OPEN:
            place = APEX if motion[n + i] <= near_length else AIR
        elif p <= near_force and abs(q) <= f * p + near_force:
            place = APEX
        elif f == 0.0:
            place = FRICTIONLESS
        elif act.state[i] != STICK:
            place = act.state[i]
        elif f * p - q <= near_force:
            place = ON_BACKWARD
        elif f * p + q <= near_force:
            place = ON_FORWARD
        rate.place[i] = place


@numba.njit(cache=True)
def next_state(act: Any, rate: Any, i: int, small_rate: float, small_motion: float) -> int:
    """The state of node i if its conditions hold, else the one to try next."""
    n, state, place, f = len(act.f), act.state[i], rate.place[i], act.f[i]
    v, w, q, p = rate.motion[i], rate.motion[n + i], rate.reaction[i], rate.reaction[n + i]
    if place in (ON_BACKWARD, ON_FORWARD):
        side = place
        if state == STICK:
            return side if side * q - f * p > small_rate else STICK
        return STICK if side * v > small_motion else state
    if place == FRICTIONLESS:
        return BACKWARD_SLIP
    if place != APEX:
        return state
    if state == OPEN:
        if w >= -small_motion:
            return OPEN
        return STICK if f > 0.0 else BACKWARD_SLIP
    if state == STICK:
        backward, forward = q - f * p, -q - f * p
        if backward <= small_rate and forward <= small_rate:
            return STICK
        return BACKWARD_SLIP if backward >= forward else FORWARD_SLIP
    if p < -small_rate:
        return OPEN
    if f > 0.0 and state * v > small_motion:
        return STICK
    return state


@numba.njit(cache=True)
def rates_of_states(act: Any, rate: Any) -> None:
    """Rates of motion and reaction in the present states, refined where the inverse has worn out."""
    solve(act, rate.welded, rate.motion)
    rate.reaction[:] = rate.welded
    add_product(act, rate.motion, rate.reaction)
    rate.pivots[0] += 1
    for attempt in range(3):
        if largest_residual(act, rate.reaction) <= REFINED * np.abs(rate.reaction).max():
            return
        if attempt == 1 and (act.meta[FRESH] == 0 or not factorize(act)):
            return
        solve(act, rate.reaction, rate.change)
        for k in range(len(rate.motion)):
            rate.motion[k] += rate.change[k]
        add_product(act, rate.change, rate.reaction)


@numba.njit(cache=True)
def broken_conditions(act: Any, rate: Any, rate_tol: float) -> int:
    """Compute the rates, set ``wanted``; returns how many nodes break their conditions."""
    rates_of_states(act, rate)
    small_rate = rate_tol * np.abs(rate.reaction).max()
    small_rate = max(small_rate, rate_tol * np.abs(rate.welded).max())
    small_motion = rate_tol * np.abs(rate.motion).max()
    count = 0
    for i in range(len(act.f)):
        rate.wanted[i] = next_state(act, rate, i, small_rate, small_motion)
        if rate.wanted[i] != act.state[i]:
            count += 1
    return count


@numba.njit(cache=True)
def pivot_to_solution(act: Any, rate: Any, rate_tol: float) -> bool:
    """Block pivoting with Murty's rule as a safeguard, from the present states."""
    n = len(act.f)
    fewest, patience = n + 1, 3
    for _ in range(20 + 10 * n):
        count = broken_conditions(act, rate, rate_tol)
        if count == 0:
            return act.meta[SIGN] > 0
        if count < fewest:
            fewest, patience = count, 3
        else:
            patience -= 1
        if patience < 0:
            keep_first(act, rate)
        if not change_states(act, rate.wanted):
            return False
    return False


@numba.njit(cache=True)
def keep_first(act: Any, rate: Any) -> None:
    """Withdraw every wanted change of state but that of the lowest node."""
    found = False
    for i in range(len(act.f)):
        if rate.wanted[i] != act.state[i]:
            if found:
                rate.wanted[i] = act.state[i]
            found = True
