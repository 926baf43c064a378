"""``[contact]``: nodes or pairs, normals into the first body, axes of the plane, positions."""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shakedown.condensation.contact_frame import node_names
from shakedown.ground.errors import ProblemError, found_in
from shakedown.ground.float_array import FloatArray
from shakedown.importing.initial_gap import initial_gap
from shakedown.importing.model_section import Model
from shakedown.readers.input_files import InputFiles
from shakedown.readers.mesh import Mesh
from shakedown.readers.toml_table import Table

_NEAR = 0.25  # of the smallest spacing: a partner must lie nearer, so that no other can be meant


@dataclass(frozen=True, eq=False)
class ContactSection:
    """Where the contact is.

    Attributes
    ----------
    labels : (n,) or (n, 2)
        Contact nodes, or pairs (node of the first body, node of the second).
    normals : (n, 2)
        Into the first body.
    axes
        The two directions that span the plane.
    free_out_of_plane : bool
        Whether a third direction moves without friction.
    tied : (n,) or None
        The node tied to each contact node, for reactions.
    relative : bool
        Whether the rows of the contact nodes are displacements u₁ − u₂ of two bodies.
    x : (n,) or None
        Positions along the contact [length].
    coordinates : (n, 3) or None
        Where the nodes of the first body are [length].
    gap : () or (n,)
        Initial gap [length]; negative is interference.
    area : (n,) or None
        Area that each node stands for [length²], where the faces of the model give it.
    """

    labels: NDArray[np.intp]
    normals: FloatArray
    axes: tuple[int, int]
    free_out_of_plane: bool
    tied: NDArray[np.intp] | None
    relative: bool
    x: FloatArray | None
    coordinates: FloatArray | None
    gap: FloatArray
    area: FloatArray | None

    @property
    def first(self) -> NDArray[np.intp]:
        """Contact nodes of the first body, (n,)."""
        return self.labels if self.labels.ndim == 1 else self.labels[:, 0]

    @property
    def moved(self) -> NDArray[np.intp]:
        """Nodes that unit displacements move: those of the first body, then those of the second."""
        return self.labels.T.ravel()

    @property
    def names(self) -> tuple[str, ...]:
        """What each contact node is called: its label, or the labels of its pair."""
        return node_names(self.labels)


def contact_section(table: Table, model: Model, files: InputFiles) -> ContactSection:
    """Take the section from its table.

    Raises
    ------
    ProblemError
        If it is malformed, a set is unknown, nodes of two sets do not match, or
        the normals are neither given nor to be had from the model.
    """
    axes = table.array("axes", int, (2,), required=False) or [1, 2]
    if sorted({1, 2, 3} & set(axes)) != sorted(axes):
        raise ProblemError(f"{table.where}: key 'axes': expected two of 1, 2, 3, found {axes}")
    _check_axisymmetric(axes, model, table.where)
    labels, from_sets = _labels(table, model)
    first = labels if labels.ndim == 1 else labels[:, 0]
    gap = initial_gap(table, model, files)
    area = _areas(table, model, first)  # before the normals take 'surface'
    contact = ContactSection(
        labels,
        _normals(table, model, first, (axes[0], axes[1])),
        (axes[0], axes[1]),
        table.flag("free_out_of_plane"),
        _integers(table, "tied"),
        table.flag("relative"),
        _positions(table),
        None if model.mesh is None else model.mesh.at(first),
        gap.listed,
        area,
    )
    table.done()
    if contact.relative:
        _check_relative(contact, model, table.where)
    if model.mesh is not None:
        rotated = [label for label in contact.labels.ravel().tolist() if label in model.mesh.rotated]
        if rotated:
            raise ProblemError(
                f"{table.where}: expected contact nodes with directions x, y, z, found node {rotated[0]} in "
                "a *TRANSFORM"
            )
    placed = _placed(contact, table.where, sort=from_sets)
    normals = in_space(placed.normals, placed.axes)
    return replace(placed, gap=gap.at(placed.labels, normals, placed.x, model.mesh))


def in_space(vectors: FloatArray, axes: tuple[int, int]) -> FloatArray:
    """Vectors (n, 2) along two of the axes x, y, z as vectors (n, 3).

    Examples
    --------
    >>> in_space(np.array([[0.6, 0.8]]), (1, 3)).tolist()
    [[0.6, 0.0, 0.8]]
    """
    found = np.zeros((len(vectors), 3))
    found[:, [axes[0] - 1, axes[1] - 1]] = vectors
    return found


