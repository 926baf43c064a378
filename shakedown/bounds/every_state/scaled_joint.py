"""The joint in its own units: every node in a length unit in which its stiffness is near 1."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS
from shakedown.joint.derived import once_per_problem
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips


@dataclass(frozen=True)
class ScaledJoint:
    """κ, friction and loads with slips and gaps of node i in units of ``lengths[i]``, a power of two.

    Reactions are generalised forces then, lengths[i] times those of the node: both sides of every
    friction limit have the same factor, and no result depends on it but by round-off. A joint in the plane
    has a second direction in which nothing happens.

    Attributes
    ----------
    A, B : (2n, 2n), (n, 2n)
        Tangential stiffness and coupling.
    f : (n,)
        Friction coefficients, as they are.
    q0, p0, q1, p1
        Constant and periodic part of the loads, as :class:`~shakedown.joint.loading.Loading`.
    lengths : (n,)
        Units of slip [length].
    motions : (2n, r)
        Z, the slips that change no reaction; 1 at ``pinned[k]`` and 0 at the other pinned ones [–].
    pinned
        As many slips as there are such motions.
    directions
        How many the joint has.
    """

    A: FloatArray
    B: FloatArray
    f: FloatArray
    q0: FloatArray
    p0: FloatArray
    q1: FloatArray
    p1: FloatArray
    lengths: FloatArray
    motions: FloatArray
    pinned: tuple[int, ...]
    directions: int

    @property
    def n(self) -> int:
        """Number of contact nodes."""
        return len(self.f)

    @property
    def fB(self) -> FloatArray:
        """f B, (n, 2n): how slips change the friction limits."""
        return np.asarray(self.f[:, None] * self.B)

    @property
    def stiffness(self) -> FloatArray:
        """What powers of two leave of the stiffness of every node, 0.5 to 2, or 1 where it has none: (n,)."""
        own = np.diagonal(self.A).reshape(self.n, 2).max(axis=1)
        return np.where(own > 0, own, 1.0)

    @property
    def floats(self) -> bool:
        """Whether friction alone holds the body: some slips change no reaction."""
        return bool(self.motions.shape[1])

    def in_balance(self, reactions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Reactions (2n,) of some slip, from their part at the slips that are not pinned; and their error.

        Such reactions have no resultant along a rigid motion, Zᵀ z = 0; their part may be anything.
        """
        found, pinned, kept = reactions.copy(), list(self.pinned), self.kept
        loose = np.zeros_like(found)
        found[pinned] = -reactions[kept] @ self.motions[kept]
        loose[pinned] = (len(kept) + 2) * EPS * (np.abs(reactions[kept]) @ np.abs(self.motions[kept]))
        return found, loose

    @property
    def kept(self) -> NDArray[np.intp]:
        """The slips that there are and that are not pinned, by number."""
        every = np.arange(2 * self.n).reshape(self.n, 2)[:, : self.directions]
        return np.setdiff1d(every, self.pinned)

    @cached_property
    def kept_stiffness(self) -> FloatArray:
        """A in the slips that are kept, (k, k)."""
        return self.A[np.ix_(self.kept, self.kept)]

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
    def limits_by_forces(self) -> FloatArray:
        """f B A⁻¹ in the slips that are kept, (n, k)."""
        return np.asarray(self.fB[:, self.kept] @ self.inverse)

    @cached_property
    def pressures_by_forces(self) -> FloatArray:
        """B A⁻¹ in the slips that are kept, (n, k)."""
        return np.asarray(self.B[:, self.kept] @ self.inverse)

    def of_joint(self, reactions: FloatArray) -> FloatArray:
        """Reactions (2n,) in the units and directions of the joint itself, (dn,) [force]."""
        return np.asarray((reactions.reshape(-1, 2) / self.lengths[:, None])[:, : self.directions].ravel())


@once_per_problem
def scaled_joint(problem: Problem) -> ScaledJoint:
    """The joint in units of its own; made once per problem."""
    stiffness = problem.layout.by_node(np.diagonal(problem.A)).max(axis=1)
    relative = np.ldexp(stiffness, -int(np.frexp(stiffness.max(initial=0.0))[1]))  # so that units cancel
    lengths = np.exp2(np.rint(-0.5 * np.log2(np.where(stiffness > 0, relative, 1.0))))
    both, loop, rigid, d = np.repeat(lengths, 2), loading(problem), rigid_slips(problem), problem.directions
    pinned = [k if d == 2 else 2 * k for k in rigid.pinned]
    A, B = _in_two(_in_two(problem.A, d).T, d), _in_two(problem.B, d)
    return ScaledJoint(
        A=A * both * both[:, None],
        B=B * both * lengths[:, None],
        f=problem.f,
        q0=_in_two(loop.q0, d) * both,
        p0=loop.p0 * lengths,
        q1=_in_two(loop.q1, d) * both,
        p1=loop.p1 * lengths,
        lengths=lengths,
        motions=_in_two(rigid.motions.T, d).T / both[:, None] * both[pinned],
        pinned=tuple(pinned),
        directions=d,
    )


def _in_two(slips: FloatArray, directions: int) -> FloatArray:
    """Slips or rows (…, dn) with two directions, (…, 2n): the second one, where added, is zero."""
    if directions == 2:
        return slips
    return np.stack([slips, np.zeros_like(slips)], axis=-1).reshape(*slips.shape[:-1], 2 * slips.shape[-1])
