"""What least pressures prove from every state for a body that friction alone holds."""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

from shakedown.bounds.discs.disc_limits import largest_load_factor
from shakedown.bounds.discs.disc_rows import DiscRows
from shakedown.bounds.every_state.disc_centres import LeaningDiscs, leaning_discs
from shakedown.bounds.every_state.least_pressures import LeastPressures, pressures_of_floating
from shakedown.bounds.every_state.rigid_rates import rigid_rates
from shakedown.bounds.every_state.scaled_joint import ScaledJoint, scaled_joint
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS, NEGLIGIBLE, ROUND_OFF, SIX_DIGITS
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import Constraints
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import RigidSlips

SHARES = (1.0, 1.0 - ROUND_OFF, 1.0 - NEGLIGIBLE, 1.0 - SIX_DIGITS)  # of a program's end that may be inside
HALVINGS = 12  # bisections between load factors with and without a proof that motions continue


class FloatingReach(NamedTuple):
    """How far the load may grow: with the reactions z there and under the mean load, the node that ends it.

    ``jumps``: whether it ends because motions are not proved to go on without a jump.
    """

    load_factor: float
    reactions: FloatArray
    mean_reactions: FloatArray
    node: int
    jumps: bool

    def part(self, share: float) -> "FloatingReach":
        """The point at a share of the way from the mean load."""
        z0, z = self.mean_reactions, self.reactions
        return FloatingReach(share * self.load_factor, z0 + share * (z - z0), z0, self.node, self.jumps)


@dataclass(frozen=True)
class FloatingLimits:
    """Where slip at node i costs energy: size_i |w| − lean_i · w < f_i π_i, w = q_w,i + z_i.

    Attributes
    ----------
    joint
        The joint.
    least
        π, of every node.
    shapes
        Discs, that lean or not (docs/universal.md, statements 6.3 and 6.4).
    steepest : (n,)
        By how much what is left of it is more than f_i p_i + u · w at most [–].
    """

    joint: ScaledJoint
    least: LeastPressures
    shapes: LeaningDiscs
    steepest: FloatArray

    def triples(self, q: FloatArray, p: FloatArray) -> FloatArray:
        """(f π + lean · w, size w) of every node under loads (m, 2n), (m, n) or parts of them: (m, n, 3)."""
        w, f = q.reshape(len(q), -1, 2), self.joint.f
        first = f * self.least.at(self.joint, q, p) + np.sum(self.shapes.lean * w, axis=2)
        return np.concatenate([first[..., None], self.shapes.size[:, None] * w], axis=2)

    def rows(self) -> DiscRows:
        """The same as limits of a program, in the slips that are not pinned; z = A v."""
        joint, n = self.joint, self.joint.n
        constant = self.triples(joint.q0[None], joint.p0[None])[0]
        periodic = self.triples(joint.q1, joint.p1)
        flat = periodic[..., 1:].reshape(len(periodic), -1)
        node, step = Law(np.ones(n), 2).extreme_steps(flat, periodic[..., 0])
        k, everywhere = len(joint.kept), np.zeros((2 * n, len(joint.kept)))
        everywhere[joint.kept] = joint.A[np.ix_(joint.kept, joint.kept)]
        everywhere[list(joint.pinned)] = -joint.motions[joint.kept].T @ everywhere[joint.kept]
        stiffness = everywhere.reshape(n, 2, k)
        leaning = np.einsum("na,nak->nk", self.shapes.lean, stiffness)
        return DiscRows(
            stiffness=np.concatenate([leaning[:, None], self.shapes.size[:, None, None] * stiffness], axis=1),
            node=node,
            step=step,
            c=constant[node],
            e=periodic[step, node],
            half_spaces=_no_half_spaces(k),
            names=np.arange(n),
        )

    def left(self, z: FloatArray, load_factor: float) -> tuple[FloatArray, FloatArray]:
        """Lower bounds of the slack and upper bounds of |w| at every load step, (m, n) each [force].

        With reactions z (2n,), those at pinned slips exactly in balance with the others. Nothing (−inf) where
        the node may lift off: a disc that leans in the plane does not ask for π ≥ 0 by itself.
        """
        joint, shapes = self.joint, self.shapes
        z, loose = joint.in_balance(z)
        q = joint.q0 + load_factor * joint.q1
        terms = np.abs(joint.q0) + np.abs(load_factor * joint.q1) + np.abs(z)
        off = (loose + 8 * EPS * terms).reshape(len(q), -1, 2).sum(axis=2)
        w = (q + z).reshape(len(q), -1, 2)
        long = np.hypot(w[..., 0], w[..., 1]) + off
        lean = np.sum(shapes.lean * w, axis=2) - off * np.abs(shapes.lean).sum(axis=1)
        limit = joint.f * bounds_at(joint, self.least, load_factor)
        left = limit + lean - shapes.size * long * (1.0 + 4 * EPS)
        return np.where(limit >= 0.0, left, -inf), long


