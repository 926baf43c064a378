"""The joint in its own units: every node in a length unit in which its stiffness is near 1."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import EPS, FloatArray
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.law import Law
from shakedown.joint.loading import loading
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
        Constant and periodic part of the loads, as :class:`~shakedown.joint.loading.Loading`.
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
