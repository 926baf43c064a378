"""The neighbourhood of the nodes of a contact: its strips or patches, and their edges.

A patch is a part of the contact in space along which the normal nowhere turns by more than 40° from one face
to the next; where no faces are known, from one node to its neighbours.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray, IntArray, Mask
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.places import NONE
from shakedown.joint.problem import Problem

TURN = float(np.cos(np.radians(40.0)))  # least cosine between neighbouring normals of one patch
GAP = 2.5  # a distance this many times the usual one separates two patches
NEIGHBOURS = 8  # nearest neighbours considered per node


def flanks(x: FloatArray) -> Iterator[IntArray]:
    """Nodes in order of position, cut where two neighbours are far apart: no line joins two flanks.

    Examples
    --------
    >>> [nodes.tolist() for nodes in flanks(np.array([0.0, 1.0, 2.0, 9.0, 11.0, 10.0]))]
    [[0, 1, 2], [3, 5, 4]]
    """
    order = np.argsort(x, kind="stable")
    steps = np.diff(x[order])
    if len(steps) < 3:  # too few to know the usual distance
        yield order
        return
    beside = np.maximum(np.append(0.0, steps[:-1]), np.append(steps[1:], 0.0))
    far = (steps > GAP * beside) & (steps > GAP * np.median(steps))
    yield from np.split(order, np.flatnonzero(far) + 1)


@dataclass(frozen=True, eq=False)
class Surface:
    """The nodes of a contact in its surface.

    Attributes
    ----------
    points : (n, 1), (n, 2) or (n, 3)
        Positions of the nodes: along a contact in the plane, in one plane, or in space [length].
    normals : (n, 3), optional
        Normals of the surface at the nodes: nodes that face each other belong to two patches.
    parts
        The nodes of every strip, in order, or of every patch.
    edge : (n,)
        Whether a node is an end of its strip, or at the rim of its patch.
    rings
        Which strips have no ends: (first to last step) lengths to close them, else 0 [length].
    """

    points: FloatArray
    normals: FloatArray | None
    parts: tuple[IntArray, ...]
    edge: Mask
    rings: tuple[float, ...] = ()

    @property
    def in_plane(self) -> bool:
        """Whether it is a line, of a joint in the plane."""
        return self.points.shape[1] == 1

    @cached_property
    def spacing(self) -> FloatArray:
        """The distance of every node from the nearest one of its part, (n,); inf where it is alone."""
        from scipy.spatial import KDTree

        found = np.full(len(self.points), np.inf)
        for part in self.parts:
            if len(part) > 1:
                found[part] = KDTree(self.points[part]).query(self.points[part], k=2)[0][:, 1]
        for part, closing in zip(self.parts, self.rings, strict=False):  # patches in space have no rings
            if closing:
                found[part[[0, -1]]] = np.minimum(found[part[[0, -1]]], closing)
        return found


@once_per_problem
def surface_of(problem: Problem) -> Surface | None:
    """The surface of a joint; None where it does not know where its nodes are, or two are at one place."""
    points = _points(problem)
    if points is None:
        return None
    return (_line if points.shape[1] == 1 else _patches)(problem, points)


def element_count(problem: Problem) -> float:
    """How many elements a contact has, triangles counted half; halved in length they are 2^d times as many.

    In space the faces; without them n − b/2 − 1 for every patch, b its nodes at the rim (Euler's formula, for
    patches without holes). In the plane one less than nodes for every strip, as many as nodes around a
    ring. Without positions (n^(1/d) − 1)^d, as for a square.

    Examples
    --------
    >>> import shakedown
    >>> element_count(shakedown.example("block-9")), element_count(shakedown.example("block-3x3"))
    (8.0, 4.0)
    """
    if problem.faces is not None:
        return float((np.sum(problem.faces != NONE, axis=1) - 2).sum() / 2)
    surface, d = surface_of(problem), problem.directions
    if surface is None:
        return float((problem.n ** (1 / d) - 1) ** d)
    return float(problem.n - surface.edge.sum() / 2 - (0 if surface.in_plane else len(surface.parts)))


def _points(problem: Problem) -> FloatArray | None:
    if problem.directions == 1:
        return None if problem.x is None else problem.x[:, None]
    if problem.coordinates is not None:
        return problem.coordinates
    return None if problem.x is None or problem.x.ndim < 2 else problem.x


def _line(problem: Problem, points: FloatArray) -> Surface | None:
    parts, edge = tuple(flanks(points[:, 0])), np.zeros(problem.n, dtype=np.bool_)
    rings = []
    for part in parts:
        rings.append(_closing(problem, part))
        if not rings[-1]:
            edge[part[[0, -1]]] = True
    found = Surface(points, None, parts, edge, tuple(rings))
    return found if (found.spacing > 0).all() else None


def _closing(problem: Problem, part: IntArray) -> float:
    """The step from the last node of a ring to its first; 0 where the strip has ends.

    Areas tell a ring from an arc whose ends are near: they include that step, or do not.
    """
    if problem.coordinates is None or len(part) < NEIGHBOURS:
        return 0.0
    place = problem.coordinates[part]
    steps = np.linalg.norm(place - np.roll(place, 1, axis=0), axis=1)
    if not 0 < steps[0] <= GAP * steps[1:].max():
        return 0.0
    if problem.node_area is not None:
        area, length = problem.node_area[part], (steps + np.roll(steps, -1)) / 2
        ends, beside = [0, -1], [1, 2, -3, -2]
        thickness = area[beside].sum() / length[beside].sum()
        if area[ends].sum() < thickness * (length[ends].sum() - steps[0] / 4):
            return 0.0
    return float(steps[0])


def _patches(problem: Problem, points: FloatArray) -> Surface | None:
    places = points if points.shape[1] == 3 else np.column_stack([points, np.zeros(len(points))])
    owner = np.full(len(points), -1)
    for k, (nodes, _) in enumerate(contact_patches(places, problem.normal, problem.faces)):
        owner[nodes[owner[nodes] < 0]] = k  # at an edge between two patches of the larger one
    parts = tuple(np.flatnonzero(owner == k) for k in np.unique(owner))
    bare = Surface(points, problem.normal, parts, np.zeros(len(points), dtype=np.bool_))
    if not (bare.spacing > 0).all():
        return None
    if problem.faces is None:
        return replace(bare, edge=_rim(bare))
    bare.edge[
        [node for side, faces in sides_of(problem.faces).items() if len(faces) == 1 for node in side]
    ] = True
    return bare


def _rim(surface: Surface) -> Mask:
    """Whether nodes have a wide sector without other nodes of their patch, (n,)."""
    edge = np.ones(len(surface.points), dtype=np.bool_)
    for part in surface.parts:
        for node in part:
            beside, near = around(surface, int(node), part[part != node])
            if len(beside) > 2:
                near = near[cell_weights(near) > 0]
                size = np.linalg.norm(near, axis=1)
                # times the usual distance of a neighbour: nodes farther away lie across a hole
                near = near[size <= 1.9 * np.median(size)]
            angles = np.sort(np.arctan2(near[:, 1], near[:, 0]))
            gaps = np.diff(np.append(angles, angles[:1] + 2 * np.pi))
            # width of a sector without neighbours from which on a node is at an edge
            edge[node] = len(near) < 3 or gaps.max() > 0.7 * np.pi
    return edge


def around(surface: Surface, node: int, among: IntArray) -> tuple[IntArray, FloatArray]:
    """The nearest of some nodes, and where they are from a node in its tangent plane, as far as in space.

    (k,) and (k, 2) [length].
    """
    offsets = surface.points[among] - surface.points[node]
    size = np.linalg.norm(offsets, axis=1)
    # nearest nodes among which the neighbours of a node are sought
    nearest = np.argsort(size, kind="stable")[: 2 * NEIGHBOURS]
    offsets, size = offsets[nearest], size[nearest]
    if offsets.shape[1] == 3:
        normal = None if surface.normals is None else surface.normals[node]
        offsets = _unrolled(offsets, size, normal)
    return among[nearest], offsets


def _unrolled(offsets: FloatArray, size: FloatArray, normal: FloatArray | None) -> FloatArray:
    """Offsets of a curved surface in its tangent plane, (k, 2), their lengths kept."""
    if normal is None:
        normal = np.linalg.svd(np.vstack([offsets, np.zeros((3, 3))]), full_matrices=False)[2][2]
    first = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    flat = offsets @ np.column_stack([first, np.cross(normal, first)])
    length = np.linalg.norm(flat, axis=1)
    return np.asarray(flat * np.divide(size, length, out=np.ones_like(size), where=length > 0)[:, None])


def cell_weights(offsets: FloatArray) -> FloatArray:
    """Weights of points (k, 2) about the origin: the side between their cells and its, over the distance.

    They are not negative and sum to one, are zero of points that are no neighbours, and their mean
    place is the origin where it lies between them (Laplace's interpolation between natural neighbours).

    Examples
    --------
    >>> cell_weights(np.array([[1.0, 1], [-1, 1], [-1, -1], [1, -1], [3, 0]])).round(6).tolist()
    [0.25, 0.25, 0.25, 0.25, 0.0]
    """
    from scipy.spatial import Voronoi

    size = np.linalg.norm(offsets, axis=1)
    weights, unit = np.zeros(len(offsets)), float(size.min())
    turn = np.linspace(0.0, 2.0 * np.pi, 13)[:-1] + 0.1  # not aligned with a grid
    # spacings: distance of auxiliary points that close the cells of edge nodes
    ghosts = 40.0 * size.max() * np.column_stack([np.cos(turn), np.sin(turn)])
    cells = Voronoi(np.vstack([np.zeros(2), offsets, ghosts]) / unit)
    for (one, other), sides in zip(cells.ridge_points, cells.ridge_vertices, strict=True):
        point = int(one + other)  # the origin is number 0
        if 0 in (one, other) and 0 < point <= len(offsets) and -1 not in sides:
            side = np.linalg.norm(np.subtract(*cells.vertices[sides]))
            weights[point - 1] = side * unit / size[point - 1]
    weights[weights < 1e-9 * weights.max()] = 0.0  # round-off of four points on a circle
    return np.asarray(weights / weights.sum())


def contact_patches(
    places: FloatArray, normals: FloatArray | None, faces: NDArray[np.integer] | None
) -> list[tuple[IntArray, IntArray | None]]:
    """Nodes of each patch, and its faces between them, the one with the most nodes first.

    Parameters
    ----------
    places, normals : (n, 3)
        Positions and normals of the nodes; normals where they are known.
    faces : (m, 4), optional
        Corners of the faces, numbers of nodes; −1 as the last of a triangle. A node at the edge between two
        patches is one of both.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]])
    >>> both = np.concatenate([corners, corners + [7.0, 0.0, 0.0]])
    >>> [nodes.tolist() for nodes, _ in contact_patches(both, None, None)]
    [[0, 1, 2, 3], [4, 5, 6, 7]]
    """
    parts: list[tuple[IntArray, IntArray | None]]
    if faces is None:
        parts = [(nodes, None) for nodes in _without_faces(places, normals)]
    else:
        parts = list(_with_faces(places, normals, faces.astype(np.intp)))
    return sorted(parts, key=lambda part: (-len(part[0]), part[0][0]))


def _with_faces(
    places: FloatArray, normals: FloatArray | None, faces: IntArray
) -> Iterator[tuple[IntArray, IntArray | None]]:
    """Nodes and faces of each patch; a node without faces belongs to the patch of the nearest one."""
    from scipy.spatial import KDTree

    across = normals_of(places, normals, faces)
    across = across / np.linalg.norm(across, axis=1).clip(np.finfo(float).tiny)[:, None]
    owner = _components(len(faces), *_beside(faces, across, either_side=normals is None))
    corners = np.where(faces < 0, faces[:, :1], faces)
    covered = np.unique(corners)
    bare = np.setdiff1d(np.arange(len(places)), covered)
    nearest = covered[KDTree(places[covered]).query(places[bare])[1]] if len(bare) else bare
    for number in np.unique(owner):
        own = faces[owner == number]
        nodes = np.unique(corners[owner == number])
        place = np.full(len(places) + 1, -1)
        nodes = np.concatenate([nodes, bare[np.isin(nearest, nodes)]])
        place[nodes] = np.arange(len(nodes))
        yield nodes, place[own]


def _beside(faces: IntArray, across: FloatArray, *, either_side: bool) -> tuple[IntArray, IntArray]:
    """Pairs of faces with a common side at which the normal turns little."""
    pairs = [(of[0], other) for of in sides_of(faces).values() for other in of[1:]]
    first, second = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
    cosine = (across[first] * across[second]).sum(axis=1)
    gentle = (np.abs(cosine) if either_side else cosine) > TURN
    return first[gentle], second[gentle]


def sides_of(faces: IntArray) -> dict[tuple[int, int], list[int]]:
    """The faces that every side, two nodes in increasing order, belongs to."""
    sides: dict[tuple[int, int], list[int]] = {}
    for k, face in enumerate(faces.tolist()):
        ring = [node for node in face if node >= 0]
        for one, other in zip(ring, [*ring[1:], ring[0]], strict=True):
            sides.setdefault((min(one, other), max(one, other)), []).append(k)
    return sides


def normals_of(places: FloatArray, normals: FloatArray | None, faces: IntArray) -> FloatArray:
    """Normals of faces, twice as long as their areas, on the side of those of their nodes where known."""
    corners = np.where(faces < 0, faces[:, :1], faces)  # a triangle has its first corner twice
    at = places[corners]
    across = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    if normals is not None:
        across[(across * normals[corners].sum(axis=1)).sum(axis=1) < 0] *= -1.0
    return np.asarray(across)


def _without_faces(places: FloatArray, normals: FloatArray | None) -> list[IntArray]:
    """Nodes of each patch: near neighbours with similar normals."""
    from scipy.spatial import KDTree

    n = len(places)
    if n <= 2:
        return [np.arange(n)]
    count = min(NEIGHBOURS, n - 1)
    apart, near = KDTree(places).query(places, k=count + 1)
    usual = apart[:, min(3, count)]
    first, second = np.repeat(np.arange(n), count), near[:, 1:].ravel()
    linked = apart[:, 1:].ravel() <= GAP * np.minimum(usual[first], usual[second])
    if normals is not None:
        linked &= (normals[first] * normals[second]).sum(axis=1) > TURN
    owner = _components(n, first[linked], second[linked])
    return [np.flatnonzero(owner == number) for number in np.unique(owner)]


def _components(count: int, first: IntArray, second: IntArray) -> IntArray:
    """The component of each item, given pairs that link them."""
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    graph = sparse.coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.intp)