def bound_of_floating(
    problem: Problem, tolerances: Tolerances
) -> tuple[LeastPressures, FloatingReach | None]:
    """The least pressures of a body that friction alone holds, and how far the load may grow.

    The reactions z have to be those of a slip, in balance with each other: one program over all nodes. They
    are those of its end under the largest load, those that leave most friction under the mean load, and in
    proportion between; along them motions go on without a jump up to some load factor (statement 6.8).
    None where nothing is within the limits under the mean load.

    Raises
    ------
    SolverError
        If a program ends without an answer.
    """
    joint = scaled_joint(problem)
    least = pressures_of_floating(joint)
    if not least.proved.all() or not (bounds_at(joint, least, 0.0) > 0).all():
        return least, None
    limits = floating_limits(joint, least)
    rows = limits.rows()
    centred = largest_load_factor(_under_mean_load(rows), None, True, tolerances)
    if centred.status != Status.OPTIMAL:
        return least, None
    z0 = _reactions(joint, centred.x)
    if not (limits.left(z0, 0.0)[0] > 0).all():
        return least, None
    found = largest_load_factor(rows, None, True, tolerances)
    if found.status != Status.OPTIMAL:
        grows = joint.q1.any() or joint.p1.any()
        return least, None if grows else _without_jumps(limits, FloatingReach(inf, z0, z0, -1, False))
    node = int(rows.node[np.linalg.norm(found.y, axis=1).argmax()])
    whole = FloatingReach(found.load_factor, _reactions(joint, found.x), z0, node, False)
    for reach in (whole.part(share) for share in SHARES):
        if (limits.left(reach.reactions, reach.load_factor)[0] >= 0).all():
            return least, _without_jumps(limits, reach)
    return least, None


def bounds_at(joint: ScaledJoint, pressures: LeastPressures, load_factor: float) -> FloatArray:
    """Bounds of pressures at all load steps, (m, n), at a load factor."""
    of_mean = pressures.at(joint, joint.q0[None], joint.p0[None])
    periodic = load_factor * pressures.at(joint, joint.q1, joint.p1)
    return np.asarray(of_mean + periodic - 4 * EPS * (np.abs(of_mean) + np.abs(periodic)))


def floating_limits(joint: ScaledJoint, least: LeastPressures) -> FloatingLimits:
    """Discs that lean where that is of use; in the plane, where w turns nowhere, their size is |1 − f h|."""
    shapes, regular = leaning_discs(joint, least)
    every = np.arange(joint.n)
    turned = np.abs(1.0 - joint.f * least.weights[every, every]) + 8 * EPS
    long = np.hypot(shapes.lean[:, 0], shapes.lean[:, 1]) + joint.f * least.error
    size = shapes.size if joint.directions == 2 else turned + joint.f * least.error + 8 * EPS * long
    shapes = LeaningDiscs(np.where(regular[:, None], shapes.lean, 0.0), np.where(regular, size, 1.0))
    return FloatingLimits(joint, least, shapes, np.where(regular, turned + long, 1.0))


def _without_jumps(limits: FloatingLimits, reach: FloatingReach) -> FloatingReach:
    """The load up to which motions are proved to continue without a jump, from the mean load on."""
    joint = limits.joint
    rates, most = rigid_rates(joint), pressures_of_floating(joint, sign=-1.0)

    low = reach._replace(load_factor=0.0, reactions=reach.mean_reactions, node=-1, jumps=True)
    if not most.proved.all():
        return low

    def about(at: FloatingReach) -> tuple[FloatArray, ...]:
        left, long = limits.left(at.reactions, at.load_factor)
        low, high = (joint.f * bounds_at(joint, each, at.load_factor) for each in (limits.least, most))
        return left / limits.steepest, long, low, -high

    of_mean = [each[:1] for each in about(low)]  # all load steps are alike

    def goes_on(at: FloatingReach) -> bool:
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
    return reach.part(share)._replace(node=-1, jumps=True)


def _reactions(joint: ScaledJoint, x: FloatArray) -> FloatArray:
    z = np.zeros(2 * joint.n)
    z[joint.kept] = joint.A[np.ix_(joint.kept, joint.kept)] @ x
    return joint.in_balance(z)[0]


def _under_mean_load(rows: DiscRows) -> DiscRows:
    """The rows of one load step of every node; what varies is the share of their friction that is left."""
    one = np.unique(rows.node, return_index=True)[1]
    less = rows.c[one] * [-1.0, 0.0, 0.0]
    return rows.under(node=rows.node[one], step=rows.step[one], c=rows.c[one], e=less)


def _no_half_spaces(columns: int) -> Constraints:
    none, number = np.zeros(0), np.zeros(0, dtype=np.intp)
    held = RigidSlips(np.zeros((columns, 0)), ())
    return Constraints(np.zeros((0, columns)), none, none, number, number, number, held)
