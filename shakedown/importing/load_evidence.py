"""Evidence of an import: what rigid motions meet, and what each load amounts to."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.condensation.condense import Condensation
from shakedown.condensation.load_case import LoadCase
from shakedown.ground.float_array import FloatArray
from shakedown.importing.contact.contact_section import ContactSection
from shakedown.joint.result import Result
from shakedown.readers.mesh import Mesh
from shakedown.readers.stiffness import Stiffness
from shakedown.readers.text import quoted


@dataclass(frozen=True, eq=False, repr=False)
class LoadEvidence(Result):
    """Resultants of a load case at factor 1.

    Attributes
    ----------
    name : str
        The load case.
    applied : (d + 1,)
        Sum of its nodal forces along the axes [force].
    contact : (d + 1,)
        Sum of the welded reactions along them: forces of the contact on the
        first body [force]. Where the contact alone holds the model, and no
        displacement is prescribed, it is minus the applied force.
    """

    name: str
    applied: FloatArray
    contact: FloatArray


def load_evidence(
    case: LoadCase, reduced: Condensation, stiffness: Stiffness, contact: ContactSection
) -> LoadEvidence:
    """Resultants of one load case."""
    applied = np.zeros(len(contact.axes))
    if case.force is not None:
        applied = np.array([case.force[stiffness.dofs[:, 1] == axis].sum() for axis in contact.axes])
    welded, frame = reduced.welded_reactions(case), reduced.frame
    q, p = reduced.layout.split(welded)
    carried = q @ frame.slip_axes.reshape(len(q), -1) + p @ frame.normals
    return LoadEvidence(case.name, applied, carried)


def few_digits(case: LoadCase, rounding: FloatArray | None, reduced: Condensation) -> tuple[str, ...]:
    """A note: how accurate welded reactions are that come from displacements off by so much, (n, d + 1)."""
    if rounding is None:
        return ()
    frame = reduced.frame
    slips = (rounding[:, None, :] * np.abs(frame.slip_axes)).sum(axis=2).ravel()
    local = reduced.layout.joined(slips, (rounding * np.abs(frame.normals)).sum(axis=1))
    error = np.abs(reduced.stiffness) @ local
    largest = np.abs(reduced.welded_reactions(case)).max()
    if not (error.any() and largest):
        return ()
    accurate = f"{quoted(case.name)} are accurate to {error.max() / largest:.0e} of the largest"
    return (f"the welded reactions of {accurate}, by the digits of the displacements with the contact open",)


def rigid_residual(stiffness: Stiffness, mesh: Mesh | None, axes: tuple[int, ...]) -> float:
    """Largest force that a rigid motion (in the plane, of a plane problem) meets, by max |K| and the motion.

    A body of revolution moves along its axis only.

    NaN where the mesh does not know the coordinates of every node with rows, or
    the rows are not displacements (multipliers, modes).
    """
    if mesh is None:
        return float("nan")
    there = set(mesh.labels.tolist())
    moving = np.isin(stiffness.dofs[:, 1], axes)
    if not set(stiffness.dofs[moving, 0].tolist()) <= there:
        return float("nan")
    xyz = mesh.at(stiffness.dofs[moving, 0])[:, [axis - 1 for axis in axes]]
    xyz = xyz - xyz.mean(axis=0)
    size = max(float(np.abs(xyz).max()), np.finfo(float).tiny)
    scale = float(np.abs(stiffness.K.data[np.abs(stiffness.K.data) < 1e35]).max())
    if len(axes) == 3:
        return float(np.abs(stiffness.K @ _motions(stiffness, moving, xyz / size, size)).max() / scale)
    motions = np.zeros((len(stiffness.dofs), 3))  # along the two axes, and turned in their plane
    along = stiffness.dofs[moving, 1] == axes[0]
    rotation = np.where(along, -xyz[:, 1], xyz[:, 0]) / size
    motions[moving] = np.column_stack([along, ~along, rotation])
    turning = np.flatnonzero(stiffness.dofs[:, 1] == 3 + ({1, 2, 3} - set(axes)).pop())
    sign = 1.0 if axes in ((1, 2), (2, 3), (3, 1)) else -1.0
    motions[turning, 2] = sign / size
    if mesh.axisymmetric:  # moves as a body along its axis only
        motions = motions[:, 1:2]
    return float(np.abs(stiffness.K @ motions).max() / scale)


def _motions(stiffness: Stiffness, moving: NDArray[np.bool_], xyz: FloatArray, size: float) -> FloatArray:
    """The six rigid motions of a body in space, (N, 6): along x, y, z, and turned about them."""
    motions = np.zeros((len(stiffness.dofs), 6))
    direction = stiffness.dofs[moving, 1] - 1
    turned = [np.cross(axis, xyz)[np.arange(len(xyz)), direction] for axis in np.eye(3)]
    motions[moving] = np.column_stack([np.eye(3)[direction], *turned])
    for axis in range(3):
        motions[stiffness.dofs[:, 1] == 4 + axis, 3 + axis] = 1.0 / size
    return motions
