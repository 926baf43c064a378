"""Surfaces of meshes: facets, shape functions, nodes tied to those of another surface."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

from shakedown.ground.constants import ITERATIONS, NEGLIGIBLE, ROUND_OFF, FloatArray, IntArray
from shakedown.ground.errors import ProblemError
from shakedown.joint.arguments import real_array
from shakedown.joint.places import split_face
from shakedown.joint.result import Result

CORNERS = {(2, 2): 2, (2, 3): 2, (3, 3): 3, (3, 6): 3, (3, 4): 4, (3, 8): 4, (3, 9): 4}  # by dimension, nodes
# u_middle = α (u_corner + u_corner) + (1 − 2 α) û_middle: ∫N̂ is then 2/15 and 1/5 of a triangle of six nodes,
# 1/20 and 1/5 of a quadrilateral of eight, where ∫N of the corners is 0 and −1/12
ALPHA = 0.2
CHANGED = {(3, 6), (3, 8)}
_GAUSS, _WEIGHT = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)]), np.array([5.0, 8.0, 5.0]) / 9
_POINTS = {  # local places and weights of integration points, by the number of corners
    2: (_GAUSS[:, None], _WEIGHT),
    3: (np.array([[1 / 6, 1 / 6], [2 / 3, 1 / 6], [1 / 6, 2 / 3]]), np.full(3, 1 / 6)),
    4: (np.array([(s, t) for t in _GAUSS for s in _GAUSS]), np.outer(_WEIGHT, _WEIGHT).ravel()),
}
_SIGNS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def shapes(kind: tuple[int, int], place: FloatArray) -> FloatArray:
    """Values of the functions of a facet, (…, k), at local places (…, 1) or (…, 2).

    Examples
    --------
    >>> shapes((3, 6), np.array([1 / 3, 1 / 3])).round(3).tolist()
    [-0.111, -0.111, -0.111, 0.444, 0.444, 0.444]
    """
    if kind[0] == 2:
        t = place[..., 0]
        if kind[1] == 2:
            return np.stack([(1 - t) / 2, (1 + t) / 2], axis=-1)
        return np.stack([t * (t - 1) / 2, t * (t + 1) / 2, 1 - t * t], axis=-1)
    if CORNERS[kind] == 3:
        corners = np.stack([1 - place[..., 0] - place[..., 1], place[..., 0], place[..., 1]], axis=-1)
        if kind[1] == 3:
            return corners
        middle = 4 * corners * np.roll(corners, -1, axis=-1)
        return np.concatenate([corners * (2 * corners - 1), middle], axis=-1)
    return _square(place, kind[1])


def changed_shapes(kind: tuple[int, int], place: FloatArray) -> FloatArray:
    """Shape functions in the changed basis, N̂ = N T, (…, k): their integrals are all positive."""
    if kind not in CHANGED:
        return shapes(kind, place)
    corners = CORNERS[kind]
    between = [(corners + k, k, (k + 1) % corners) for k in range(corners)]
    return np.asarray(shapes(kind, place) @ corner_basis(np.array(between), kind[1]).toarray())


def corner_basis(between: IntArray, size: int, *, inverse: bool = False) -> sparse.csr_array:
    """T with u = T û, (size, size), or T⁻¹.

    ``between`` (t, 3) has an unknown between two corners, and those of the corners; −1 is one that is not
    there.
    """
    own, mixed = (1 / (1 - 2 * ALPHA), -ALPHA / (1 - 2 * ALPHA)) if inverse else (1 - 2 * ALPHA, ALPHA)
    middle, corners = between[:, :1], between[:, 1:]
    diagonal = np.ones(size)
    diagonal[middle] = own
    there = corners >= 0
    where = np.broadcast_to(middle, corners.shape)[there], corners[there]
    parts = sparse.csr_array((np.full(there.sum(), mixed), where), shape=(size, size))
    return sparse.csr_array(sparse.diags_array(diagonal) + parts)


def local_places(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Local places (n, g, 1 or 2) of points (n, g, 1 or 2) on facets with corners (n, 2 to 4, 1 or 2)."""
    first = corners[:, :1]
    if corners.shape[1] == 2:
        return np.asarray((2 * points - first - corners[:, 1:]) / (corners[:, 1:] - first))
    if corners.shape[1] == 3:
        sides = (corners[:, 1:] - first).swapaxes(1, 2)[:, None]
        return np.asarray(np.linalg.solve(sides, (points - first)[..., None])[..., 0])
    along = np.zeros_like(points)
    size = np.ptp(corners, axis=1).max()
    for _ in range(ITERATIONS):
        sides = 1 + along[:, :, None, :] * _SIGNS
        left = points - np.einsum("ngc,ncd->ngd", 0.25 * sides[..., 0] * sides[..., 1], corners)
        slopes = 0.25 * np.stack([_SIGNS[:, 0] * sides[..., 1], _SIGNS[:, 1] * sides[..., 0]], axis=-1)
        jacobian = np.einsum("ngca,ncd->ngda", slopes, corners)
        along += np.linalg.solve(jacobian, left[..., None])[..., 0]
        if np.abs(left).max(initial=0.0) <= 4 * np.finfo(float).eps * size:
            break
    return along


