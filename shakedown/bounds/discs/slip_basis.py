"""Well-conditioned unknowns for slips: orthonormal columns, whatever the loads are."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import qr, solve_triangular

from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import CONE
from shakedown.programs.shared_blocks import SharedBlocks

RANK = 64 * np.finfo(float).eps  # relative size of a diagonal of the triangular factor that counts as zero


@dataclass(frozen=True, eq=False)
class Basis:
    """N = D Q R with orthonormal Q: changes of limits with slips, D a size of every node or half-space.

    Attributes
    ----------
    Q : (3n + o, K)
        The rows of the discs' nodes, then those of the half-spaces.
    to_slips : (k, K)
        R⁻¹, in the slips that some limit depends on; those of the others are zero.
    sizes : (n + o,)
        D [force/length].
    """

    Q: FloatArray
    to_slips: FloatArray
    sizes: FloatArray

    @cached_property
    def shared(self) -> SharedBlocks:
        """Q of the discs' nodes, (n, 3, K)."""
        n = (len(self.Q) - len(self.sizes)) // (CONE - 1)
        return SharedBlocks(self.Q[: CONE * n].reshape(n, CONE, self.Q.shape[1]))


def slip_basis(stiffness: FloatArray, gaps: FloatArray) -> Basis:
    """The basis of the slips in limits of nodes (n, 3, k) and in half-spaces (o, k) [force/length].

    Every node is in units of its own stiffness.
    """
    of_nodes, of_gaps = np.linalg.norm(stiffness, axis=(1, 2)), np.linalg.norm(gaps, axis=1)
    sizes, of_rows = np.append(of_nodes, of_gaps), np.append(np.repeat(of_nodes, CONE), of_gaps)
    rows = np.vstack([stiffness.reshape(CONE * len(stiffness), stiffness.shape[-1]), gaps])
    M = rows * (1.0 / np.where(of_rows > 0, of_rows, 1.0))[:, None]
    known = np.flatnonzero(M.any(axis=0))
    to_slips = np.zeros((M.shape[1], 0))
    if not known.size:
        return Basis(np.zeros((len(M), 0)), to_slips, sizes)
    lengths = np.linalg.norm(M[:, known], axis=0)
    Q, R = qr(M[:, known] / lengths, mode="economic", check_finite=False)
    diagonal = np.abs(np.diag(R))
    to_slips = np.zeros((M.shape[1], Q.shape[1]))
    if len(R) == R.shape[1] and diagonal.min() > RANK * len(M) * diagonal.max():
        to_slips[known] = solve_triangular(R, np.eye(len(R)), check_finite=False) / lengths[:, None]
        return Basis(Q, to_slips, sizes)
    U, values, V = np.linalg.svd(M[:, known] / lengths, full_matrices=False)
    kept = values > RANK * len(M) * values[0]
    to_slips = np.zeros((M.shape[1], int(kept.sum())))
    to_slips[known] = V[kept].T / values[kept] / lengths[:, None]
    return Basis(np.ascontiguousarray(U[:, kept]), to_slips, sizes)
