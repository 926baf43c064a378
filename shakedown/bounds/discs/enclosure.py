"""Safe slips, and two load factors with λ_max of the joint as stored between them, proved.

Every rounding is bounded. The statements that it rests on are Theorems U1 to U3 of docs/space.md.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import fsum, inf, nan, nextafter

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.discs.disc_rows import DiscRows, triples
from shakedown.bounds.discs.scaled_solution import UnscaledSolution
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import Missing
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import loading, no_mean
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.program import exact_products
from shakedown.programs.self_dual import balanced_multipliers, inner_point

HALF_ULP = 0.5 * np.finfo(float).eps  # relative error of one rounding
TINY = float(np.finfo(float).tiny)  # largest loss by underflow in a sum of products
SUMS = 16 * HALF_ULP  # relative error of a sum of few rounded parts
LOADS = 8 * HALF_ULP  # relative error of a load: a mean, a difference, a product


class Inverse:
    """A symmetric matrix with an approximate inverse, and how near it is proved to be (Theorem U3)."""

    def __init__(self, matrix: FloatArray) -> None:
        """Invert it in units in which its diagonal is near 1."""
        diagonal, size = np.diag(matrix), len(matrix)
        powers = -np.frexp(np.where(diagonal > 0, diagonal, 1.0))[1] // 2
        self.lengths = np.ldexp(1.0, powers)
        scaled = matrix * self.lengths * self.lengths[:, None]
        try:
            self.approximate = np.linalg.inv(scaled)
        except np.linalg.LinAlgError:
            self.approximate = np.full((size, size), np.nan)
        with np.errstate(all="ignore"):
            rest = np.abs(np.eye(size) - self.approximate @ scaled).sum(axis=1)
            rounding = np.abs(self.approximate) @ np.abs(scaled).sum(axis=1)
            norm = np.max(rest + (size + 8) * 2 * HALF_ULP * (rounding + 1.0), initial=0.0)
        self.norm = float(norm) if np.isfinite(norm) else inf

    @property
    def proved(self) -> bool:
        """Whether it is near enough to its own inverse to be used."""
        return self.norm <= 0.25  # of I − R A

    def solved(self, forces: FloatArray) -> FloatArray:
        """The inverse times forces, about."""
        return np.asarray(self.lengths * (self.approximate @ (self.lengths * forces)))

    def bound(self, forces: FloatArray) -> FloatArray:
        """The sizes of the exact inverse times r at most, for |r| ≤ forces."""
        reach = np.abs(self.approximate) @ (self.lengths * forces) * (1.0 + len(forces) * 2 * HALF_ULP)
        reach = reach + self.norm / (1.0 - self.norm) * reach.max(initial=0.0)
        return np.asarray(self.lengths * reach * (1.0 + SUMS))


@dataclass(frozen=True)
class Loads:
    """The loads of a problem as triples (f p, q_x, q_y), to ``LOADS`` of its parts; f as in ``pressing``.

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


def pressing(law: Law) -> Law:
    """The law with f = 1 where there is no friction: f p is what must not be negative, of every node."""
    return replace(law, f=np.where(law.f == 0, 1.0, law.f))


