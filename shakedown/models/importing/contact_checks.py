"""Checks of a contact against its model: distances of pairs, normals the wrong way, nodes left out."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from shakedown.ground.constants import THREE_DIGITS, FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.joint.result import Result
from shakedown.models.condensation.surface_coupling import REACH
from shakedown.models.importing.contact_section import ContactSection, spacings
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.text import quoted

DOUBTFUL = 0.03  # relative to the spacing, along the surface: more than the rounding of printed coordinates
LEVEL = np.cos(np.radians(84.0))  # from the faces' normal: beyond it a normal does not point inwards
TURNED = np.cos(np.radians(15.0))  # as far off is the last facet of an arc of 12 to the circle


@dataclass(frozen=True, eq=False, repr=False)
class PairDistances(Result):
    """Distances of the pairs, in the length of the model.

    Attributes
    ----------
    along : (n,)
        Distance along the surface [length]: 0 where the meshes of both sides match.
    across : (n,)
        Distance along the normal [length]: the gap as the model is drawn, negative where the bodies overlap.
    spacing : (n,)
        Distance from a node of the first body to the nearest other one of the contact [length]; NaN for a
        single pair.
    """

    along: FloatArray
    across: FloatArray
    spacing: FloatArray

    @property
    def off(self) -> FloatArray:
        """Distances along the surface relative to the spacing, (n,)."""
        return self.along / self.spacing

    @property
    def apart(self) -> FloatArray:
        """Distances across the surface relative to the spacing, (n,)."""
        return np.abs(self.across) / self.spacing

    def to_dict(self) -> dict[str, object]:
        """What ``shakedown-bounds import --check --json`` writes of them."""
        values = {
            "along": self.along,
            "across": np.abs(self.across),
            "along_by_spacing": self.off,
            "across_by_spacing": self.apart,
        }
        return {key: {"largest": each.max(), "mean": each.mean()} for key, each in values.items()}


def distances_of(contact: ContactSection, mesh: Mesh) -> PairDistances | None:
    """Distances of the pairs of a contact, or of those that equations make; None where there are none."""
    pairs = contact.labels
    if contact.relative:
        keys = [(label, contact.axes[0]) for label in contact.first.tolist()]
        pairs = np.array([mesh.relative[key] for key in keys if key in mesh.relative])
    if contact.coordinates is None or len(pairs) < contact.first.size or pairs.ndim == 1:
        return None
    first, units = mesh.at(pairs[:, 0]), contact.unit_normals
    between = first - mesh.at(pairs[:, 1])
    across = (between * units).sum(axis=1)
    along = np.linalg.norm(between - across[:, None] * units, axis=1)
    return PairDistances(along, across, spacings(first, mesh.coordinates))


def check_contact(contact: ContactSection, mesh: Mesh, where: str) -> tuple[str, ...]:
    """Warnings about every patch of a contact in its model, from the positions of its nodes alone.

    Raises
    ------
    ProblemError
        If it cannot be meant so: pairs too far apart, normals out of the body.
    """
    if contact.patches:
        return tuple(
            f"{part.name}: {doubt}"
            for part in contact.parts
            for doubt in check_contact(part, mesh, f"{where}: {quoted(part.name)}")
        )
    coupled = () if contact.surfaces is None else contact.surfaces.warnings
    return (
        *_distances(contact, mesh, where),
        *coupled,
        *_drawn_apart(contact),
        *_gap(contact),
        *_normals(contact, mesh, where),
    )


def _distances(contact: ContactSection, mesh: Mesh, where: str) -> Iterator[str]:
    """Refuse or doubt pairs that do not lie on each other; without a stated gap they should touch."""
    pairs, names = distances_of(contact, mesh), contact.names
    if pairs is None:
        return
    over = "across it; say 'gap' where they are meant (\"coordinates\": as the model is drawn)"
    along, across = np.nan_to_num(pairs.off), np.nan_to_num(pairs.apart)
    if contact.gap_is_stated:
        across[:] = 0.0
    for share, distance, how in ((along, pairs.along, "along the surface"), (across, pairs.across, over)):
        k = int(np.argmax(share))
        if share[k] > REACH:
            raise ProblemError(
                f"{where}: key 'pairs': expected nodes that lie on each other (nearer than {REACH:g} of the "
                f"spacing {pairs.spacing[k]:.3g}), found {names[k]} {abs(distance[k]):.3g} apart {how}"
            )
    k = int(np.argmax(along))
    if along[k] > DOUBTFUL:
        yield (
            f"pairs do not lie on each other: {names[k]} is {pairs.along[k]:.3g} apart along the surface, "
            f"{along[k]:.2g} of the spacing (mean {np.nanmean(pairs.off):.2g}), and taken as lying at one "
            "place"
        )
    k = int(np.argmax(across))
    if across[k] > THREE_DIGITS:
        drawn = "overlap by" if pairs.across[k] < 0 else "lie apart by"
        yield (
            f"pairs are drawn so that they {drawn} {abs(pairs.across[k]):.3g} across the surface "
            f'({names[k]}), but taken as touching: gap = "coordinates" takes what is drawn, gap = 0 says '
            "that touching is meant"
        )


def _drawn_apart(contact: ContactSection) -> Iterator[str]:
    """A warning about coupled surfaces that are drawn apart or into each other without a stated gap."""
    coupling = contact.surfaces
    if coupling is None or contact.gap_is_stated:
        return
    mean = float(coupling.distance[1])
    if abs(mean) > (THREE_DIGITS if coupling.flat else DOUBTFUL) * coupling.size:
        drawn = "overlap by" if mean < 0 else "lie apart by"
        word = ' (or "coordinates")' if coupling.flat else ""
        yield (
            f"the surfaces are drawn so that they {drawn} {abs(mean):.3g} on average, but taken as touching: "
            f"gap = a number{word} takes what is meant, gap = 0 says that touching is"
        )


def _gap(contact: ContactSection) -> Iterator[str]:
    """A warning about a gap, or an interference, that is large beside the distance of the nodes."""
    if contact.coordinates is None or not contact.gap.any():
        return
    share = np.nan_to_num(contact.gap / spacings(contact.coordinates))
    least, deepest = share.min(), -share.min()
    if max(least, deepest) > REACH:
        size = contact.gap.min()
        touch = f"the bodies touch nowhere: the least gap is {size:.3g}"
        what = touch if size > 0 else f"the interference is up to {-size:.3g}"
        yield (
            f"{what}, {max(least, deepest):.2g} of the spacing of the nodes: is it in the unit of the model?"
        )


def _normals(contact: ContactSection, mesh: Mesh, where: str) -> Iterator[str]:
    """Refuse normals out of the first body; doubt those unlike the faces, and nodes that are left out.

    Where no faces are known, nothing is said. The faces of the second body must look at the first one's.
    """
    if contact.coordinates is None or not mesh.elements:
        return
    names, given = contact.names, contact.unit_normals
    if contact.normals_are_given:
        faces = mesh.face_normals(contact.first, contact.surface)
        cosine = (given * faces).sum(axis=1)
        if (wrong := cosine < LEVEL).any():
            k = int(np.argmax(wrong))
            raise ProblemError(
                f"{where}: expected normals into the first body, found {_shown(given[k])} at {names[k]}, "
                f"where its faces have {_shown(faces[k])} ({int(wrong.sum())} of {len(names)} do not)"
            )
        if turned := int((cosine < TURNED).sum()):
            k = int(np.nanargmin(cosine))
            yield (
                f"the normal of {names[k]} is turned by {np.degrees(np.arccos(cosine[k])):.0f}° from the "
                f"faces there ({turned} of {len(names)} by more than 15°)"
            )
    if contact.coupling is not None:
        return
    yield from _left_out(mesh, contact.first.tolist())
    if contact.labels.ndim > 1:
        opposite = mesh.face_normals(contact.labels[:, 1])
        if ((given * opposite).sum(axis=1) > 0).all():
            raise ProblemError(
                f"{where}: expected faces of the second body that look at those of the first, found that "
                f"both bodies lie on the same side of the contact at {names[0]}"
            )
        yield from _left_out(mesh, contact.labels[:, 1].tolist())


def _left_out(mesh: Mesh, labels: list[int]) -> Iterator[str]:
    """A warning about nodes between the corners of a body's faces at the contact that are not in it."""
    between = {node for facet in mesh.boundary(set(labels)) for node in facet.between}.difference(labels)
    if between:
        yield (
            f"faces at the contact have {len(between)} node(s) between their corners that are no contact "
            f"nodes, first {min(between)}: these pass through the other body; take them in, or linear "
            "elements"
        )


def _shown(vector: FloatArray) -> str:
    return f"[{', '.join(f'{x:.3g}' for x in vector + 0.0)}]"
