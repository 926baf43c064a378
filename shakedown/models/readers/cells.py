"""A mesh as other programs have it: points, blocks of cells of one kind, named sets of both."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.models.readers.mesh import CORNERS, Mesh

_KINDS = {  # as meshio calls them
    "tetrahedron": "tetra",
    "wedge": "wedge",
    "hexahedron": "hexahedron",
    "triangle": "triangle",
    "quadrilateral": "quad",
}
_FACETS = {2: "line", 3: "triangle", 4: "quad"}  # by the number of corners


class Cells(NamedTuple):
    """Points (k, 3), blocks (kind, points of every cell), sets of cells in every block, sets of points."""

    points: FloatArray
    cells: list[tuple[str, list[tuple[int, ...]]]]
    cell_sets: dict[str, list[NDArray[np.intp]]]
    point_sets: dict[str, NDArray[np.intp]]


def cells_of(mesh: Mesh) -> Cells:
    """Elements and the faces of element surfaces as cells; sets are called as the deck spells them.

    Examples
    --------
    >>> from numpy import arange, eye
    >>> elements = {7: ("triangle", (1, 2, 3))}
    >>> found = cells_of(Mesh("", arange(1, 4), eye(3), surfaces={"S": ((7, 1),)}, elements=elements))
    >>> found.cells, [own.tolist() for own in found.cell_sets["S"]]
    ([('triangle', [(0, 1, 2)]), ('line', [(0, 1)])], [[], [0]])
    """
    number = {label: k for k, label in enumerate(mesh.labels.tolist())}
    blocks: dict[str, list[tuple[int, ...]]] = {}
    members: dict[str, list[tuple[str, int]]] = {}  # kind, place in its block

    def add(kind: str, nodes: tuple[int, ...]) -> tuple[str, int]:
        blocks.setdefault(kind, []).append(tuple(number[node] for node in nodes))
        return kind, len(blocks[kind]) - 1

    place = {}
    for label, (shape, nodes) in mesh.elements.items():
        order = str(len(nodes)) if len(nodes) > CORNERS[shape] else ""
        place[label] = add(f"{_KINDS[shape]}{order}", nodes)
    for name, labels in mesh.element_sets.items():
        members[name] = [place[label] for label in labels.tolist() if label in place]
    for name in mesh.surfaces:
        facets = [facet.corners for facet in mesh.facets(name)]
        members[name] = [add(_FACETS[len(corners)], corners) for corners in facets]
    cell_sets = {
        mesh.spelled.get(name, name): [
            np.array([k for kind, k in own if kind == block], dtype=np.intp) for block in blocks
        ]
        for name, own in members.items()
    }
    point_sets = {
        mesh.spelled.get(name, name): np.array([number[label] for label in own.tolist()], dtype=np.intp)
        for name, own in mesh.node_sets.items()
    }
    return Cells(mesh.coordinates, list(blocks.items()), cell_sets, point_sets)
