"""Axisymmetric models: which part of the circumference a matrix stands for.

CalculiX turns axisymmetric elements into a wedge of 2 degrees. The matrices that
it stores are those of the wedge, ``*CLOAD`` is the force on the whole
circumference, of which it applies 1/180, and the reactions that it prints are
those of the wedge without what the stress around the circumference carries.
Abaqus takes and writes everything for the whole circumference.
"""

from shakedown.ground.constants import PER_CENT
from shakedown.ground.errors import ProblemError
from shakedown.models.readers.abaqus import ABAQUS_MATRIX
from shakedown.models.readers.mapped_matrices import NUMBERED
from shakedown.models.readers.mesh import ABAQUS, CALCULIX, Mesh
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.text import unfit

HOOP = (
    "CalculiX prints the forces of a wedge of 2 degrees, and of the radial ones not what the stress around "
    "the circumference carries"
)


def circumference_factor(
    mesh: Mesh | None, format: str, angle: float | None, scale: float, where: str
) -> float:
    """By how much a matrix of an axisymmetric model is multiplied to stand for the whole circumference.

    Parameters
    ----------
    mesh
        The model; a matrix of one that is not axisymmetric is taken as it is.
    format
        What the matrix file was found to be.
    angle
        Degrees that the matrix stands for, where the configuration says it.
    scale
        The factor that the configuration itself gives, which must not be this one again.
    where
        The table of the configuration, for messages.

    Returns
    -------
    float
        360 over the angle: 180 for the ``.sti`` file of a deck with
        ``SOLVER=MATRIXSTORAGE`` (CalculiX), 1 for what Abaqus writes.

    Raises
    ------
    ProblemError
        If neither the deck nor the configuration says it, or they say it where
        nothing is axisymmetric, or the factor is in ``scale`` too.
    """
    if angle is not None and not 0 < angle <= 360:
        raise unfit(f"{where}: key 'angle'", "degrees above 0 up to 360", f"{angle:g}")
    if mesh is None or not mesh.axisymmetric:
        if angle is not None and mesh is not None and mesh.elements:
            raise unfit(
                where, f"no key 'angle', because {mesh.name} has no axisymmetric elements", f"{angle:g}"
            )
        return 1.0 if angle is None else 360.0 / angle
    found = _angle(mesh, format) if angle is None else angle
    if found is None:
        raise ProblemError(
            f"{where}: expected the key 'angle' (the degrees of the circumference that the matrix stands "
            f"for: 2 from CalculiX, 360 from Abaqus and Ansys), because {mesh.name} is axisymmetric, found "
            "none"
        )
    factor = 360.0 / found
    if factor != 1 and abs(scale / factor - 1) < PER_CENT:  # then it is the same factor
        raise ProblemError(
            f"{where}: key 'scale': expected no factor for the circumference, which is taken from the deck "
            f"(360/{found:g} = {factor:g}), found {scale:g}; leave it out"
        )
    return factor


def _angle(mesh: Mesh, format: str) -> float | None:
    """The degrees that a matrix stands for; None where neither deck nor format says it."""
    if format == ABAQUS_MATRIX:
        return 360.0
    return {CALCULIX: 2.0, ABAQUS: 360.0}.get(mesh.matrix_by) if format == NUMBERED else None


def circumference_notes(stiffness: Stiffness, mesh: Mesh | None) -> tuple[str, ...]:
    """What a user should know of the import of an axisymmetric model."""
    if stiffness.circumference == 1 and (mesh is None or not mesh.axisymmetric):
        return ()
    taken = "stands for the whole circumference"
    if stiffness.circumference != 1:
        taken = (
            f"is that of {360 / stiffness.circumference:g} degrees, taken {stiffness.circumference:g} times"
        )
    return (
        f"axisymmetric: the matrix {taken}; forces and reactions are those on the whole circumference, areas "
        "2 pi r times a length",
    )
