"""What an import finds of model and contact, whatever loads them: bodies, patches, pairs, normals, doubts."""

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from shakedown import __version__
from shakedown.ground.constants import (
    BLOCK,
    FOUR_DIGITS,
    NEGLIGIBLE,
    NOTABLE,
    RESOLVED,
    SIX_DIGITS,
    THREE_DIGITS,
    FloatArray,
    IntArray,
    Mask,
)
from shakedown.ground.errors import ProblemError
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.result import Result
from shakedown.models.condensation.stiffness_checks import motions_in_words, rigid_motions, uncoupled
from shakedown.models.condensation.surface_coupling import REACH
from shakedown.models.importing.contact_section import ContactSection, spacings
from shakedown.models.readers.mesh import SOLIDS, Mesh
from shakedown.models.readers.parsing import quoted
from shakedown.models.readers.stiffness import Stiffness

DOUBTFUL = 0.03  # relative to the spacing, along the surface: more than the rounding of printed coordinates


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
    """Distances of the pairs of a contact; None where there are none."""
    pairs = contact.labels
    if contact.coordinates is None or pairs.ndim == 1:
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
    """Refuse normals out of the first body; doubt those unlike the faces.

    Where no faces are known, nothing is checked. The faces of the second body must look at the first one's.
    """
    if contact.coordinates is None or not mesh.elements:
        return
    names, given = contact.names, contact.unit_normals
    if contact.normals_are_given:
        faces = mesh.face_normals(contact.first, contact.surface)
        cosine = (given * faces).sum(axis=1)
        # from the faces' normal: beyond it a normal does not point inwards
        if (wrong := cosine < np.cos(np.radians(84.0))).any():
            k = int(np.argmax(wrong))
            raise ProblemError(
                f"{where}: expected normals into the first body, found {_shown(given[k])} at {names[k]}, "
                f"where its faces have {_shown(faces[k])} ({int(wrong.sum())} of {len(names)} do not)"
            )
        # as far off is the last facet of an arc of 12 to the circle
        if turned := int((cosine < np.cos(np.radians(15.0))).sum()):
            k = int(np.nanargmin(cosine))
            yield (
                f"the normal of {names[k]} is turned by {np.degrees(np.arccos(cosine[k])):.0f}° from the "
                f"faces there ({turned} of {len(names)} by more than 15°)"
            )
    if contact.coupling is not None:
        return
    yield from _left_out(mesh, contact.first.tolist())
    if contact.labels.ndim > 1:
        yield from _left_out(mesh, contact.labels[:, 1].tolist())
        opposite = mesh.face_normals(contact.labels[:, 1])
        if ((given * opposite).sum(axis=1) > 0).all():
            raise ProblemError(
                f"{where}: expected faces of the second body that look at those of the first, found that "
                f"both bodies lie on the same side of the contact at {names[0]}"
            )


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


@dataclass(frozen=True, eq=False, repr=False)
class ModelBody(Result):
    """One connected part of the model.

    Attributes
    ----------
    name : str
        "first body" and "second body" where there are no more; else bodies are numbered.
    nodes : (k,)
        Labels of its nodes that have rows in the matrix.
    free : tuple of str
        Rigid motions that nothing but the contact resists, in words: "along x", "turning about z".
    contact_nodes : int
        How many of its nodes are contact nodes.
    """

    name: str
    nodes: IntArray
    free: tuple[str, ...]
    contact_nodes: int

    def to_dict(self) -> dict[str, object]:
        """What ``shakedown-bounds import --check --json`` writes of it."""
        count = {"nodes": len(self.nodes), "contact_nodes": self.contact_nodes}
        return {"name": self.name, **count, "free": list(self.free)}


@dataclass(frozen=True, eq=False, repr=False)
class ModelEvidence(Result):
    """What an import finds of a model, for it and against it.

    Attributes
    ----------
    bodies : tuple of ModelBody
        The connected parts of the model, with the rigid motions that nothing but the contact resists.
    patches : (n,)
        Which patch of the configuration every node belongs to, from 0.
    pairs : tuple of PairDistances or None
        For every patch of the configuration: how far apart the nodes of its pairs lie, where that is known.
    rigid_residual : float
        As :class:`~shakedown.models.importing.import_model.Import` has it.
    alone : (k, 2)
        (node, direction) of the rows that couple with no displacement and bear no load, as component modes
        of a superelement.
    warnings : tuple of str
        What is doubtful.
    """

    bodies: tuple[ModelBody, ...]
    patches: IntArray
    pairs: tuple[PairDistances | None, ...]
    rigid_residual: float
    alone: IntArray
    warnings: tuple[str, ...]

    @property
    def notes(self) -> Iterator[str]:
        """Notes on parts of the model that the contact does not touch, and rows that are left out."""
        apart = [body.nodes for body in self.bodies if not body.contact_nodes]
        if apart:
            one = f"one of {len(apart[0])} node(s) from {apart[0][0]}"
            yield f"{len(apart)} part(s) of the model have no contact node, {one}"
        if len(self.alone):
            yield (
                f"{len(self.alone)} row(s), first of point {self.alone[0, 0]}, couple with no displacement "
                "(component modes of a fixed boundary) and are left out"
            )


