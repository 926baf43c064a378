"""Safe slips, and two load factors with λ_max of the joint as stored between them, proved.

Every rounding is bounded. It rests on Theorems U1 to U3 of docs/space.md.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import fsum, inf, nan, nextafter

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.disc_rows import DiscRows, triples
from shakedown.bounds.scaled_solution import UnscaledSolution
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import Missing
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import loading
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.program import exact_products
from shakedown.programs.self_dual import inner_point

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


def pressing(law: Law) -> Law:
    """The law with f = 1 where there is no friction: f p is what must not be negative, of every node."""
    return replace(law, f=np.where(law.f == 0, 1.0, law.f))


@dataclass(frozen=True)
class Proof:
    """The joint as stored, and what its statements are proved with; f as in ``pressing``.

    Attributes
    ----------
    problem, rows
        The joint, with all nodes closed, and its limits.
    kept
        The slips that are not pinned.
    c : (n, 3)
        Constant part of the loads as triples (f p, q_x, q_y), to ``LOADS`` of its terms [force].
    e : (m, n, 3)
        Periodic part at load factor 1 [force].
    left : (m, n, 3)
        What the periodic part may be off, at most [force]; where nothing changes it is exactly zero.
    """

    problem: Problem
    rows: DiscRows
    kept: NDArray[np.intp]
    c: FloatArray
    e: FloatArray
    left: FloatArray

    def slack(self, x: FloatArray, load_factor: float, constant: float = 1.0) -> FloatArray:
        """What f p − |q| certainly is, at least, at every load step (m, n) [force]; p without friction.

        At a slip x (2n,) and constant · c + load_factor · e.
        """
        law, held = pressing(self.problem.law), self.kept
        q = exact_products(self.problem.A[:, held], x[held])
        p = exact_products(self.problem.B[:, held], x[held])
        u = np.concatenate([law.limit(p)[:, None], law.layout.by_node(q)], axis=-1)
        c, e = constant * self.c, load_factor * self.e
        s = c + e + u
        size = np.abs(c) + np.abs(e) + np.abs(u)
        left = SUMS * size + load_factor * self.left * (1.0 + SUMS)
        left += np.where(size > 0, TINY * x.size, 0.0)
        if self.frictionless.size:
            left += self._moved(s, left, load_factor)
        slack = s[..., 0] - np.hypot(s[..., 1], s[..., 2]) - left.sum(axis=-1) * (1.0 + SUMS)
        slack[:, self.frictionless] = (s[..., 0] - left[..., 0] * (1.0 + SUMS))[:, self.frictionless]
        slack[:, self.weightless] = inf
        return np.asarray(slack)

    @cached_property
    def frictionless(self) -> NDArray[np.intp]:
        """The nodes that never have a limit above zero."""
        return np.unique(self.rows.node[self.rows.frictionless])

    @cached_property
    def weightless(self) -> NDArray[np.bool_]:
        """The nodes (n,) whose pressure, or f p, is zero whatever happens."""
        loaded = self.c[:, 0].astype(bool) | self.e[..., 0].any(axis=0)
        return np.asarray(~(loaded | self.problem.B.any(axis=1)))

    @cached_property
    def _frictionless_slips(self) -> tuple[NDArray[np.intp], "Inverse"]:
        places = self.problem.layout.slips_of(self.frictionless)
        return places, Inverse(self.problem.A[np.ix_(places, places)])

    def _moved(self, s: FloatArray, left: FloatArray, load_factor: float) -> FloatArray:
        """Bounds (n, 3) on the change of triples as frictionless nodes move until they have no reaction.

        Infinite where no bound is proved, as where the loads on these nodes vary: one slip must do for all
        load steps.
        """
        places, inverse = self._frictionless_slips
        loads = load_factor * self.e[:, self.frictionless, 1:]
        pinned = np.setdiff1d(places, self.kept).size
        if loads.any() or pinned or not inverse.proved:
            return np.full(s.shape[1:], inf)
        rest = (np.abs(s) + left)[:, self.frictionless, 1:].max(axis=0)
        change = inverse.bound(rest.ravel())
        law = pressing(self.problem.law)
        of_limits, of_q = (
            law.limit(np.abs(self.problem.B[:, places]) @ change),
            np.abs(self.problem.A[:, places]) @ change,
        )
        moved = np.concatenate([of_limits[:, None], law.layout.by_node(of_q)], axis=-1)
        return np.asarray(moved * (1.0 + len(s) * SUMS + places.size * SUMS))

    @cached_property
    def inverse(self) -> Inverse:
        """That of A at the slips that are kept, with a bound of what it leaves."""
        return Inverse(self.problem.A[np.ix_(self.kept, self.kept)])

    @cached_property
    def _columns(self) -> FloatArray:
        held = np.vstack([self.problem.A[:, self.kept], self.problem.B[:, self.kept]])
        return np.ascontiguousarray(held.T)

    def _weights(self, y: FloatArray) -> FloatArray:
        """Y and f S of all nodes, each sum rounded once."""
        rows, law = self.rows, pressing(self.problem.law)
        order = np.argsort(rows.node, kind="stable")
        parts = np.split(y[order], np.cumsum(np.bincount(rows.node, minlength=len(rows.stiffness)))[:-1])
        totals = np.array([[fsum(column) for column in part.T.tolist()] for part in parts])
        return np.concatenate([totals[:, 1:].ravel(), law.limit(totals[:, 0])])

    def balanced(self, y: FloatArray) -> "Balance":
        """Multipliers with the correction that remains: bounded, but not yet known to fit into the cones.

        What is missing is A Y + Bᵀ(f S) at the kept slips; f S is rounded in a sum, a product, their bound.
        """
        rows, columns, y = self.rows, self._columns, y.copy()
        disc = _with_most_slack(rows, y)
        for exact in (False, True):  # what the first one leaves of its round-off the second takes away
            change, weights = np.zeros(2 * self.problem.n), self._weights(y)
            missing = exact_products(columns, weights) if exact else columns @ weights
            change[self.kept] = self.inverse.solved(missing)
            y[disc, 1:] -= change.reshape(-1, 2)
        weights, correction = self._weights(y), np.zeros(2 * self.problem.n)
        found = exact_products(columns, weights)
        error = 4 * HALF_ULP * (np.abs(columns) @ np.abs(weights)) + TINY * weights.size
        correction[self.kept] = self.inverse.bound(np.abs(found) + (error + SUMS * np.abs(found)))
        return Balance(y, disc, correction.reshape(-1, 2))


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


def proof_of(problem: Problem, rows: DiscRows) -> Proof:
    """What statements about a joint are proved with, its means rounded once."""
    loop, law, pinned = loading(problem), pressing(problem.law), rigid_slips(problem).pinned
    parts = []
    for samples, mean, plain, periodic in (
        (problem.q_w, problem.q_mean, loop.q0, loop.q1),
        (problem.p_w, problem.p_mean, loop.p0, loop.p1),
    ):
        means = [fsum(column) / len(samples) for column in samples.T.tolist()] if mean is None else plain
        constant = np.where(plain != 0.0, means, 0.0)
        moving = periodic.any(axis=0)
        parts.append((constant, np.where(moving, samples - constant, 0.0), moving.astype(float)))
    c, e, varies = (triples(law, q, p) for q, p in zip(*parts, strict=True))
    left = np.where(varies != 0, LOADS * (np.abs(e) + np.abs(c)), 0.0)
    return Proof(problem, rows, np.setdiff1d(np.arange(problem.layout.slip_size), pinned), c, e, left)


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
    steady = proof.slack(direction, 1.0, constant=0.0).min() >= 0
    return bool(steady) and any(proof.slack(*each).min() >= 0 for each in safe)


UNPROVED = "what proves that there is no largest load factor does not survive its rounding errors"


def _slacks(rows: DiscRows, y: FloatArray) -> FloatArray:
    """σ − |y| of multipliers (j, 3), at least; of reactions that must vanish σ alone counts."""
    slack = y[:, 0] - np.hypot(y[:, 1], y[:, 2]) * (1.0 + SUMS)
    return np.asarray(np.where(rows.frictionless, np.where(y[:, 0] >= 0, inf, -inf), slack))


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
    proof: Proof, y: FloatArray, inner: list[tuple[FloatArray, float]], most: float = inf
) -> Balance | None:
    """Exact multipliers next to y, as little of inner ones mixed in as it takes; None where there are none.

    ``inner`` has multipliers with slack, and by how much each is worse than y; ``most`` is what may be lost.
    """
    first, rows = proof.balanced(y), proof.rows
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
        balance = proof.balanced(y + taken * (best - y))
        if _fits(rows, balance):
            return balance
    return None


def _totals(proof: Proof, balance: Balance) -> tuple[float, float, float, float]:
    """Σ yᵀ c and Σ yᵀ e of the exact multipliers: each at least and at most."""
    rows, found = proof.rows, []
    for load, left in (
        (proof.c[rows.node], LOADS * np.abs(proof.c[rows.node])),
        (proof.e[rows.step, rows.node], proof.left[rows.step, rows.node]),
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
    proof: Proof, y: FloatArray, inner: list[tuple[FloatArray, float]], tolerances: Tolerances
) -> float:
    """A load factor above which no slip is safe, from multipliers with Σ yᵀ e < 0; inf if none is proved.

    Where that would be ``agreement`` of the terms of its proof above the optimum, it is not looked for.
    """
    constant = proof.c[proof.rows.node]
    most = tolerances.agreement * float(np.abs(np.einsum("ij,ij->i", y, constant)).sum())
    balance = fitting(proof, y, inner, most)
    if balance is None:
        return inf
    _, most, _, slope = _totals(proof, balance)
    if not slope < 0:
        return inf
    return nextafter(nextafter(most / -slope, inf), inf) if most > 0 else 0.0


def proved_infeasible(problem: Problem, rows: DiscRows, end: UnscaledSolution) -> bool:
    """Whether the multipliers of the end prove that no slip is safe at any load factor ≥ 0."""
    if rigid_slips(problem).doubt:
        return False
    proof = proof_of(problem, rows)
    if not proof.inverse.proved:
        return False
    balance = fitting(proof, rows.with_pressures(end.y, end.z), [])
    if balance is None:
        return False
    _, most, _, slope = _totals(proof, balance)
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
    # no slip follows a load that changes of a node without friction
    places = problem.layout.slips_of(proof.frictionless)
    q, moving = problem.q_w[:, places], loading(problem).q1[:, places].any(axis=0)
    if low == 0 and np.any(moving & (q != q[0]).any(axis=0)):
        return 0.0, 0.0
    if not proof.inverse.proved:
        return Missing("the tangential stiffness is too nearly singular to prove the balance of multipliers")
    high = proved_high(proof, rows.with_pressures(best.y, best.z), multipliers, tolerances)
    if not np.isfinite(high):
        return Missing("no multipliers were found that prove more than their rounding errors")
    return low, high


Near = list[tuple[FloatArray, float]]  # points with slack: slips and their load factors, or multipliers


def inner_points(rows: DiscRows, best: UnscaledSolution) -> tuple[Near, Near]:
    """Slips with slack, with their load factors, and multipliers with slack, with what they lose."""
    scaled, slips, multipliers = best.scaled, Near(), Near()
    program = scaled.program
    slack = program.limits - program.times(best.scaled_solution.x)
    for gap in (1e-4, 1e-2):  # means of slack times multiplier
        point = inner_point(program, best.scaled_solution, gap)
        if point is not None:
            slips.append((scaled.slips(point.x), float(point.x[-1] * scaled.load_unit)))
            loss = abs(float(slack @ point.y)) * scaled.load_unit
            multipliers.append((rows.with_pressures(*scaled.multipliers(point.y)), loss))
    return slips, multipliers
