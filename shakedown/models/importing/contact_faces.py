"""Checks of a contact against the faces of the model: normals the wrong way, nodes left out, sharp edges."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.joint.places import faces_among, split_face
from shakedown.models.condensation.contact_frame import SPACE
from shakedown.models.importing.contact_section import ContactSection
from shakedown.models.readers.mesh import CORNERS, Mesh

LEVEL = np.cos(np.radians(84.0))  # from the faces' normal: beyond it a normal does not point inwards
TURNED = np.cos(np.radians(15.0))  # as far off is the last facet of an arc of 12 to the circle
SHARP = np.cos(np.radians(37.0))  # from the mean: faces that meet at more than 74° belong to two sides


def contact_doubts(contact: ContactSection, mesh: Mesh | None, where: str) -> tuple[str, ...]:
    """Warnings about the normals, and nodes left out, of a contact in a model.

    Raises
    ------
    ProblemError
        If a normal points out of the first body, or the faces of the second body do not face the first.
    """
    names, normals = contact.names, contact.unit_normals
    if mesh is None or contact.coordinates is None:
        return ()
    if not mesh.elements:
        return opposed_neighbours(names, normals, contact.coordinates)
    faces, least = mesh.face_normals(contact.first, contact.surface)
    warnings = (
        check_normals(names, normals, faces, where)
        if contact.normals_are_given
        else sharp_edges(names, least)
    )
    if contact.coupling is not None:
        return warnings
    warnings += left_out(mesh, contact.first)
    if contact.labels.ndim > 1:
        opposite, _ = mesh.face_normals(contact.labels[:, 1])
        _check_opposite(names, normals, opposite, where)
        warnings += left_out(mesh, contact.labels[:, 1])
    return warnings


def faces_between(contact: ContactSection, mesh: Mesh | None) -> NDArray[np.intp] | None:
    """The corners of a contact's faces in space as numbers of its nodes, (k, 4); None for a plane one."""
    if mesh is None or contact.axes != SPACE:
        return None
    found: list[tuple[int, ...]] = []
    for part in contact.parts:
        for facet in mesh.boundary(set(part.first.tolist()), part.surface):
            if len(facet.corners) > 2:  # no edge of a plate
                found += split_face(facet.corners, facet.between, mesh.at(facet.nodes))
    return faces_among(np.array(found), contact.first.tolist()) if found else None


def _check_opposite(names: Sequence[str], normals: FloatArray, opposite: FloatArray, where: str) -> None:
    """Refuse faces of the second body that do not face the first: both normals point away from the gap."""
    cosine = (normals * opposite).sum(axis=1)
    if (cosine > 0).all():
        raise ProblemError(
            f"{where}: expected faces of the second body that look at those of the first, found that both "
            f"bodies lie on the same side of the contact at {names[0]}"
        )


def check_normals(names: Sequence[str], given: FloatArray, faces: FloatArray, where: str) -> tuple[str, ...]:
    """Warnings about given unit normals (n, 3) unlike those of the faces, (n, 3), NaN where there are none.

    Raises
    ------
    ProblemError
        If a normal points out of the body.

    Examples
    --------
    >>> up = np.array([[0.0, 0.0, 1.0]])
    >>> check_normals(["7"], np.array([[0.0, 0.6, 0.8]]), up, "contact")
    ('the normal of 7 is turned by 37° from the faces there (1 of 1 by more than 15°)',)
    """
    cosine = (given * faces).sum(axis=1)
    if (wrong := cosine < LEVEL).any():
        k = int(np.argmax(wrong))
        raise ProblemError(
            f"{where}: expected normals into the first body, found {_shown(given[k])} at {names[k]}, where "
            f"its faces have {_shown(faces[k])} ({int(wrong.sum())} of {len(names)} do not)"
        )
    turned = int((cosine < TURNED).sum())
    if not turned:
        return ()
    k = int(np.nanargmin(cosine))
    angle = np.degrees(np.arccos(cosine[k]))
    return (
        f"the normal of {names[k]} is turned by {angle:.0f}° from the faces there ({turned} of {len(names)} "
        "by more than 15°)",
    )


def opposed_neighbours(names: Sequence[str], normals: FloatArray, places: FloatArray) -> tuple[str, ...]:
    """A warning about unit normals (n, 3) opposed to that of the nearest node, where no faces are known."""
    if len(places) < 2:
        return ()
    nearest = cKDTree(places).query(places, k=2)[1][:, 1]
    opposed = np.flatnonzero((normals * normals[nearest]).sum(axis=1) < 0)
    if not opposed.size:
        return ()
    k = int(opposed[0])
    return (
        f"the normals of {names[k]} and of the node beside it, {names[nearest[k]]}, look against each other: "
        "does one of them point out of its body?",
    )


def sharp_edges(names: Sequence[str], least: FloatArray) -> tuple[str, ...]:
    """A warning about normals that are the mean of two sides of the body.

    ``least`` (n,) is the least cosine between the mean and one of the faces.
    """
    sharp = np.flatnonzero(least < SHARP)
    if not sharp.size:
        return ()
    k = int(sharp[np.argmin(least[sharp])])
    return (
        f"the contact goes around an edge of the body at {sharp.size} node(s), first {names[sharp[0]]}: the "
        f"normal is the mean of faces that are {np.degrees(np.arccos(least[k])):.0f}° away from it; name the "
        "'surface', or give 'normals'",
    )


def left_out(mesh: Mesh, labels: NDArray[np.intp]) -> tuple[str, ...]:
    """Warnings about nodes of one body that lie within its contact but are not contact nodes."""
    wanted = set(labels.tolist())
    between = sorted({node for facet in mesh.boundary(wanted) for node in facet.between} - wanted)
    warnings = []
    if between:
        warnings.append(
            f"faces at the contact have {len(between)} node(s) between their corners that are no contact "
            f"nodes, first {between[0]}: these pass through the other body; take them in, or linear elements"
        )
    holes = sorted(_surrounded(mesh, wanted))
    if holes:
        warnings.append(
            f"{len(holes)} node(s) within the contact are no contact nodes, first {holes[0]}: the bodies "
            "pass through each other there"
        )
    return tuple(warnings)


def _surrounded(mesh: Mesh, wanted: set[int]) -> Iterable[int]:
    """Nodes on the boundary of a body all of whose neighbours on its faces are contact nodes.

    The tip of an element whose other nodes are all contact nodes does not count.
    """
    near = {node for face in mesh.outer_faces(wanted) if len(face - wanted) == 1 for node in face - wanted}
    around: dict[int, bool] = dict.fromkeys(near, True)
    for face in mesh.outer_faces(near):
        for node in face & near:
            around[node] &= face - {node} <= wanted
    corners = (set(nodes[: CORNERS[shape]]) for shape, nodes in mesh.elements.values())
    deep = {node for own in corners if len(own - wanted) > 1 for node in own}
    return (node for node, inside in around.items() if inside and node in deep)


def _shown(vector: FloatArray) -> str:
    return f"[{', '.join(f'{x:.3g}' for x in vector + 0.0)}]"
