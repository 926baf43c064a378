"""What least pressures prove from every state for a body that friction alone holds."""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

from shakedown.bounds.discs.disc_rows import DiscRows
from shakedown.bounds.every_state.least_pressures import (
    LeastPressures,
    SlipCurves,
    pressures_of_floating,
    slip_curves,
)
from shakedown.bounds.every_state.rates import ScaledJoint, rigid_rates
from shakedown.bounds.largest_load_factor import largest_load_factor
from shakedown.ground.constants import EPS, NEGLIGIBLE, ROUND_OFF, SIX_DIGITS, FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import Constraints
from shakedown.joint.law import Law
from shakedown.joint.rigid_slips import RigidSlips

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
    limits = FloatingLimits(joint, least, slip_curves(joint, least))
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
    rates, most = rigid_rates(joint), pressures_of_floating(joint, sign=-1.0)
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