def loads(problem: Problem) -> Loads:
    """The loads with means that are rounded once."""
    loop, law = loading(problem), pressing(problem.law)
    parts = []
    for samples, mean, plain, periodic in (
        (problem.q_w, problem.q_mean, loop.q0, loop.q1),
        (problem.p_w, problem.p_mean, loop.p0, loop.p1),
    ):
        constant = plain
        if mean is None:
            sums = np.array([fsum(column) for column in samples.T.tolist()])
            constant = np.where(no_mean(samples, plain), 0.0, sums / len(samples))
        moving = periodic.any(axis=0)
        parts.append((constant, np.where(moving, samples - constant, 0.0), moving))
    (q0, q1, of_q), (p0, p1, of_p) = parts

    c, e = triples(law, q0, p0), triples(law, q1, p1)
    moving = triples(law, of_q.astype(float), of_p.astype(float)) != 0
    return Loads(c, e, np.where(moving, LOADS * (np.abs(e) + np.abs(c)), 0.0))


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

    def slack(self, x: FloatArray, load_factor: float, constant: float = 1.0) -> FloatArray:
        """What f p − |q| certainly is, at least, at every load step (m, n) [force]; p without friction.

        At a slip x (2n,) and constant · c + load_factor · e.
        """
        law, held = pressing(self.problem.law), self.kept
        q = exact_products(self.problem.A[:, held], x[held])
        p = exact_products(self.problem.B[:, held], x[held])
        u = np.concatenate([law.limit(p)[:, None], law.layout.by_node(q)], axis=-1)
        c, e = constant * self.loads.c, load_factor * self.loads.e
        s = c + e + u
        size = np.abs(c) + np.abs(e) + np.abs(u)
        left = SUMS * size + load_factor * self.loads.left * (1.0 + SUMS)
        left += np.where(size > 0, TINY * x.size, 0.0)
        if self.smooth.size:
            left += self._moved(s, left, load_factor)
        slack = s[..., 0] - np.hypot(s[..., 1], s[..., 2]) - left.sum(axis=-1) * (1.0 + SUMS)
        slack[:, self.smooth] = (s[..., 0] - left[..., 0] * (1.0 + SUMS))[:, self.smooth]
        slack[:, self.weightless] = inf
        return np.asarray(slack)

    @cached_property
    def smooth(self) -> NDArray[np.intp]:
        """The nodes that never have a limit above zero."""
        return np.unique(self.rows.node[self.rows.smooth])

    @cached_property
    def weightless(self) -> NDArray[np.bool_]:
        """The nodes (n,) whose pressure, or f p, is zero whatever happens."""
        loaded = self.loads.c[:, 0].astype(bool) | self.loads.e[..., 0].any(axis=0)
        return np.asarray(~(loaded | self.problem.B.any(axis=1)))

    @cached_property
    def _smooth_slips(self) -> tuple[NDArray[np.intp], "Inverse"]:
        places = self.problem.layout.slips_of(self.smooth)
        return places, Inverse(self.problem.A[np.ix_(places, places)])

    def _moved(self, s: FloatArray, left: FloatArray, load_factor: float) -> FloatArray:
        """By how much triples change (n, 3), at most, where smooth nodes move until they have no reaction.

        Not at all clear, inf, where that is not proved: one slip must do for all load steps.
        """
        places, inverse = self._smooth_slips
        loads = load_factor * self.loads.e[:, self.smooth, 1:]
        pinned = np.setdiff1d(places, self.kept).size
        if loads.any() or pinned or not inverse.proved:
            return np.full(s.shape[1:], inf)
        rest = (np.abs(s) + left)[:, self.smooth, 1:].max(axis=0)
        change = inverse.bound(rest.ravel())
        law = pressing(self.problem.law)
        of_limits, of_q = (
            law.limit(np.abs(self.problem.B[:, places]) @ change),
            np.abs(self.problem.A[:, places]) @ change,
        )
        moved = np.concatenate([of_limits[:, None], law.layout.by_node(of_q)], axis=-1)
        return np.asarray(moved * (1.0 + len(s) * SUMS + places.size * SUMS))


def proof_of(problem: Problem, rows: DiscRows) -> Proof:
    """What statements about a joint are proved with."""
    pinned = set(rigid_slips(problem).pinned)
    kept = np.array([k for k in range(problem.layout.slip_size) if k not in pinned], dtype=np.intp)
    return Proof(problem, rows, loads(problem), kept)


