"""Gauss–Seidel at fixed load steps, for one and two tangential directions."""

import math
from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.constants import CONVERGED, DIRECTIONS, HALVINGS, NEWTON_ROUNDS, ROUND_OFF, FloatArray
from shakedown.ground.named_state import borrowing, entered, inner
from shakedown.ground.status import NO_STATE, OPEN, SLIP, STICK
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import require_problem
from shakedown.joint.law import Layout
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import free_stiffness
from shakedown.motion.checked_law import Scales, reactions
from shakedown.motion.course import EventKind
from shakedown.motion.event_history import EventHistory
from shakedown.motion.method import SLIDES_AWAY, CycleRecord, Motion, State, Stop

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
    axes, tension = tuple(range(layout.d)), 2 * CONVERGED * float(force)
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
        if missed <= CONVERGED:
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


REMEMBERED = 2  # cycles whose load steps are kept, whether recorded or not


class FixedSteps(Motion):
    """A joint under its loading loop, carried from load step to load step.

    Transient load steps, where the problem has them, come first and are no cycle. An initial slip that the
    law does not allow under the first load of all becomes one that it does.

    Parameters
    ----------
    problem, load_factor, initial_slip, tolerances, open_nodes
        As for :func:`evolve`.

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> motion = FixedSteps(shakedown.example("two-node"), 0.9)
    >>> first, second = motion.cycle(), motion.cycle()
    >>> second.slip.round(6)
    array([0.      , 1.893552])

    A load of constant size goes around, f p = 0.6, A = 1: the slip goes around a circle of radius 0.8.

    >>> t = 2 * np.pi * np.arange(1, 1201)[:, None] / 1200
    >>> q_w = np.hstack([np.cos(t), np.sin(t)])
    >>> node = shakedown.Problem(A=np.eye(2), B=np.zeros((1, 2)), f=0.3, q_w=q_w, p_w=np.full((1200, 1), 2.0))
    >>> motion = FixedSteps(node, 1.0)
    >>> first, second = motion.cycle(), motion.cycle()
    >>> (second.slip / (2 * np.pi)).round(3), round(second.dissipation / (2 * np.pi), 3)
    (array([0.798]), 0.479)
    """

    def __init__(
        self,
        problem: Problem,
        load_factor: float,
        initial_slip: ArrayLike | None = None,
        tolerances: Tolerances = DEFAULT,
        open_nodes: Iterable[int] = (),
    ) -> None:
        require_problem(problem)
        self.problem, self.tolerances = problem, tolerances
        self.u, self.contact = problem.layout.zeros(), np.zeros(problem.n, dtype=np.int64)
        self.begin(load_factor, initial_slip, open_nodes)

    def _begin(self, state: State, load: FloatArray, transient: FloatArray) -> None:
        problem, layout = self.problem, self.problem.layout
        self.residual = 0.0  # largest relative violation of the friction law so far
        self.recent: deque[tuple[EventHistory, FloatArray]] = deque(maxlen=REMEMBERED)
        kappa, separable = free_stiffness(problem), problem.C is not None
        self._at = places_by_node(layout)
        self._nodes = contact_nodes(layout, kappa, problem.f, separable, self.scale.force)
        self.state = state
        self.start = self.u[layout.slips].copy()
        if len(transient):
            self.pieces.append(self._advance(transient, -len(transient))[0])

    def _set_state(self, state: State) -> None:
        self.u[:], self.contact[:] = state.u, state.contact

    @property
    def history(self) -> EventHistory:
        """The states after all recorded load steps; nothing is known of what is between them."""
        return EventHistory.joined(self.pieces or [EventHistory.none(self.problem.layout)])

    def last(self, cycles: int) -> tuple[EventHistory, FloatArray]:
        """The load steps of the last cycles, at most ``REMEMBERED``, and the slip in contact during each.

        In space its length.
        """
        chosen = list(self.recent)[max(len(self.recent) - cycles, 0) :]
        if not chosen:
            return EventHistory.none(self.problem.layout), np.zeros((0, self.problem.n))
        slip = np.concatenate([slip for _, slip in chosen])
        slip = slip if self.problem.directions == 1 else self.problem.law.size(slip)
        return EventHistory.joined([path for path, _ in chosen]), slip

    def _follow(self, cycles: int, record: bool) -> bool:
        self._steps = self._advance(self.load, 0)
        if record:
            self.pieces.append(self._steps[0])
        if self.stop is not None:
            return False
        self.done += 1
        self.recent.append(self._steps)
        return True

    def _what_it_did(self) -> CycleRecord:
        (path, slip), layout = self._steps, self.problem.layout
        work, gap = -(layout.by_node(path.q) * layout.by_node(slip)).sum(axis=(0, 2)), path.w > 0
        return CycleRecord(
            end_slip=self.u[layout.slips].copy(),
            slip=self.problem.law.size(slip).sum(axis=0),
            work=work,
            friction_dissipation=float(work.sum()),
            jump_dissipation=0.0,
            opened=np.asarray(gap.any(axis=0)),
            closed=~np.asarray(gap.all(axis=0)),
        )

    def _advance(self, loads: FloatArray, first: int) -> tuple[EventHistory, FloatArray]:
        """Solve load steps (k, (d + 1) n), the last perhaps in vain, and check the law on those before.

        The states after them, and the slip in contact during each, (k, dn) [length].
        """
        layout, at, u = self.problem.layout, self._at, self.u[self._at]
        slips, found = np.empty((len(loads), layout.slip_size)), np.empty_like(loads)
        tolerance, given = self.tolerances.convergence * self.scale.length, loads[:, at].copy()
        _, change, failed, node = load_steps(self._nodes, given, u, tolerance, MOST_SWEEPS, found, slips)
        k = len(loads) if failed < 0 else failed + 1
        states, slip = np.empty_like(found[:k]), slips[:k]
        self.u[at], states[:, at] = u, found[:k]
        path = self._path_of(states, slip, loads[:k], first)
        self.contact[:] = path.state[-1]
        good = path.rows(np.arange(k if failed < 0 else failed))
        missed = projection_error(self.problem, good, slip[: len(good)], self.scale)
        self.residual = max(self.residual, missed)
        reason, slides_away = "", False
        if failed >= 0:
            self.residual = max(self.residual, change / self.scale.length)
            slides_away = node < 0 and self._slides_away(given[failed:k], u)
            lifts = node >= 0 and not self._nodes.separable and path.p[-1, node] < 0.0
            reason = self._failure(f"load step {first + failed}", node, change, lifts, slides_away)
        elif missed > self.tolerances.friction_law:
            reason = f"the friction law is violated by {missed:.1e} after converged load steps"
        if reason:
            when = self.done + (first + k - 1) / self.problem.m
            self.stop = Stop(reason, when, node, slides_away)
        return path, slip

    def _path_of(self, u: FloatArray, slip: FloatArray, loads: FloatArray, first: int) -> EventHistory:
        """The load steps with these states and slips in contact, the first of them with this number."""
        k, problem, split = len(loads), self.problem, self.problem.layout.split
        (v, w), (q_w, p_w) = split(u), split(loads)
        q, p = reactions(problem, q_w, p_w, v, w)
        moving = -np.sign(slip) if problem.directions == 1 else SLIP * (problem.law.size(slip) > 0)
        return EventHistory(
            cycle=self.done + (first + np.arange(k)) / problem.m,
            kind=np.full(k, EventKind.LOAD_STEP, dtype=np.int64),
            node=np.full(k, -1),
            v=v, w=w, q=q, p=p, q_w=q_w, p_w=p_w,
            state=np.where(w > 0, OPEN, moving.astype(np.int64)),
        )  # fmt: skip

    def _failure(self, where: str, node: int, change: float, lifts: bool, slides_away: bool) -> str:
        """Why a load step was not solved."""
        if lifts:
            return f"node {node} lifts off at {where}, and the problem has no C"
        if node >= 0:
            return f"no admissible state of node {node} at {where} (friction above a threshold?)"
        if slides_away:
            return f"{SLIDES_AWAY} at {where}"
        last = change / self.scale.length
        return f"{where} not converged in {MOST_SWEEPS} sweeps (last relative change {last:.1e})"

    def _slides_away(self, load: FloatArray, u: FloatArray) -> bool:
        """Whether the displacement of some more sweeps goes on, and nothing holds it."""
        before, kappa, stiffest = u.copy(), self._nodes.kappa, np.abs(np.diag(self._nodes.kappa)).max()
        # so many sweeps show whether a body that found no rest keeps moving
        load_steps(self._nodes, load, u, 0.0, 50, np.empty_like(load), np.empty((1, len(u))))
        way = u - before
        held = way @ kappa @ way > self.tolerances.zero_mode * stiffest * (way @ way)
        return bool(stiffest * np.abs(way).max() > self.scale.force and not held)


def projection_error(problem: Problem, path: EventHistory, slip: FloatArray, scale: Scales) -> float:
    """The relative violation by states (k, …) of the law of a load step with slips in contact (k, dn).

    The departure of the reactions from their projections on what the law allows, q from the limits at
    q − slip and p from max(p − w, 0), forces and lengths relative to the scales. Where a node slips by
    ever less it loses its direction and not its meaning, other than that of q + f p slip/|slip|.
    """
    q, p = path.q / scale.force, path.p / scale.force
    pressed = np.maximum(p - path.w / scale.length, 0.0)
    apart = q - problem.law.projection(q - slip / scale.length, pressed)
    return max(float(np.abs(apart).max(initial=0.0)), float(np.abs(p - pressed).max(initial=0.0)))
