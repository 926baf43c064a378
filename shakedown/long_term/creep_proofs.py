"""What keeps a body that friction alone holds from creeping, and what makes it (docs/creep.md).

All of it is about joints in the plane with one rigid slip z, nodes closed. Slips are in units of z, so that
the rigid slip is 1 at every node, and each limit is multiplied by |z_i|: forces are generalised ones.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import inf, nan

import numpy as np

from shakedown.ground.constants import EPS, NEGLIGIBLE, SIX_DIGITS, FloatArray, IntArray, Mask
from shakedown.ground.status import OPEN, Status
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.constraints import loading
from shakedown.joint.contact_zone import coupled_parts
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import can_creep, rigid_slips, with_free_rigid_slips
from shakedown.motion.event_history import EventHistory
from shakedown.programs.program import Program
from shakedown.programs.simplex import solve

SIDES = FORWARD, BACKWARD = 0, 1  # directions of creep: along z, against it
NONE = 1e-12  # largest coupling M_ij that counts as none, relative to √(M_ii M_jj): round-off of condensation
SLACK = 2e-6  # of the rows of a path, relative to the friction limits: far above what programs leave
HELD_NODES = 64  # nodes tried as the one that is held, those that would slip last first


@dataclass(frozen=True, eq=False)
class SlidingBody:
    """A joint in the plane with one rigid slip, in units in which that is 1 at every node.

    Side 0 is about forward slip, side 1 the same of the mirrored joint (v → −v): a node i slips along the
    side only where (M x)_i + h_i = 0, x being its slips; against it only where the other M x = h, so that
    M[1] is A − f B.

    Attributes
    ----------
    problem
        The joint.
    z : (n,)
        The rigid slip [–]; not 0 anywhere.
    M : (2, n, n)
        A ± f B [force × length], whose rows sum to 0.
    h0, h1 : (2, n), (2, m, n)
        Constant and periodic part of f p_w ± q_w [force × length].
    """

    problem: Problem
    z: FloatArray
    M: FloatArray
    h0: FloatArray
    h1: FloatArray

    @cached_property
    def neighbours(self) -> tuple[Mask, Mask]:
        """For each side the nodes j whose slip changes the limit of i: M_ij < 0 beyond round-off."""
        own = np.sqrt(np.abs(np.einsum("sii->si", self.M)))
        coupled = np.abs(self.M) > NONE * own[:, :, None] * own[:, None, :]
        coupled &= ~np.eye(len(self.z), dtype=bool)
        return coupled[0], coupled[1]

    @cached_property
    def monotone(self) -> tuple[bool, bool]:
        """For each side whether slip of other nodes never brings a node nearer to its limit: all M_ij ≤ 0."""
        return tuple(not (self.M[side][self.neighbours[side]] > 0).any() for side in SIDES)  # type: ignore[return-value]

    @cached_property
    def all_mixtures_irreducible(self) -> bool:
        """Whether every matrix whose rows are those of M[0] or of M[1] is irreducible.

        One is not where some nodes S, not all, have either in M[0] or in M[1] no neighbour outside S. From a
        node outside such an S all that is joined by nodes with neighbours in both stays outside.
        """
        one, other = self.neighbours
        for start in range(len(self.z)):
            outside = np.arange(len(self.z)) == start
            for _ in range(len(self.z)):
                joined = outside | (one @ outside & other @ outside)
                if (joined == outside).all():
                    break
                outside = joined
            if not outside.all():
                return False
        return True

    def closed_classes(self, side: int) -> Iterable[FloatArray]:
        """The left null vectors y ≥ 0 of M, one for each class of nodes that none outside acts on."""
        from scipy.sparse.csgraph import connected_components  # where a body floats only

        arcs, M = self.neighbours[side], self.M[side]
        count, label = connected_components(arcs, directed=True, connection="strong")
        for one in range(count):
            nodes = np.flatnonzero(label == one)
            if arcs[nodes][:, label != one].any():
                continue
            y = np.zeros(len(M))
            y[nodes] = np.linalg.svd(M[np.ix_(nodes, nodes)].T)[2][-1]
            yield y * np.sign(y.sum())

    @cached_property
    def wedge_bounds(self) -> tuple[float, float]:
        """For each side λ_w, below which no closed motion creeps that way (Theorem 1); NaN where unknown.

        Σ y_i min_t h_i(t; λ) = 0 there.
        """
        return tuple(self._wedge_bound(side) if self.monotone[side] else nan for side in SIDES)  # type: ignore[return-value]

    def _wedge_bound(self, side: int) -> float:
        found = [_last(y @ self.h0[side], y @ self.h1[side].min(axis=0)) for y in self.closed_classes(side)]
        return min(found)

    @cached_property
    def uncoupled(self) -> bool:
        """Whether slip changes no friction limit, f B = 0."""
        return bool((np.abs(self.M[0] - self.M[1]) <= NONE * np.abs(self.M[0]).max()).all())

    @cached_property
    def gross_slip(self) -> float:
        """λ_g: from there on some load step has no equilibrium with all nodes closed; inf where none is."""
        n, most = len(self.z), inf
        matrix = np.zeros((2 * n, n + 1))
        matrix[:, :n] = np.vstack([-self.M[0], self.M[1]])
        matrix[:, 0] = 0.0  # of a rigid slip
        cost, lower = np.append(np.zeros(n), -1.0), np.append(np.full(n, -inf), 0.0)
        for k in range(self.h1.shape[1]):
            matrix[:, n] = -self.h1[:, k].ravel()
            found = solve(Program(matrix.copy(), self.h0.ravel(), cost, lower=lower))
            if found.status == Status.OPTIMAL:
                most = min(most, -found.value)
            elif found.status == Status.INFEASIBLE:
                return 0.0
        return most

    @cached_property
    def certain_creep(self) -> tuple[float, float]:
        """The load factors between which every closed motion creeps (Theorem 5); NaN where there are none.

        Only where f B = 0: from the wedge bound, of the sums of all nodes, to the swing of a single node, or
        to gross slip.
        """
        if not self.uncoupled:
            return nan, nan
        least = self.h1.min(axis=1)
        wedge = min(_last(self.h0[side].sum(), least[side].sum()) for side in SIDES)
        swing = min(_last(*each) for each in zip(self.h0.sum(axis=0), least.sum(axis=0), strict=True))
        end = min(swing, self.gross_slip)
        return (wedge, end) if 0 < wedge < end else (nan, nan)

    def reactions_left(self, history: EventHistory) -> FloatArray:
        """The least distance of every node from either limit during a path, (2, n); 0 where it slips."""
        return self._room(history).min(axis=1)

    def _room(self, history: EventHistory) -> FloatArray:
        """The distance of every node from either limit along a path, (2, t, n)."""
        limit = np.abs(self.z) * self.problem.f * history.p
        return np.stack([limit + sign * self.z * history.q for sign in (1.0, -1.0)])

    def drift_enclosure(self, history: EventHistory) -> tuple[float, float]:
        """The drift per cycle along z of every closed motion lies between these, by one cycle (Theorem 2).

        NaN unless the joint is monotone with all mixtures of rows irreducible, and the path one or several
        whole cycles, closed and without an interval in which all nodes are at their limits.
        """
        nothing = nan, nan
        if not (all(self.monotone) and self.all_mixtures_irreducible) or not len(history):
            return nothing
        length = float(np.ptp(history.cycle))
        cycles = round(length)
        if cycles < 1 or abs(length - cycles) > SIX_DIGITS:
            return nothing
        room = self._room(history)
        largest, left = 0.5 * room.sum(axis=0).max(), room.min(axis=0)
        between = 0.5 * (left[1:] + left[:-1])  # zero only where it is at both ends
        lasting = np.diff(history.cycle) > 0
        at_limits = (between <= SIX_DIGITS * largest).all(axis=1) & lasting
        jumps = ~lasting & (np.diff(history.v, axis=0) != 0).any(axis=1)
        if (history.state == OPEN).any() or jumps.any() or at_limits.any():
            return nothing
        change = (history.v[-1] - history.v[0]) / self.z / cycles
        return float(change.min()), float(change.max())

    def interval_proved(self, side: int, back: Mask, start: float, goal: float) -> float:
        """Up to where no motion creeps along a side, from a proved load factor on (Theorem 3).

        By a periodic path x that goes back only where ``back`` (m, n) says, during load step k from k − 1 to
        k. The load factors with such a path are an interval; it reaches from
        ``start``, or nothing is added, to ``goal`` at most.
        """
        last = _path_end(self, side, back, (start, goal), -1.0)
        if not last > start or not _path_end(self, side, back, (0.5 * start, goal), 1.0) <= start:
            return start
        return last

    def held_bound(self, start: FloatArray) -> tuple[float, FloatArray]:
        """λ_H, below which a node stays in place from a start, so nothing creeps (Theorem 6); and a box.

        The box (2, n): slips, in units of z, that the motion does not leave, in any order of the loads. 0
        where the mean load does not hold the start strictly.
        """
        x0, n = start / self.z, len(self.z)
        moved = np.stack([self.M[0] @ x0, -self.M[1] @ x0])
        if not (self.h0 + moved > NEGLIGIBLE * np.abs(self.h0).max()).all():
            return 0.0, np.stack([x0, x0])
        # the worst corner of the box for the upper end of node i by M[0], for its lower end by −M[1]
        rows, own = list[FloatArray](), np.eye(n, dtype=bool)
        for M, upper in ((self.M[0], True), (self.M[1], False)):
            far = np.where(own | (M < 0), M, 0.0)
            near = M - far
            # forward: Σ_far M u + Σ_near M l ≥ −h; backward: Σ_far M l + Σ_near M u ≤ h
            rows.append(np.hstack([-near, -far]) if upper else np.hstack([far, near]))
        # the loop in any order, and the ramp from no reactions to the first load step under its pressures
        ramp0 = np.abs(self.z) * self.problem.f * loading(self.problem).p0
        ramp1 = np.abs(self.z) * self.problem.f * loading(self.problem).p1[0]
        A = 0.5 * (self.M[0] + self.M[1])
        shift = np.concatenate([-(A @ x0), A @ x0])
        boxes = np.vstack(rows)
        matrix = np.vstack(
            [
                np.hstack([boxes, -self.h1.min(axis=1).reshape(-1, 1)]),
                np.hstack([boxes, -np.tile(ramp1, 2)[:, None]]),
            ]
        )
        right = np.concatenate([self.h0.ravel(), np.tile(ramp0, 2) + shift])
        cost = np.append(np.zeros(2 * n), -1.0)
        lower = np.concatenate([np.full(n, -inf), x0, [0.0]])
        upper_ends = np.concatenate([x0, np.full(n, inf), [inf]])
        swing = np.maximum(-self.h1.min(axis=1), NEGLIGIBLE * np.abs(self.h0).max())
        room = ((self.h0 + moved) / swing).min(axis=0)
        best, box = 0.0, np.stack([x0, x0])
        for node in np.argsort(-room)[:HELD_NODES]:
            low, high = lower.copy(), upper_ends.copy()
            low[node], high[n + node] = x0[node], x0[node]
            found = solve(Program(matrix, right, cost, lower=low, upper=high))
            if found.status == Status.UNBOUNDED:
                return inf, box
            if found.status == Status.OPTIMAL and -found.value > best:
                best, box = -found.value, found.x[: 2 * n].reshape(2, n)
        return best, box


def _last(constant: float, growing: float) -> float:
    """The load factor up to which constant + λ growing > 0; 0 where it never is, inf where always."""
    if not constant > 0.0:
        return 0.0
    return constant / -growing if growing < 0.0 else inf


def _path_end(body: SlidingBody, side: int, back: Mask, within: tuple[float, float], cost: float) -> float:
    """The least (``cost`` 1) or largest (−1) load factor between two with a path of Theorem 3; NaN without.

    The program is of a periodic path x (m, n) and λ; nodes that never go back stand still. What it finds is
    checked by its residuals.
    """
    from scipy.optimize import linprog
    from scipy.sparse import coo_array, vstack

    (m, n), columns = back.shape, _path_columns(back)
    # forces in units of their mean, slips in those that this force causes
    scale, stiff = float(np.abs(body.h0[side]).mean()), float(np.abs(np.diagonal(body.M[side])).mean())
    count, slack = int(columns.max()) + 1, SLACK * scale
    ahead = np.roll(columns, 1, axis=0)
    k, i = np.divmod(np.arange(m * n), n)
    dense = np.broadcast_to(np.repeat(np.arange(m * n), n)[:, None], (m * n * n, 1)).ravel()

    def rows(M: FloatArray, at: IntArray, growing: FloatArray) -> coo_array:
        values = np.append(-np.tile(M, (m, 1)).ravel() / stiff, -growing.ravel() / scale)
        places = np.append(dense, np.arange(m * n)), np.append(at[k].ravel(), np.full(m * n, count))
        return coo_array((values, places), (m * n, count + 1))

    M, h0, h1 = body.M[side], body.h0[side], body.h1[side]
    matrices, right = [rows(M, columns, h1)], [np.tile(h0, m) - slack]
    other, g0, g1 = body.M[1 - side], body.h0[1 - side], body.h1[1 - side]
    chosen = np.flatnonzero(back.ravel())
    for at, load in ((columns, g1), (ahead, np.roll(g1, 1, axis=0))):
        matrices.append(rows(other, at, -load).tocsr()[chosen])
        right.append(-np.tile(g0, m)[chosen] - slack)
    free = np.flatnonzero(~back.ravel() & np.any(back, axis=0).take(i))
    pair = np.concatenate([ahead.ravel()[free], columns.ravel()[free]])
    values = np.repeat([1.0, -1.0], len(free))
    again = coo_array((values, (np.tile(np.arange(len(free)), 2), pair)), (len(free), count + 1))
    end = linprog(
        np.append(np.zeros(count), cost),
        A_ub=vstack([*matrices, again]).tocsr(),
        b_ub=np.concatenate([each / scale for each in right] + [np.zeros(len(free))]),
        bounds=[(0.0, 0.0)] + [(None, None)] * (count - 1) + [within],
        method="highs",
    )
    if end.x is None:
        return nan
    x, load_factor = _without_round_off(back, end.x[columns] * (scale / stiff)), float(end.x[count])
    return load_factor if _path_holds(body, side, back, x, load_factor) else nan


def _path_columns(back: Mask) -> IntArray:
    """The unknown of the program that the slip of every node is at every load step, (m, n)."""
    (m, n), moving = back.shape, back.any(axis=0)
    column = np.where(moving, np.arange(m)[:, None], 0) * n + np.arange(n)
    return np.unique(column, return_inverse=True)[1].reshape(m, n)


def _without_round_off(back: Mask, x: FloatArray) -> FloatArray:
    """The path with no step back, however small, where it must not go back."""
    x, m = x.copy(), len(x)
    for k in range(2 * m):
        now, before = k % m, (k - 1) % m
        x[now] = np.where(back[now], x[now], np.maximum(x[now], x[before]))
    return x


def _path_holds(body: SlidingBody, side: int, back: Mask, x: FloatArray, load_factor: float) -> bool:
    """Whether a path passes every row at a load factor, beyond round-off."""
    before, last = np.roll(x, 1, axis=0), np.roll(body.h1[1 - side], 1, axis=0)
    size = (len(body.z) + 4) * EPS * (np.abs(x) @ np.abs(body.M).max(axis=0).T + np.abs(body.h0).max())

    def left(which: int, path: FloatArray, load: FloatArray, sign: float) -> FloatArray:
        value = path @ body.M[which].T + sign * (body.h0[which] + load_factor * load)
        return np.asarray(value - size)

    held = left(side, x, body.h1[side], 1.0) > 0
    released = (left(1 - side, x, body.h1[1 - side], -1.0) > 0) & (left(1 - side, before, last, -1.0) > 0)
    return bool(held.all() and released[back].all() and (x >= before)[~back].all())


def steps_back(body: SlidingBody, side: int, history: EventHistory) -> Mask:
    """The load steps (m, n) in which the nodes of a cycle go back, seen from a side: from step k − 1 to k."""
    m, sign = body.h1.shape[1], 1.0 if side == FORWARD else -1.0
    # a cycle begins with the last load step; load step k is reached at (k + 1) / m
    change = sign * np.diff(history.at(history.cycle[0] + np.arange(m + 1) / m).v, axis=0) / body.z
    # a node that goes back in a small part of a step need not be free in all of it: that would prove less
    return np.asarray(change < -0.03 * np.abs(change).max(initial=0.0))


@once_per_problem
def sliding_bodies(problem: Problem) -> tuple[SlidingBody | None, ...]:
    """The bodies that friction alone holds among the uncoupled parts of a joint; none where no slip is rigid.

    None for a part with several rigid slips, one that leaves a node in place, or one in doubt.
    """
    if problem.directions > 1 or not can_creep(problem):
        return ()
    found = list[SlidingBody | None]()
    for part in coupled_parts(problem):
        if can_creep(part.joint):
            rigid = rigid_slips(part.joint)
            found.append(_body(part.joint) if len(rigid.pinned) == 1 and not rigid.doubt else None)
    return tuple(found)


def _body(problem: Problem) -> SlidingBody | None:
    z = rigid_slips(problem).motions[:, 0]
    if not (np.abs(z) > NEGLIGIBLE * np.abs(z).max()).all():
        return None
    free, loop = with_free_rigid_slips(problem), loading(problem)
    A, fB = free.A * z * z[:, None], (np.abs(z) * problem.f)[:, None] * free.B * z

    def sides(q: FloatArray, p: FloatArray) -> FloatArray:
        limit = np.abs(z) * problem.f * p
        return np.stack([limit + z * q, limit - z * q])

    return SlidingBody(
        problem, z, np.stack([A + fB, A - fB]), sides(loop.q0, loop.p0), sides(loop.q1, loop.p1)
    )
