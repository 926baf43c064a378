"""``[contact]``: nodes, pairs or surfaces, normals and tangents, positions, the initial gap."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shakedown.ground.constants import NEGLIGIBLE, SIX_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import ProblemError, found_in
from shakedown.joint.contact_surface import NEIGHBOURS
from shakedown.joint.places import arc_lengths, faces_among, strips
from shakedown.models.condensation import contact_frame, surface_mesh
from shakedown.models.condensation.contact_frame import SPACE, Axes
from shakedown.models.condensation.surface_coupling import SurfaceCoupling, surface_coupling
from shakedown.models.condensation.surface_mesh import ContactSurface, NodeCoupling
from shakedown.models.importing.contact_directions import contact_directions, one_or_each
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.parsing import InputFiles, quoted, read_table, unfit
from shakedown.models.readers.toml_table import TomlTable, is_number, labels_of, nodes_of, shown

Friction = FloatArray | Mapping[str, float]  # () or (n,), or a coefficient for each node set


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactSection:
    """Where the contact is, and in which directions the gap opens and the nodes slip.

    Attributes
    ----------
    axes
        The two directions that span the plane, or all three where the nodes slip in two directions.
    normals : (n, d + 1)
        They point into the first body.
    tangent : (3,) or (n, 3) or None
        The direction towards which the first of two tangents points, where it is given.
    assumed : bool
        Whether one direction of slip is only assumed, as the normals lie in the plane of x and y.
    surface : str or None
        The surface of the deck whose faces gave the normals.
    normals_are_given : bool
        Whether the configuration gives the normals, not the faces.
    labels : (n,) or (n, 2)
        Contact nodes, or pairs (node of the first body, node of the second).
    tied : (n,) or None
        The node tied to each contact node, for reactions.
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
    middle_nodes : (t, 3)
        Nodes between two corners of quadratic faces of solids, and these corners.
    coupling : SurfaceCoupling or None
        What the nodes of the first of two surfaces follow, whose meshes need not match.
    name : str
        Its name in the configuration; "" where it has none.
    friction : () or (n,) or a mapping, or None
        The coefficients that stand beside it, as :func:`taken_friction` returns them.
    patches : tuple of ContactSection
        The parts of a contact of several patches, each by itself.
    """

    axes: Axes
    normals: FloatArray
    tangent: FloatArray | None
    assumed: bool
    surface: str | None
    normals_are_given: bool
    labels: IntArray
    tied: IntArray | None
    x: FloatArray | None
    coordinates: FloatArray | None
    gap: FloatArray
    gap_is_stated: bool
    area: FloatArray | None
    sorted_by_place: bool
    middle_nodes: IntArray
    coupling: NodeCoupling | None
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
    def first(self) -> IntArray:
        """Contact nodes of the first body, (n,)."""
        return self.labels if self.labels.ndim == 1 else self.labels[:, 0]

    @property
    def met(self) -> NodeCoupling:
        """What the nodes of the first body follow: nodes of the second, a surface, or a rigid obstacle."""
        if self.coupling is not None:
            return self.coupling
        return surface_mesh.coupling_of_nodes(self.labels, self.unit_normals, self.middle_nodes)

    def positions(self, labels: IntArray) -> IntArray:
        """Where nodes of the first body stand in it."""
        place = {label: k for k, label in enumerate(self.first.tolist())}
        return np.array([place[label] for label in labels.tolist()], dtype=np.intp)

    @property
    def moved(self) -> IntArray:
        """Nodes that unit displacements move: those of the first body, then those of the second."""
        return np.array(list(dict.fromkeys([*self.first.tolist(), *self.met.master.tolist()])), dtype=np.intp)

    @property
    def clamped(self) -> IntArray:
        """Nodes that are held in a static run in which both bodies are held apart, (c,)."""
        beside = [part.surfaces.uncovered for part in self.parts if part.surfaces is not None]
        return np.unique(np.concatenate([self.moved, *beside]))

    @property
    def two_bodies(self) -> bool:
        """Whether a second body is known."""
        return self.labels.ndim > 1 or self.coupling is not None

    @property
    def facing(self) -> IntArray:
        """Every node and its partner, (n, 2): the node of the largest weight, or without one itself."""
        found = np.column_stack([self.first, self.first])
        found[self.positions(self.met.labels), 1] = self.met.partner
        return found

    @property
    def unit_normals(self) -> FloatArray:
        """Unit normals along x, y, z, (n, 3)."""
        found = contact_frame.in_space(self.normals, self.axes)
        return found / np.linalg.norm(found, axis=1)[:, None]

    @property
    def names(self) -> tuple[str, ...]:
        """What each node is called: its label, or the labels of its pair, after the name of its patch."""
        if self.patches:
            return tuple(name for part in self.patches for name in part.names)
        names = contact_frame.node_names(self.labels)
        return tuple(f"{self.name}: {own}" if self.name else own for own in names)

    @property
    def numbers(self) -> IntArray:
        """Which of its parts every node belongs to, (n,), from 0."""
        return np.repeat(np.arange(len(self.parts)), [len(part.labels) for part in self.parts])

    @property
    def directions(self) -> int:
        """Tangential directions of a node."""
        return len(self.axes) - 1


def contact_section(
    table: TomlTable, mesh: Mesh, files: InputFiles, *, assume_plane: bool = True
) -> ContactSection:
    """Take the section from its table; ``assume_plane`` as :func:`contact_directions` takes it.

    Raises
    ------
    ProblemError
        If it is malformed, a set is unknown, nodes of two sets do not match, or
        the normals are neither given nor known from the model.
    """
    name, friction = table.text("name", "") or "", taken_friction(table, required=False)
    coupling, surface = coupled_surfaces(table, mesh)
    labels, from_sets = contact_nodes(table, mesh) if coupling is None else (coupling.labels, True)
    with found_in(table.where.removesuffix(": contact")):
        contact_frame.check_unique(labels)
    first = labels if labels.ndim == 1 else labels[:, 0]
    given = table.content.get("surface", surface)
    named = given if isinstance(given, str) else None
    on = mesh.surface(first, named) if mesh.elements else None
    between = np.zeros((0, 3), dtype=np.intp) if on is None else on.middle_nodes
    area = _areas(table, mesh, first, between, coupling, named)
    faces = None if coupling is None else contact_frame.in_space(coupling.normals)
    normals_are_given = table.has("normal") or table.has("normals")
    axes, normals, assumed = contact_directions(table, mesh, first, assume_plane=assume_plane, faces=faces)
    contact = ContactSection(
        axes=axes,
        normals=normals,
        tangent=one_or_each(table, "tangent", len(first), 3) if axes == SPACE else None,
        assumed=assumed,
        surface=named,
        normals_are_given=normals_are_given,
        labels=labels,
        tied=_array(table, "tied", int, (None,)),
        x=_array(table, "x", float, (None,) if axes != SPACE else (None, 2)),
        coordinates=mesh.at(first) if mesh.is_known else None,
        gap=np.zeros(()),
        gap_is_stated=table.has("gap"),
        area=area,
        sorted_by_place=from_sets and axes != SPACE and mesh.is_known,
        middle_nodes=between,
        coupling=coupling,
        name=name,
        friction=friction,
    )
    check_order(contact, table.where, {"x": contact.x})
    if contact.coordinates is not None and axes != SPACE:
        contact = _placed(contact, contact.coordinates, mesh)
    elif contact.coordinates is not None and contact.x is None:
        x = contact_frame.patch_positions(contact.coordinates, contact.unit_normals, contact.tangent)
        contact = replace(contact, x=x)
    contact = replace(contact, gap=_initial_gap(table, contact, mesh, files))
    table.done()
    return contact


def contact_nodes(table: TomlTable, mesh: Mesh) -> tuple[IntArray, bool]:
    """Contact nodes (n,) or pairs (n, 2), and whether sets named them.

    Raises
    ------
    ProblemError
        If there are neither or both, other keys contradict them, a set is unknown, or the nodes of two sets
        do not lie on each other.
    """
    key = table.one_of("nodes", "pairs", "one of the keys 'nodes', 'pairs' and 'surfaces'")
    if key == "pairs" and table.has("tied"):
        raise table.unfit("no key 'tied' beside 'pairs', whose second nodes are known", "both")
    value, where = table.content[key], table.at(key)
    if key == "nodes" and isinstance(value, str):
        return nodes_of(mesh, str(table.text(key)), where), True
    if key == "pairs" and _are_two_names(value):
        first, second = (nodes_of(mesh, name, where) for name in table.take(key, "two sets"))
        if len(first) != len(second):
            more, fewer = (first, second) if len(first) > len(second) else (second, first)
            alone = more[int(np.argmax(cKDTree(mesh.at(fewer)).query(mesh.at(more))[0]))]
            found = f"{len(first)} and {len(second)}, node {alone} farthest from a partner"
            raise unfit(where, "sets of equally many nodes", found)
        nearest = cKDTree(mesh.at(second)).query(mesh.at(first))[1]  # whether they touch is checked later
        return np.column_stack([first, second[nearest]]), True
    return np.array(table.array(key, int, (None, 2)[: 1 + (key == "pairs")]), dtype=np.intp), False


def _are_two_names(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(isinstance(name, str) for name in value)


def spacings(places: FloatArray, model: FloatArray | None = None) -> FloatArray:
    """The distance of every node from the nearest one that lies elsewhere, (n,); NaN where there is none.

    For a single node it is taken from the nodes of the whole ``model``, (k, 3).
    """
    if len(places) == 1 and model is not None and len(model) > 2:
        return np.sort(np.linalg.norm(model - places, axis=1))[2:3]  # beyond itself and its partner
    if len(places) == 1:
        return np.full(1, np.nan)
    distance, _ = cKDTree(places).query(places, k=min(len(places), NEIGHBOURS))
    elsewhere = distance > NEGLIGIBLE * np.ptp(places, axis=0).max()
    first = np.argmax(elsewhere, axis=1)
    return np.where(elsewhere.any(axis=1), distance[np.arange(len(places)), first], np.nan)


def coupled_surfaces(table: TomlTable, mesh: Mesh) -> tuple[SurfaceCoupling | None, str | None]:
    """The coupling of two surfaces, and the first one's name where it is an element surface.

    Raises
    ------
    ProblemError
        If other keys contradict it, a surface is unknown or has no faces, or the two cannot be coupled.
    """
    names = table.take("surfaces", "two names, of the first body and of the second", fits=_are_two_names)
    reach, where = table.number("reach"), table.at("surfaces")
    if names is None:
        if reach is not None:
            raise table.missing("surfaces", "beside 'reach'")
        return None, None
    # keys that do not stand beside it
    if others := [key for key in ("nodes", "pairs", "surface", "tied") if table.has(key)]:
        raise table.unfit(f"no key '{others[0]}' beside 'surfaces'", "both")
    if not mesh.elements:
        raise unfit(where, "[model] with a deck that has elements", "none")
    slave, master = (_surface(mesh, name, where) for name in names)
    with found_in(where):
        found = surface_coupling(slave, master, reach=reach, revolved=mesh.axisymmetric)
    key = names[0].strip().upper()
    return found, key if key in mesh.surfaces else None


def faces_between(contact: ContactSection, mesh: Mesh) -> IntArray | None:
    """The corners of a contact's faces in space as numbers of its nodes, (k, 4); None for a plane one."""
    if contact.axes != SPACE:
        return None
    surfaces = [mesh.surface(part.first, part.surface) for part in contact.parts if mesh.elements]
    found = [face for own in surfaces if own is not None and own.dimension == 3 for face in own.split()]
    return faces_among(np.array(found), contact.first.tolist()) if found else None


