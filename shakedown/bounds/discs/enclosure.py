"""Two load factors with λ_max of the joint as stored between them: proved, with every rounding bounded.

The statements that it rests on are Theorems U1 to U3 of docs/space.md.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import fsum, inf, nextafter

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.discs.disc_rows import DiscRows
from shakedown.bounds.discs.safe_proof import (
    HALF_ULP,
    LOADS,
    SUMS,
    TINY,
    Inverse,
    Proof,
    doubled,
    exact_products,
    only_at_zero,
    pressing,
    proof_of,
    proved_low,
)
from shakedown.bounds.discs.scaled_solution import UnscaledSolution
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import Missing
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.self_dual import balanced_multipliers, inner_point

INNER_GAPS = (1e-4, 1e-2)  # of inner points

ROUNDED_TWICE = 4 * HALF_ULP  # relative error of f S: a sum, a product, and the rounding of their bound

TOO_SOFT = "the tangential stiffness is too nearly singular to prove the balance of multipliers"
NO_SLACK = "no slip was found that is safe at every load step by more than its rounding errors"
NO_INNER = "no multipliers were found that prove more than their rounding errors"
ROUND_OFF_DECIDES = "the slip is so large that round-off in the stored stiffness decides the answer"
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
        error = ROUNDED_TWICE * (np.abs(self.columns) @ np.abs(weights)) + TINY * weights.size
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
        return Missing(ROUND_OFF_DECIDES)
    proof, (slips, multipliers) = proof_of(problem, rows), inner_points(rows, best)
    low, _ = proved_low(proof, best.x, best.load_factor, slips)
    if not np.isfinite(low):
        return Missing(NO_SLACK)
    if low == 0 and only_at_zero(proof):
        return 0.0, 0.0
    repair = Repair(proof)
    if not repair.inverse.proved:
        return Missing(TOO_SOFT)
    high = proved_high(repair, rows.with_pressures(best.y, best.z), multipliers, tolerances)
    return (low, high) if np.isfinite(high) else Missing(NO_INNER)


Near = list[tuple[FloatArray, float]]  # points with slack: slips and their load factors, or multipliers


def inner_points(rows: DiscRows, best: UnscaledSolution) -> tuple[Near, Near]:
    """Slips with slack, with their load factors, and multipliers with slack, with what they lose."""
    scaled, slips, multipliers = best.scaled, Near(), Near()
    program = scaled.program
    slack = program.limits - program.times(best.end.x)
    for gap in INNER_GAPS:
        point = inner_point(program, best.end, gap)
        if point is not None:
            slips.append((scaled.slips(point.x), float(point.x[-1] * scaled.load_unit)))
            loss = abs(float(slack @ point.y)) * scaled.load_unit
            multipliers.append((rows.with_pressures(*scaled.multipliers(point.y)), loss))
    return slips, multipliers
