"""Where the slip and the gap of a node stand in the vectors of a joint."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray

T = TypeVar("T", bound=np.generic)
Nodes = Sequence[int] | NDArray[np.intp]


@dataclass(frozen=True)
class Layout:
    """The order of a state u = (v, w): the slips of all nodes, node by node, and then their gaps.

    Reactions r = (q, p), the rows and columns of κ and what is written of a load step have the same order.

    Attributes
    ----------
    n
        Number of contact nodes.
    d
        Tangential directions of a node: 1 in the plane, 2 in space.

    Examples
    --------
    >>> plane, space = Layout(3), Layout(3, 2)
    >>> plane.size, space.size, space.of_nodes([0, 2])
    (6, 9, array([0, 1, 4, 5, 6, 8]))
    """

    n: int
    d: int = 1

    @property
    def slip_size(self) -> int:
        """The number of slips, dn."""
        return self.d * self.n

    @property
    def size(self) -> int:
        """The number of slips and gaps together, (d + 1) n."""
        return self.slip_size + self.n

    @cached_property
    def slips(self) -> slice:
        """The place of the slips (of tangential reactions, of columns of A)."""
        return slice(0, self.slip_size)

    @cached_property
    def gaps(self) -> slice:
        """The place of the gaps (of normal reactions, of columns of Bᵀ)."""
        return slice(self.slip_size, self.size)

    def split(self, u: NDArray[T]) -> tuple[NDArray[T], NDArray[T]]:
        """Slips (…, dn) and gaps (…, n) of states (…, (d + 1) n), as views."""
        return u[..., self.slips], u[..., self.gaps]

    def joined(self, slip: NDArray[T], gap: NDArray[T]) -> NDArray[T]:
        """The states (…, (d + 1) n) of slips (…, dn) and gaps (…, n)."""
        return np.concatenate([slip, gap], axis=-1)

    def zeros(self, *leading: int) -> FloatArray:
        """States (…, (d + 1) n) of no slip and no gap."""
        return np.zeros((*leading, self.size))

    def blocks(self, matrix: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """A (dn, dn), B (n, dn) and C (n, n) of a stiffness κ, as views."""
        return (matrix[self.slips, self.slips], matrix[self.gaps, self.slips], matrix[self.gaps, self.gaps])

    def of_blocks(self, A: FloatArray, B: FloatArray, C: FloatArray) -> FloatArray:
        """κ = [[A, Bᵀ], [B, C]]."""
        return np.block([[A, B.T], [B, C]])

    def slips_of(self, nodes: Nodes) -> NDArray[np.intp]:
        """The places of the slips of some nodes, node by node, (d k,)."""
        chosen = np.asarray(nodes, dtype=np.intp)
        return (self.d * chosen[:, None] + np.arange(self.d)).ravel()

    def gaps_of(self, nodes: Nodes) -> NDArray[np.intp]:
        """The places of the gaps of some nodes, (k,)."""
        return self.slip_size + np.asarray(nodes, dtype=np.intp)

    def of_nodes(self, nodes: Nodes) -> NDArray[np.intp]:
        """The places of the slips of some nodes, then of their gaps: a state of these nodes alone."""
        return np.concatenate([self.slips_of(nodes), self.gaps_of(nodes)])

    def by_node(self, slip: NDArray[T]) -> NDArray[T]:
        """Slips or tangential reactions (…, dn) node by node, (…, n, d), as a view."""
        return slip.reshape(*slip.shape[:-1], self.n, self.d)

    def ways(self, change: FloatArray) -> FloatArray:
        """How far each node slips in a change of a state ((d + 1) n,), (n,) [length]."""
        return np.asarray(np.linalg.norm(self.by_node(change[self.slips]), axis=1))


@cache
def layout_of(n: int, d: int) -> Layout:
    """The layout for a number of nodes and directions, cached."""
    return Layout(n, d)