def _surface(mesh: Mesh, name: str, where: str) -> ContactSurface:
    """The faces of an element surface, or those that have all their corners in a node set."""
    key = name.strip().upper()
    with found_in(where):
        found = mesh.surface(mesh.nodes(name), key if key in mesh.surfaces else None)
    if found is None:
        raise unfit(where, f"faces of elements in the set {quoted(name)}", "none")
    return found


def _initial_gap(table: TomlTable, contact: ContactSection, mesh: Mesh, files: InputFiles) -> FloatArray:
    """The key ``gap``, () or (n,) [length]: a number, a list, a word or a table; absent it is 0."""
    given = table.content.get("gap", 0.0)
    if isinstance(given, str):
        if table.text("gap") != "coordinates":
            raise table.wrong("gap", "'coordinates', a number, a list or a table", shown(given))
        return _drawn_gap(table, contact, mesh)
    if isinstance(given, list):
        gap = np.array(table.array("gap", float, (None,)), dtype=float)
    elif not isinstance(given, dict):
        gap = np.array(table.number("gap", 0.0))
    else:
        source = table.table("gap")
        if source.one_of("nodes", "file", "one of the keys 'nodes' and 'file'") == "nodes":
            return _gap_of_nodes(table, source, contact, mesh)
        name, column = str(source.text("file")), source.key_of_column("column") or 1
        source.done()
        gap = files.read(name, lambda path: read_table(path).column(column), source.at("file"))
    check_order(contact, table.where, {"gap": gap})
    if gap.ndim and len(gap) != len(contact.labels):
        raise table.wrong("gap", f"one for each of {len(contact.labels)} nodes", len(gap))
    return gap


