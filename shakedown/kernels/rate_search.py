"""Solution of the rate problem: pivoting, and complete enumeration or Lemke's method where it fails."""

from typing import Any

import numba
import numpy as np

from shakedown.kernels.active_set import SIGN, add_product, change_states, solve
from shakedown.kernels.gauss_seidel import BACKWARD_SLIP, FORWARD_SLIP, OPEN, STICK
from shakedown.kernels.lemke import FOUND, lemke
from shakedown.kernels.rate_problem import (
    AIR,
    APEX,
    FRICTIONLESS,
    INSIDE,
    ON_BACKWARD,
    ON_FORWARD,
    broken_conditions,
    pivot_to_solution,
)

SOLVED, NO_RATES = 0, 1
ENUMERABLE = 1024  # combinations of states up to which all are tried


@numba.njit(cache=True)
def solve_rates(act: Any, rate: Any, rate_tol: float) -> int:
    """States and rates after the instant whose places are set: SOLVED, or NO_RATES and nothing changed."""
    before = act.state.copy()
    for i in range(len(before)):
        rate.wanted[i] = admissible_start(rate.place[i], before[i])
    if change_states(act, rate.wanted) and pivot_to_solution(act, rate, rate_tol):
        return SOLVED
    rate.pivots[1] += 1
    if enumerate_states(act, rate, before, rate_tol) or lemke_states(act, rate, before, rate_tol):
        return SOLVED
    change_states(act, before)
    return NO_RATES


@numba.njit(cache=True)
def admissible_start(place: int, state: int) -> int:
    """The state to start from at a place: the one held before where the place allows it."""
    if place == FRICTIONLESS:
        return BACKWARD_SLIP
    if place == INSIDE or (place in (ON_BACKWARD, ON_FORWARD) and state != place):
        return STICK
    return state


@numba.njit(cache=True)
def choices(place: int, f: float) -> Any:
    """States that a place leaves open, first the number of them."""
    if place == APEX:
        if f == 0.0:
            return 2, (BACKWARD_SLIP, OPEN, OPEN, OPEN)
        return 4, (STICK, BACKWARD_SLIP, FORWARD_SLIP, OPEN)
    if place in (ON_BACKWARD, ON_FORWARD):
        return 2, (STICK, place, place, place)
    if place == AIR:
        return 1, (OPEN, OPEN, OPEN, OPEN)
    if place == FRICTIONLESS:
        return 1, (BACKWARD_SLIP, OPEN, OPEN, OPEN)
    return 1, (STICK, OPEN, OPEN, OPEN)


@numba.njit(cache=True)
def enumerate_states(act: Any, rate: Any, before: Any, rate_tol: float) -> bool:
    """Try all combinations of states, if they are few enough, and take the first stable solution."""
    n, total = len(before), 1
    for i in range(n):
        total *= choices(rate.place[i], act.f[i])[0]
        if total > ENUMERABLE:
            return False
    for number in range(total):
        rest = number
        for i in range(n):
            count, states = choices(rate.place[i], act.f[i])
            rate.wanted[i] = states[rest % count]
            rest //= count
        solved = change_states(act, rate.wanted) and broken_conditions(act, rate, rate_tol) == 0
        if solved and act.meta[SIGN] > 0:
            return True
    return False


@numba.njit(cache=True)
def lemke_states(act: Any, rate: Any, before: Any, rate_tol: float) -> bool:
    """Take the states from the linear complementarity problem of all nodes at their limits.

    Unknowns z ≥ 0: the slip rate −s v̇ of a node on limit s; v̇⁺, v̇⁻ and ẇ at an
    apex. Their complements: f ṗ − s q̇; f ṗ + q̇, f ṗ − q̇ and ṗ.
    """
    n = len(before)
    for i in range(n):  # what certainly moves is condensed, everything else held
        rate.wanted[i] = choices(rate.place[i], act.f[i])[1][0]
    if not change_states(act, rate.wanted):
        return False
    node, kind = np.empty(3 * n, dtype=np.int64), np.empty(3 * n, dtype=np.int64)
    k = 0
    for i in range(n):
        place = rate.place[i]
        if place in (ON_BACKWARD, ON_FORWARD):
            node[k], kind[k] = i, place
            k += 1
        elif place == APEX:
            for kind_of_motion in (FORWARD_SLIP, BACKWARD_SLIP, OPEN):
                if act.f[i] > 0.0 or kind_of_motion == OPEN:
                    node[k], kind[k] = i, kind_of_motion
                    k += 1
    M, b = rate_matrix(act, rate, node[:k], kind[:k])
    status, z = lemke(M, b, 50 * k + 100)
    if status != FOUND:
        return False
    largest = z.max() if k > 0 else 0.0
    for a in range(k):
        if z[a] > 1e-14 * largest and rate.wanted[node[a]] != OPEN:
            rate.wanted[node[a]] = kind[a]
    if not change_states(act, rate.wanted) or act.meta[SIGN] <= 0:
        return False
    return broken_conditions(act, rate, rate_tol) == 0 or pivot_to_solution(act, rate, rate_tol)


@numba.njit(cache=True)
def rate_matrix(act: Any, rate: Any, node: Any, kind: Any) -> Any:
    """Matrix and right-hand side of the linear complementarity problem of the nodes at their limits."""
    n, k = len(act.f), len(node)
    M, b = np.empty((k, k)), np.empty(k)
    solve(act, rate.welded, rate.motion)
    rate.reaction[:] = rate.welded
    add_product(act, rate.motion, rate.reaction)
    for a in range(k):
        b[a] = distance(act, rate.reaction, node[a], kind[a])
    for c in range(k):
        col = node[c] + n if kind[c] == OPEN else node[c]
        sign = 1.0 if kind[c] == OPEN else -1.0 * kind[c]
        unit = sign * act.kappa[col]
        solve(act, unit, rate.motion)
        add_product(act, rate.motion, unit)
        for a in range(k):
            M[a, c] = distance(act, unit, node[a], kind[a])
    return M, b


@numba.njit(cache=True)
def distance(act: Any, reaction: Any, i: int, kind: int) -> float:
    """What must not become negative while node i does not move in the given way [force]."""
    n = len(act.f)
    if kind == OPEN:
        return reaction[n + i]
    return act.f[i] * reaction[n + i] - kind * reaction[i]
