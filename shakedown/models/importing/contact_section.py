"""``[contact]``: nodes or pairs, normals into the first body, tangents or a plane, positions."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import ProblemError, found_in
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import SIX_DIGITS
from shakedown.joint.places import arc_lengths, strips
from shakedown.models.condensation.contact_frame import SPACE, check_unique, node_names
from shakedown.models.condensation.coupled_frame import hat_areas
from shakedown.models.condensation.node_coupling import NodeCoupling
from shakedown.models.condensation.surface_coupling import SurfaceCoupling
from shakedown.models.condensation.tangent_pairs import patch_positions
from shakedown.models.importing.contact_directions import Axes, contact_directions, in_space
from shakedown.models.importing.contact_nodes import contact_nodes, coupled_surfaces, middle_nodes
from shakedown.models.importing.initial_gap import COORDINATES, initial_gap
from shakedown.models.importing.model_section import Model
from shakedown.models.readers.input_files import InputFiles
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.toml_table import TomlTable, is_number, shown

Friction = FloatArray | Mapping[str, float]  # () or (n,), or a coefficient for each node set


@dataclass(frozen=True, eq=False)
class ContactSection:
    """Where the contact is.

    Attributes
    ----------
    labels : (n,) or (n, 2)
        Contact nodes, or pairs (node of the first body, node of the second).
    normals : (n, d + 1)
        Into the first body.
    axes
        The two directions that span the plane, or all three where the nodes slip in two directions.
    tangent : (3,) or (n, 3) or None
        Towards which the first of two tangents leads, where that is given.
    assumed : bool
        Whether nothing says that the nodes slip in one direction only.
    free_out_of_plane : bool
        Whether a third direction moves without friction.
    tied : (n,) or None
        The node tied to each contact node, for reactions.
    relative : bool
        Whether the rows of the contact nodes are displacements u₁ − u₂ of two bodies.
    x : (n,) or (n, 2) or (n, 3) or None
        Positions along the contact; of a flat patch in space on its plane, else where they are [length].
    coordinates : (n, 3) or None
        Where the nodes of the first body are [length].
    gap : () or (n,)
        Initial gap [length]; negative is interference.
    gap_is_stated : bool
        Whether the configuration says what it is, be it 0.
    area : (n,) or None
        Area that each node stands for [length²], where the faces of the model give it.
    sorted_by_place : bool
        Whether the nodes stand in the order of their places, not in that of the configuration.
    surface : str or None
        The surface of the deck whose faces gave the normals.
    normals_are_given : bool
        Whether the configuration gives the normals, not the faces.
    middle_nodes : (t, 3)
        Nodes between two corners of quadratic faces of solids, and these corners.
    coupling : SurfaceCoupling or None
        What the nodes of the first of two surfaces follow, whose meshes need not match.
    clamped : (c,)
        Nodes that are held in a static run in which both bodies are held apart.
    name : str
        Its name in the configuration; "" where it has none.
    friction : () or (n,) or a mapping, or None
        The coefficients that stand beside it, as :func:`taken_friction` returns them.
    patches : tuple of ContactSection
        The parts of a contact of several patches, each by itself.
    """

    labels: NDArray[np.intp]
    normals: FloatArray
    axes: Axes
    tangent: FloatArray | None
    assumed: bool
    free_out_of_plane: bool
    tied: NDArray[np.intp] | None
    relative: bool
    x: FloatArray | None
    coordinates: FloatArray | None
    gap: FloatArray
    gap_is_stated: bool
    area: FloatArray | None
    sorted_by_place: bool
    surface: str | None
    normals_are_given: bool
    middle_nodes: NDArray[np.intp]
    coupling: NodeCoupling | None
    clamped: NDArray[np.intp]
    name: str = ""
    friction: Friction | None = None
    patches: "tuple[ContactSection, ...]" = ()

    @property
    def parts(self) -> "tuple[ContactSection, ...]":
        """The patches that the configuration names, or the only one."""
        return self.patches or (self,)

    @property
    def surfaces(self) -> SurfaceCoupling | None:
        """How two surfaces whose meshes need not match lie on each other; None where there are none."""
        return self.coupling if isinstance(self.coupling, SurfaceCoupling) else None

    @property
    def first(self) -> NDArray[np.intp]:
        """Contact nodes of the first body, (n,)."""
        return self.labels if self.labels.ndim == 1 else self.labels[:, 0]

    @property
    def moved(self) -> NDArray[np.intp]:
        """Nodes that unit displacements move: those of the first body, then those of the second."""
        own = self.labels.T.ravel()
        if self.coupling is None:
            return own
        return np.array(list(dict.fromkeys([*own.tolist(), *self.coupling.master.tolist()])), dtype=np.intp)

    @property
    def two_bodies(self) -> bool:
        """Whether a second body is known."""
        return self.labels.ndim > 1 or self.coupling is not None

    @property
    def facing(self) -> NDArray[np.intp]:
        """Every node and its partner, (n, 1 or 2); on surfaces the partner is that of the largest weight."""
        if self.coupling is None:
            return self.labels.reshape(len(self.labels), -1)
        partner = dict(zip(self.coupling.labels.tolist(), self.coupling.partner.tolist(), strict=True))
        return np.array([[label, partner[label]] for label in self.labels.tolist()], dtype=np.intp)

    @property
    def unit_normals(self) -> FloatArray:
        """Unit normals along x, y, z, (n, 3)."""
        found = in_space(self.normals, self.axes)
        return found / np.linalg.norm(found, axis=1)[:, None]

    @property
    def names(self) -> tuple[str, ...]:
        """What each node is called: its label, or the labels of its pair, after the name of its patch."""
        if self.patches:
            return tuple(name for part in self.patches for name in part.names)
        return tuple(f"{self.name}: {own}" if self.name else own for own in node_names(self.labels))

    @property
    def numbers(self) -> NDArray[np.intp]:
        """Which of its parts every node belongs to, (n,), from 0."""
        return np.repeat(np.arange(len(self.parts)), [len(part.labels) for part in self.parts])

    @property
    def plane(self) -> tuple[int, int]:
        """The two directions of a plane contact; x and y, which mean nothing, for one in space."""
        return (self.axes[0], self.axes[1])

    @property
    def directions(self) -> int:
        """Tangential directions of a node."""
        return len(self.axes) - 1


def contact_section(
    table: TomlTable, model: Model, files: InputFiles, *, assume_plane: bool = True
) -> ContactSection:
    """Take the section from its table; ``assume_plane`` as :func:`contact_directions` takes it.

    Raises
    ------
    ProblemError
        If it is malformed, a set is unknown, nodes of two sets do not match, or
        the normals are neither given nor known from the model.
    """
    name, friction = table.text("name", "") or "", taken_friction(table, required=False)
    coupled = coupled_surfaces(table, model)
    labels, from_sets = contact_nodes(table, model) if coupled is None else (coupled[0].labels, True)
    with found_in(table.where.removesuffix(": contact")):
        check_unique(labels)
    first = labels if labels.ndim == 1 else labels[:, 0]
    given, gap_is_stated = table.content.get("gap"), table.has("gap")
    of_file = isinstance(given, dict) and "file" in given
    gap = initial_gap(table, model, files)
    coupling, slave, surface = (None, None, None) if coupled is None else coupled
    between = middle_nodes(model.mesh, first, table.content.get("surface", surface))
    area = _areas(table, model, first, between, coupling)  # before the normals take 'surface'
    faces = None if coupling is None else in_space(coupling.normals, SPACE[: coupling.normals.shape[1]])
    found = contact_directions(table, model, first, assume_plane=assume_plane, faces=faces)
    contact = ContactSection(
        labels,
        found.normals,
        found.axes,
        found.tangent,
        found.assumed,
        table.flag("free_out_of_plane"),
        _array(table, "tied", int, (None,)),
        table.flag("relative"),
        _array(table, "x", float, (None,) if len(found.axes) == 2 else (None, 2)),
        None if model.mesh is None else model.mesh.at(first),
        np.zeros(()),
        gap_is_stated,
        area,
        from_sets and found.axes != SPACE and model.mesh is not None,
        found.surface or surface,
        found.given,
        between,
        coupling,
        labels.T.ravel() if slave is None or coupling is None else np.union1d(slave.labels, coupling.master),
        name,
        friction,
    )
    table.done()
    if contact.relative:
        _check_relative(contact, model, table.where)
    listed = gap(labels, contact.unit_normals, contact.x) if of_file else given
    listed = np.asarray(listed) if isinstance(listed, list | np.ndarray) else None
    check_order(contact, table.where, {"x": contact.x, "gap": listed})
    placed = _placed(contact, model.mesh) if found.axes != SPACE else _on_patch(contact)
    if placed.surfaces is not None and given == COORDINATES:
        return replace(placed, gap=_drawn(placed.surfaces, placed, table))
    normals = in_space(placed.normals, placed.axes)
    return replace(placed, gap=gap(placed.labels, normals, placed.x))


def _drawn(coupling: SurfaceCoupling, contact: ContactSection, table: TomlTable) -> FloatArray:
    """The gap between two surfaces as the deck draws them, (n,)."""
    if not coupling.flat:
        expected = "a number, or of nodes, between curved surfaces, whose facets are chords"
        raise table.wrong("gap", expected, f"'{COORDINATES}'")
    drawn = dict(zip(coupling.labels.tolist(), coupling.gap.tolist(), strict=True))
    return np.array([drawn[label] for label in contact.labels.tolist()])


def _array(table: TomlTable, key: str, kind: type, shape: tuple[int | None, ...]) -> NDArray[Any] | None:
    values = table.array(key, kind, shape, required=False)
    return None if values is None else np.array(values, dtype=np.intp if kind is int else float)


def _areas(
    table: TomlTable,
    model: Model,
    first: NDArray[np.intp],
    between: NDArray[np.intp],
    coupling: SurfaceCoupling | None,
) -> FloatArray | None:
    """Areas of the nodes of the first body, where the model has their faces."""
    given, thickness = table.has("thickness"), table.number("thickness", 1.0) or 0.0
    if not thickness > 0:
        raise table.wrong("thickness", "a number > 0", f"{thickness:g}")
    if model.axisymmetric and given:
        raise table.wrong(
            "thickness",
            "none, because the areas of an axisymmetric model are 2 pi r times a length",
            f"{thickness:g}",
        )
    if model.mesh is None or not model.mesh.elements:
        return None
    if coupling is not None:
        return coupling.area * (thickness if coupling.normals.shape[1] == 2 else 1.0)
    surface = table.content.get("surface")
    area = model.mesh.node_areas(first, surface if isinstance(surface, str) else None, thickness)
    return None if area is None else hat_areas(area, first, between)


def _check_relative(contact: ContactSection, model: Model, where: str) -> None:
    """Refuse ``relative`` unless the deck's equations make the rows of contact nodes u₁ − u₂."""
    if contact.labels.ndim != 1:
        raise ProblemError(f"{where}: key 'relative': expected 'nodes' (u1 - u2), found 'pairs'")
    if model.mesh is None or not model.mesh.elements:
        return
    for label in contact.labels.tolist():
        for axis in contact.axes:
            if (label, axis) not in model.mesh.relative:
                raise ProblemError(
                    f"{where}: key 'relative': expected an *EQUATION u1 - u2 - u = 0 for direction {axis} of "
                    f"node {label}, found none in the deck"
                )