def _drawn_gap(table: TomlTable, contact: ContactSection, mesh: Mesh) -> FloatArray:
    """The distance of the nodes of each pair, or of two surfaces, as the deck draws them, (n,)."""
    coupling, labels = contact.surfaces, contact.labels
    if coupling is not None and not coupling.flat:
        expected = "a number, or of nodes, between curved surfaces, whose facets are chords"
        raise table.wrong("gap", expected, "'coordinates'")
    if coupling is not None:
        drawn = np.zeros(len(labels))
        drawn[contact.positions(coupling.labels)] = coupling.gap
        return drawn
    if contact.coordinates is None or labels.ndim == 1:
        found = "nodes of one body" if labels.ndim == 1 else "no [model]"
        raise table.wrong("gap", "pairs in a model with coordinates beside 'coordinates'", found)
    apart = mesh.at(labels[:, 0]) - mesh.at(labels[:, 1])
    return np.asarray((apart * contact.unit_normals).sum(axis=1))


def _gap_of_nodes(table: TomlTable, source: TomlTable, contact: ContactSection, mesh: Mesh) -> FloatArray:
    """Gaps of [node or set, gap] entries; the other nodes touch."""
    gap, where, seen = np.zeros(len(contact.labels)), source.at("nodes"), set[int]()
    for name, value in source.entries("nodes", 2) or []:
        if not is_number(value):
            raise source.wrong("nodes", "a finite number", shown([name, value]))
        for label in labels_of(mesh, name, where).tolist():
            if label in seen:
                raise source.wrong("nodes", "every node once", f"node {label} twice")
            seen.add(label)
            place = (contact.labels.reshape(len(gap), -1) == label).any(axis=1)
            if not place.any():
                raise table.wrong("gap", "contact nodes", f"node {label}")
            gap[place] = value
    source.done()
    return gap