def counter_clockwise(polygon: FloatArray) -> FloatArray:
    """Polygons (n, c, 2) with their corners in this order."""
    turned = cross(polygon[:, 1] - polygon[:, 0], polygon[:, -1] - polygon[:, 0]) < 0
    return np.where(turned[:, None, None], polygon[:, ::-1], polygon)


def clipped(polygon: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """The part of each polygon left of a line, with one corner more than before; corners may coincide."""
    after = np.roll(polygon, -1, axis=1)
    own, next_ = (cross((end - start)[:, None], corner - start[:, None]) for corner in (polygon, after))
    crossing = (own < 0) != (next_ < 0)
    share = np.where(crossing, own, 0.0) / np.where(crossing, own - next_, 1.0)
    cut = polygon + share[..., None] * (after - polygon)
    n, v = own.shape
    corners = np.stack([polygon, cut], axis=2).reshape(n, 2 * v, 2)
    kept = np.stack([own >= 0, crossing], axis=2).reshape(n, 2 * v)
    order = np.argsort(~kept, axis=1, kind="stable")[:, : v + 1]
    last = np.maximum(np.minimum(kept.sum(axis=1), v + 1) - 1, 0)
    order = np.where(
        np.arange(v + 1) <= last[:, None], order, np.take_along_axis(order, last[:, None], axis=1)
    )
    return np.take_along_axis(corners, order[..., None], axis=1)


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """a_x b_y − a_y b_x of vectors (…, 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _square(place: FloatArray, count: int) -> FloatArray:
    s, t = place[..., 0, None], place[..., 1, None]
    across, along = 1 + s * _SIGNS[:, 0], 1 + t * _SIGNS[:, 1]
    linear = 0.25 * across * along
    if count == 4:
        return linear
    bubble = [(1 - s * s) * (1 - t), (1 + s) * (1 - t * t), (1 - s * s) * (1 + t), (1 - s) * (1 - t * t)]
    middle = 0.5 * np.concatenate(bubble, axis=-1)
    if count == 9:  # each side function less its half of the middle one
        centre = (1 - s * s) * (1 - t * t)
        middle = middle - 0.5 * centre
        corners = linear - 0.5 * (middle + np.roll(middle, 1, axis=-1)) - 0.25 * centre
        return np.concatenate([corners, middle, centre], axis=-1)
    return np.concatenate([linear - 0.5 * (middle + np.roll(middle, 1, axis=-1)), middle], axis=-1)


@dataclass(frozen=True, eq=False, repr=False)
class ContactSurface(Result):
    """Nodes and facets of one side of a contact.

    Parameters
    ----------
    labels : (k,) int
        Labels of the nodes.
    places : (k, 2) or (k, 3)
        Where they are [length]. Facets of a plane model are edges.
    facets : sequence of F tuples of labels
        Corners in order, then the nodes between them, then one in the middle: 2 or 3 of an edge; 3, 6, 4, 8
        or 9 of a facet in space.
    inside : (F, 2) or (F, 3)
        A place inside the body behind every facet [length].

    Raises
    ------
    ProblemError
        If there is no facet, a facet is of another kind or has a node without a place, or has no area.
    """

    labels: IntArray | Any  # what NumPy can turn into arrays is accepted
    places: FloatArray | Any
    facets: Sequence[Any]
    inside: FloatArray | Any

    def __post_init__(self) -> None:
        labels = real_array("labels", self.labels)
        for name, value in (
            ("labels", labels.astype(np.intp)),
            ("places", real_array("places", self.places)),
            ("facets", [tuple(int(node) for node in facet) for facet in self.facets]),
            ("inside", real_array("inside", self.inside)),
        ):
            object.__setattr__(self, name, value)
        super().__post_init__()
        if not self.facets:
            raise ProblemError("surface: expected facets, found none")
        if labels.ndim != 1 or (labels % 1).any() or len(np.unique(labels)) < len(labels):
            raise ProblemError("labels: expected one whole number for each node, no two the same")
        for name, count in (("places", len(labels)), ("inside", len(self.facets))):
            if (shape := getattr(self, name).shape) not in [(count, 2), (count, 3)]:
                raise ProblemError(f"{name}: expected shape ({count}, 2) or ({count}, 3), found {shape}")
        if self.inside.shape[1] != self.dimension:
            raise ProblemError("inside: expected places of as many coordinates as the nodes have")
        known = set(self.labels.tolist())
        for facet in self.facets:
            if (self.dimension, len(facet)) not in CORNERS or not known.issuperset(facet):
                raise ProblemError(
                    f"surface: expected facets of 2 or 3 nodes in the plane, 3, 6, 4, 8 or 9 in space, all "
                    f"of them with places, found {facet} in {self.dimension} dimensions"
                )
        if not (self.areas > 0).all():
            flat = self.facets[int(np.argmin(self.areas))]
            raise ProblemError(f"surface: expected facets with an area, found none of {flat}")

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.places.shape[1])

    @cached_property
    def blocks(self) -> tuple[tuple[tuple[int, int], IntArray, IntArray], ...]:
        """By kinds of facets (dimension, count of nodes): positions of their nodes, (F, k); their numbers."""
        position = dict(zip(self.labels.tolist(), range(len(self.labels)), strict=True))
        found: dict[int, list[int]] = {}
        for number, facet in enumerate(self.facets):
            found.setdefault(len(facet), []).append(number)
        return tuple(
            (
                (self.dimension, count),
                np.array([[position[node] for node in self.facets[number]] for number in numbers]),
                np.array(numbers),
            )
            for count, numbers in sorted(found.items())
        )

    @cached_property
    def nodes(self) -> IntArray:
        """The nodes of every facet, (F, k), as positions in the labels; beyond its own their number."""
        found = np.full((len(self.facets), max(map(len, self.facets))), len(self.labels))
        for kind, nodes, numbers in self.blocks:
            found[numbers, : kind[1]] = nodes
        return found

    @cached_property
    def frames(self) -> FloatArray:
        """Middle, unit normal into the body and radius of every facet, (F, 2 d + 1)."""
        d, found = self.dimension, np.zeros((len(self.facets), 2 * self.dimension + 2))
        for kind, nodes, numbers in self.blocks:
            corners = self.places[nodes[:, : CORNERS[kind]]]
            middle = corners.mean(axis=1)
            if d == 2:
                along = corners[:, 1] - corners[:, 0]
                normal = np.column_stack([-along[:, 1], along[:, 0]])
            else:
                arms = corners - middle[:, None]
                normal = 0.5 * np.cross(arms, np.roll(arms, -1, axis=1)).sum(axis=1)
            area = np.linalg.norm(normal, axis=1)
            into = np.where(((self.inside[numbers] - middle) * normal).sum(axis=1) < 0, -1.0, 1.0)
            unit = normal * (into / np.maximum(area, np.finfo(float).tiny))[:, None]
            radius = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
            found[numbers] = np.column_stack([middle, unit, radius, area])
        return found

    @property
    def middles(self) -> FloatArray:
        """Middle of every facet, (F, d) [length]."""
        return self.frames[:, : self.dimension]

    @property
    def normals(self) -> FloatArray:
        """Unit normals into the body, (F, d)."""
        return self.frames[:, self.dimension : 2 * self.dimension]

    @property
    def radii(self) -> FloatArray:
        """Distance of every facet's middle from its farthest corner, (F,) [length]."""
        return self.frames[:, -2]

    @property
    def areas(self) -> FloatArray:
        """Areas (in the plane lengths) of the facets, their sides taken as straight, (F,)."""
        return self.frames[:, -1]

    @property
    def nodal_normals(self) -> FloatArray:
        """Unit normals into the body at all nodes, (k, d): the means of their facets, weighted by area."""
        total = np.zeros((len(self.labels) + 1, self.dimension))
        np.add.at(total, self.nodes, (self.areas[:, None] * self.normals)[:, None, :])
        return total[:-1] / np.maximum(np.linalg.norm(total[:-1], axis=1), np.finfo(float).tiny)[:, None]

    def node_areas(self, *, revolved: bool = False) -> FloatArray:
        """∫ N_j dA of every node, (k,): what a unit pressure gives it as nodal force [length²].

        The sides are taken as straight. Of a facet with nodes on its sides the corners get less than the
        others: 1/6 and 2/3 of an edge, nothing and 1/3 of a triangle, −1/12 and 1/3 of a quadrilateral of
        eight nodes. Edges count per thickness; where they revolve about the axis x = 0, 2 π r per length.

        Examples
        --------
        >>> edge = ContactSurface([1, 2, 3], [[0, 0], [6, 0], [3, 0]], [(1, 2, 3)], [[3, 1]])
        >>> edge.node_areas().round(12).tolist()
        [1.0, 1.0, 4.0]
        """
        total = np.zeros(len(self.labels))
        for kind, nodes, _ in self.blocks:
            straight = (kind[0], CORNERS[kind])  # linear along each local direction: differences are slopes
            corners = self.places[nodes[:, : straight[1]]]
            places, weight = _POINTS[straight[1]]
            sides = [
                0.5 * (shapes(straight, places + step) - shapes(straight, places - step)) @ corners
                for step in np.eye(places.shape[1])
            ]
            stretch = sides[0] if kind[0] == 2 else np.cross(sides[0], sides[1])
            weight = weight * np.linalg.norm(stretch, axis=2)
            if revolved:
                weight = weight * 2 * np.pi * (corners[..., 0] @ shapes(straight, places).T)
            np.add.at(total, nodes, weight @ shapes(kind, places))
        return total

    @property
    def size(self) -> float:
        """Median size of the facets [length]."""
        return float(np.median(self.areas ** (1.0 / (self.dimension - 1))))

    def split(self) -> list[tuple[int, ...]]:
        """Facets in space, cut at nodes between their corners: four labels each, −1 last of a triangle."""
        place = dict(zip(self.labels.tolist(), self.places, strict=True))
        found: list[tuple[int, ...]] = []
        for facet in self.facets:
            count = CORNERS[3, len(facet)]
            found += split_face(facet[:count], facet[count:], np.array([place[node] for node in facet]))
        return found

    @cached_property
    def middle_nodes(self) -> IntArray:
        """(node between two corners, these corners) of facets whose basis is changed, (t, 3) labels."""
        found = [np.zeros((0, 3), dtype=np.intp)]
        for kind, nodes, _ in self.blocks:
            if kind in CHANGED:
                corners, between = np.split(self.labels[nodes], [CORNERS[kind]], axis=1)
                ends = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2)
                found.append(np.dstack([between[:, :, None], ends]).reshape(-1, 3))
        return np.unique(np.concatenate(found), axis=0)