def _placed(contact: ContactSection, mesh: Mesh | None) -> ContactSection:
    """The nodes in order along the contact, where sets named them, with their positions."""
    if contact.coordinates is None or mesh is None:
        return contact
    units, places = contact.unit_normals, contact.coordinates
    across = np.cross(*np.eye(3)[[axis - 1 for axis in contact.axes]])
    tangents, edges = np.cross(units, across), mesh.edges(contact.first, contact.surface)
    found = strips(places, tangents, edges)
    x, mean = contact.x, tangents.mean(axis=0)
    if x is None and (np.abs(tangents - mean) <= SIX_DIGITS).all():
        x = places @ mean / np.linalg.norm(mean)
    elif x is None:
        x = arc_lengths(places, tangents, found)
    order = np.concatenate(found) if contact.sorted_by_place else np.arange(len(x))
    return replace(
        contact,
        labels=contact.labels[order],
        normals=contact.normals[order],
        x=x[order] if contact.x is None else x,
        coordinates=places[order],
        area=None if contact.area is None else contact.area[order],
    )


def check_order(contact: ContactSection, where: str, lists: Mapping[str, FloatArray | None]) -> None:
    """Refuse lists with one entry per node beside sets, whose nodes are put in the order of their places."""
    for key, given in lists.items():
        if contact.sorted_by_place and given is not None and np.ndim(given):
            raise ProblemError(
                f"{where}: key '{key}': expected no list beside sets of nodes, whose order it cannot know, "
                f"found one of length {len(given)}; name the nodes one by one"
            )


def _on_patch(contact: ContactSection) -> ContactSection:
    """The nodes in the order of the sets that named them, with positions on the plane of a flat patch."""
    if contact.coordinates is None or contact.x is not None:
        return contact
    unit = contact.normals / np.linalg.norm(contact.normals, axis=1)[:, None]
    return replace(contact, x=patch_positions(contact.coordinates, unit, contact.tangent))


def taken_friction(root: TomlTable, *, required: bool = True) -> Friction | None:
    """The key ``friction``, before the contact nodes are known; None where it is absent and not required."""
    value = root.content.get("friction")
    if isinstance(value, dict):
        root.take("friction", "a table", required=True)
        wrong = [item for item in value.values() if not is_number(item)]
        if wrong or not value:
            raise root.wrong("friction", "a number for each node set", shown(wrong[0] if wrong else value))
        return {name: float(item) for name, item in value.items()}
    if isinstance(value, list):
        return np.array(root.array("friction", float, (None,)), dtype=float)
    if root.has("friction"):
        return np.array(root.number("friction"))
    root.known.append("friction")
    if required:
        raise root.missing("friction", "a number, a list, or a table of node sets")
    return None
