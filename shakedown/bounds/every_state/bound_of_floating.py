"""Where rates of slip are unique; what least pressures prove for a body that friction alone holds."""

from dataclasses import dataclass
from itertools import product
from math import inf
from typing import NamedTuple

import numpy as np

from shakedown.bounds.coupling import Uniqueness, least_of_sums
from shakedown.bounds.disc_rows import DiscRows
from shakedown.bounds.every_state import least_pressures
from shakedown.bounds.every_state.least_pressures import LeastPressures, ScaledJoint, SlipCurves
from shakedown.bounds.largest_load_factor import largest_load_factor
from shakedown.ground.constants import EPS, NEGLIGIBLE, ROUND_OFF, SIX_DIGITS, FloatArray, Mask
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import Constraints
from shakedown.joint.law import Law
from shakedown.joint.rigid_slips import RigidSlips


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
MOST_BOXES = 2_000_000  # boxes times nodes at once; larger cases are not proved


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
    steepest
        ‖Σ ε_i feeds_i‖ ≤ steepest · √Σ f_i² c_i ε_i², c_i being stiffnesses.
    motions : (n, d, r)
        The rigid motions, Σ c_i f_i z_i · z'_i = 0 or 1 of any two, c_i being stiffnesses.
    """

    joint: ScaledJoint
    margin: float
    weights: FloatArray
    stretch: float
    feeds: FloatArray
    steepest: float
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
        spread, sizes_of_feeds = self._sizes(signs), self.joint.f * np.sqrt(self.joint.stiffness)
        feed_off = float(np.linalg.norm(spread * sizes_of_feeds, axis=1).max()) * self.steepest
        # of a sum of feeds that cancel
        round_off = float(len(self.feeds) * EPS * np.abs(self.feeds).max() * 8)
        half = 1.0 / PARTS
        line = half * (2.0 * np.arange(PARTS) + 1.0) - 1.0
        boxes = np.insert(np.array(list(product(line, repeat=others))), axis, 1.0, axis=1)
        # halvings of a box at most
        for _ in range(6):
            if len(boxes) * self.joint.n > MOST_BOXES:
                return False
            sizes = self._sizes(boxes)
            fed = np.linalg.norm(sizes @ self.feeds, axis=1) * (1.0 + NEGLIGIBLE) + round_off
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
    motions, scaled = np.linalg.qr(root * joint.motions)[0] / root, pressures / np.sqrt(joint.stiffness)
    return RigidRates(
        joint=joint,
        margin=energy_margin(joint, units),
        weights=weights,
        stretch=float(np.linalg.eigvalsh(weighted @ weighted.T)[-1]) * (1.0 + NEGLIGIBLE),
        feeds=np.asarray((pressures * joint.f).T),
        steepest=float(np.sqrt(np.linalg.eigvalsh(scaled.T @ scaled)[-1])) * (1.0 + NEGLIGIBLE),
        motions=motions.reshape(n, joint.d, r),
    )


HALVINGS = 12  # bisections between load factors with and without a proof that motions continue


class Reach(NamedTuple):
    """How far the load may grow: with the reactions z there and under the mean load, the node that ends it.

    ``limited_by``: whether it ends by the swing of a load, lift-off, or the rates, because motions are not
    proved to go on without a jump.
    """

    load_factor: float
    reactions: FloatArray
    mean_reactions: FloatArray
    node: int
    limited_by: str

    def part(self, share: float) -> "Reach":
        """The point at a share of the way from the mean load."""
        z = self.mean_reactions + share * (self.reactions - self.mean_reactions)
        return self._replace(load_factor=share * self.load_factor, reactions=z)


@dataclass(frozen=True)
class FloatingLimits:
    """Where slip of a node costs energy: its curve reaches less than f_i π_i along −w, w = q_w,i + z_i.

    Attributes
    ----------
    joint
        The joint.
    least
        π, of every node.
    curves
        What slip in any direction asks of w (docs/universal.md, Corollary 3 and eq. 2).
    """

    joint: ScaledJoint
    least: LeastPressures
    curves: SlipCurves

    @property
    def steepest(self) -> FloatArray:
        """By how much what is left of it is more than f_i p_i + u · w at most, (n,) [–]."""
        return np.asarray(self.curves.size + self.curves.length + self.curves.loose)

    def rows(self) -> DiscRows:
        """Limits of a program that imply it, in the slips that are not pinned; z = A v.

        They are discs, α |w| − lean · w ≤ f π, α = √(size² + |lean|²), or size itself with one direction.
        """
        joint, n = self.joint, self.joint.n
        constant = self._triples(joint.q0[None], joint.p0[None])[0]
        periodic = self._triples(joint.q1, joint.p1)
        flat = periodic[..., 1:].reshape(len(periodic), -1)
        node, step = Law(np.ones(n), 2).extreme_steps(flat, periodic[..., 0])
        k, everywhere = len(joint.kept), np.zeros((joint.d * n, len(joint.kept)))
        everywhere[joint.kept] = joint.kept_stiffness
        everywhere[list(joint.pinned)] = -joint.motions[joint.kept].T @ everywhere[joint.kept]
        stiffness = np.moveaxis(everywhere.reshape(n, joint.d, k), 2, 0)
        none, number = np.zeros(0), np.zeros(0, dtype=np.intp)
        held = RigidSlips(np.zeros((k, 0)), ())
        return DiscRows(
            stiffness=np.moveaxis(self._of_reactions(stiffness), 0, 2),
            node=node,
            step=step,
            c=constant[node],
            e=periodic[step, node],
            half_spaces=Constraints(np.zeros((0, k)), none, none, number, number, number, held),
            names=np.arange(n),
        )

    def _triples(self, q: FloatArray, p: FloatArray) -> FloatArray:
        """(f π + lean · w, α w) of every node under loads (m, dn), (m, n) or parts of them: (m, n, 3)."""
        found = self._of_reactions(self.joint.law.layout.by_node(q))
        found[..., 0] += self.joint.f * self.least.at(self.joint, q, p)
        return found

    def _of_reactions(self, w: FloatArray) -> FloatArray:
        """(lean · w, α w) of reactions (…, n, d), the second component 0 where there is none: (…, n, 3)."""
        curves, found = self.curves, np.zeros((*w.shape[:-1], 3))
        size = curves.size if self.joint.d == 1 else np.hypot(curves.size, curves.length)
        found[..., 0] = np.sum(curves.lean * w, axis=-1)
        found[..., 1 : 1 + self.joint.d] = size[:, None] * w
        return found

    def left(self, z: FloatArray, load_factor: float) -> tuple[FloatArray, FloatArray]:
        """Lower bounds of the slack and upper bounds of |w| at every load step, (m, n) each [force].

        With reactions z (dn,), those at pinned slips exactly in balance with the others. Nothing (−inf) where
        the node may lift off: two limits in the plane do not ask for π ≥ 0 by themselves.
        """
        joint, by_node = self.joint, self.joint.law.layout.by_node
        z, loose = joint.in_balance(z)
        q = joint.q0 + load_factor * joint.q1
        terms = np.abs(joint.q0) + np.abs(load_factor * joint.q1) + np.abs(z)
        off = by_node(loose + 8 * EPS * terms).sum(axis=2)
        long = joint.law.size(q + z) + off
        limit = joint.f * bounds_at(joint, self.least, load_factor)
        round_off = self.steepest * off + (self.curves.loose + 16 * EPS * self.steepest) * long
        left = limit - self.curves.reach(-by_node(q + z)) - round_off
        return np.where(limit >= 0.0, left, -inf), long


def floating_reach(
    joint: ScaledJoint, least: LeastPressures, unique: bool, tolerances: Tolerances
) -> Reach | None:
    """How far the load of a body that friction alone holds may grow; None where not even to the mean load.

    The reactions z have to be those of a slip, in balance with each other: one program over all nodes. They
    are those of its end under the largest load, those that leave most friction under the mean load, and in
    proportion between; along them motions go on without a jump up to some load factor (Theorem 8),
    unless the motion is known to be ``unique``.

    Raises
    ------
    SolverError
        If a program ends without an answer.
    """
    limits = FloatingLimits(joint, least, least_pressures.slip_curves(joint, least))
    rows = limits.rows()
    # under the mean load, of one load step of every node, the share of friction that is left varies
    one = np.unique(rows.node, return_index=True)[1]
    less = rows.c[one] * [-1.0, 0.0, 0.0]
    mean = rows.under(node=rows.node[one], step=rows.step[one], c=rows.c[one], e=less)
    centred = largest_load_factor(mean, None, True, tolerances)
    if centred.status != Status.OPTIMAL:
        return None
    z0 = _reactions(joint, centred.x)
    if not (limits.left(z0, 0.0)[0] > 0).all():
        return None
    found = largest_load_factor(rows, None, True, tolerances)
    if found.status != Status.OPTIMAL:
        still = Reach(inf, z0, z0, -1, "swing")
        grows = joint.q1.any() or joint.p1.any()
        return None if grows else still if unique else _without_jumps(limits, still)
    node = int(rows.node[np.linalg.norm(found.y, axis=1).argmax()])
    whole = Reach(found.load_factor, _reactions(joint, found.x), z0, node, "swing")
    # shares of the end of the program that may be inside
    for reach in [whole.part(share) for share in (1.0, 1.0 - ROUND_OFF, 1.0 - NEGLIGIBLE, 1.0 - SIX_DIGITS)]:
        if (limits.left(reach.reactions, reach.load_factor)[0] >= 0).all():
            return reach if unique else _without_jumps(limits, reach)
    return None


def bounds_at(joint: ScaledJoint, pressures: LeastPressures, load_factor: float) -> FloatArray:
    """Bounds of pressures at all load steps, (m, n), at a load factor."""
    of_mean = pressures.at(joint, joint.q0[None], joint.p0[None])
    periodic = load_factor * pressures.at(joint, joint.q1, joint.p1)
    return np.asarray(of_mean + periodic - 4 * EPS * (np.abs(of_mean) + np.abs(periodic)))


def _without_jumps(limits: FloatingLimits, reach: Reach) -> Reach:
    """The load up to which motions are proved to continue without a jump, from the mean load on."""
    joint = limits.joint
    rates, most = rigid_rates(joint), least_pressures.pressures_of_floating(joint, sign=-1.0)
    low = reach._replace(load_factor=0.0, reactions=reach.mean_reactions, node=-1, limited_by="rates")
    if not most.proved.all():
        return low

    def about(at: Reach) -> tuple[FloatArray, ...]:
        left, long = limits.left(at.reactions, at.load_factor)
        low, high = (joint.f * bounds_at(joint, each, at.load_factor) for each in (limits.least, most))
        return left / limits.steepest, long, low, -high

    of_mean = [each[:1] for each in about(low)]  # all load steps are alike

    def goes_on(at: Reach) -> bool:
        both = [np.concatenate(parts) for parts in zip(of_mean, about(at), strict=True)]
        return bool((both[0] >= 0).all()) and rates.proved(*both)

    if not goes_on(low):
        return low
    if reach.load_factor == inf or goes_on(reach):
        return reach
    share, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (share + high)
        if goes_on(reach.part(middle)):
            share = middle
        else:
            high = middle
    return reach.part(share)._replace(node=-1, limited_by="rates")


def _reactions(joint: ScaledJoint, x: FloatArray) -> FloatArray:
    z = np.zeros(joint.d * joint.n)
    z[joint.kept] = joint.kept_stiffness @ x
    return joint.in_balance(z)[0]