def _check_axisymmetric(axes: list[int], model: Model, where: str) -> None:
    """That an axisymmetric model lies where its elements expect it: radius x >= 0, axis y."""
    if not model.axisymmetric or model.mesh is None:
        return
    if axes != [1, 2]:
        raise ProblemError(
            f"{where}: key 'axes': expected [1, 2] (radius, axis) of an axisymmetric model, found {axes}"
        )
    k = int(np.argmin(model.mesh.coordinates[:, 0]))
    if model.mesh.coordinates[k, 0] < 0:
        raise ProblemError(
            f"{model.mesh.name}: expected radii x >= 0 of an axisymmetric model, found "
            f"{model.mesh.coordinates[k, 0]:g} at node {model.mesh.labels[k]}"
        )


def _integers(table: Table, key: str) -> NDArray[np.intp] | None:
    values = table.array(key, int, (None,), required=False)
    return None if values is None else np.array(values, dtype=np.intp)


def _positions(table: Table) -> FloatArray | None:
    values = table.array("x", float, (None,), required=False)
    return None if values is None else np.array(values, dtype=float)


def _labels(table: Table, model: Model) -> tuple[NDArray[np.intp], bool]:
    """Contact nodes or pairs, and whether sets named them."""
    if table.has("nodes") == table.has("pairs"):
        found = "both" if table.has("nodes") else "neither"
        raise ProblemError(f"{table.where}: expected one of the keys 'nodes' and 'pairs', found {found}")
    if table.has("nodes"):
        if isinstance(table.content["nodes"], str):
            return model.nodes(str(table.text("nodes")), f"{table.where}: key 'nodes'"), True
        return np.array(table.array("nodes", int, (None,)), dtype=np.intp), False
    value = table.content["pairs"]
    if isinstance(value, list) and len(value) == 2 and all(isinstance(name, str) for name in value):
        table.take("pairs", "two sets", required=True)
        where = f"{table.where}: key 'pairs'"
        first, second = (model.nodes(name, where) for name in value)
        assert model.mesh is not None  # or the sets were not found
        return _matched(model.mesh, first, second, where), True
    return np.array(table.array("pairs", int, (None, 2)), dtype=np.intp), False


def _matched(mesh: Mesh, first: NDArray[np.intp], second: NDArray[np.intp], where: str) -> NDArray[np.intp]:
    """Pairs of the nodes of two sets that lie on each other."""
    if len(first) != len(second):
        more, fewer = (first, second) if len(first) > len(second) else (second, first)
        alone = more[int(np.argmax(cKDTree(mesh.at(fewer)).query(mesh.at(more))[0]))]
        raise ProblemError(
            f"{where}: expected sets of equally many nodes, found {len(first)} and {len(second)}, node "
            f"{alone} farthest from a partner"
        )
    one, two = mesh.at(first), mesh.at(second)
    distance, partner = cKDTree(two).query(one)
    spacing = _spacing(one, mesh)
    far = np.flatnonzero(distance > _NEAR * spacing)
    if far.size:
        k = int(far[0])
        raise ProblemError(
            f"{where}: expected nodes that lie on each other (nearer than {_NEAR:g} of the spacing "
            f"{spacing:.3g}), "
            f"found node {first[k]} at a distance of {distance[k]:.3g} from the nearest; give pairs of labels"
        )
    (shared, count), *_ = Counter(partner.tolist()).most_common(1)
    if count > 1:
        rivals = first[partner == shared]
        raise ProblemError(
            f"{where}: expected one partner for each node, found node {second[shared]} nearest to both "
            f"{rivals[0]} and {rivals[1]}; give pairs of labels"
        )
    return np.column_stack([first, second[partner]])


def _spacing(places: FloatArray, mesh: Mesh) -> float:
    """The smallest distance between some nodes; of a single one, that to a node elsewhere in the model."""
    if len(places) > 1:
        return float(cKDTree(places).query(places, k=2)[0][:, 1].min())
    others = np.linalg.norm(mesh.coordinates - places[0], axis=1)
    return float(np.sort(others)[2]) if len(others) > 2 else 0.0  # beyond itself and its partner


