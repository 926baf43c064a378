"""Two joints that friction holds together, as parts of CalculiX decks.

- *double lap*: a free plate between two plates that are clamped at one end and pressed
  onto it; it is pulled to and fro. Plane strain.
- *shrink fit*: a hub that cools down on a hollow shaft and is pushed to and fro along it.
  Axisymmetric; CalculiX writes the matrix of a wedge of 2° and takes forces on the whole ring.

Bodies touch node on node along straight lines, so that node-to-surface contact with small
sliding acts between the very pairs of the problem: both have the same unknowns and the same
stiffness, and differ by the penalties and, in the ring, by 2e-4: its wedge has flat faces. The
loads are so small that the surfaces do not turn; what matters is their ratio.
"""

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray

Labels = NDArray[np.intp]
Values = dict[tuple[int, int], float]  # {(node, direction): value}

YOUNG, POISSON, FRICTION = 200e3, 0.3, 0.3
SIZE = 0.5  # of an element [mm]
PERIOD = (0.0, 1.0, 0.0, -1.0)  # factors of the varying load
EXPANSION, COOLING = 1e-5, -0.5  # of the hub [1/K], [K]
RADIUS = 2.0
WEDGES = 180.0  # of 2° in a ring
HELD = "HELD"


class Block(NamedTuple):
    """A rectangle of square elements, bottom row first."""

    nodes: Labels  # numbers, (rows + 1, columns + 1)
    elements: Labels  # numbers, (rows, columns)
    corner: tuple[float, float]  # the lower left one [length]

    def places(self) -> FloatArray:
        """Coordinates of the nodes, row by row, (k, 2)."""
        rows, columns = self.nodes.shape
        x, y = np.meshgrid(np.arange(columns), np.arange(rows))
        return SIZE * np.column_stack([x.ravel(), y.ravel()]) + self.corner

    def node_lines(self) -> Iterator[str]:
        for node, (x, y) in zip(self.nodes.ravel(), self.places(), strict=True):
            yield f"{node}, {x:.10g}, {y:.10g}"

    def element_lines(self) -> Iterator[str]:
        lower, upper = self.nodes[:-1], self.nodes[1:]
        corners = np.stack([lower[:, :-1], lower[:, 1:], upper[:, 1:], upper[:, :-1]], axis=-1)
        for element, four in zip(self.elements.ravel(), corners.reshape(-1, 4), strict=True):
            yield f"{element}, " + ", ".join(map(str, four))


def block(first: int, corner: tuple[float, float], columns: int, rows: int) -> Block:
    """A block whose nodes and elements are numbered from ``first`` on."""
    nodes = first + np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    return Block(nodes, first + np.arange(rows * columns).reshape(rows, columns), corner)


class Joint(NamedTuple):
    """A joint in two contact zones or one: the deck, the pairs, the loads."""

    model: tuple[str, ...]  # lines of the deck up to the supports
    faces: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]  # "element, face" of slaves, masters per zone
    pairs: Labels  # (n, 2): nodes of the free body and of the held ones
    normals: FloatArray  # (n, 2): into the free body
    places: FloatArray  # (n, 2): where the pairs are [length]
    area: FloatArray  # (n,): that each stands for [length²]
    assembly: tuple[str, ...]  # lines of the load that is brought on first and stays
    forces: Values  # the same as forces,
    shrinkage: Values  # and as displacements of bodies that are free to shrink
    moved: Values  # the load that goes to and fro, as forces at load factor 1
    wedges: float  # how many times the matrix is to be taken
    tangent: tuple[int, int]  # which of CalculiX's two tangential directions is in the plane, and its sense


def _each(nodes: Labels, direction: int, value: float) -> Values:
    return {(int(node), direction): value for node in nodes}


def _set_lines(name: str, nodes: Labels) -> list[str]:
    lines = [", ".join(map(str, nodes[k : k + 10])) for k in range(0, len(nodes), 10)]
    return [f"*NSET, NSET={name}", *lines]


def _model(kind: str, blocks: list[Block], sets: dict[str, Labels], held: str) -> list[str]:
    """Nodes, elements, sets, material and supports of a deck."""
    return [
        "*NODE, NSET=ALL",
        *(line for part in blocks for line in part.node_lines()),
        f"*ELEMENT, TYPE={kind}, ELSET=BODIES",
        *(line for part in blocks for line in part.element_lines()),
        *(line for name, nodes in sets.items() for line in _set_lines(name, nodes.ravel())),
        "*MATERIAL, NAME=STEEL", "*ELASTIC", f"{YOUNG}, {POISSON}",
        "*EXPANSION", f"{EXPANSION}", "*DENSITY", "7.85e-9",
        "*SOLID SECTION, ELSET=BODIES, MATERIAL=STEEL", "1.",
        "*INITIAL CONDITIONS, TYPE=TEMPERATURE", "ALL, 0.",
        "*BOUNDARY", held,
    ]  # fmt: skip


