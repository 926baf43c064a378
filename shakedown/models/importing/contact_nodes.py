"""Contact nodes, or pairs of nodes of two bodies: by label, or by the sets that name them."""

from collections import Counter

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.models.importing.model_section import Model
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.toml_table import TomlTable

FARTHEST = 0.25  # of the spacing: beyond, another partner may be meant


def contact_nodes(table: TomlTable, model: Model) -> tuple[NDArray[np.intp], bool]:
    """Contact nodes (n,) or pairs (n, 2), and whether sets named them.

    Raises
    ------
    ProblemError
        If there are neither or both, a set is unknown, or the nodes of two sets do not lie on each other.
    """
    if table.has("nodes") == table.has("pairs"):
        found = "both" if table.has("nodes") else "neither"
        raise ProblemError(
            f"{table.where}: expected one of the keys 'nodes', 'pairs' and 'surfaces', found {found}"
        )
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
    far = np.flatnonzero(distance > FARTHEST * spacing)
    if far.size:
        k = int(far[0])
        raise ProblemError(
            f"{where}: expected nodes that lie on each other (nearer than {FARTHEST:g} of the spacing "
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
