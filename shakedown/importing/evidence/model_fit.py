"""Whether matrix, row map and deck are of one model: neighbours by both, rigid motions that must be free."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT
from shakedown.importing.evidence.bodies import coupled_nodes, rigid_motions
from shakedown.readers.mesh import Mesh
from shakedown.readers.stiffness import Stiffness

_FEWEST = (
    0.1  # of the nodes inside: a few may be held by springs, elements that have no shape here, equations
)
_RESISTS = 1e-4  # of the stiffness of a row: what a rigid motion of its neighbours may meet there


def model_doubts(stiffness: Stiffness, mesh: Mesh | None) -> tuple[str, ...]:
    """A warning where many nodes inside the mesh do not behave as those of the matrix.

    Inside are nodes whose elements have rows for all their directions, so that no support is near. Their
    rows couple nodes of one element only, and a rigid motion of these meets no resistance there.
    """
    if mesh is None or not mesh.elements or stiffness.superelement or mesh.relative or mesh.rotated:
        return ()
    labels, node, coupled = coupled_nodes(stiffness)
    touching = _neighbours(mesh, labels)
    inside = _inside(stiffness, mesh, labels, node, touching)
    if not inside.any():
        return ()
    strange = (coupled - coupled.multiply(touching)).sum(axis=1) > 0
    if (share := strange[inside].mean()) > _FEWEST:
        k = int(np.argmax(inside & strange))
        return (
            f"the matrix couples nodes that share no element of the deck ({100 * share:.2g} % of those "
            f"inside, first {labels[k]}): are matrix, row map and deck of one run?",
        )
    resisted = np.zeros(len(labels))
    np.maximum.at(resisted, node, _resistance(stiffness, mesh))
    if (share := (resisted[inside] > _RESISTS).mean()) > _FEWEST:
        k = int(np.argmax(np.where(inside, resisted, 0.0)))
        return (
            f"rigid motions of the deck's nodes meet resistance inside the model ({100 * share:.2g} % of the "
            f"nodes, most at {labels[k]}): are coordinates and matrix of one model?",
        )
    return ()


def _neighbours(mesh: Mesh, labels: NDArray[np.intp]) -> sparse.csr_array:
    """Which of the nodes share an element, (k, k)."""
    number = {label: k for k, label in enumerate(labels.tolist())}
    pairs = [
        (row, number[label])
        for row, (_, nodes) in enumerate(mesh.elements.values())
        for label in nodes
        if label in number
    ]
    row, column = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
    inside = sparse.coo_array(
        (np.ones(len(row)), (row, column)), shape=(len(mesh.elements), len(labels))
    ).tocsr()
    return ((inside.T @ inside) > 0).tocsr()


def _inside(
    stiffness: Stiffness,
    mesh: Mesh,
    labels: NDArray[np.intp],
    node: NDArray[np.intp],
    touching: sparse.csr_array,
) -> NDArray[np.bool_]:
    """Nodes of elements all of whose nodes have free rows for all their directions, (k,)."""
    dofs = stiffness.dofs
    free = (stiffness.K.diagonal() < DEFAULT.constrained_diagonal) & np.isin(dofs[:, 1], (1, 2, 3))
    rows = np.bincount(node[free], minlength=len(labels))
    whole = rows == rows.max()
    there = set(labels[whole].tolist())
    lacking = {k for _, nodes in mesh.elements.values() if not there.issuperset(nodes) for k in nodes}
    known = np.asarray(touching.diagonal() > 0)  # is the node of an element
    return known & whole & ~np.isin(labels, list(lacking))


def _resistance(stiffness: Stiffness, mesh: Mesh) -> FloatArray:
    """What a rigid motion of its neighbours meets in every row, by the terms of that row, (N,)."""
    dofs = stiffness.dofs
    place = dict(zip(mesh.labels.tolist(), mesh.coordinates, strict=True))
    xyz = np.array([place.get(label, np.zeros(3)) for label in dofs[:, 0].tolist()])
    axes = [2] if mesh.axisymmetric else sorted({1, 2, 3} & set(dofs[:, 1].tolist()))
    motions = rigid_motions(dofs, xyz - xyz.mean(axis=0), axes)
    terms = abs(stiffness.K) @ np.abs(motions)
    met = np.abs(stiffness.K @ motions)
    return np.asarray((met / np.maximum(terms, np.finfo(float).tiny)).max(axis=1))