def _normals(table: Table, model: Model, first: NDArray[np.intp], axes: tuple[int, int]) -> FloatArray:
    """Normals as given, or from the faces of the model."""
    normal = _vectors(table, "normal", False, axes)
    normals = _vectors(table, "normals", True, axes)
    surface = table.text("surface", required=False)
    named = {"normal": normal, "normals": normals, "surface": surface}
    given = [f"'{key}'" for key, value in named.items() if value is not None]
    if len(given) > 1:
        raise ProblemError(
            f"{table.where}: expected one of the keys 'normal', 'normals' and 'surface', found "
            f"{' and '.join(given)}"
        )
    if normal is not None or normals is not None:
        values = normals if normal is None else normal
        assert values is not None
        if values.ndim == 2 and len(values) != len(first):
            raise ProblemError(
                f"{table.where}: key 'normals': expected one for each of {len(first)} nodes, found "
                f"{len(values)}"
            )
        return np.broadcast_to(values, (len(first), 2)).copy()
    if model.mesh is None or not model.mesh.elements:
        raise ProblemError(
            f"{table.where}: expected one of 'normal' and 'normals', or [model] with a deck that has "
            "elements, found none"
        )
    with found_in(table.where):
        return model.mesh.normals(first, axes, surface)


def _vectors(table: Table, key: str, many: bool, axes: tuple[int, int]) -> FloatArray | None:
    """Components along the axes, or along x, y, z where that across their plane is zero."""
    value = table.content.get(key)
    first = value[0] if many and isinstance(value, list) and value else value
    width = 3 if isinstance(first, list) and len(first) == 3 else 2
    given = table.array(key, float, (None, width) if many else (width,), required=False)
    if given is None:
        return None
    vectors, (across,) = np.array(given, dtype=float), {1, 2, 3} - set(axes)
    if width == 2:
        return vectors
    wrong = vectors.reshape(-1, 3)[vectors.reshape(-1, 3)[:, across - 1] != 0]
    if len(wrong):
        raise ProblemError(
            f"{table.where}: key '{key}': expected 2 numbers, along directions {axes[0]} and {axes[1]}, or "
            f"3 of which that in direction {across} is 0, found {wrong[0].tolist()}; of a solid model, "
            f"'axes' names the two directions of slip and normal ([1, 3] for x and z), and the third one "
            "is held ([supports] fixed) or moves without friction (free_out_of_plane)"
        )
    return vectors[..., [axis - 1 for axis in axes]]


def _areas(table: Table, model: Model, first: NDArray[np.intp]) -> FloatArray | None:
    """Areas of the nodes of the first body, where the model has their faces."""
    given, thickness = table.has("thickness"), table.number("thickness", 1.0) or 0.0
    if not thickness > 0:
        raise ProblemError(f"{table.where}: key 'thickness': expected a number > 0, found {thickness:g}")
    if model.axisymmetric and given:
        raise ProblemError(
            f"{table.where}: key 'thickness': expected none, because the areas of an axisymmetric model are "
            f"2 pi r times a length, found {thickness:g}"
        )
    if model.mesh is None or not model.mesh.elements:
        return None
    surface = table.content.get("surface")
    return model.mesh.node_areas(first, surface if isinstance(surface, str) else None, thickness)


def _check_relative(contact: ContactSection, model: Model, where: str) -> None:
    """That the deck makes the rows of the contact nodes displacements of one body relative to another."""
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


def _placed(contact: ContactSection, where: str, *, sort: bool) -> ContactSection:
    """The nodes in order along the contact, where sets named them, with their positions."""
    if contact.coordinates is None:
        return contact
    plane = contact.coordinates[:, [contact.axes[0] - 1, contact.axes[1] - 1]]
    unit = contact.normals / np.maximum(np.hypot(*contact.normals.T), np.finfo(float).tiny)[:, None]
    tangent = np.array([unit[:, 1].mean(), -unit[:, 0].mean()])
    along = plane @ tangent
    order = np.argsort(along, kind="stable") if sort else np.arange(len(along))
    if sort and (contact.x is not None or contact.gap.ndim):
        key, given = ("gap", contact.gap) if contact.x is None else ("x", contact.x)
        raise ProblemError(
            f"{where}: key '{key}': expected no list beside sets of nodes, whose order it cannot know, found "
            f"one of length {len(given)}; name the nodes one by one"
        )
    size = np.hypot(*tangent)
    x = along[order] / size if contact.x is None and size > 0 else contact.x
    return replace(
        contact,
        labels=contact.labels[order],
        normals=contact.normals[order],
        x=x,
        coordinates=contact.coordinates[order],
        area=None if contact.area is None else contact.area[order],
    )
