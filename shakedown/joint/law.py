"""Coulomb's law: the tangential reaction of a node lies in an interval, or a disc, of size f p."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import EPS, FloatArray

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

    def slip_distances(self, change: FloatArray) -> FloatArray:
        """How far each node slips in a change of a state ((d + 1) n,), (n,) [length]."""
        return np.asarray(np.linalg.norm(self.by_node(change[self.slips]), axis=1))


layout_of = cache(Layout)  # for a number of nodes and directions; what it works out is kept


RealArray = NDArray[Any]  # floats, or exact numbers as objects


@dataclass(frozen=True, eq=False)
class Law:
    """Coulomb's law at n nodes, |q| ≤ f p, in one tangential direction or two (thesis (2.7)–(2.9)).

    A node slips only at the limit, and against its reaction: q = −f p v̇/|v̇|. As a cone, the law
    says that s(q, p) lies in K: with one direction s = (f p − q, f p + q) in a quadrant, one
    half-space for backward and one for forward slip; with two s = (f p, q_x, q_y) in a
    second-order cone. Where f > 0 a node in K is pressed, p ≥ 0. Where f = 0 it need not be: the p of these
    nodes follow, one half-space for each. Nothing here depends on units.

    Tangential quantities are (…, dn), node by node, normal ones (…, n).

    Attributes
    ----------
    f : (n,)
        Friction coefficients; exact numbers too, for what takes no root.
    d
        Tangential directions of a node, 1 or 2.

    Examples
    --------
    >>> law, q, p = Law(np.array([0.4]), 2), np.array([0.3, 0.4]), np.array([1.0])
    >>> law.excess(q, p).round(6), law.projection(q, p).round(6), law.direction(q)
    (array([0.1]), array([0.24, 0.32]), array([-0.6, -0.8]))
    """

    f: RealArray
    d: int = 1

    @cached_property
    def layout(self) -> Layout:
        """The layout of slips by node."""
        return Layout(len(self.f), self.d)

    @property
    def rows(self) -> int:
        """How many rows s has for the friction of a node: two half-spaces, or one cone of three."""
        return self.d + 1

    @cached_property
    def frictionless(self) -> NDArray[np.intp]:
        """The nodes without friction, whose pressures are rows of their own."""
        return np.flatnonzero(self.f == 0)

    def limit(self, p: RealArray) -> RealArray:
        """The largest tangential reaction f p, (…, n) [force]."""
        return self.f * p

    def size(self, q: FloatArray) -> FloatArray:
        """The size of a tangential reaction, or of a slip, of every node, (…, n)."""
        return np.abs(q) if self.d == 1 else np.hypot(*self._components(q))

    def excess(self, q: FloatArray, p: FloatArray) -> FloatArray:
        """|q| − f p, (…, n) [force]: positive outside the limit, minus the distance to it within."""
        return self.size(q) - self.limit(p)

    def violation(self, q: FloatArray, p: FloatArray, slip: FloatArray) -> FloatArray:
        """The excess, or the distance of q from −f p along the slip where that is larger, (…, n).

        The distance is capped at the slip, so that no threshold is needed for whether a node slips:
        forces and lengths are relative to those of the scene.
        """
        limit, excess = self.limit(p), self.excess(q, p)
        if self.d == 1:  # forward slip only at q = −f p, backward slip only at q = +f p
            forward, backward = np.minimum(slip, np.abs(q + limit)), np.minimum(-slip, np.abs(q - limit))
            return np.asarray(np.maximum(np.maximum(excess, forward), backward))
        opposed = -self._each(limit) * self._unit(slip)
        return np.asarray(np.maximum(excess, np.minimum(self.size(slip), self.size(q - opposed))))

    def projection(self, q: FloatArray, p: FloatArray) -> FloatArray:
        """The allowed tangential reaction nearest to q at the pressure p, (…, dn) [force]; 0 in tension."""
        limit = np.maximum(self.limit(p), 0.0)
        if self.d == 1:
            return np.clip(q, -limit, limit)
        size = self.size(q)
        return q * self._each(np.divide(limit, size, out=np.ones_like(size), where=size > limit))

    def direction(self, q: FloatArray) -> FloatArray:
        """The unit vectors −q/|q| along which nodes at their limits slip, (…, dn); 0 where q is."""
        return -self._unit(q)

    def cone(self, q: RealArray, p: RealArray) -> RealArray:
        """s(q, p), which the law wants in K, (…, r) [force]: node by node, then p without friction."""
        limit = self.limit(p)
        rows = _by_node(limit - q, limit + q) if self.d == 1 else _by_node(limit, *self._components(q))
        return self._with_pressures(rows, p)

    def load_terms(self, q: RealArray, p: RealArray) -> RealArray:
        """−s(q, p), (…, r) [force]: what a load takes from the slack within the limits."""
        limit = self.limit(p)
        return self._with_pressures(_by_node(q - limit, -q - limit), -p) if self.d == 1 else -self.cone(q, p)

    def limit_rows(self, B: RealArray) -> RealArray:
        """f B, (n, k): the limits that pressures p = B v (n, k) leave, as functions of v."""
        return self.f[:, None] * B

    def stiffness(self, A: RealArray, B: RealArray) -> RealArray:
        """−∂s/∂v, (r, k) [force/length]: what slips take of it, with q = A v and p = B v.

        A is (dn, k), B (n, k).
        """
        fB = self.limit_rows(B)
        if self.d == 1:
            rows = np.stack([A - fB, -(A + fB)], axis=1).reshape(2 * len(B), -1)
        else:
            by_node = np.moveaxis(A.reshape(len(B), 2, -1), 1, 0)
            rows = -np.stack([fB, *by_node], axis=1).reshape(3 * len(B), -1)
        return self._with_pressures(rows.T, -B.T).T

    def stiffness_terms(self, A: FloatArray, B: FloatArray) -> FloatArray:
        """The sizes of the terms of :meth:`stiffness` together: what its round-off is relative to."""
        if self.d == 1:
            rows = np.repeat(np.abs(A) + self.limit_rows(np.abs(B)), 2, axis=0)
            return np.vstack([rows, np.abs(B[self.frictionless])])
        return np.abs(self.stiffness(A, B))

    def extreme_steps(self, q: FloatArray, p: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The (node, load step) pairs whose discs, of reactions (m, 2n) and (m, n), imply all others.

        A disc is convex: of the load path (q_x, q_y, p) of a node only the corners of its hull matter.
        Nor does a step k matter that another one, l, implies: |q_k − q_l| ≤ f (p_k − p_l), p_k ≥ p_l.

        Examples
        --------
        >>> q = np.array([[1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [0.1, 0.1]])
        >>> p = np.array([[1.0], [1.0], [1.0], [9.0]])
        >>> Law(np.array([0.5]), 2).extreme_steps(q, p)
        (array([0, 0]), array([0, 1]))
        """
        path = np.concatenate([self.layout.by_node(q), p[..., None]], axis=-1)
        found = []
        for node in range(self.layout.n):
            steps = _hull(path[:, node])
            apart = path[steps, node][:, None] - path[steps, node]
            implied = Law(self.f[[node]], 2).excess(apart[..., :2], apart[..., 2:])[..., 0] <= 0
            implied &= apart[..., 2] >= 0
            earlier = np.tri(len(steps), k=-1, dtype=bool)
            others = ~np.eye(len(steps), dtype=bool)
            found.append(steps[~(implied & (earlier | ~implied.T) & others).any(axis=1)])
        count = [len(steps) for steps in found]
        return np.repeat(np.arange(self.layout.n), count), np.concatenate(found)

    def of_nodes(self, rows: RealArray) -> RealArray:
        """The rows of friction among rows (…, r), node by node, (…, n, d + 1)."""
        return rows[..., : self.rows * len(self.f)].reshape(*rows.shape[:-1], len(self.f), self.rows)

    def _with_pressures(self, rows: RealArray, p: RealArray) -> RealArray:
        """Rows (…, (d + 1) n) followed by those of the pressures of nodes without friction."""
        return np.concatenate([rows, p[..., self.frictionless]], axis=-1) if len(self.frictionless) else rows

    def _components(self, q: RealArray) -> RealArray:
        return np.moveaxis(self.layout.by_node(q), -1, 0)

    def _each(self, of_nodes: FloatArray) -> FloatArray:
        """Numbers (…, n) at every direction of their nodes, (…, dn)."""
        return np.repeat(of_nodes, self.d, axis=-1)

    def _unit(self, q: FloatArray) -> FloatArray:
        size = self._each(self.size(q))
        return np.divide(q, size, out=np.zeros_like(size), where=size > 0)


def _by_node(*parts: RealArray) -> RealArray:
    """Rows (…, n) of every node together: those of node 0, of node 1, …"""
    return np.stack(parts, axis=-1).reshape(*parts[0].shape[:-1], -1)


def _hull(points: FloatArray) -> NDArray[np.intp]:
    """The corners of the convex hull of points (m, 3) that may lie in a plane or a line, in order."""
    from scipy.spatial import ConvexHull, QhullError  # in space only

    size = float(np.abs(points).max())
    spread = np.ldexp(points - points[0], -int(np.frexp(size)[1]))
    values, directions = np.linalg.svd(spread, full_matrices=False)[1:]
    # round-off of a load, relative to the largest of its node
    rank = int(np.count_nonzero(values > 16 * EPS * len(points)))
    along = spread @ directions.T
    corners = {int(along[:, 0].argmin()), int(along[:, 0].argmax())}
    for k in range(2, rank + 1):  # Qhull loses corners of what is nearly flat: also those of projections
        try:
            corners |= set(ConvexHull(along[:, :k]).vertices.tolist())
        except QhullError:
            return np.arange(len(points))
    return np.array(sorted(corners), dtype=np.intp)