def proved_low(
    proof: Proof, x: FloatArray, load_factor: float, inner: list[tuple[FloatArray, float]]
) -> tuple[float, FloatArray]:
    """A load factor next to the one given at which a slip is proved to be safe, and it; NaN where none is.

    ``inner`` has slips with slack, and their load factors: as little of one of them is mixed in as it takes.
    """
    short = -proof.slack(x, load_factor)
    if short.max() <= 0:
        return load_factor, x
    best, share, lost = None, inf, inf
    for slip, at in inner:
        if not (at >= 0 and np.isfinite(slip).all()):
            continue
        slack = proof.slack(slip, at)
        if slack.min() > 0:
            lacking = short > 0
            part = short[lacking] / (short[lacking] + slack[lacking])
            needed = float(part.max(initial=0.0))
            if needed * (load_factor - at) < lost:
                best, share, lost = (slip, at), needed, needed * (load_factor - at)
    if best is None:
        return nan, x
    for taken in doubled(share):
        mixed, at = x + taken * (best[0] - x), load_factor + taken * (best[1] - load_factor)
        if proof.slack(mixed, at).min() >= 0:
            return float(at), mixed
    return float(best[1]), best[0]


def doubled(share: float) -> Iterator[float]:
    """Shares of an inner point to mix in: twice what is needed, then twice as much each time, up to all."""
    while 0.0 < share < 1.0:
        share = min(1.0, 2.0 * share)
        yield share


def proved_unbounded(
    problem: Problem, rows: DiscRows, direction: FloatArray, safe: list[tuple[FloatArray, float]]
) -> bool:
    """Whether one of some slips is proved to be safe, and to stay so along a direction as loads grow."""
    if rigid_slips(problem).doubt or not np.isfinite(direction).all():
        return False
    proof = proof_of(problem, rows)
    if not proof.slack(direction, 1.0, constant=0.0).min() >= 0:
        return False
    return any(proof.slack(*each).min() >= 0 for each in safe)


def only_at_zero(proof: Proof) -> bool:
    """Whether the load of a node without friction changes through the period: no slip follows that."""
    places = proof.problem.layout.slips_of(proof.smooth)
    moving = loading(proof.problem).q1[:, places].any(axis=0)
    q = proof.problem.q_w[:, places]
    return bool(np.any(moving & (q != q[0]).any(axis=0)))


UNPROVED = "what proves that there is no largest load factor does not survive its rounding errors"