@dataclass(frozen=True, eq=False, repr=False)
class NodeCoupling(Result):
    """u₁ = (slip, gap) + P u₂ of contact nodes by nodes of the second body.

    Attributes
    ----------
    labels : (n,)
        The contact nodes, all of the first body.
    master : (m,)
        Nodes of the second body that have a weight.
    P : (d n, d m)
        Weights, node by node and direction by direction; rigid motions of both bodies open no gap.
    normals : (n, d)
        Unit normals into the first body.
    middle_nodes : (t, 3)
        Nodes between two corners of quadratic facets whose basis is changed, and these two corners.
    partner : (n,)
        The node of the second body with the largest weight; where there is none the node itself.
    """

    labels: IntArray
    master: IntArray
    P: sparse.csr_array
    normals: FloatArray
    middle_nodes: IntArray
    partner: IntArray

    def opening(self, displacement: Callable[[IntArray], FloatArray]) -> FloatArray:
        """û₁ − P u₂, (n, d), of displacements (k, d) by the labels of k nodes."""
        every = np.union1d(self.labels, self.middle_nodes)
        changed = own_basis(every, self.middle_nodes, inverse=True) @ displacement(every)
        own = changed[np.searchsorted(every, self.labels)]
        if len(self.master):
            own -= (self.P @ displacement(self.master).ravel()).reshape(own.shape)
        return np.asarray(own)

    def on_master(self, forces: FloatArray) -> FloatArray:
        """Forces (m, d) on the nodes of the second body where the contact nodes carry (n, d): −Pᵀ r."""
        return -(self.P.T @ forces.ravel()).reshape(-1, self.normals.shape[1])


