"""The thesis's time integration: Gauss–Seidel over the nodes at fixed load steps (§2.3.2, (2.15), fig. 2.2).

Each load step is solved by sweeps over the nodes. A node takes the one of its states (stick, slip,
separation) that satisfies the law while its neighbours are held, with one tangential direction and with
two. It is the baseline that the exact, event-driven integrators are measured against.

Displacements and reactions stand node by node, u = (v, w) and r = (q, p), d + 1 places a node.

A node left exactly on its limit by a previous slip fails |q| ≤ f p by a unit in the last place. So a node
slips against the reaction that exceeds its limit, not along whichever candidate happens to pass, and
separation is accepted only with a positive gap.
"""

import math
from typing import NamedTuple

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import borrowing, entered, inner
from shakedown.ground.round_off import HALVINGS, NEWTON_ROUNDS, ROUND_OFF, SETTLED
from shakedown.ground.size_limits import DIRECTIONS
from shakedown.ground.status import NO_STATE, OPEN, SLIP, STICK
from shakedown.joint.layout import Layout

MOST_SWEEPS = 10_000


class Nodes(NamedTuple):
    """Contact stiffness κ (N, N) and friction as compiled code takes them, node by node.

    ``flexibility`` (n, d + 1, d + 1) are the inverses of the nodes' own blocks of κ, zero where one has none.
    ``weights`` (N,) count changes of stiff places as their reactions change, those of soft ones as they are.
    ``axes``, a tuple of the tangential directions, tells the compiler how many there are.
    ``separable`` is False where C is not known; ``tension`` is the round-off [force] by which a closed node's
    p may be negative.
    """

    kappa: FloatArray
    flexibility: FloatArray
    f: FloatArray
    weights: FloatArray
    axes: tuple[int, ...]
    separable: bool
    tension: float


def places_by_node(layout: Layout) -> FloatArray:
    """Where the places of one node after the other stand in a vector of slips, then gaps, ((d + 1) n,)."""
    slips = layout.by_node(np.arange(layout.slip_size))
    return np.column_stack([slips, layout.slip_size + np.arange(layout.n)]).ravel()


def contact_nodes(layout: Layout, kappa: FloatArray, f: FloatArray, separable: bool, force: float) -> Nodes:
    """The nodes of a joint with this stiffness, slips before gaps; ``force`` is the scale of the scene."""
    n, size, at = layout.n, layout.d + 1, places_by_node(layout)
    own = np.ascontiguousarray(kappa[np.ix_(at, at)])
    blocks = own.reshape(n, size, n, size)[np.arange(n), :, np.arange(n)]
    diagonals = np.diagonal(blocks, axis1=1, axis2=2).prod(axis=1)
    held = (np.linalg.det(blocks) > ROUND_OFF * diagonals) & separable
    flexibility = np.zeros_like(blocks)
    flexibility[held] = np.linalg.inv(blocks[held])
    diagonal = np.diag(own)
    softest = diagonal[diagonal > 0].min(initial=np.inf)
    friction, weights = np.array(f, dtype=float), np.maximum(diagonal / softest, 1.0)
    axes, tension = tuple(range(layout.d)), 2 * SETTLED * float(force)
    return Nodes(own, flexibility, friction, weights, axes, bool(separable), tension)


@inner
def slip_in_plane(a: float, b: float, f: float, q: float, p: float, tension: float) -> tuple[bool, float]:
    """The slip of a node with stiffness a and coupling b that takes it to its limit, if there is one."""
    first = 1.0 if q > 0.0 else -1.0
    for side in (first, -first):
        excess, resistance = side * q - f * p, a - side * f * b
        if excess > 0.0 and resistance > 0.0:
            slip = -side * excess / resistance
            if p + b * slip >= -tension:
                return True, slip
    return False, 0.0


@inner
def along(A, b, f, q, p, angle):  # type: ignore[no-untyped-def]
    """For slip in a given direction: driving force, stiffness, residual of the transverse equation."""
    x, y = math.cos(angle), math.sin(angle)
    ahead = A[0] * x + A[1] * y, A[1] * x + A[2] * y
    holds = x * ahead[0] + y * ahead[1] + f * (b[0] * x + b[1] * y)
    drives = -(x * q[0] + y * q[1] + f * p)
    return drives, holds, (x * q[1] - y * q[0]) * holds + drives * (x * ahead[1] - y * ahead[0])


@inner
def slip_by_direction(A, b, f, q, p, tension):  # type: ignore[no-untyped-def]
    """The slip of the held direction nearest to −q: whether there is one, and its components."""
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
        if drives > 0.0 and holds > 0.0:
            speed = drives / holds
            x, y = speed * math.cos(high), speed * math.sin(high)
            if p + b[0] * x + b[1] * y >= -tension:
                return True, x, y
    return False, 0.0, 0.0


@inner
def slip_by_newton(A, b, f, q, p, tension):  # type: ignore[no-untyped-def]
    """The slip from −q on: whether it was found, and its components."""
    weight, size, missed = 0.5 * (A[0] + A[2]), math.hypot(q[0], q[1]), math.inf
    qx, qy = q[0], q[1]
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
        missed = (abs(Fx) + abs(Fy)) / (size + f * abs(p))
        if missed <= SETTLED:
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
    pressed = p + b[0] * x + b[1] * y >= -tension
    return missed <= ROUND_OFF and pressed and x * qx + y * qy <= 0.0, x, y


