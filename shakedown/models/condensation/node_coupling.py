"""The coupling of nodes of one body to the other: pairs or non-matching surfaces, exact for rigid motions."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, ROUND_OFF
from shakedown.joint.result import Result
from shakedown.models.condensation.facet_shapes import corner_basis

IntArray = NDArray[np.intp]


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