def model_evidence(
    stiffness: Stiffness,
    contact: ContactSection,
    rows: IntArray,
    mesh: Mesh,
    warnings: tuple[str, ...],
    alone: Mask,
) -> ModelEvidence:
    """What is found of a model with held ``rows``, beside ``warnings`` of its contact and rows left out."""
    held = np.asarray(stiffness.K.diagonal() >= DEFAULT.constrained_diagonal)
    held[rows] = True
    # a superelement, or a matrix of contact nodes only, should be a condensed one
    own, sparse = stiffness.are_displacements if stiffness.superelement else ~held, ""
    if stiffness.superelement or np.isin(stiffness.dofs[own, 0], contact.moved).all():
        sparse = uncoupled(stiffness.K[own][:, own], stiffness.dofs[own, 0])
    if sparse:
        warnings = (*warnings, f"the matrix should be a condensed one, but {sparse}")
    return ModelEvidence(
        bodies=bodies_of(stiffness, held, contact, mesh),
        patches=contact.numbers,
        pairs=tuple(distances_of(part, mesh) for part in contact.parts),
        rigid_residual=rigid_residual(stiffness, mesh, contact.axes),
        alone=stiffness.dofs[alone],
        warnings=(*warnings, *model_doubts(stiffness, contact, mesh)),
    )


def source_text(
    config_path: str | os.PathLike[str],
    sources: Mapping[str, str],
    command: str,
    warnings: Sequence[str] = (),
) -> str:
    """``source`` of a problem as JSON: toolkit, command, configuration, files, warnings; no date."""
    raw = Path(config_path).read_bytes()
    text = raw.decode() if len(raw) <= BLOCK else None  # of a longer one only its SHA-256 is kept
    about = {
        "toolkit": f"shakedown-bounds {__version__}",
        "command": command,
        "configuration": {"name": Path(config_path).name, "text": text},
        "files": [{"name": name, "sha256": digest} for name, digest in sources.items()],
        "warnings": list(warnings),
    }
    return json.dumps({key: value for key, value in about.items() if value})


def bodies_of(stiffness: Stiffness, held: Mask, contact: ContactSection, mesh: Mesh) -> tuple[ModelBody, ...]:
    """The bodies, those of the contact first.

    Parameters
    ----------
    held : (N,)
        Rows that are held.
    contact
        The contact, of which nodes on either side may have no rows (held).
    """
    part = stiffness.parts
    met = [stiffness.part_of[label] for label in contact.moved.tolist() if label in stiffness.part_of]
    order = [own for own in dict.fromkeys([*met, *part.tolist()]) if own >= 0]
    two = contact.two_bodies and len(set(met)) == 2 == len(order)
    places, axial = places_of_rows(stiffness, mesh), mesh.axisymmetric
    bodies = []
    for number, which in enumerate(order):
        rows = np.flatnonzero(part == which)
        name = "body" if len(order) == 1 else f"body {number + 1}"
        if two:
            name = ("first body", "second body")[number]
        motions = free_motions(stiffness, rows, held, places, axial=axial)
        own = stiffness.are_displacements[rows]
        words = motions_in_words(motions[own], stiffness.dofs[rows[own]], places) if motions.size else ()
        nodes = np.unique(stiffness.dofs[rows, 0])
        nodes = nodes[nodes > 0]  # without internal ones
        bodies.append(ModelBody(name, nodes, tuple(words), met.count(which)))
    return tuple(bodies)