def coupling_of_nodes(labels: IntArray, normals: FloatArray, middle_nodes: IntArray) -> NodeCoupling:
    """The coupling of nodes (n,) to a rigid obstacle (P has no columns), or of pairs (n, 2), where P = 1.

    On quadratic faces, in the basis û = T⁻¹ u, the second body's nodes are changed as the first one's are.

    Examples
    --------
    >>> found = coupling_of_nodes(np.array([[1, 5]]), np.array([[0.0, 1.0]]), np.zeros((0, 3), int))
    >>> found.P.toarray().tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """
    first, *second = labels.reshape(len(labels), -1).T
    between = middle_nodes[np.isin(middle_nodes, first).all(axis=1)]
    n, d = normals.shape
    weights = own_basis(first, between, inverse=True) if second else sparse.csr_array((n, 0))
    return NodeCoupling(
        labels=first,
        master=second[0] if second else first[:0],
        P=sparse.csr_array(sparse.kron(weights, sparse.eye_array(d))),
        normals=normals,
        middle_nodes=between,
        partner=second[0] if second else first,
    )


def joined_couplings(parts: Sequence[NodeCoupling]) -> NodeCoupling:
    """The couplings of several patches as one; nodes of the second body may occur twice."""
    labels, master, normals, between, partner = (
        np.concatenate([getattr(part, key) for part in parts])
        for key in ("labels", "master", "normals", "middle_nodes", "partner")
    )
    P = sparse.csr_array(sparse.block_diag([part.P for part in parts]))
    return NodeCoupling(labels, master, P, normals, between, partner)