def _array(table: TomlTable, key: str, kind: type, shape: tuple[int | None, ...]) -> NDArray[Any] | None:
    values = table.array(key, kind, shape, required=False)
    return None if values is None else np.array(values, dtype=np.intp if kind is int else float)


def _areas(
    table: TomlTable,
    mesh: Mesh,
    first: IntArray,
    between: IntArray,
    coupling: SurfaceCoupling | None,
    named: str | None,
) -> FloatArray | None:
    """Areas of the nodes of the first body, where the model has their faces."""
    given, thickness = table.has("thickness"), table.number("thickness", 1.0) or 0.0
    if not thickness > 0 or (mesh.axisymmetric and given):
        expected = "a number > 0 (none of an axisymmetric model, whose areas are 2 pi r times a length)"
        raise table.wrong("thickness", expected, f"{thickness:g}")
    if not mesh.elements:
        return None
    if coupling is not None:
        return coupling.area * (thickness if coupling.normals.shape[1] == 2 else 1.0)
    area = mesh.node_areas(first, named, thickness)
    return None if area is None else surface_mesh.hat_areas(area, first, between)


def _placed(contact: ContactSection, places: FloatArray, mesh: Mesh) -> ContactSection:
    """The nodes in order along the contact, where sets named them, with their positions."""
    across = np.cross(*np.eye(3)[[axis - 1 for axis in contact.axes]])
    tangents, edges = np.cross(contact.unit_normals, across), mesh.edges(contact.first, contact.surface)
    found = strips(places, tangents, edges)
    x, mean = contact.x, tangents.mean(axis=0)
    if x is None and (np.abs(tangents - mean) <= SIX_DIGITS).all():
        x = places @ mean
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


def taken_friction(root: TomlTable, *, required: bool = True) -> Friction | None:
    """The key ``friction``, before the contact nodes are known; None where it is absent and not required."""
    expected = "a number, a list of numbers, or a table with a number for each node set"
    value = root.take("friction", expected, required=required, fits=_are_coefficients)
    if isinstance(value, dict):
        return {name: float(item) for name, item in value.items()}
    return None if value is None else np.array(value, dtype=float)


def _are_coefficients(value: Any) -> bool:
    each = list(value.values()) if isinstance(value, dict) else value
    return is_number(value) or (isinstance(each, list) and bool(each) and all(map(is_number, each)))