@dataclass(frozen=True)
class Balance:
    """Approximate multipliers y, and a proved bound on the correction that makes them balance exactly.

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
    """The balance of multipliers at the slips that are kept, and what makes up for what is missing."""

    def __init__(self, proof: Proof) -> None:
        """Invert A there, and bound what the inverse leaves."""
        problem, self.proof, self.kept = proof.problem, proof, proof.kept
        self.inverse = Inverse(problem.A[np.ix_(self.kept, self.kept)])
        held = np.vstack([problem.A[:, self.kept], problem.B[:, self.kept]])
        self.columns = np.ascontiguousarray(held.T)

    def missing(self, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """A Y + Bᵀ(f S) at the kept slips, and its rounding error at most."""
        weights = self._weights(y)
        found = exact_products(self.columns, weights)
        # f S is rounded in a sum, a product, and their bound
        error = 4 * HALF_ULP * (np.abs(self.columns) @ np.abs(weights)) + TINY * weights.size
        return found, error + SUMS * np.abs(found)

    def _weights(self, y: FloatArray) -> FloatArray:
        """Y and f S of all nodes."""
        totals, law = self._totals(y), pressing(self.proof.problem.law)
        return np.concatenate([totals[:, 1:].ravel(), law.limit(totals[:, 0])])

    def _totals(self, y: FloatArray) -> FloatArray:
        """S and Y of every node, (n, 3), each sum rounded once."""
        rows = self.proof.rows
        order = np.argsort(rows.node, kind="stable")
        ends = np.cumsum(np.bincount(rows.node, minlength=len(rows.stiffness)))[:-1]
        parts = np.split(y[order], ends)
        return np.array([[fsum(column) for column in part.T.tolist()] for part in parts])

    def balanced(self, y: FloatArray) -> Balance:
        """Multipliers with the correction that remains: bounded, but not yet known to fit into the cones."""
        rows, n = self.proof.rows, self.proof.problem.n
        y, disc = y.copy(), _with_most_slack(rows, y)
        for exact in (False, True):  # what the first one leaves of its round-off the second takes away
            change, weights = np.zeros(2 * n), self._weights(y)
            missing = exact_products(self.columns, weights) if exact else self.columns @ weights
            change[self.kept] = self.inverse.solved(missing)
            y[disc, 1:] -= change.reshape(-1, 2)
        found, error = self.missing(y)
        correction = np.zeros(2 * n)
        correction[self.kept] = self.inverse.bound(np.abs(found) + error)
        return Balance(y, disc, correction.reshape(-1, 2))


def _slacks(rows: DiscRows, y: FloatArray) -> FloatArray:
    """σ − |y| of multipliers (j, 3), at least; of reactions that must vanish σ alone counts."""
    slack = y[:, 0] - np.hypot(y[:, 1], y[:, 2]) * (1.0 + SUMS)
    return np.asarray(np.where(rows.smooth, np.where(y[:, 0] >= 0, inf, -inf), slack))


def _with_most_slack(rows: DiscRows, y: FloatArray) -> NDArray[np.intp]:
    """The disc of every node with the largest slack for a correction."""
    order = np.lexsort((_slacks(rows, y), rows.node))
    last = np.flatnonzero(np.diff(rows.node[order], append=-1))
    return np.asarray(order[last])


def _fits(rows: DiscRows, balance: Balance) -> bool:
    needed = balance.correction.sum(axis=1) * (1.0 + SUMS)
    outside = _slacks(rows, balance.y)
    return bool(np.all(outside >= 0) and np.all(outside[balance.disc] >= needed))


def fitting(
    repair: Repair, y: FloatArray, inner: list[tuple[FloatArray, float]], most: float = inf
) -> Balance | None:
    """Exact multipliers next to y, as little of inner ones mixed in as it takes; None where there are none.

    ``inner`` has multipliers with slack, and by how much each is worse than y; ``most`` is what may be lost.
    """
    first, rows = repair.balanced(y), repair.proof.rows
    if _fits(rows, first):
        return first
    outside = np.maximum(-np.minimum(_slacks(rows, y), _slacks(rows, first.y)), 0.0)
    needed = first.correction.sum(axis=1)
    best, share, lost = None, inf, inf
    for other, worse in inner:
        slack = _slacks(rows, other)
        if not slack.min() > 0:
            continue
        largest = slack[_with_most_slack(rows, other)]
        wanted = float(max(np.max(outside / (outside + slack)), np.max(needed / (needed + largest))))
        if wanted * worse < lost:
            best, share, lost = other, wanted, wanted * worse
    if best is None or lost > most:
        return None
    for taken in doubled(share):
        balance = repair.balanced(y + taken * (best - y))
        if _fits(rows, balance):
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
        error = (error + float(moved.sum())) * (1.0 + terms.size * 2 * HALF_ULP) + TINY * np.count_nonzero(
            terms
        )
        error += SUMS * abs(value)
        found += [value - error, value + error]
    return found[0], found[1], found[2], found[3]


def proved_high(
    repair: Repair, y: FloatArray, inner: list[tuple[FloatArray, float]], tolerances: Tolerances
) -> float:
    """A load factor above which no slip is safe, from multipliers with Σ yᵀ e < 0; inf if none is proved.

    Where that would be ``agreement`` of the terms of its proof above the optimum, it is not looked for.
    """
    constant = repair.proof.loads.c[repair.proof.rows.node]
    most = tolerances.agreement * float(np.abs(np.einsum("ij,ij->i", y, constant)).sum())
    balance = fitting(repair, y, inner, most)
    if balance is None:
        return inf
    _, most, _, slope = _totals(repair.proof, balance)
    if not slope < 0:
        return inf
    return nextafter(nextafter(most / -slope, inf), inf) if most > 0 else 0.0


def proved_infeasible(problem: Problem, rows: DiscRows, end: UnscaledSolution) -> bool:
    """Whether multipliers, those of the end first, prove that no slip is safe at any load factor ≥ 0."""
    if rigid_slips(problem).doubt:
        return False
    repair = Repair(proof_of(problem, rows))
    return repair.inverse.proved and any(_excludes(repair, y) for y in _exclusions(rows, end))


def _exclusions(rows: DiscRows, end: UnscaledSolution) -> Iterator[FloatArray]:
    """Multipliers that exclude every slip, then those with more slack on the way to them."""
    yield rows.with_pressures(end.y, end.z)
    for point in end.end.path[-2::-2]:
        y, z = end.scaled.multipliers(balanced_multipliers(end.scaled.program, point._replace(tau=0.0)))
        size = -float(np.vdot(y, end.scaled.rows.c) + z @ end.scaled.rows.half_spaces.g)
        if size > 0 and np.isfinite(y).all():
            yield rows.with_pressures(y / size, z / size)


def _excludes(repair: Repair, y: FloatArray) -> bool:
    """Whether multipliers, balanced exactly, exclude every load factor ≥ 0."""
    balance = fitting(repair, y, [])
    if balance is None:
        return False
    _, most, _, slope = _totals(repair.proof, balance)
    return bool(most < 0 and slope <= 0)


def enclosed(
    problem: Problem, rows: DiscRows, best: UnscaledSolution, tolerances: Tolerances
) -> tuple[float, float] | Missing:
    """(low, high) with λ_max of the joint as stored between them, or why there are none."""
    doubt = rigid_slips(problem).doubt
    if doubt:
        return Missing(doubt)
    terms = np.abs(rows.flat) @ np.abs(best.x)
    forces = np.abs(rows.c).max() + best.load_factor * np.abs(rows.e).max()
    if np.finfo(float).eps * terms.max(initial=0.0) > tolerances.stored_digits * forces:
        return Missing("the slip is so large that round-off in the stored stiffness decides the answer")
    proof, (slips, multipliers) = proof_of(problem, rows), inner_points(rows, best)
    low, _ = proved_low(proof, best.x, best.load_factor, slips)
    if not np.isfinite(low):
        return Missing("no slip was found that is safe at every load step by more than its rounding errors")
    if low == 0 and only_at_zero(proof):
        return 0.0, 0.0
    repair = Repair(proof)
    if not repair.inverse.proved:
        return Missing("the tangential stiffness is too nearly singular to prove the balance of multipliers")
    high = proved_high(repair, rows.with_pressures(best.y, best.z), multipliers, tolerances)
    return (
        (low, high)
        if np.isfinite(high)
        else Missing("no multipliers were found that prove more than their rounding errors")
    )


Near = list[tuple[FloatArray, float]]  # points with slack: slips and their load factors, or multipliers


def inner_points(rows: DiscRows, best: UnscaledSolution) -> tuple[Near, Near]:
    """Slips with slack, with their load factors, and multipliers with slack, with what they lose."""
    scaled, slips, multipliers = best.scaled, Near(), Near()
    program = scaled.program
    slack = program.limits - program.times(best.end.x)
    for gap in (1e-4, 1e-2):  # means of slack times multiplier
        point = inner_point(program, best.end, gap)
        if point is not None:
            slips.append((scaled.slips(point.x), float(point.x[-1] * scaled.load_unit)))
            loss = abs(float(slack @ point.y)) * scaled.load_unit
            multipliers.append((rows.with_pressures(*scaled.multipliers(point.y)), loss))
    return slips, multipliers
