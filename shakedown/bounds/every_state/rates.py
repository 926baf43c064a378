"""Rates of slip: where they are unique, and of bodies that friction alone holds; a joint in its own units."""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.uniqueness.coupling import Uniqueness, least_of_sums
from shakedown.ground.constants import EPS, NEGLIGIBLE, SIX_DIGITS, FloatArray, Mask
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.constraints import loading
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips


@dataclass(frozen=True)
class ScaledJoint:
    """κ, friction and loads with slips and gaps of node i in units of ``lengths[i]``, a power of two.

    Reactions are generalised forces then, lengths[i] times those of the node: both sides of every
    friction limit have the same factor, and no result depends on it but by round-off.

    Attributes
    ----------
    law
        Coulomb's law, with the friction coefficients as they are.
    A, B : (dn, dn), (n, dn)
        Tangential stiffness and coupling.
    q0, p0, q1, p1
        Constant and periodic part of the loads, as :class:`~shakedown.joint.constraints.Loading`.
    lengths : (n,)
        Units of slip [length].
    motions : (dn, r)
        Z, the slips that change no reaction; 1 at ``pinned[k]`` and 0 at the other pinned ones [–].
    pinned
        As many slips as there are such motions.
    """

    law: Law
    A: FloatArray
    B: FloatArray
    q0: FloatArray
    p0: FloatArray
    q1: FloatArray
    p1: FloatArray
    lengths: FloatArray
    motions: FloatArray
    pinned: tuple[int, ...]

    @property
    def n(self) -> int:
        """Number of contact nodes."""
        return self.law.layout.n

    @property
    def d(self) -> int:
        """Tangential directions of a node, 1 or 2."""
        return self.law.d

    @property
    def f(self) -> FloatArray:
        """Friction coefficients, (n,)."""
        return np.asarray(self.law.f)

    @property
    def fB(self) -> FloatArray:
        """f B, (n, dn): how slips change the friction limits."""
        return np.asarray(self.f[:, None] * self.B)

    @property
    def stiffness(self) -> FloatArray:
        """What powers of two leave of the stiffness of every node, 0.5 to 2, or 1 where it has none: (n,)."""
        own = self.law.layout.by_node(np.diagonal(self.A)).max(axis=1)
        return np.where(own > 0, own, 1.0)

    @property
    def floats(self) -> bool:
        """Whether friction alone holds the body: some slips change no reaction."""
        return bool(self.motions.shape[1])

    def in_balance(self, reactions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Reactions (dn,) of some slip, from their part at the slips that are not pinned; and their error.

        Such reactions have no resultant along a rigid motion, Zᵀ z = 0; their part may be anything.
        """
        found, pinned, kept = reactions.copy(), list(self.pinned), self.kept
        loose = np.zeros_like(found)
        found[pinned] = -reactions[kept] @ self.motions[kept]
        loose[pinned] = (len(kept) + 2) * EPS * (np.abs(reactions[kept]) @ np.abs(self.motions[kept]))
        return found, loose

    @cached_property
    def kept(self) -> NDArray[np.intp]:
        """The slips that there are and that are not pinned, by number."""
        return np.setdiff1d(np.arange(self.d * self.n), self.pinned)

    @cached_property
    def kept_stiffness(self) -> FloatArray:
        """A in the slips that are kept, (k, k)."""
        return self.A[np.ix_(self.kept, self.kept)]

    @cached_property
    def held(self) -> bool:
        """Whether A is positive definite in the slips that are kept, if any, clear of round-off."""
        values = np.linalg.eigvalsh(self.kept_stiffness)
        return bool(len(values)) and bool(values[0] > 4 * len(values) * EPS * values[-1])

    @cached_property
    def inverse(self) -> NDArray[np.floating]:
        """That of A in the slips that are kept, (k, k)."""
        return np.linalg.inv(self.kept_stiffness)

    @cached_property
    def inverse_error(self) -> float:
        """α ≥ ‖I − A X‖ of this inverse X, round-off of the product included."""
        n, A, size = self.n, self.kept_stiffness, np.abs(self.inverse)
        off = np.abs(np.eye(len(A)) - A @ self.inverse) + (2 * n + 4) * EPS * (np.abs(A) @ size)
        return float(off.sum(axis=0).max(initial=0.0))

    @cached_property
    def pressures_by_forces(self) -> FloatArray:
        """B A⁻¹ in the slips that are kept, (n, k)."""
        return np.asarray(self.B[:, self.kept] @ self.inverse)

    def of_joint(self, reactions: FloatArray) -> FloatArray:
        """Reactions (dn,) in the units of the joint itself [force]."""
        return np.asarray(reactions / np.repeat(self.lengths, self.d))


@once_per_problem
def scaled_joint(problem: Problem) -> ScaledJoint:
    """The joint in units of its own; made once per problem."""
    stiffness = problem.layout.by_node(np.diagonal(problem.A)).max(axis=1)
    relative = np.ldexp(stiffness, -int(np.frexp(stiffness.max(initial=0.0))[1]))  # so that units cancel
    lengths = np.exp2(np.rint(-0.5 * np.log2(np.where(stiffness > 0, relative, 1.0))))
    both, loop, rigid = np.repeat(lengths, problem.directions), loading(problem), rigid_slips(problem)
    return ScaledJoint(
        law=problem.law,
        A=problem.A * both * both[:, None],
        B=problem.B * both * lengths[:, None],
        q0=loop.q0 * both,
        p0=loop.p0 * lengths,
        q1=loop.q1 * both,
        p1=loop.p1 * lengths,
        lengths=lengths,
        motions=rigid.motions / both[:, None] * both[list(rigid.pinned)],
        pinned=rigid.pinned,
    )


def unique_rates(joint: ScaledJoint) -> Uniqueness:
    """Whether every M(u) is a P-matrix, by energy (docs/universal.md, Theorem 6).

    M_ij = u_i · A_ij u_j + f_i B_ij · u_j, for all unit vectors u of the nodes.
    """
    if joint.floats or not joint.held:
        return Uniqueness(
            None, "only friction holds the body: if all its nodes slip, nothing determines how fast"
        )
    if not joint.fB.any():
        return Uniqueness(True, "slip changes no friction limit (f B = 0)")
    if energy_margin(joint) > 0.0:
        return Uniqueness(True, "every motion stores more energy than friction can feed it")
    return Uniqueness(None, "slip of some nodes may change the limits of others too strongly")


UnitSlips = tuple[FloatArray, FloatArray, FloatArray]


def energy_margin(joint: ScaledJoint, units: UnitSlips | None = None) -> float:
    """Above 0 where it proves vᵀ A v > Σ f_i |v_i| |(B v)_i| for every v ≠ 0, relative to vᵀ A v.

    Of a floating body for every v that is not rigid, less its rigid part.

    The sum is at most ½ vᵀ (c S F + Bᵀ F S⁻¹ B / c) v, F = diag f, S = the stiffnesses of the nodes, so
    that units do not matter, for every c > 0; the best c by golden section. ``units`` are the unit slips.
    """
    root, slips, pressures = unit_slips(joint) if units is None else units
    f, scale = np.sqrt(joint.f), np.sqrt(joint.stiffness)
    slip, pressure = slips * np.repeat(f * scale, joint.d), pressures * f / scale
    A = joint.kept_stiffness
    condition = float(np.abs(root).sum(axis=1).max() ** 2 * np.abs(A).sum(axis=1).max())
    largest = least_of_sums(slip @ slip.T, pressure @ pressure.T)
    return 1.0 - 0.5 * largest - 16 * len(root) * EPS * condition if largest > 0.0 else 1.0


def unit_slips(joint: ScaledJoint) -> UnitSlips:
    """Slips of unit energy, independent of each other, and the pressures that they cause.

    As rows: in the slips that are not pinned (k, k), in all (k, dn), and pressures (k, n). Of a floating body
    a rigid motion is added to each, so that Σ c_i f_i z_i · w_i = 0 for all rigid z, c_i being stiffnesses:
    then Σ c_i f_i |w_i|² is least.
    """
    kept = joint.kept
    root = np.asarray(np.linalg.inv(np.linalg.cholesky(joint.kept_stiffness)))
    pressures = root @ np.take(joint.B, kept, axis=1).T
    if not joint.floats:
        return root, root, pressures
    slips, Z = np.zeros((len(kept), joint.d * joint.n)), joint.motions
    slips[:, kept] = root
    weighted = np.repeat(joint.f * joint.stiffness, joint.d)[:, None] * Z
    return root, slips - np.linalg.solve(Z.T @ weighted, (slips @ weighted).T).T @ Z.T, pressures


PARTS = 4  # initial parts of every edge of the cube of rigid motions
MOST = 2_000_000  # boxes times nodes at once; larger cases are not proved


@dataclass(frozen=True)
class RigidRates:
    """What the condition of Theorem 8 (docs/universal.md) asks, but for what depends on the load.

    With w = v − z for a rigid z, base = max Σ f_i |w_i| |(B w)_i| / ‖w‖² and

        rest = max Σ a_i |w_i| / ‖w‖ · max over rigid z of ‖Σ f_i |z_i| B_i‖ / Σ r_i |z_i|,

    motions go on without a jump where base + rest < 1. Every factor is bounded from above.

    Attributes
    ----------
    joint
        The joint.
    margin
        At most 1 − base.
    weights, stretch : (n,), one number
        Σ weights_i |w_i|² ≤ stretch ‖w‖².
    feeds : (n, k)
        f_i B_i in unit slips: ‖Σ |z_i| feeds_i‖ is how much rigid slip changes friction limits.
    motions : (n, d, r)
        The rigid motions, Σ c_i f_i z_i · z'_i = 0 or 1 of any two, c_i being stiffnesses.
    """

    joint: ScaledJoint
    margin: float
    weights: FloatArray
    stretch: float
    feeds: FloatArray
    motions: FloatArray

    def proved(self, firm: FloatArray, long: FloatArray, low: FloatArray, high: FloatArray) -> bool:
        """Whether base + rest < 1 under each of some loads, and so under all loads of their hull.

        Of a node whose least friction is more than |s_i| both r_i and a_i go with its pressure, whatever it
        is between the least and the largest; of others the worst of each is taken.

        Parameters
        ----------
        firm : (m, n)
            m_i, what f_i p_i + u · s_i is at least in slip; of every load.
        long : (m, n)
            |s_i| at most.
        low, high : (m, n)
            f_i times the least and the largest pressure.
        """
        if not self.margin > 0.0:
            return False
        sure, share = (low >= long).all(axis=0), self.margin * (1.0 - SIX_DIGITS)
        held = np.stack([np.where(sure, limit - long, firm) for limit in (low, high)], axis=1)
        pull = np.stack([np.where(sure, 2.0 * limit, high + long + firm) for limit in (low, high)], axis=1)
        reach = np.sqrt(np.sum(pull.mean(axis=1) ** 2 / self.weights, axis=1) * self.stretch)
        squares = 0.5 * pull**2 / self.weights * self.stretch / reach[:, None, None]
        loads = list(zip(squares, 0.5 * reach, share * held, strict=True))
        return all(self._on_face(axis, loads) for axis in range(self.motions.shape[2]))

    def _on_face(self, axis: int, loads: "Loads") -> bool:
        """All motions c with c[axis] = 1 ≥ |c_k|, in boxes halved until all pass or a centre fails."""
        others = self.motions.shape[2] - 1
        signs = np.insert(np.array(list(product((-1.0, 1.0), repeat=others))), axis, 0.0, axis=1)
        spread = self._sizes(signs)
        feed_off = float(np.linalg.norm(spread * self._sizes_of_feeds, axis=1).max()) * self._largest_feed
        half = 1.0 / PARTS
        line = half * (2.0 * np.arange(PARTS) + 1.0) - 1.0
        boxes = np.insert(np.array(list(product(line, repeat=others))), axis, 1.0, axis=1)
        # halvings of a box at most
        for _ in range(6):
            if len(boxes) * self.joint.n > MOST:
                return False
            sizes = self._sizes(boxes)
            fed = np.linalg.norm(sizes @ self.feeds, axis=1) * (1.0 + NEGLIGIBLE) + self._round_off
            least = np.maximum(sizes - half * spread.max(axis=0), 0.0)
            failed = ~_outweighed(loads, fed + half * feed_off, least)
            if not failed.any():
                return True
            if not _outweighed(loads, fed[failed], sizes[failed]).all():
                return False
            half *= 0.5
            boxes = (boxes[failed, None] + half * signs).reshape(-1, others + 1)
        return False

    def _sizes(self, c: FloatArray) -> FloatArray:
        """|z_i| of some motions (b, r): (b, n)."""
        return np.asarray(np.linalg.norm(np.tensordot(c, self.motions, axes=(1, 2)), axis=2))

    @cached_property
    def _largest_feed(self) -> float:
        """‖Σ ε_i feeds_i‖ ≤ this · √Σ (sizes_i ε_i)²."""
        return float(np.linalg.norm(self.feeds / self._sizes_of_feeds[:, None], 2)) * (1.0 + NEGLIGIBLE)

    @property
    def _sizes_of_feeds(self) -> FloatArray:
        return np.asarray(self.joint.f * np.sqrt(self.joint.stiffness))

    @cached_property
    def _round_off(self) -> float:
        """The round-off of a sum of feeds that cancel."""
        return float(len(self.feeds) * np.finfo(float).eps * np.abs(self.feeds).max() * 8)


Loads = list[tuple[FloatArray, float, FloatArray]]


def _outweighed(loads: Loads, fed: FloatArray, sizes: FloatArray) -> Mask:
    """Whether (S + κ) ‖Σ |z_i| feeds_i‖ < Σ held_i |z_i| under each load, S a sum of squares.

    For motions that feed so much (b,), with |z_i| (b, n). Of each load the squares (2, n), κ and ``held``
    (2, n) at the least and the largest pressure of every node; squares are convex in it and ``held`` is
    linear, so that these are the worst. √x ≤ (x/κ + κ)/2 for any κ.
    """
    passed = np.ones(len(fed), dtype=bool)
    for squares, kappa, held in loads:
        least, largest = fed[:, None] * squares[:, None] - sizes * held[:, None]
        passed &= np.maximum(least, largest).sum(axis=1) + fed * kappa < 0.0
    return passed


def rigid_rates(joint: ScaledJoint) -> RigidRates:
    """The factors of base and rest that do not depend on the load factor. All nodes must have friction."""
    units = unit_slips(joint)
    _, slips, pressures = units
    weights = joint.f * np.maximum(joint.p0, NEGLIGIBLE * joint.p0.max()) * np.sqrt(joint.stiffness)
    weighted = slips * np.sqrt(np.repeat(weights, joint.d))
    n, r = joint.n, joint.motions.shape[1]
    root = np.sqrt(np.repeat(joint.f * joint.stiffness, joint.d))[:, None]
    motions = np.linalg.qr(root * joint.motions)[0] / root
    return RigidRates(
        joint=joint,
        margin=energy_margin(joint, units),
        weights=weights,
        stretch=float(np.linalg.norm(weighted @ weighted.T, 2)) * (1.0 + NEGLIGIBLE),
        feeds=np.asarray((pressures * joint.f).T),
        motions=motions.reshape(n, joint.d, r),
    )
