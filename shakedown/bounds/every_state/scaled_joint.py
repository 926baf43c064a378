"""The joint in units of its own: every node in lengths in which its stiffness is near 1."""

from dataclasses import dataclass

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.joint.derived import once_per_problem
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem


@dataclass(frozen=True)
class ScaledJoint:
    """κ, friction and loads with slips and gaps of node i in units of ``lengths[i]``, a power of two.

    Reactions are generalised forces then, lengths[i] times those of the node: both sides of every
    friction limit have the same factor, and no result depends on it but by round-off.

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
    """

    A: FloatArray
    B: FloatArray
    f: FloatArray
    q0: FloatArray
    p0: FloatArray
    q1: FloatArray
    p1: FloatArray
    lengths: FloatArray

    @property
    def n(self) -> int:
        """Number of contact nodes."""
        return len(self.f)

    @property
    def fB(self) -> FloatArray:
        """f B, (n, 2n): how slips change the friction limits."""
        return np.asarray(self.f[:, None] * self.B)


@once_per_problem
def scaled_joint(problem: Problem) -> ScaledJoint:
    """The joint in units of its own; made once per problem."""
    stiffness = problem.layout.by_node(np.diagonal(problem.A)).max(axis=1)
    relative = np.ldexp(stiffness, -int(np.frexp(stiffness.max(initial=0.0))[1]))  # so that units cancel
    lengths = np.exp2(np.rint(-0.5 * np.log2(np.where(stiffness > 0, relative, 1.0))))
    both, loop = np.repeat(lengths, 2), loading(problem)
    return ScaledJoint(
        A=problem.A * both * both[:, None],
        B=problem.B * both * lengths[:, None],
        f=problem.f,
        q0=loop.q0 * both,
        p0=loop.p0 * lengths,
        q1=loop.q1 * both,
        p1=loop.p1 * lengths,
        lengths=lengths,
    )
