"""Slips that are proved to be safe, with every rounding bounded (docs/space.md, Theorem U1)."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import fsum, inf, nan

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.discs.disc_rows import DiscRows, triples
from shakedown.ground.constants import HALVINGS, FloatArray
from shakedown.joint.constraints import loading, no_mean
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips

HALF_ULP = 0.5 * np.finfo(float).eps  # relative error of one rounding
TINY = float(np.finfo(float).tiny)  # largest loss by underflow in a sum of products
SUMS = 16 * HALF_ULP  # relative error of a sum of few rounded parts
SPLITTER = 2.0 ** (HALVINGS // 2) + 1.0  # parts a number in two of half its digits
REPAIRABLE = 0.25  # largest norm of I − R A for an approximate inverse R of A
LOADS = 8 * HALF_ULP  # relative error of a load: a mean, a difference, a product


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
        return self.norm <= REPAIRABLE

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
