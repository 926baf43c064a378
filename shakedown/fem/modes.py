"""Vibration modes of a joint whose contact sticks, and the inertia forces of a mode as a load."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.linalg import qr
from scipy.sparse.linalg import ArpackNoConvergence, eigsh
from skfem import BilinearForm
from skfem.helpers import dot

from shakedown.fem.body import ElasticBody, IntArray, rigid_motion
from shakedown.fem.loads import History, sampled
from shakedown.ground.constants import NEGLIGIBLE, SIX_DIGITS, FloatArray
from shakedown.ground.errors import ProblemError, SolverError
from shakedown.joint.result import Result
from shakedown.models.condensation.load_case import LoadCase, histories


@dataclass(frozen=True, eq=False, repr=False)
class ModalLoad(Result):
    """The inertia forces M φ of a mode, as a load (:func:`modal_load`).

    Attributes
    ----------
    mode
        Its number, from 0; rigid motions of a free structure are left out.
    frequency
        Circular frequency ω of the mode with the contact stuck [1/time].
    shape : (N,)
        φ, the displacements of all bodies, φᵀ M φ = 1 [1/√mass].
    force : (N,)
        M φ [√mass].
    free
        Whether nothing supports the structure.
    history
        Time function of the modal force α; one sine in a period by default.
    """

    mode: int
    frequency: float
    shape: FloatArray
    force: FloatArray
    free: bool
    history: History

    def case(self, steps: int | None) -> LoadCase:
        """The load case in a model of all bodies."""
        history = sampled(self.history, steps, "ModalLoad")
        return LoadCase(history=history, force=self.force, frequency=self.frequency, name=f"mode {self.mode}")


def sine(t: FloatArray) -> FloatArray:
    """One sine in a period."""
    return np.sin(2.0 * np.pi * t)


def mass_of(body: ElasticBody) -> sparse.csr_array:
    """The consistent mass matrix of a body, (N, N) [mass].

    Raises
    ------
    ProblemError
        If a material has no density.
    """
    if any(material.density is None for material, _ in body.parts()):
        raise ProblemError("material: expected a density for a mode, found none")
    return body.integrated(lambda material: BilinearForm(lambda u, v, w: material.density * dot(u, v)))


def stuck_mode(
    K: sparse.csr_array, M: sparse.csr_array, motions: sparse.csr_array, number: int, rigid: int
) -> tuple[float, FloatArray]:
    """Circular frequency and shape φ (N,), φᵀ M φ = 1, of a mode; the first ``rigid`` ones do not count.

    The shape is a combination of the columns of ``motions``, (N, k).

    Raises
    ------
    ProblemError
        If there are not so many modes.
    SolverError
        If it is not found.
    """
    K, M = sparse.csc_array(motions.T @ K @ motions), sparse.csc_array(motions.T @ M @ motions)
    count = number + rigid + 1
    if number < 0 or count >= K.shape[0]:
        raise ProblemError(f"mode: expected a number from 0 to {K.shape[0] - rigid - 2}, found {number}")
    shift = -NEGLIGIBLE * K.trace() / M.trace() if rigid else 0.0  # makes K of a free structure regular
    start = np.random.default_rng(0).random(K.shape[0])  # of no symmetry, and the same every time
    try:
        values, vectors = eigsh(K, count, M, sigma=shift, v0=start)
    except ArpackNoConvergence as error:
        raise SolverError(f"mode {number}: not found ({error})") from None
    chosen = np.argsort(values)[-1]
    shape = motions @ vectors[:, chosen]
    largest = shape[np.abs(shape).argmax()]
    return float(np.sqrt(values[chosen])), np.asarray(shape * np.sign(largest))


def determinate_rows(dofs: IntArray, places: Mapping[int, Sequence[float]], candidates: IntArray) -> IntArray:
    """Rows far apart that hold a free structure, statically determinate: three in a plane, six in space.

    Loads in equilibrium cause no force there, so that the choice does not change any result.
    """
    where = np.array([places[node] for node in dofs[candidates, 0].tolist()])
    motion = rigid_motion(where)[np.arange(len(candidates)), dofs[candidates, 1] - 1]
    *_, order = qr(motion.T, mode="economic", pivoting=True)
    return np.sort(candidates[order[: motion.shape[1]]])


def check_balanced(cases: Sequence[LoadCase], places: FloatArray, direction: IntArray) -> None:
    """Raise ``ProblemError`` unless the loads of a free structure are together in equilibrium at every step.

    ``places`` (N, 2) or (N, 3) and ``direction`` (N,) of the rows of the forces.
    """
    if not cases:
        return
    motion, factors = rigid_motion(places)[np.arange(len(places)), direction - 1], histories(cases)
    forces = np.array([case.force for case in cases])
    known = [part for part in (factors.period, factors.mean, factors.transient) if part is not None]
    steps = np.vstack(known)
    left = np.abs(steps @ (forces @ motion)).max(axis=1)
    # what may be left of a resultant, relative to the forces
    if (left > SIX_DIGITS * (np.abs(steps) @ np.abs(forces).sum(axis=1))).any():
        raise ProblemError(
            "loads: expected loads in equilibrium, as nothing supports the bodies, found a resultant of "
            f"{left.max():.3g} (add a Support, or a load that balances the others)"
        )
