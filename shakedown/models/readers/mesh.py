"""Nodes, node sets and element faces of a finite-element model; normals and areas of its boundary."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.constants import NEGLIGIBLE, THREE_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import ProblemError, found_in
from shakedown.joint.places import without_cancelled
from shakedown.models.condensation.surface_mesh import ContactSurface
from shakedown.models.readers.parsing import listed, number, quoted, unfit

Line = tuple[str, list[str]]  # where it stands in a deck, its fields


def axes_at(places: FloatArray, first: FloatArray, second: FloatArray, kind: str, name: str) -> FloatArray:
    """Three perpendicular axes at places (n, 3), one per row, (n, 3, 3).

    Parameters
    ----------
    first, second : (3,)
        Rectangular (``kind`` R): a vector along the first axis, and one in the plane of the first and the
        second axis. Cylindrical (C), radial, circumferential and axial: two points on the axis [length].
    name
        What the deck calls the system, with the file, for messages.

    Raises
    ------
    ProblemError
        If these do not say the axes, or a place lies on the axis of a cylinder.

    Examples
    --------
    >>> axes_at(np.array([[0.0, 2.0, 5.0]]), np.zeros(3), np.array([0.0, 0.0, 1.0]), "C", "pin").tolist()
    [[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]]
    """
    if kind == "R":
        third = np.cross(first, second)
        if not np.linalg.norm(third) > NEGLIGIBLE * np.linalg.norm(first) * np.linalg.norm(second):
            raise unfit(name, "two directions that span a plane", "others")
        axes = np.array([first, np.cross(third, first), third])
        return np.tile(axes / np.linalg.norm(axes, axis=1)[:, None], (len(places), 1, 1))
    axis = second - first
    if not (length := float(np.linalg.norm(axis))) > 0:
        raise unfit(name, "two points on the axis", "others")
    axis, arm = axis / length, places - first
    radial = arm - np.outer(arm @ axis, axis)
    radius = np.linalg.norm(radial, axis=1)
    if not (radius > NEGLIGIBLE * length).all():
        raise unfit(name, "nodes beside its axis", "others")
    radial = radial / radius[:, None]
    along = np.broadcast_to(axis, radial.shape)
    return np.stack([radial, np.cross(axis, radial), along], axis=1) + 0.0


Element = tuple[str, tuple[int, ...]]  # shape, node labels
Orientation = tuple[dict[str, str], list[Line]]  # parameters, data lines

# Corners of the faces, and edges that carry the midside nodes, as Abaqus, CalculiX and Nastran number them.
FACES: dict[str, tuple[tuple[int, ...], ...]] = {
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quadrilateral": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "tetrahedron": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "hexahedron": ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
}
_RING = {n: tuple((k, (k + 1) % n) for k in range(n)) for n in (3, 4)}
EDGES: dict[str, tuple[tuple[int, int], ...]] = {
    "triangle": _RING[3],
    "quadrilateral": _RING[4],
    "tetrahedron": (*_RING[3], (0, 3), (1, 3), (2, 3)),
    "wedge": (*_RING[3], (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    "hexahedron": (*_RING[4], (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
}
SOLIDS = ("tetrahedron", "wedge", "hexahedron")
CALCULIX, ABAQUS = "CalculiX", "Abaqus"  # codes that a deck may ask for a matrix
CORNERS = {"triangle": 3, "quadrilateral": 4, "tetrahedron": 4, "wedge": 6, "hexahedron": 8}


class Facet(NamedTuple):
    """A face of an element: its corners in order, and the nodes between them."""

    element: int
    corners: tuple[int, ...]
    between: tuple[int, ...]

    @property
    def nodes(self) -> tuple[int, ...]:
        """All nodes, corners first."""
        return self.corners + self.between


@dataclass(frozen=True, eq=False)
class Mesh:
    """What a deck or a list of nodes says about the model.

    Attributes
    ----------
    name : str
        The file, for messages.
    labels : (k,)
        Node labels, in the order of the file.
    coordinates : (k, 3)
        Where they are [length].
    node_sets : mapping
        Node labels of each set, by its name in upper case.
    surfaces : mapping
        (element, face from 1) of each element surface, by its name in upper case.
    elements : mapping
        Shape and nodes of every element.
    rotated : mapping
        The system (``*TRANSFORM``) of nodes whose directions are not x, y, z, as the deck has it.
    equations : bool
        Whether an ``*EQUATION`` ties some of its displacements to others.
    axisymmetric : bool
        Whether the elements are sections of a body of revolution about the axis x = 0.
    matrix_by : str
        The code whose keywords for writing a matrix the deck has: CalculiX, Abaqus or none.
    young : tuple of float
        Young's moduli of the isotropic materials; empty where there are others.
    sections : tuple of int
        Nodes of ``*PRE-TENSION SECTION``: their displacement in direction 1 is the shortening of the section.
    incompatible : int
        How many elements have incompatible modes (C3D8I), for which CalculiX makes three nodes each.
    unusable : mapping
        Why a surface is none of faces of solids or plane elements, by its name in upper case.
    element_sets : mapping
        Element labels of each set, by its name in upper case.
    frames : mapping
        For nodes whose output directions are not x, y, z (Nastran), the (3, 3) matrix R with u_own = R u.
    spelled : mapping
        The names of sets and surfaces as the deck writes them first, by those in upper case.
    """

    name: str
    labels: IntArray
    coordinates: FloatArray
    node_sets: dict[str, IntArray] = field(default_factory=dict)
    surfaces: Mapping[str, tuple[tuple[int, int], ...]] = field(default_factory=dict)
    elements: Mapping[int, Element] = field(default_factory=dict)
    rotated: Mapping[int, Orientation] = field(default_factory=dict)
    equations: bool = False
    axisymmetric: bool = False
    matrix_by: str = ""
    young: tuple[float, ...] = ()
    sections: tuple[int, ...] = ()
    incompatible: int = 0
    unusable: Mapping[str, str] = field(default_factory=dict)
    element_sets: Mapping[str, IntArray] = field(default_factory=dict)
    spelled: Mapping[str, str] = field(default_factory=dict)
    frames: Mapping[int, FloatArray] = field(default_factory=dict)

    @classmethod
    def of_nodes(cls, labels: IntArray, coordinates: FloatArray, name: str) -> "Mesh":
        """Nodes without elements; ``ProblemError`` if a label occurs twice."""
        repeated = [label for label, count in Counter(labels.tolist()).items() if count > 1]
        if repeated:
            raise unfit(name, "every node once", f"node {repeated[0]} twice")
        return cls(name, labels, coordinates)

    @classmethod
    def unknown(cls) -> "Mesh":
        """No nodes, where a configuration names no file of the model."""
        return cls("", np.zeros(0, dtype=np.intp), np.zeros((0, 3)))

    @property
    def is_known(self) -> bool:
        """Whether there are any nodes, as there are none where a configuration names no file."""
        return bool(self.labels.size)

    def nodes(self, name: str) -> IntArray:
        """Labels of a node set or of the nodes of a surface, in the order of the file.

        Raises
        ------
        ProblemError
            If there is no such set, or it is empty.
        """
        key = name.strip().upper()
        if key in self.unusable:
            raise ProblemError(self.unusable[key])
        if key in self.surfaces:
            found = dict.fromkeys(node for facet in self.facets(key) for node in facet.nodes)
            labels = np.array(list(found), dtype=np.intp)
        elif key in self.node_sets:
            labels = np.array(list(dict.fromkeys(self.node_sets[key].tolist())), dtype=np.intp)
        else:
            known = listed(sorted({*self.node_sets, *self.surfaces}))
            raise unfit(self.name, f"the node set or surface {quoted(name)}", known)
        if not len(labels):
            raise unfit(self.name, f"nodes in the set {quoted(name)}", "none")
        return labels

    def directions_of(self, labels: ArrayLike) -> FloatArray:
        """The directions 1, 2, 3 of nodes, one per row, (k, 3, 3): x, y, z unless the deck turns them.

        Raises
        ------
        ProblemError
            If a system is of another kind than rectangular or cylindrical, or a node lies on its axis.
        """
        wanted = np.asarray(labels).ravel()
        places, found = self.at(wanted), np.tile(np.eye(3), (len(wanted), 1, 1))
        for k, label in enumerate(wanted.tolist()):
            if label in self.rotated:
                parameters, data = self.rotated[label]
                kind = parameters.get("TYPE", "R").strip().upper()
                where = data[0][0] if data else self.name
                fields = [text for _, own in data for text in own if text]
                if kind not in ("R", "C") or len(fields) != 6:
                    found_there = quoted(", ".join([kind, *fields]))
                    raise unfit(where, "*TRANSFORM of TYPE=R or C with two points", found_there)
                first, second = np.array([number(text, where) for text in fields]).reshape(2, 3)
                found[k] = axes_at(places[k : k + 1], first, second, kind, f"{where}: *TRANSFORM")[0]
        return found

    def at(self, labels: ArrayLike) -> FloatArray:
        """Coordinates of nodes, (k, 3) [length]; ``ProblemError`` names the first that is not there."""
        index = self._index
        wanted = [int(label) for label in np.asarray(labels).ravel()]
        absent = [label for label in wanted if label not in index]
        if absent:
            raise unfit(self.name, f"node {absent[0]}", "no coordinates of it")
        return self.coordinates[[index[label] for label in wanted]]

    @cached_property
    def places(self) -> dict[int, list[float]]:
        """Where every node is, (x, y, z) [length], by its label."""
        return dict(zip(self.labels.tolist(), self.coordinates.tolist(), strict=True))

    @cached_property
    def _index(self) -> dict[int, int]:
        """The position of every node, by its label."""
        return {label: k for k, label in enumerate(self.labels.tolist())}

    def _facets_of(self, element: int) -> list[Facet]:
        """Every face of an element."""
        shape, nodes = self.elements[element]
        count = CORNERS[shape]
        middle = {
            frozenset(edge): nodes[count + k] for k, edge in enumerate(EDGES[shape]) if count + k < len(nodes)
        }
        found = []
        for corners in FACES[shape]:
            edges = map(frozenset, zip(corners, corners[1:] + corners[:1], strict=True))
            between = dict.fromkeys(middle[edge] for edge in edges if edge in middle)
            found.append(Facet(element, tuple(nodes[k] for k in corners), tuple(between)))
        return found

    def facets(self, surface: str) -> list[Facet]:
        """The faces of an element surface, called by its name in upper case."""
        return [self._facets_of(element)[face - 1] for element, face in self.surfaces[surface]]

    def normals(
        self,
        labels: ArrayLike,
        axes: tuple[int, ...] = (1, 2),
        surface: str | None = None,
        faces: FloatArray | None = None,
    ) -> FloatArray:
        """Unit normals into the body at nodes of its boundary, (n, 2) or (n, 3) [–].

        Each is the mean, weighted by area, of the faces of the boundary that
        have all their corners among the nodes.

        Parameters
        ----------
        labels : (n,)
            Nodes.
        axes
            The two directions that span the plane of the problem, or all three of one in space.
        surface
            Surface of the deck that the faces must belong to, where edges of the
            body make it unclear.
        faces : (n, 3), optional
            Mean normals of the faces, where these are known already.

        Raises
        ------
        ProblemError
            If no face of the boundary ends at a node, or a normal leaves the plane.
        """
        wanted = np.asarray(labels).ravel()
        units = self.face_normals(wanted, surface) if faces is None else faces
        bare = np.isnan(units[:, 0])
        if bare.any():
            raise ProblemError(
                f"{self.name}: expected a face of the boundary at contact node {wanted[np.argmax(bare)]} "
                "with all its corners among the contact nodes, found none; give 'normal' or 'normals'"
            )
        if len(axes) == 3:
            return units
        plane = units[:, [axes[0] - 1, axes[1] - 1]]
        if (np.abs(np.linalg.norm(plane, axis=1) - 1) > THREE_DIGITS).any():
            k = int(np.argmin(np.linalg.norm(plane, axis=1)))
            raise ProblemError(
                f"{self.name}: expected normals in the plane of directions {axes[0]} and {axes[1]}, found "
                f"({', '.join(f'{c:.3g}' for c in units[k])}) at node {wanted[k]}; give 'normal' or 'axes'"
            )
        return plane

    def surface(self, labels: ArrayLike, name: str | None = None) -> ContactSurface | None:
        """The faces of :meth:`boundary`, of solids where there are any, else edges; None without any."""
        found = self.boundary({int(label) for label in np.asarray(labels).ravel()}, name)
        solid = any(len(facet.corners) > 2 for facet in found)
        facets = [facet for facet in found if len(set(facet.corners)) >= (3 if solid else 2)]
        if not facets:
            return None
        used = np.array(sorted({node for facet in facets for node in facet.nodes}), dtype=np.intp)
        inside = [self.at(self.elements[facet.element][1]).mean(axis=0) for facet in facets]
        d = 3 if solid else 2
        nodes = [facet.nodes for facet in facets]
        with found_in(self.name):
            return ContactSurface(used, self.at(used)[:, :d], nodes, np.array(inside)[:, :d])

    def face_normals(self, labels: ArrayLike, surface: str | None = None) -> FloatArray:
        """Mean unit normals into the body of the faces of :meth:`normals`, (n, 3).

        NaN where a node has no such face.
        """
        wanted, faces = np.asarray(labels).ravel(), self.surface(labels, surface)
        units = np.full((len(wanted), 3), np.nan)
        if faces is not None:
            place = {label: k for k, label in enumerate(faces.labels.tolist())}
            there = np.array([place.get(label, -1) for label in wanted.tolist()])
            units[there >= 0] = 0.0
            units[there >= 0, : faces.dimension] = faces.nodal_normals[there[there >= 0]]
        units[~units.any(axis=1)] = np.nan  # faces that cancel each other
        return units

    def node_areas(
        self, labels: ArrayLike, surface: str | None = None, thickness: float = 1.0
    ) -> FloatArray | None:
        """Area of the boundary that each node stands for, (n,) [length²]: ∫ N_j dA.

        The faces are those of :meth:`normals`. Edges of plane elements count with the thickness, those of
        axisymmetric ones with the circumference, 2 π r.

        Returns
        -------
        (n,) or None
            None where a node has no such face, or a face has other nodes too. Corners of quadratic faces,
            where nodal forces say nothing of the pressure, have no positive area (0 at triangles).
        """
        wanted, faces = np.asarray(labels).ravel(), self.surface(labels, surface)
        if faces is None or set(wanted.tolist()) != set(faces.labels.tolist()):
            return None
        area = faces.node_areas(revolved=self.axisymmetric) * (thickness if faces.dimension == 2 else 1.0)
        return without_cancelled(area[np.searchsorted(faces.labels, wanted)])

    def edges(self, labels: ArrayLike, surface: str | None = None) -> list[list[int]] | None:
        """Positions among the nodes, for every edge of a plane element as :meth:`normals` takes them.

        None where there are none, or faces of solids.
        """
        wanted = {int(label): k for k, label in enumerate(np.asarray(labels).ravel())}
        faces = self.surface(labels, surface)
        if faces is None or faces.dimension == 3:
            return None
        return [[wanted[node] for node in facet if node in wanted] for facet in faces.facets]

    def faces_with(self, corners: set[frozenset[int]]) -> dict[frozenset[int], tuple[int, int]]:
        """(element, face from 1) of those of some sets of corners that are the corners of a face."""
        nodes, found = set().union(*corners), dict[frozenset[int], tuple[int, int]]()
        for element, (_, own) in self.elements.items():
            if not nodes.isdisjoint(own):
                for k, facet in enumerate(self._facets_of(element), start=1):
                    if (key := frozenset(facet.corners)) in corners:
                        found.setdefault(key, (element, k))
        return found

    def boundary(self, wanted: set[int], surface: str | None = None) -> list[Facet]:
        """The faces on the boundary whose corners are all wanted; or those of an element surface."""
        if surface is not None:
            key = surface.strip().upper()
            self.nodes(key)
            if key not in self.surfaces:
                raise unfit(self.name, f"the element surface {quoted(surface)}", "a node set")
            return self.facets(key)
        near = [element for element, (_, nodes) in self.elements.items() if not wanted.isdisjoint(nodes)]
        found = [
            facet
            for element in near
            for facet in self._facets_of(element)
            if wanted.issuperset(facet.corners)
        ]
        seen = Counter(frozenset(facet.corners) for facet in found)
        return [facet for facet in found if seen[frozenset(facet.corners)] == 1]
