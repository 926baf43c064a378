"""Contact nodes, pairs of nodes of two bodies, or surfaces whose meshes need not match: by label or set."""

from collections import Counter

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shakedown.ground.errors import ProblemError, found_in
from shakedown.ground.float_array import FloatArray
from shakedown.models.condensation.surface_coupling import REACH, UNCOVERED, SurfaceCoupling, surface_coupling
from shakedown.models.condensation.surface_mesh import ContactSurface
from shakedown.models.importing.model_section import Model
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.text import quoted
from shakedown.models.readers.toml_table import TomlTable, shown

_BESIDE = ("reach", "uncovered", "finer")  # keys that stand beside 'surfaces' only
_ALONE = ("nodes", "pairs", "surface", "relative", "tied")  # keys that do not stand beside it


def contact_nodes(table: TomlTable, model: Model) -> tuple[NDArray[np.intp], bool]:
    """Contact nodes (n,) or pairs (n, 2), and whether sets named them.

    Raises
    ------
    ProblemError
        If there are neither or both, a set is unknown, or the nodes of two sets do not lie on each other.
    """
    if table.has("nodes") == table.has("pairs"):
        found = "both" if table.has("nodes") else "neither"
        raise table.unfit("one of the keys 'nodes', 'pairs' and 'surfaces'", found)
    if table.has("nodes"):
        if isinstance(table.content["nodes"], str):
            return model.nodes(str(table.text("nodes")), f"{table.where}: key 'nodes'"), True
        return np.array(table.array("nodes", int, (None,)), dtype=np.intp), False
    value = table.content["pairs"]
    if isinstance(value, list) and len(value) == 2 and all(isinstance(name, str) for name in value):
        table.take("pairs", "two sets", required=True)
        where = f"{table.where}: key 'pairs'"
        first, second = (model.nodes(name, where) for name in value)
        assert model.mesh is not None  # else the sets would not have been found
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
    far = np.flatnonzero(distance > REACH * spacing)
    if far.size:
        k = int(far[0])
        raise ProblemError(
            f"{where}: expected nodes that lie on each other (nearer than {REACH:g} of the spacing "
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
    """The smallest distance between nodes; for a single one that to a node elsewhere in the model."""
    if len(places) > 1:
        return float(cKDTree(places).query(places, k=2)[0][:, 1].min())
    others = np.linalg.norm(mesh.coordinates - places[0], axis=1)
    return float(np.sort(others)[2]) if len(others) > 2 else 0.0  # beyond itself and its partner


def coupled_surfaces(
    table: TomlTable, model: Model
) -> tuple[SurfaceCoupling, ContactSurface, str | None] | None:
    """The coupling, the slave surface and its name where it is an element surface; None without the key.

    Raises
    ------
    ProblemError
        If other keys contradict it, a surface is unknown or has no faces, or the two cannot be coupled.
    """
    table.known += ["surfaces", *_BESIDE, "nodes", "pairs"]  # named as expected where another is unknown
    if not table.has("surfaces"):
        for key in _BESIDE:
            if table.has(key):
                raise ProblemError(f"{table.where}: key '{key}': expected beside 'surfaces' only")
        return None
    others = [key for key in _ALONE if table.has(key)]
    if others:
        raise table.unfit(f"no key '{others[0]}' beside 'surfaces'", "both")
    names = table.content["surfaces"]
    if not (isinstance(names, list) and len(names) == 2 and all(isinstance(name, str) for name in names)):
        raise table.wrong("surfaces", "two names, of the first body and of the second", shown(names))
    table.take("surfaces", "two names", required=True)
    reach, uncovered = table.number("reach"), table.number("uncovered", UNCOVERED)
    finer = table.flag("finer")
    where = f"{table.where}: key 'surfaces'"
    if model.mesh is None or not model.mesh.elements:
        raise ProblemError(f"{where}: expected [model] with a deck that has elements, found none")
    slave, master = (_surface(model.mesh, name, where) for name in names)
    if slave.dimension != master.dimension:
        raise ProblemError(f"{where}: expected two plane bodies or two solid ones, found one of each")
    with found_in(where):
        found = surface_coupling(
            slave,
            master,
            reach=reach,
            uncovered=UNCOVERED if uncovered is None else uncovered,
            finer=finer,
            revolved=model.axisymmetric,
        )
    key = names[0].strip().upper()
    return found, slave, key if key in model.mesh.surfaces else None


def middle_nodes(mesh: Mesh | None, first: NDArray[np.intp], surface: object) -> NDArray[np.intp]:
    """Nodes between corners of quadratic faces of solids at the contact, and these corners, (t, 3).

    Of a surface where its name is given.
    """
    if mesh is None or not mesh.elements:
        return np.zeros((0, 3), dtype=np.intp)
    between = {
        (node, *sorted((facet.corners[k], facet.corners[(k + 1) % len(facet.corners)])))
        for facet in mesh.boundary(set(first.tolist()), surface if isinstance(surface, str) else None)
        if len(facet.between) == len(facet.corners) > 2
        for k, node in enumerate(facet.between)
    }
    return np.array(sorted(between), dtype=np.intp).reshape(-1, 3)


def _surface(mesh: Mesh, name: str, where: str) -> ContactSurface:
    """The faces of an element surface, or those that have all their corners in a node set."""
    with found_in(where):
        labels = mesh.nodes(name)
    key = name.strip().upper()
    facets = mesh.boundary(set(labels.tolist()), key if key in mesh.surfaces else None)
    if not facets:
        raise ProblemError(f"{where}: expected faces of elements in the set {quoted(name)}, found none")
    edges = {len(facet.corners) == 2 for facet in facets}
    if len(edges) > 1:
        raise ProblemError(
            f"{where}: expected faces of solids or edges of plane elements in {quoted(name)}, found both"
        )
    d = 2 if edges.pop() else 3
    used = np.array(sorted({node for facet in facets for node in facet.nodes}), dtype=np.intp)
    inside = [mesh.at(mesh.elements[facet.element][1]).mean(axis=0)[:d] for facet in facets]
    with found_in(f"{where}: {quoted(name)}"):
        return ContactSurface(used, mesh.at(used)[:, :d], [facet.nodes for facet in facets], np.array(inside))