def _lengths(count: int) -> FloatArray:
    """What each of a row of nodes stands for [length]."""
    return SIZE * np.r_[0.5, np.ones(count - 2), 0.5]


def _faces(elements: Labels, face: str) -> tuple[str, ...]:
    return tuple(f"{element}, {face}" for element in elements)


def double_lap() -> Joint:
    """A free plate 8 × 2 between two plates 8 × 1 that are clamped 2 left of it and lap it over 6."""
    plate, above, below = (
        block(1, (0.0, -1.0), 16, 4),
        block(1001, (-2.0, 1.0), 16, 2),
        block(2001, (-2.0, -2.0), 16, 2),
    )
    lapped, beside = 13, 4  # nodes of each zone, elements left of it
    top, bottom = plate.nodes[-1, :lapped], plate.nodes[0, :lapped]
    sets = {
        HELD: np.concatenate([above.nodes[:, 0], below.nodes[:, 0]]),
        "ABOVE": above.nodes[-1, beside:],
        "BELOW": below.nodes[0, beside:],
    }
    x = SIZE * np.arange(lapped)
    return Joint(
        model=tuple(_model("CPE4", [plate, above, below], sets, f"{HELD}, 1, 2")),
        faces=(
            (_faces(plate.elements[-1, : lapped - 1], "S3"), _faces(above.elements[0, beside:], "S1")),
            (_faces(plate.elements[0, : lapped - 1], "S1"), _faces(below.elements[-1, beside:], "S3")),
        ),
        pairs=np.column_stack([np.r_[top, bottom], np.r_[above.nodes[0, beside:], below.nodes[-1, beside:]]]),
        normals=np.repeat([[0.0, -1.0], [0.0, 1.0]], lapped, axis=0),
        places=np.column_stack([np.tile(x, 2), np.repeat([1.0, -1.0], lapped)]),
        area=np.tile(_lengths(lapped), 2),
        assembly=("*CLOAD", "ABOVE, 2, -1.", "BELOW, 2, 1."),
        forces=_each(sets["ABOVE"], 2, -1.0) | _each(sets["BELOW"], 2, 1.0),
        shrinkage={},
        moved=_each(plate.nodes[:, -1], 1, 1.0),
        wedges=1.0,
        tangent=(1, 1),
    )


def shrink_fit() -> Joint:
    """A hub 2 < r < 3.5, 2 < z < 6 on a shaft 0.5 < r < 2, 0 < z < 8 that is held at z = 0."""
    shaft, hub = block(1, (0.5, 0.0), 3, 16), block(1001, (RADIUS, 2.0), 3, 8)
    under = slice(4, 13)
    sets = {HELD: shaft.nodes[0], "HUB": hub.nodes}
    count = len(hub.nodes)
    shrinkage = {
        (int(node), axis + 1): EXPANSION * COOLING * place[axis]
        for node, place in zip(hub.nodes.ravel(), hub.places(), strict=True)
        for axis in (0, 1)
    }
    return Joint(
        model=tuple(_model("CAX4", [shaft, hub], sets, f"{HELD}, 2, 2")),
        faces=((_faces(hub.elements[:, 0], "S4"), _faces(shaft.elements[4:12, -1], "S2")),),
        pairs=np.column_stack([hub.nodes[:, 0], shaft.nodes[under, -1]]),
        normals=np.tile([1.0, 0.0], (count, 1)),
        places=np.column_stack([np.full(count, RADIUS), 2.0 + SIZE * np.arange(count)]),
        area=2 * np.pi * RADIUS * _lengths(count),
        assembly=("*TEMPERATURE", f"HUB, {COOLING}"),
        forces={},
        shrinkage=shrinkage,
        moved=_each(hub.nodes[:, -1], 2, 1.0),
        wedges=WEDGES,
        tangent=(2, -1),
    )


JOINTS = {"double lap": double_lap, "shrink fit": shrink_fit}


@cache
def joint(name: str) -> Joint:
    return JOINTS[name]()