def rigid_residual(stiffness: Stiffness, mesh: Mesh, axes: Sequence[int]) -> float:
    """Largest force that a rigid motion of the whole model meets, relative to max |K| times the motion.

    A plane problem moves in its plane, a body of revolution along its axis only. NaN where the mesh does not
    know the coordinates of every node with rows, or the rows are not displacements (multipliers, modes).
    """
    moving = np.isin(stiffness.dofs[:, 1], axes) & stiffness.are_displacements  # modes and sections stay
    places = places_of_rows(stiffness, mesh)
    if places is None:
        return float("nan")
    motions = rigid_motions(stiffness.dofs, places, [2] if mesh.axisymmetric else axes)
    marked = stiffness.K.diagonal() >= DEFAULT.constrained_diagonal
    entries = np.abs(stiffness.K[moving].data)
    scale = float(entries[entries < DEFAULT.constrained_diagonal].max(initial=np.finfo(float).tiny))
    return float(np.abs((stiffness.K @ motions)[~marked]).max(initial=0.0) / scale)


def places_of_rows(stiffness: Stiffness, mesh: Mesh) -> Mapping[int, Sequence[float]] | None:
    """Node → (x, y, z), or None where the coordinates of a node that moves are not known."""
    labels = stiffness.dofs[stiffness.are_displacements, 0]
    return mesh.places if mesh.places.keys() >= set(labels.tolist()) else None


def rigid_motions_of_bodies(
    stiffness: Stiffness, held: Mask, mesh: Mesh, shanks: Sequence[tuple[float, FloatArray]]
) -> FloatArray:
    """The rigid motions of bodies that nothing but the contact resists, (N, k), up to few printed digits.

    Shanks of bolts, each with its stiffness and e of its shortening e · u, (N,), keep their length.
    """
    part, places = stiffness.parts, places_of_rows(stiffness, mesh)
    found = [np.zeros((len(part), 0))]
    for own in np.unique(part[part >= 0]) if stiffness.accuracy else ():
        rows = np.flatnonzero(part == own)
        motions = free_motions(stiffness, rows, held, places, axial=mesh.axisymmetric)
        found.append(np.zeros((len(part), motions.shape[1])))
        found[-1][rows] = motions
    motions, tight = np.hstack(found), [own for stiff, own in shanks if stiff]
    _, size, vectors = np.linalg.svd(np.reshape(tight, (-1, len(part))) @ motions)
    return motions @ vectors[np.count_nonzero(size > NEGLIGIBLE) :].T


def free_motions(
    stiffness: Stiffness,
    rows: IntArray,
    held: Mask,
    places: Mapping[int, Sequence[float]] | None,
    *,
    axial: bool = False,
) -> FloatArray:
    """Rigid motions of the nodes of some rows that meet no resistance and move no held row, (rows, k).

    Where places are not known none is a rotation; a body of revolution (``axial``) moves along its
    axis only.
    """
    dofs = stiffness.dofs[rows]
    own = stiffness.are_displacements[rows]  # multipliers, pressures and modes stay as they are
    axes = [2] if axial else sorted({1, 2, 3} & set(dofs[own, 1].tolist()))
    moved = rigid_motions(dofs[own], places, axes)
    moved = moved[:, np.abs(moved).max(axis=0, initial=0.0) > DEFAULT.symmetry]
    motions = np.zeros((len(rows), moved.shape[1]))
    motions[own] = moved
    loose = ~held[rows]
    K = stiffness.K[rows[loose]][:, rows[loose]]
    met = np.vstack([K @ motions[loose] / (abs(K).max() if K.nnz else 1.0), motions[~loose]])
    _, size, modes = np.linalg.svd(np.linalg.qr(met, mode="r"))
    # a motion is free if it meets no more than round-off
    null = modes[size <= max(NEGLIGIBLE, 10.0 * (stiffness.accuracy or 0.0)) * np.sqrt(len(rows))].T
    return motions @ null


def model_doubts(stiffness: Stiffness, contact: ContactSection, mesh: Mesh) -> Iterator[str]:
    """Warnings where matrix, row map and deck hardly belong together, or nodes that touch are no pairs."""
    yield from _touching(stiffness, contact, mesh)
    if not mesh.elements or stiffness.superelement or mesh.equations or mesh.rotated:
        return
    dofs = stiffness.dofs
    nodes = dofs[dofs[:, 0] > 0, 0]
    unknown = nodes[~np.isin(nodes, mesh.labels)]
    if len(unknown) > NOTABLE * len(nodes):
        yield (
            f"{len(unknown)} of {len(nodes)} rows are of nodes that are none of the deck, first "
            f"{unknown[0]}: are matrix, row map and deck of one run?"
        )
    # rows of nodes of elements all of whose nodes have free rows in all their directions
    free = (stiffness.K.diagonal() < DEFAULT.constrained_diagonal) & np.isin(dofs[:, 1], (1, 2, 3))
    labels, count = np.unique(dofs[free, 0], return_counts=True)
    there = set(labels[count == count.max(initial=0)].tolist())
    elements = [corners for _, corners in mesh.elements.values()]
    lacking = {node for nodes in elements if not there.issuperset(nodes) for node in nodes}
    known = {node for nodes in elements for node in nodes} & there
    inside = np.isin(dofs[:, 0], list(known - lacking))
    if inside.any():
        yield from _resisting(stiffness, mesh, inside)
        yield from _out_of_size(stiffness, mesh, inside)


