"""The thesis's time integration: Gauss–Seidel over the nodes at fixed load steps (§2.3.2, (2.15), fig. 2.2).

Each load step is solved by sweeps over the nodes. A node takes the one of the
four states (stick, forward slip, backward slip, separation) that satisfies the
law while its neighbours are held. It is the baseline that the exact,
event-driven integrator is measured against.

A node left exactly on its limit by a previous slip fails |q| ≤ f p by a unit in
the last place. The direction of slip is therefore taken from the sign of the
violation, never by trying which candidate happens to pass, and separation is
accepted only with a positive gap.
"""

import math
from typing import Any, NamedTuple

import numba
import numpy as np

from shakedown.ground.code_cache import compiled, pipeline
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import BACKWARD_SLIP, FORWARD_SLIP, NO_STATE, OPEN, STICK

linked: Any = numba.njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **pipeline())  # type: ignore[call-overload]


class PlaneStiffness(NamedTuple):
    """Contact stiffness as the compiled loops take it.

    ``separable`` is False where C is not known; ``tension`` is the round-off
    [force] by which a closed node's p may be negative.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    f: FloatArray
    separable: bool
    tension: float

    def compact(self) -> "PlaneStiffness":
        """Its arrays row by row and read-only, whatever they were: the loops are compiled for one kind."""
        A, B, C, f = (_read_only(array) for array in self[:4])
        return PlaneStiffness(A, B, C, f, bool(self.separable), float(self.tension))


def _read_only(array: FloatArray) -> FloatArray:
    compact = np.ascontiguousarray(array, dtype=float).view()
    compact.flags.writeable = False
    return compact


@compiled
def nodal_state(stiff, i, q_stick, p_stick, v_stick):  # type: ignore[no-untyped-def]
    """State, slip and gap of node i, neighbours held, contact position ``v_stick`` (fig. 2.2).

    ``q_stick``, ``p_stick`` are the reactions with the node stuck at ``v_stick``.
    """
    a, b, c, f = stiff.A[i, i], stiff.B[i, i], stiff.C[i, i], stiff.f[i]
    backward, forward = q_stick - f * p_stick, -q_stick - f * p_stick
    if backward <= 0.0 and forward <= 0.0:
        return STICK, v_stick, 0.0
    if backward > 0.0 and (forward <= 0.0 or backward >= forward):
        first, second = BACKWARD_SLIP, FORWARD_SLIP
    else:
        first, second = FORWARD_SLIP, BACKWARD_SLIP
    for side in (first, second):
        violation = backward if side == BACKWARD_SLIP else forward
        resistance = a - side * f * b
        if violation > 0.0 and resistance > 0.0:
            slip = -side * violation / resistance
            if p_stick + b * slip >= -stiff.tension:
                return side, v_stick + slip, 0.0
    det = a * c - b * b
    if stiff.separable and det > 0.0:
        gap = (b * q_stick - a * p_stick) / det
        if gap > 0.0:
            return OPEN, v_stick - (q_stick + b * gap) / a, gap
    return NO_STATE, v_stick, 0.0


@linked
def contact_position(stiff, i, q, p, v, w, v_old, w_old):  # type: ignore[no-untyped-def]
    """Where node i touches: its old slip or, after separation, its slip when the gap closes.

    The gap of an open node is taken to close linearly between its old position
    and the one that it would reach free of reactions.
    """
    if w_old <= 0.0:
        return v_old
    a, b, c = stiff.A[i, i], stiff.B[i, i], stiff.C[i, i]
    det = a * c - b * b
    free_v = v - (c * q - b * p) / det
    free_w = w - (a * p - b * q) / det
    if free_w >= 0.0:
        return free_v
    return v_old + (free_v - v_old) * w_old / (w_old - free_w)


@linked
def load_step(stiff, q_w, p_w, v, w, v_contact, change_tol, max_sweeps):  # type: ignore[no-untyped-def]
    """Solve one load step in place; returns (sweeps, last relative change, unsolved node or −1).

    On entry v, w hold the state of the step before; on exit that of this step,
    and ``v_contact`` the position from which each node's slip in this step counts.
    """
    n = len(v)
    v_old, w_old = v.copy(), w.copy()
    q = q_w + stiff.A @ v + stiff.B.T @ w
    p = p_w + stiff.B @ v + stiff.C @ w
    change, unsolved = math.inf, -1
    for sweep in range(max_sweeps):
        change, unsolved = 0.0, -1
        for i in range(n):
            start = contact_position(stiff, i, q[i], p[i], v[i], w[i], v_old[i], w_old[i])
            v_contact[i] = start
            q_stick = q[i] + stiff.A[i, i] * (start - v[i]) - stiff.B[i, i] * w[i]
            p_stick = p[i] + stiff.B[i, i] * (start - v[i]) - stiff.C[i, i] * w[i]
            state, v_new, w_new = nodal_state(stiff, i, q_stick, p_stick, start)
            if state == NO_STATE:
                unsolved = i
            dv, dw = v_new - v[i], w_new - w[i]
            if dv != 0.0 or dw != 0.0:
                v[i], w[i] = v_new, w_new
                for j in range(n):
                    q[j] += stiff.A[j, i] * dv + stiff.B[i, j] * dw
                    p[j] += stiff.B[j, i] * dv + stiff.C[j, i] * dw
                change = max(change, abs(dv), abs(dw))
            if state == OPEN:
                v_contact[i] = v_new
        if change <= change_tol:
            return sweep + 1, change, unsolved
    return max_sweeps, change, unsolved


@compiled
def load_steps(stiff, q_w, p_w, v, w, change_tol, max_sweeps, v_path, w_path, slip_path):  # type: ignore[no-untyped-def]
    """Solve the load steps q_w, p_w (m, n) one after the other from the state v, w, in place.

    Fills v_path, w_path (slips and gaps after each step) and slip_path (slip in
    contact during each step), all (m, n). Returns (sweeps in all, worst last
    change, first step that did not converge or −1, node without a state or −1).
    """
    sweeps, worst = 0, 0.0
    v_contact = np.empty_like(v)
    for k in range(len(q_w)):
        used, change, unsolved = load_step(stiff, q_w[k], p_w[k], v, w, v_contact, change_tol, max_sweeps)
        sweeps += used
        worst = max(worst, change)
        for i in range(len(v)):  # slice assignments would take longer to compile than everything else here
            v_path[k, i], w_path[k, i], slip_path[k, i] = v[i], w[i], v[i] - v_contact[i]
        if change > change_tol or unsolved >= 0:
            return sweeps, worst, k, unsolved
    return sweeps, worst, -1, -1
