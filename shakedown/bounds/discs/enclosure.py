"""Two load factors with λ_max of the joint as stored between them: proved, with every rounding bounded.

The two statements that it rests on stand in docs/space.md (U1, U2).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import fsum, inf, nan, nextafter

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.discs.disc_program import DiscEnd
from shakedown.bounds.discs.disc_rows import DiscRows, triples
from shakedown.ground.evidence import Missing
from shakedown.ground.float_array import FloatArray
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.interior.self_dual import balanced_multipliers, inner_point

HALF_ULP = 0.5 * np.finfo(float).eps  # of a rounding, relative
TINY = float(np.finfo(float).tiny)  # what an underflow may lose, at most, in a sum of products
LOADS = 8 * HALF_ULP  # of a load in its parts, relative: a mean, a difference, a product
SUMS = 16 * HALF_ULP  # of what is put together of few rounded parts, relative to them
SPLITTER = 2.0**27 + 1.0
REPAIRABLE = 0.25  # largest norm of I − R A for an approximate inverse R of A
ROUNDS = 12  # of mixing more of an inner point, four times as much every time
INNER_GAPS = (1e-4, 1e-2)  # of inner points
SPARE = 2.0  # more room than is needed at first

TOO_SOFT = "the tangential stiffness is too nearly singular to prove the balance of multipliers"
NO_ROOM = "no slip with room at every load step was found: where friction vanishes there is none"
NO_INNER = "no multipliers with room were found"
UNPROVED = "what proves that there is no largest load factor does not survive its rounding errors"


@dataclass(frozen=True)
class Loads:
    """The loads of a problem as triples (f p, q_x, q_y), each to ``LOADS`` of its parts.

    Attributes
    ----------
    c : (n, 3)
        Constant part [force].
    e : (m, n, 3)
        Periodic part at load factor 1 [force].
    left : (m, n, 3)
        What the periodic part may be off, at most [force]; where nothing changes it is exactly zero.
    """

    c: FloatArray
    e: FloatArray
    left: FloatArray


def loads(problem: Problem) -> Loads:
    """The loads with means that are rounded once."""
    loop, law = loading(problem), problem.law
    parts = []
    for samples, mean, periodic in (
        (problem.q_w, problem.q_mean, loop.q1),
        (problem.p_w, problem.p_mean, loop.p1),
    ):
        constant = mean
        if constant is None:
            constant = np.array([fsum(column) for column in samples.T.tolist()]) / len(samples)
        moving = periodic.any(axis=0)
        parts.append((constant, np.where(moving, samples - constant, 0.0), moving))
    (q0, q1, of_q), (p0, p1, of_p) = parts

    c, e = triples(law, q0, p0), triples(law, q1, p1)
    moving = triples(law, of_q.astype(float), of_p.astype(float)) != 0
    return Loads(c, e, np.where(moving, LOADS * (np.abs(e) + np.abs(c)), 0.0))


def exact_products(matrix: FloatArray, x: FloatArray) -> FloatArray:
    """M x with every entry rounded once: products split without error, their sums rounded once.

    Examples
    --------
    >>> exact_products(np.array([[1e16, 1.0, -1e16]]), np.ones(3))
    array([1.])
    """
    found = np.empty(len(matrix))
    x_high = _high(x)
    x_low = x - x_high
    for i, row in enumerate(matrix):
        high = _high(row)
        low, product = row - high, row * x
        rest = low * x_low - (((product - high * x_high) - low * x_high) - high * x_low)
        found[i] = fsum(np.concatenate([product, rest]).tolist())
    return found


def _high(values: FloatArray) -> FloatArray:
    """The first 26 bits."""
    lifted = SPLITTER * values
    return np.asarray(lifted - (lifted - values))


@dataclass(frozen=True)
class Proof:
    """The joint as stored, and what its statements are proved with.

    Attributes
    ----------
    problem, rows
        The joint, with all nodes closed, and its limits.
    loads
        Its loads.
    kept
        The slips that are not pinned.
    """

    problem: Problem
    rows: DiscRows
    loads: Loads
    kept: NDArray[np.intp]

    def room(self, x: FloatArray, load_factor: float, constant: float = 1.0) -> FloatArray:
        """What f p − |q| certainly is, at least, at every load step (m, n) [force].

        At a slip x (2n,) and constant · c + load_factor · e.
        """
        law, held = self.problem.law, self.kept
        q = exact_products(self.problem.A[:, held], x[held])
        p = exact_products(self.problem.B[:, held], x[held])
        u = np.concatenate([law.limit(p)[:, None], law.layout.by_node(q)], axis=-1)
        c, e = constant * self.loads.c, load_factor * self.loads.e
        s = c + e + u
        size = np.abs(c) + np.abs(e) + np.abs(u)
        left = SUMS * size + load_factor * self.loads.left * (1.0 + SUMS)
        left += np.where(size > 0, TINY * x.size, 0.0)
        return np.asarray(s[..., 0] - np.hypot(s[..., 1], s[..., 2]) - left.sum(axis=-1) * (1.0 + SUMS))


def proof_of(problem: Problem, rows: DiscRows) -> Proof:
    """What statements about a joint are proved with."""
    pinned = set(rigid_slips(problem).pinned)
    kept = np.array([k for k in range(problem.layout.slip_size) if k not in pinned], dtype=np.intp)
    return Proof(problem, rows, loads(problem), kept)


def proved_low(
    proof: Proof, x: FloatArray, load_factor: float, inner: list[tuple[FloatArray, float]]
) -> tuple[float, FloatArray]:
    """A load factor next to the one given at which a slip is proved to be safe, and it; NaN where none is.

    ``inner`` has slips with room, and their load factors: as little of one of them is mixed in as it takes.
    """
    short = -proof.room(x, load_factor)
    if short.max() <= 0:
        return load_factor, x
    best, share, lost = None, inf, inf
    for slip, at in inner:
        if not (at >= 0 and np.isfinite(slip).all()):
            continue
        room = proof.room(slip, at)
        if room.min() > 0:
            needed = float(np.max(short / (short + room), initial=0.0, where=short > 0))
            if needed * (load_factor - at) < lost:
                best, share, lost = (slip, at), needed, needed * (load_factor - at)
    if best is None:
        return nan, x
    for _ in range(ROUNDS):
        share = min(1.0, SPARE * share)
        mixed, at = x + share * (best[0] - x), load_factor + share * (best[1] - load_factor)
        if proof.room(mixed, at).min() >= 0:
            return float(at), mixed
    return float(best[1]), best[0]


@dataclass(frozen=True)
class Balance:
    """Multipliers that balance exactly, as far as is proved: y and what is to be added to it, at most.

    Attributes
    ----------
    y : (j, 3)
        Multipliers in their cones.
    disc : (n,)
        The disc of every node that takes the correction.
    correction : (n, 2)
        Its size, at most: there are exact multipliers that differ from y by no more, in their cones.
    """

    y: FloatArray
    disc: NDArray[np.intp]
    correction: FloatArray


class Repair:
    """The tangential stiffness of the slips that are kept, and an inverse proved to be near its own."""

    def __init__(self, proof: Proof) -> None:
        """Invert it, and bound what the inverse leaves."""
        problem, self.kept = proof.problem, proof.kept
        self.proof = proof
        A = problem.A[np.ix_(self.kept, self.kept)]
        diagonal = np.diag(A)
        powers = -np.frexp(np.where(diagonal > 0, diagonal, 1.0))[1] // 2
        self.lengths = np.ldexp(1.0, powers)
        scaled = A * self.lengths * self.lengths[:, None]
        size = len(A)
        try:
            self.inverse = np.linalg.inv(scaled)
        except np.linalg.LinAlgError:
            self.inverse = np.full((size, size), np.nan)
        with np.errstate(all="ignore"):
            rest = np.abs(np.eye(size) - self.inverse @ scaled).sum(axis=1)
            rounding = np.abs(self.inverse) @ np.abs(scaled).sum(axis=1)
            norm = np.max(rest + (size + 8) * 2 * HALF_ULP * (rounding + 1.0), initial=0.0)
        self.norm = float(norm) if np.isfinite(norm) else inf
        held = np.vstack([problem.A[:, self.kept], problem.B[:, self.kept]])
        self.columns = np.ascontiguousarray(held.T)

    def missing(self, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """A Y + Bᵀ(f S) at the kept slips, and its rounding error at most."""
        rows, problem = self.proof.rows, self.proof.problem
        totals = rows.sums @ y
        weights = np.concatenate([totals[:, 1:].ravel(), problem.law.limit(totals[:, 0])])
        sizes = rows.sums @ np.abs(y)
        largest = np.concatenate([sizes[:, 1:].ravel(), problem.law.limit(sizes[:, 0])])
        count = int(np.bincount(rows.node).max()) + 4
        found = exact_products(self.columns, weights)
        error = count * 2 * HALF_ULP * (np.abs(self.columns) @ largest) + TINY * largest.size
        return found, error + SUMS * np.abs(found)

    def solved(self, forces: FloatArray) -> FloatArray:
        """A⁻¹ times forces, about."""
        return np.asarray(self.lengths * (self.inverse @ (self.lengths * forces)))

    def bound(self, forces: FloatArray) -> FloatArray:
        """|A⁻¹ r| at most, for |r| ≤ forces."""
        reach = np.abs(self.inverse) @ (self.lengths * forces) * (1.0 + len(forces) * 2 * HALF_ULP)
        reach = reach + self.norm / (1.0 - self.norm) * reach.max(initial=0.0)
        return np.asarray(self.lengths * reach * (1.0 + SUMS))

    def balanced(self, y: FloatArray) -> Balance:
        """Multipliers with the correction that remains: bounded, but not yet known to fit into the cones."""
        rows, n = self.proof.rows, self.proof.problem.n
        y, disc = y.copy(), _roomiest(rows, y)
        for _ in range(2):
            change = np.zeros(2 * n)
            change[self.kept] = self.solved(self.missing(y)[0])
            y[disc, 1:] -= change.reshape(-1, 2)
        found, error = self.missing(y)
        correction = np.zeros(2 * n)
        correction[self.kept] = self.bound(np.abs(found) + error)
        return Balance(y, disc, correction.reshape(-1, 2))


def _rooms(y: FloatArray) -> FloatArray:
    """σ − |y| of multipliers (…, 3), at least."""
    return np.asarray(y[..., 0] - np.hypot(y[..., 1], y[..., 2]) * (1.0 + SUMS))


def _roomiest(rows: DiscRows, y: FloatArray) -> NDArray[np.intp]:
    """The disc of every node with the largest room for a correction."""
    order = np.lexsort((_rooms(y), rows.node))
    last = np.flatnonzero(np.diff(rows.node[order], append=-1))
    return np.asarray(order[last])


def _fits(balance: Balance) -> bool:
    needed = balance.correction.sum(axis=1) * (1.0 + SUMS)
    outside = _rooms(balance.y)
    return bool(np.all(outside >= 0) and np.all(outside[balance.disc] >= needed))


def fitting(repair: Repair, y: FloatArray, inner: list[tuple[FloatArray, float]]) -> Balance | None:
    """Exact multipliers next to y, as little of inner ones mixed in as it takes; None where there are none.

    ``inner`` has multipliers with room, and by how much each is worse than y.
    """
    first = repair.balanced(y)
    if _fits(first):
        return first
    outside, needed = np.maximum(-_rooms(y), 0.0), first.correction.sum(axis=1)
    best, share, lost = None, inf, inf
    for other, worse in inner:
        room = _rooms(other)
        if not room.min() > 0:
            continue
        largest = room[_roomiest(repair.proof.rows, other)]
        wanted = float(max(np.max(outside / (outside + room)), np.max(needed / (needed + largest))))
        if wanted * worse < lost:
            best, share, lost = other, wanted, wanted * worse
    if best is None:
        return None
    for _ in range(ROUNDS):
        share = min(1.0, SPARE * share)
        balance = repair.balanced(y + share * (best - y))
        if _fits(balance):
            return balance
    return None


def _totals(proof: Proof, balance: Balance) -> tuple[float, float, float, float]:
    """Σ yᵀ c and Σ yᵀ e of the exact multipliers: each at least and at most."""
    rows, of = proof.rows, proof.loads
    found = []
    for load, left in (
        (of.c[rows.node], LOADS * np.abs(of.c[rows.node])),
        (of.e[rows.step, rows.node], of.left[rows.step, rows.node]),
    ):
        terms = balance.y * load
        value = fsum(terms.ravel().tolist())
        error = float(np.sum(SUMS * np.abs(terms) + 2.0 * np.abs(balance.y) * left))
        moved = balance.correction * (np.abs(load) + 2.0 * left)[balance.disc, 1:]
        error = (error + float(moved.sum())) * (1.0 + terms.size * 2 * HALF_ULP) + TINY * terms.size
        error += SUMS * abs(value)
        found += [value - error, value + error]
    return found[0], found[1], found[2], found[3]


def proved_high(repair: Repair, y: FloatArray, inner: list[tuple[FloatArray, float]]) -> float:
    """A load factor above which no slip is safe, from multipliers with Σ yᵀ e < 0; inf if none is proved."""
    balance = fitting(repair, y, inner)
    if balance is None:
        return inf
    _, most, _, slope = _totals(repair.proof, balance)
    if not slope < 0:
        return inf
    return nextafter(nextafter(max(most, 0.0) / -slope, inf), inf)


def proved_infeasible(problem: Problem, rows: DiscRows, end: DiscEnd) -> bool:
    """Whether multipliers prove that no slip is safe at any load factor ≥ 0."""
    if rigid_slips(problem).doubt:
        return False
    proof = proof_of(problem, rows)
    repair = Repair(proof)
    if repair.norm > REPAIRABLE:
        return False
    return any(_excludes(repair, y) for y in _on_the_way(end))


def _on_the_way(end: DiscEnd) -> Iterator[FloatArray]:
    """Multipliers of an infeasible program, and those with more room on the way to them."""
    yield end.y
    for point in end.end.path[-2::-2]:
        y = end.scaled.multipliers(balanced_multipliers(end.scaled.program, point))[0]
        size = -float(np.vdot(y, end.scaled.program.rows.c))
        if size > 0 and np.isfinite(y).all():
            yield y / size


def _excludes(repair: Repair, y: FloatArray) -> bool:
    """Whether multipliers, balanced exactly, exclude every load factor ≥ 0."""
    balance = fitting(repair, y, [])
    if balance is None:
        return False
    _, most, _, slope = _totals(repair.proof, balance)
    return bool(most < 0 and slope <= 0)


def proved_unbounded(
    problem: Problem, rows: DiscRows, direction: FloatArray, safe: tuple[FloatArray, float]
) -> bool:
    """Whether a slip is proved to be safe, and to stay so along a direction at ever larger load factors."""
    if rigid_slips(problem).doubt or not np.isfinite(direction).all():
        return False
    proof = proof_of(problem, rows)
    return bool(proof.room(direction, 1.0, constant=0.0).min() >= 0 and proof.room(*safe).min() >= 0)


def enclosed(problem: Problem, rows: DiscRows, best: DiscEnd) -> tuple[float, float] | Missing:
    """(low, high) with λ_max of the joint as stored between them, or why there are none."""
    doubt = rigid_slips(problem).doubt
    if doubt:
        return Missing(doubt)
    proof, (slips, multipliers) = proof_of(problem, rows), inner_points(best)
    low, _ = proved_low(proof, best.x, best.load_factor, slips)
    if not np.isfinite(low):
        return Missing(NO_ROOM)
    repair = Repair(proof)
    if repair.norm > REPAIRABLE:
        return Missing(TOO_SOFT)
    high = proved_high(repair, best.y, multipliers)
    return (low, high) if np.isfinite(high) else Missing(NO_INNER)


def inner_points(best: DiscEnd) -> tuple[list[tuple[FloatArray, float]], list[tuple[FloatArray, float]]]:
    """Slips with room, with their load factors, and multipliers with room, with what they lose."""
    scaled, slips, multipliers = best.scaled, [], []
    program = scaled.program
    slack = program.right - program.times(best.end.x)
    for gap in INNER_GAPS:
        point = inner_point(program, best.end, gap)
        if point is not None:
            slips.append((scaled.slips(point.x), float(point.x[-1] * scaled.load_unit)))
            loss = abs(float(slack @ point.y)) * scaled.load_unit
            multipliers.append((scaled.multipliers(point.y)[0], loss))
    return slips, multipliers