def own_basis(labels: IntArray, middle_nodes: IntArray, *, inverse: bool = False) -> sparse.csr_array:
    """T of nodes (n,) among themselves, or T⁻¹: of nodes between corners that are all among them, (t, 3)."""
    place = {label: k for k, label in enumerate(labels.tolist())}
    inside = middle_nodes[np.isin(middle_nodes, labels).all(axis=1)]
    between = np.array([[place[node] for node in three] for three in inside.tolist()], dtype=np.intp)
    return corner_basis(between.reshape(-1, 3), len(labels), inverse=inverse)


def hat_areas(area: FloatArray, labels: IntArray, middle_nodes: IntArray) -> FloatArray:
    """∫N̂ of nodes (n,) from their ∫N: nodes between corners pass on a part of theirs to the corners."""
    return np.asarray(own_basis(labels, middle_nodes).T @ area)


def rigid_rows(arms: FloatArray) -> FloatArray:
    """Displacements of places (…, d) by unit translations and unit turns, (…, d, r)."""
    d = arms.shape[-1]
    along = np.broadcast_to(np.eye(d), (*arms.shape, d))
    if d == 2:
        turned = np.stack([-arms[..., 1], arms[..., 0]], axis=-1)[..., None]
    else:
        turned = np.stack([np.cross(axis, arms) for axis in np.eye(3)], axis=-1)
    return np.concatenate([along, turned], axis=-1)


