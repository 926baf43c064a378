"""The stiffness with the places of open nodes exchanged: there the reaction is given, not the displacement.

Of a free place the reaction is zero and the displacement follows from equilibrium. With these places
exchanged (a principal pivot transform of κ) the outputs

    out = reactions of the places that are not free, displacements of those that are

are linear in the displacements of the former and the welded reactions of the latter, however the
other nodes slip: an open node costs a closed one nothing until it closes again. Opening a node exchanges
its three places, closing it the same three: the exchange is its own inverse. Where one place is free
and the other is not the matrix is antisymmetric, elsewhere symmetric, so that its rows serve as columns.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from shakedown.ground.constants import ROUND_OFF, FloatArray
from shakedown.ground.named_state import inner, summing
from shakedown.ground.status import OPEN
from shakedown.motion.course import Course
from shakedown.motion.space.space_run import CompiledJoint, Slipping, SpaceMotion, SpaceRates

MOST_EXCHANGES = 60  # exchanges after which the matrix is made afresh, as each adds round-off


def eliminate(joint: CompiledJoint, free: NDArray[np.bool_]) -> None:
    """Make the stiffness afresh with these places free, (N,), all at once; from Python.

    Where nothing holds them none is: the loop then exchanges them one by one, and finds that out.
    """
    S, kappa, at, held = joint.exchanged, joint.kappa, np.flatnonzero(free), np.flatnonzero(~free)
    S[:], joint.free[:] = kappa, 0
    joint.set(exchanges=0)
    if not at.size:
        return
    try:
        factor = cho_factor(kappa[np.ix_(at, at)])
    except LinAlgError:
        return
    if (np.diag(factor[0]) ** 2 <= ROUND_OFF * np.abs(kappa[at]).max(axis=1)).any():
        return
    from_held = cho_solve(factor, kappa[np.ix_(at, held)])
    S[np.ix_(held, held)] -= kappa[np.ix_(held, at)] @ from_held
    S[np.ix_(at, at)] = cho_solve(factor, np.eye(len(at)))
    S[np.ix_(at, held)], S[np.ix_(held, at)] = -from_held, from_held.T
    joint.free[at] = 1


@summing
def exchange(joint: CompiledJoint, place: int) -> bool:
    """Exchange a place; False, and nothing changed, where nothing else holds it."""
    N, S, row, size = 3 * joint.n, joint.exchanged, 3 * joint.n * place, 0.0
    pivot = S[row + place]
    if joint.free[place] == 0:
        for j in range(N):
            size = max(size, abs(joint.kappa[row + j]))
        if pivot <= ROUND_OFF * size:
            return False
    for i in range(N):
        x = S[i * N + place] / pivot
        if i != place and x != 0.0:
            for j in range(N):
                S[i * N + j] -= x * S[row + j]
            S[i * N + place] = x
    for j in range(N):
        S[row + j] /= -pivot
    S[row + place] = 1.0 / pivot
    joint.free[place] = 1 - joint.free[place]
    joint.exchanges += 1
    return True


@inner
def is_free(joint: CompiledJoint, mo: SpaceMotion, place: int) -> bool:
    """Whether a place is free in the present contact states."""
    n = joint.n
    if place >= 2 * n:
        return mo.contact[place - 2 * n] == OPEN
    node = place // 2
    return mo.contact[node] == OPEN or joint.friction[node] == 0.0


@inner
def arrange(joint: CompiledJoint, mo: SpaceMotion) -> bool:
    """Exchange places until those free by their contact states are; False where nothing holds one."""
    held = True
    for place in range(3 * joint.n):
        if is_free(joint, mo, place) != (joint.free[place] == 1):
            held = exchange(joint, place) and held
    return held


@summing
def compute_base(joint: CompiledJoint, rates: SpaceRates) -> None:
    """Rates of the outputs while nothing slips."""
    N, S, base = 3 * joint.n, joint.exchanged, rates.base
    for i in range(N):
        base[i] = 0.0
    for j in range(N):
        x = rates.welded[j]
        if joint.free[j] == 1 and x != 0.0:
            for i in range(N):
                base[i] += x * S[j * N + i]
    for i in range(N):
        base[i] = -base[i] if joint.free[i] == 1 else base[i] + rates.welded[i]


@summing
def compute_out(joint: CompiledJoint, course: Course, mo: SpaceMotion, rates: SpaceRates) -> None:
    """Recompute the outputs from the displacements and the load at the present time."""
    N, S, out = 3 * joint.n, joint.exchanged, mo.out
    for i in range(N):
        out[i] = 0.0
    for j in range(N):
        x = course.path[mo.step * N + j] + mo.time * rates.welded[j] if joint.free[j] == 1 else mo.u[j]
        if x != 0.0:
            for i in range(N):
                out[i] += x * S[j * N + i]
    for i in range(N):
        if joint.free[i] == 1:
            out[i] = -out[i]
            mo.u[i] = out[i]
        else:
            out[i] += course.path[mo.step * N + i] + mo.time * rates.welded[i]


@summing
def move(joint: CompiledJoint, sp: Slipping, slip: FloatArray, start: int, target: FloatArray) -> None:
    """The change of the outputs due to packed slips (from ``start`` on)."""
    N, S = 3 * joint.n, joint.exchanged
    for i in range(N):
        target[i] = 0.0
    for a in range(sp.s):
        first, x, y = 2 * sp.node[a] * N, slip[start + 2 * a], slip[start + 2 * a + 1]
        for i in range(N):
            along = target[i] + x * S[first + i]
            target[i] = along + y * S[first + N + i]
    for i in range(N):
        if joint.free[i] == 1:
            target[i] = -target[i]
