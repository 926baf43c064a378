"""The patches of a contact in space.

A patch is a part of the contact along which the normal nowhere turns by more than 40° from one face to the
next; where no faces are known, from one node to its neighbours.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray, IntArray

TURN = float(np.cos(np.radians(40.0)))  # least cosine between neighbouring normals of one patch
GAP = 2.5  # a distance this many times the usual one separates two patches
NEIGHBOURS = 8  # nearest neighbours considered per node


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
    """Nodes of each patch: neighbours with similar normals; rows of nodes join their surroundings."""
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
    owner = owner[_joined(places, normals, owner, _widths(places, near[:, 1:], linked.reshape(n, -1)))]
    return [np.flatnonzero(owner == number) for number in np.unique(owner)]


def _joined(places: FloatArray, normals: FloatArray | None, owner: IntArray, widths: FloatArray) -> IntArray:
    """For every node a representative of its component, with rows of nodes joined to others."""
    from scipy.spatial import KDTree

    parts = [np.flatnonzero(owner == number) for number in range(owner.max() + 1)]
    # width over length of the neighbourhood of a node that belongs to a row
    rows = [np.median(widths[part]) < 1 / 3 for part in parts]
    looks = None if normals is None else np.array([normals[part].mean(axis=0) for part in parts])
    links: list[tuple[int, int]] = []
    tree = KDTree(places)
    for k, part in enumerate(parts):
        if len(parts) == 1 or not rows[k]:
            continue
        apart, near = tree.query(places[part], k=min(len(part) + NEIGHBOURS, len(places)))
        gaps = np.full(len(parts), np.inf)
        np.minimum.at(gaps, owner[near].ravel(), apart.ravel())
        gaps[k] = np.inf
        nearest = int(gaps.argmin())
        for other in np.flatnonzero(gaps <= GAP * gaps[nearest]).tolist():
            if looks is None or looks[other] @ looks[nearest] > TURN * np.prod(
                np.linalg.norm(looks[[other, nearest]], axis=1)
            ):
                links.append((k, other))
    first, second = np.array(links, dtype=np.intp).reshape(-1, 2).T
    whole = _components(len(parts), first, second)
    one_of = np.array([parts[int(np.argmax(whole == number))][0] for number in range(whole.max() + 1)])
    return np.asarray(one_of[whole[owner]])


def _widths(places: FloatArray, near: IntArray, linked: NDArray[np.bool_]) -> FloatArray:
    """Width over length of the neighbourhood of each node: almost zero for a node in a row."""
    arms = (places[near] - places[:, None]) * linked[:, :, None]
    sizes = np.linalg.svd(arms, compute_uv=False)
    return np.asarray(sizes[:, 1] / sizes[:, 0].clip(np.finfo(float).tiny))


def _components(count: int, first: IntArray, second: IntArray) -> IntArray:
    """The component of each item, given pairs that link them."""
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    graph = sparse.coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.intp)