def exact_rotations(
    P: sparse.csr_array, near: FloatArray, slave: FloatArray, master: FloatArray
) -> FloatArray:
    """Blocks (nnz, d, d) in the places of the entries of P, corrected so that rigid motions open no gap.

    Row j of P, as blocks P_jk I, becomes P_jk I + E_j (Σ_k n_jk R_kᵀ R_k)⁺ R_kᵀ n_jk with E_j = R(x_j) −
    Σ_k P_jk R(x_k) and R the rigid motions about x_j: of all changes with P̃ R = R the one that is least in
    the norm Σ |ΔP_jk|² / n_jk. On flat faces E = 0 but for round-off. (P_jk itself is no measure of how near
    two nodes are: it may be zero for all neighbours but one.)

    Parameters
    ----------
    P : (n, m)
        Weights of nodes at ``master`` (m, d) for nodes at ``slave`` (n, d).
    near : (nnz,)
        n_jk > 0, how much two nodes have in common, in the places of the entries of P.

    Examples
    --------
    A node on a bow between two nodes on its chord:

    >>> P = sparse.csr_array([[0.5, 0.5]])
    >>> slave, master = np.array([[0.0, 0.1]]), np.array([[-1.0, 0.0], [1.0, 0.0]])
    >>> blocks = exact_rotations(P, P.data, slave, master)
    >>> turned = rigid_rows(master)[:, :, 2]
    >>> np.allclose(np.einsum("kab,kb->a", blocks, turned), rigid_rows(slave)[0, :, 2], atol=1e-15)
    True
    """
    d, n = slave.shape[1], P.shape[0]
    row = np.repeat(np.arange(n), np.diff(P.indptr))
    blocks = P.data[:, None, None] * np.eye(d)
    arms = master[P.indices] - slave[row]
    size = np.zeros(n)
    np.maximum.at(size, row, np.linalg.norm(arms, axis=1))
    R = rigid_rows(arms / np.maximum(size, np.finfo(float).tiny)[row, None])
    own = rigid_rows(np.zeros((n, d)))
    gram = np.zeros((n, R.shape[2], R.shape[2]))
    np.add.at(gram, row, np.einsum("k,kar,kas->krs", near, R, R, optimize=True))
    # a turn about a line through all nodes of a row moves none of them
    inverse = np.linalg.pinv(gram, rcond=NEGLIGIBLE, hermitian=True)
    for _ in range(2):  # the second round removes the round-off of the first
        left = own.copy()
        np.subtract.at(left, row, np.einsum("kab,kbr->kar", blocks, R))
        left[np.abs(left).max(axis=(1, 2)) <= ROUND_OFF] = 0.0
        change = np.einsum("kar,krs,kbs->kab", left[row], inverse[row], R, optimize=True)
        blocks = blocks + near[:, None, None] * change
    return blocks
