"""Blocks that programs over discs share but for multiples of their rows, and reactions in place of y."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from shakedown.ground.constants import FloatArray

Places = NDArray[np.intp]


class Reactions(NamedTuple):
    """The last two numbers of most nodes as unknowns z = S y in place of y.

    Attributes
    ----------
    to_y : (r, r)
        S⁻¹.
    gram : (r, r)
        S⁻ᵀ S⁻¹: |y|² is zᵀ (S⁻ᵀ S⁻¹) z.
    kept : (r,)
        Which of the last two numbers of all nodes are unknowns.
    tied, others, columns : (t,), (o,), (t, 2)
        The nodes of which the last two numbers are unknowns, all others, and which unknowns.
    dense : (t + 3 o, r)
        Coefficients of z in the first number of tied nodes and in all of the others.
    """

    to_y: FloatArray
    gram: FloatArray
    kept: Places
    tied: Places
    others: Places
    columns: Places
    dense: FloatArray

    def scaled(self, scale: FloatArray) -> "Reactions":
        """The same for blocks whose rows are multiples, (n, 3), of the rows of these."""
        of_z = 1.0 / scale[:, 1:].ravel()[self.kept]
        rows = np.append(scale[self.tied, 0], scale[self.others].ravel())
        return self._replace(
            to_y=self.to_y * of_z,
            gram=self.gram * of_z * of_z[:, None],
            dense=self.dense * of_z * rows[:, None],
        )


@dataclass(frozen=True, eq=False)
class SharedBlocks:
    """Coefficients (n, 3, r) of y in the three numbers of every node."""

    blocks: FloatArray

    @cached_property
    def reactions(self) -> Reactions | None:
        """Reactions as unknowns, worked out once; None where they do not determine y."""
        n, _, r = self.blocks.shape
        if 2 * n < r:
            return None
        reactions = self.blocks[:, 1:].reshape(2 * n, r)
        kept = _independent(reactions)
        try:
            to_y = np.asarray(np.linalg.inv(reactions[kept]), dtype=float)
        except np.linalg.LinAlgError:
            return None
        column = np.full(2 * n, -1)
        column[kept] = np.arange(r)
        of_nodes = column.reshape(n, 2)
        is_tied = (of_nodes >= 0).all(axis=1)
        tied, others = np.flatnonzero(is_tied), np.flatnonzero(~is_tied)
        rows = np.vstack([self.blocks[tied, 0], self.blocks[others].reshape(-1, r)])
        return Reactions(to_y, to_y.T @ to_y, kept, tied, others, of_nodes[tied], rows @ to_y)


def _independent(rows: FloatArray) -> Places:
    """As many linearly independent rows as there are columns: the pivots of Gaussian elimination."""
    if len(rows) == rows.shape[1]:
        return np.arange(len(rows))
    order = np.arange(len(rows))
    for k, pivot in enumerate(lapack.dgetrf(rows)[1]):
        order[[k, pivot]] = order[[pivot, k]]
    return np.sort(order[: rows.shape[1]])
