"""The least correction of P with which rigid motions open no gap and slip nowhere, on curved faces too."""

import numpy as np
from scipy import sparse

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, ROUND_OFF

_ROUNDS = 2  # the second one takes away what round-off left of the first


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
    """Blocks (nnz, d, d) in the places of the entries of P that move rigid bodies as they are.

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
    # nodes of a row that lie on a line do not feel a turn about it
    inverse = np.linalg.pinv(gram, rcond=NEGLIGIBLE, hermitian=True)
    for _ in range(_ROUNDS):
        left = own.copy()
        np.subtract.at(left, row, np.einsum("kab,kbr->kar", blocks, R))
        left[np.abs(left).max(axis=(1, 2)) <= ROUND_OFF] = 0.0
        change = np.einsum("kar,krs,kbs->kab", left[row], inverse[row], R, optimize=True)
        blocks = blocks + near[:, None, None] * change
    return blocks