@inner
def slip_in_space(A, b, f, q, p, tension):  # type: ignore[no-untyped-def]
    """The slip that takes a node to its limit, against its reaction there: whether there is one, and what."""
    if not A[0] + A[2] > 0.0 or (q[0] == 0.0 and q[1] == 0.0):
        return False, 0.0, 0.0
    if p > 0.0:
        found, x, y = slip_by_newton(A, b, f, q, p, tension)
        if found:
            return True, x, y
    return slip_by_direction(A, b, f, q, p, tension)


@borrowing
def nodal_state(nodes, i, r, x):  # type: ignore[no-untyped-def]
    """State of node i with its neighbours held, from its reactions r (d + 1,) at where it touches (fig. 2.2).

    Fills x (d + 1,) with its displacement from there.
    """
    d = len(nodes.axes)
    k, K, P, f, p = i * (d + 1), nodes.kappa, nodes.flexibility, nodes.f[i], r[d]
    for a in range(d + 1):
        x[a] = 0.0
    size = abs(r[0]) if d == 1 else math.hypot(r[0], r[1])
    if p >= -nodes.tension and size <= f * p:
        return STICK
    if d == 1:
        slips, x[0] = slip_in_plane(K[k, k], K[k + 1, k], f, r[0], p, nodes.tension)
    else:
        A, b = (K[k, k], K[k, k + 1], K[k + 1, k + 1]), (K[k + 2, k], K[k + 2, k + 1])
        slips, x[0], x[1] = slip_in_space(A, b, f, (r[0], r[1]), p, nodes.tension)
    if slips:
        return SLIP
    gap = 0.0
    for a in range(d + 1):
        gap -= P[i, d, a] * r[a]
    if not gap > 0.0:
        return NO_STATE
    for a in range(d + 1):
        for c in range(d + 1):
            x[a] -= P[i, a, c] * r[c]
    return OPEN


@borrowing
def find_contact(nodes, i, u, r, start, contact):  # type: ignore[no-untyped-def]
    """Where a node that was open touches: its slip when the gap closes.

    The gap is taken to close linearly between its old position and the one that the node would reach free
    of reactions.
    """
    size = len(nodes.axes) + 1
    k, d, P = i * size, size - 1, nodes.flexibility
    gap = u[k + d]
    for b in range(size):
        gap -= P[i, d, b] * r[k + b]
    share = 1.0 if gap >= 0.0 else start[k + d] / (start[k + d] - gap)
    for a in range(d):
        free = u[k + a]
        for b in range(size):
            free -= P[i, a, b] * r[k + b]
        contact[i * d + a] = start[k + a] + share * (free - start[k + a])


@borrowing
def add_rows(kappa, k, count, x, start, r):  # type: ignore[no-untyped-def]
    """r += κ x for the first places of a node, whose first is k, x from ``start`` on; κ is symmetric."""
    for a in range(count):
        if x[start + a] != 0.0:
            for j in range(len(r)):
                r[j] += x[start + a] * kappa[k + a, j]


@borrowing
def sweep(nodes, u, r, start, contact, x, t):  # type: ignore[no-untyped-def]
    """One sweep; returns the largest weighted change of a displacement, and a node without a state or −1."""
    d, change, unsolved = len(nodes.axes), 0.0, -1
    size = d + 1
    for i in range(len(nodes.f)):
        k = i * size
        if start[k + d] > 0.0:
            find_contact(nodes, i, u, r, start, contact)
        for a in range(size):
            t[a] = r[k + a]
        for b in range(size):
            back = contact[i * d + b] - u[k + b] if b < d else -u[k + b]
            if back != 0.0:
                for a in range(size):
                    t[a] += back * nodes.kappa[k + a, k + b]
        if nodal_state(nodes, i, t, x) == NO_STATE:
            unsolved = i
        for a in range(size):
            x[a] += (contact[i * d + a] if a < d else 0.0) - u[k + a]
            u[k + a] += x[a]
            change = max(change, nodes.weights[k + a] * abs(x[a]))
        add_rows(nodes.kappa, k, size, x, 0, r)
    return change, unsolved


@entered
def load_steps(nodes, loads, u, tolerance, most, path, slips):  # type: ignore[no-untyped-def]
    """Solve load steps (k, N) one after the other from the state u (N,), in place, by ``most`` sweeps each.

    Fills path (k, N) with the states after them and slips (k, dn) with the slip in contact during each.
    Returns (sweeps in all, the last change of a displacement, weighted, the first step in which it exceeded
    the tolerance [length] or −1, its node without a state or −1).
    """
    n, N, total = len(nodes.f), len(u), 0
    d = len(nodes.axes)
    r, start, contact = np.empty(N), np.empty(N), np.empty(n * d)
    x, t, change = np.empty(d + 1), np.empty(d + 1), 0.0
    for k in range(len(loads)):
        for j in range(N):
            start[j], r[j] = u[j], loads[k, j]
        for i in range(n):
            add_rows(nodes.kappa, i * (d + 1), d + 1, u, i * (d + 1), r)
            for a in range(d):
                contact[i * d + a] = u[i * (d + 1) + a]
        solved, unsolved, sweeps = False, -1, 0
        while not solved and sweeps < most:
            change, unsolved = sweep(nodes, u, r, start, contact, x, t)
            sweeps += 1
            solved = change <= tolerance
        total += sweeps
        for j in range(N):
            path[k, j] = u[j]
        for i in range(n):
            at = i * (d + 1)
            for a in range(d):
                slips[k, i * d + a] = 0.0 if u[at + d] > 0.0 else u[at + a] - contact[i * d + a]
        if not solved or unsolved >= 0:
            return total, change, k, unsolved
    return total, change, -1, -1