def _out_of_size(stiffness: Stiffness, mesh: Mesh, inside: Mask) -> Iterator[str]:
    """A warning where stiffnesses are far from those of the materials and elements of the deck.

    The diagonal of a row is about E in the plane, E times a length in space, E times the circumference of
    a body of revolution; ``inside`` says which rows, (N,).
    """
    if not mesh.young:
        return
    size = np.ones(1)
    if mesh.axisymmetric:
        size = 2 * np.pi * mesh.at(stiffness.dofs[inside, 0])[:, 0]
    elif any(shape in SOLIDS for shape, _ in mesh.elements.values()):
        # elements that tell how large they are
        measured = list(mesh.elements.values())[:1000]
        size = np.array([np.ptp(mesh.at(nodes), axis=0).mean() for _, nodes in measured])
    length = max(float(np.median(size)), np.finfo(float).tiny)
    found = float(np.median(stiffness.K.diagonal()[inside])) / length
    low, high = min(mesh.young), max(mesh.young)
    unalike = 200.0  # ratio beyond which units differ: mm for m gives 1,000, element shapes or ν = 0.499 less
    if not low / unalike <= found <= high * unalike:
        yield (
            f"the stiffness is {found / (high if found > high else low):.1g} times what Young's modulus and "
            "the elements of the deck make: are they in the same units, is 'scale' right?"
        )


def _resisting(stiffness: Stiffness, mesh: Mesh, inside: Mask) -> Iterator[str]:
    """A warning where rigid motions meet resistance in rows (N,) inside the model."""
    places = {label: mesh.places.get(label, [0.0] * 3) for label in stiffness.dofs[:, 0].tolist()}
    axes = [2] if mesh.axisymmetric else sorted({1, 2, 3} & set(stiffness.dofs[:, 1].tolist()))
    motions = rigid_motions(stiffness.dofs, places, axes)
    terms = abs(stiffness.K) @ np.abs(motions)
    met = (np.abs(stiffness.K @ motions) / np.maximum(terms, np.finfo(float).tiny)).max(axis=1)
    most = max(FOUR_DIGITS, RESOLVED * (stiffness.accuracy or 0.0))
    nodes, resisting = (set(stiffness.dofs[rows, 0].tolist()) for rows in (inside, inside & (met > most)))
    if resisting:
        far = len(resisting) > NOTABLE * len(nodes)
        yield (
            f"rigid motions of the deck's nodes meet resistance at {len(resisting)} of {len(nodes)} nodes "
            f"inside the model, most at {stiffness.dofs[np.argmax(met * inside), 0]}: "
            + ("are matrix, row map and deck of one run?" if far else "springs, or damaged entries?")
        )


def _touching(stiffness: Stiffness, contact: ContactSection, mesh: Mesh) -> Iterator[str]:
    """A warning about nodes of two bodies at one place that are no pair of the contact."""
    labels, part = np.array(list(stiffness.part_of)), np.array(list(stiffness.part_of.values()))
    if mesh.equations or not set(labels.tolist()) <= set(mesh.labels.tolist()):
        return
    places = mesh.at(labels)
    size = float(np.ptp(places, axis=0).max())
    close = cKDTree(places).query_pairs(SIX_DIGITS * size, output_type="ndarray")
    close = close[part[close[:, 0]] != part[close[:, 1]]]
    pairs = {frozenset(pair) for pair in contact.facing.tolist()}
    coupled = [set(patch.clamped.tolist()) for patch in contact.parts if patch.surfaces is not None]
    alone = [
        pair
        for pair in labels[close].tolist()
        if frozenset(pair) not in pairs and not any(own.issuperset(pair) for own in coupled)
    ]
    if alone:
        yield (
            f"nodes of two bodies lie at one place and are no pair of the contact ({len(alone)} times, first "
            f"{alone[0][0]} and {alone[0][1]}): the bodies pass through each other there"
        )
