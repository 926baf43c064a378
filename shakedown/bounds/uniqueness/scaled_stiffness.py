"""The contact stiffness and the friction without units, scaled by powers of two: no bit depends on units."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import FIRST_DIGIT, Tolerances
from shakedown.joint.layout import Layout
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips, stiffness_error

SPREAD = 4.0  # largest error of eigenvalues of scaled matrices, in units of the error of their entries


@dataclass(frozen=True)
class ScaledStiffness:
    """A, B, C and f, divided by powers of two.

    Attributes
    ----------
    A, B : (n, n)
        Divided by the size of A, or of B where that is larger; entries of B that are
        round-off of the stiffness are 0.
    C : (n, n) or None
        Divided likewise.
    weights : (n,)
        Friction coefficients φ, divided by their size.
    friction_unit
        That size: a factor t on φ is the factor t / ``friction_unit`` on the coefficients given.
    tolerances
        What counts as zero.
    pinned
        Nodes at which the rigid slips of a body that only friction holds are pinned, in programs.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray | None
    weights: FloatArray
    friction_unit: float
    tolerances: Tolerances
    pinned: tuple[int, ...] = ()

    @property
    def n(self) -> int:
        """Number of contact nodes."""
        return len(self.A)

    @property
    def layout(self) -> Layout:
        """Where the slip and the gap of a node stand in ``kappa``."""
        return Layout(self.n)

    @cached_property
    def kappa(self) -> FloatArray:
        """[[A, Bᵀ], [B, C]], for problems with C only."""
        assert self.C is not None
        return self.layout.of_blocks(self.A, self.B, self.C)

    @cached_property
    def weighted(self) -> FloatArray:
        """φ B, (n, n)."""
        return self.weights[:, None] * self.B


def scaled_stiffness(problem: Problem, friction: FloatArray, tolerances: Tolerances) -> ScaledStiffness:
    """Bring the stiffness and the friction of a problem near the size 1, free of round-off.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> scaled = scaled_stiffness(shakedown.example("two-node"), np.full(2, 3.0), shakedown.Tolerances())
    >>> scaled.weights, scaled.friction_unit
    (array([0.75, 0.75]), 4.0)
    """
    power = exponent(max(np.abs(problem.A).max(), np.abs(problem.B).max()))
    own = exponent(friction.max())
    A, B = np.ldexp(problem.A, -power), np.ldexp(problem.B, -power)
    size = np.sqrt(np.diag(A))
    noise = tolerances.condensed_pattern * np.outer(size, size)
    return ScaledStiffness(
        A=A,
        B=np.where(np.abs(B) > noise, B, 0.0),
        C=None if problem.C is None else np.ldexp(problem.C, -power),
        weights=np.ldexp(friction, -own),
        friction_unit=float(np.ldexp(1.0, own)),
        tolerances=_of_the_data(problem, tolerances),
        pinned=rigid_slips(problem).pinned,
    )


def _of_the_data(problem: Problem, tolerances: Tolerances) -> Tolerances:
    """The tolerances, with nothing below the accuracy of the data counted as resistance."""
    error = stiffness_error(problem) / FIRST_DIGIT
    return replace(tolerances, zero_mode=max(tolerances.zero_mode, SPREAD * error))


def exponent(size: float) -> int:
    """k with 2ᵏ⁻¹ ≤ size < 2ᵏ, exactly, whatever power of two the size is multiplied by; 0 for the size 0."""
    return int(np.frexp(size)[1])


def held(matrices: FloatArray, tolerances: Tolerances) -> NDArray[np.bool_]:
    """Whether semi-definite matrices (…, k, k) have no rigid motion; scaled by their diagonals."""
    diagonal = np.diagonal(matrices, axis1=-2, axis2=-1)
    stiff = (diagonal > 0).all(axis=-1)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    eigenvalues = np.linalg.eigvalsh(matrices / (size[..., :, None] * size[..., None, :]))
    return np.asarray(stiff & (eigenvalues[..., 0] > tolerances.zero_mode * eigenvalues[..., -1]))
