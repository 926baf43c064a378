"""The statement of a program over the discs of nodes at many load steps: one block per node."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import blas, cho_factor, lapack, qr, solve_triangular

from shakedown.ground.constants import CONE, MANY_ROWS, PER_CENT, FloatArray
from shakedown.programs.cones import Cones, Scaling
from shakedown.programs.self_dual import Solve
from shakedown.programs.shared_blocks import SharedBlocks

RANK = np.finfo(float).eps  # relative size, per row, of a diagonal of the factor that counts as zero

Places = NDArray[np.intp]


class Edges(NamedTuple):
    """Excess of discs over their limits (a,), its gradients (a, N), a root of its weighted curvature."""

    excess: FloatArray
    slopes: FloatArray
    bends: FloatArray


@dataclass(frozen=True, eq=False)
class DiscProgram:
    """Minimise costᵀ w over (y, w) subject to discs, rows and a bound of the length of y.

    Every disc k of node i asks that right_k − blocks_i y − extra_k w be in a second-order cone of three
    numbers; rows ask that rows_right − rows y − rows_extra w ≥ 0; and ‖y‖ + offset ≤ norm · w. The
    coefficients of y are those of the node alone: however many load steps there are, the normal
    equations take one product of the blocks.

    Attributes
    ----------
    blocks : (n, 3, r)
        Coefficients of y in the discs of every node.
    node : (K,)
        The node of every disc.
    extra : (K, 3, p)
        Coefficients of w in every disc.
    right : (K, 3)
        Right-hand sides of the discs.
    rows, rows_extra, rows_right : (k, r), (k, p), (k,)
        The rows.
    cost : (p,)
        c.
    norm : (p,), optional
        What bounds the length of y; None where nothing does.
    offset
        What is added to that length.
    shared, scale : …, (n, 3), optional
        Blocks of which these are multiples, row by row, where several programs share them.
    """

    blocks: FloatArray
    node: Places
    extra: FloatArray
    right: FloatArray
    rows: FloatArray
    rows_extra: FloatArray
    rows_right: FloatArray
    cost: FloatArray
    norm: FloatArray | None = None
    offset: float = 0.0
    shared: SharedBlocks | None = None
    scale: FloatArray | None = None

    @property
    def left(self) -> float:
        """See :class:`ConeProgram`."""
        return PER_CENT

    @property
    def rank(self) -> int:
        """r, the number of entries of y."""
        return self.blocks.shape[2]

    def sums(self, values: FloatArray) -> FloatArray:
        """Values (K, c) of the discs, added up for every node, (n, c)."""
        count = values.shape[1]
        places = self._triples if count == CONE else self._places(count)
        found = np.bincount(places, values.ravel(), len(self.blocks) * count)
        return np.asarray(found, dtype=float).reshape(-1, count)

    def _places(self, count: int) -> Places:
        """The index under which the values of every disc are added up."""
        return (count * self.node[:, None] + np.arange(count)).ravel()

    @cached_property
    def _triples(self) -> Places:
        return self._places(CONE)

    @cached_property
    def _flat(self) -> FloatArray:
        """The blocks below each other, (3n, r)."""
        return self.blocks.reshape(CONE * len(self.blocks), self.rank)

    @cached_property
    def loads(self) -> FloatArray:
        """The coefficients of w in the discs below each other, (3K, p)."""
        return self.extra.reshape(CONE * len(self.node), len(self.cost))

    @cached_property
    def cones(self) -> Cones:
        """Where the slacks are: the discs, the rows, the bound of the length."""
        return Cones(len(self.node), len(self.rows), 0 if self.norm is None else self.rank + 1)

    @cached_property
    def limits(self) -> FloatArray:
        """Right-hand sides of discs, rows and bound together."""
        tail = np.zeros(0) if self.norm is None else np.append(-self.offset, np.zeros(self.rank))
        return np.concatenate([self.right.ravel(), self.rows_right, tail])

    @cached_property
    def costs(self) -> FloatArray:
        """The cost of all columns (y, w)."""
        return np.append(np.zeros(self.rank), self.cost)

    def times(self, x: FloatArray) -> FloatArray:
        """Discs, rows and bound at x = (y, w)."""
        y, w = x[: self.rank], x[self.rank :]
        discs = (self._flat @ y).reshape(-1, CONE)[self.node] + (self.loads @ w).reshape(-1, CONE)
        parts = [discs.ravel(), self.rows @ y + self.rows_extra @ w]
        if self.norm is not None:
            parts += [-(self.norm @ w)[None], -y]
        return np.concatenate(parts)

    def transposed(self, z: FloatArray) -> FloatArray:
        """What multipliers of discs, rows and bound add up to."""
        discs, rows, tail = self.parts(z)
        y = self.sums(discs).ravel() @ self._flat + rows @ self.rows
        w = discs.ravel() @ self.loads + rows @ self.rows_extra
        if self.norm is not None:
            y, w = y - tail[1:], w - tail[0] * self.norm
        return np.concatenate([y, w])

    def parts(self, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Slacks or multipliers of the discs (K, 3), of the rows and of the bound, as views."""
        return self.cones.parts(u)

    def columns(self, discs: Places) -> FloatArray:
        """The coefficients of (y, w) in some discs, (a, 3, r + p)."""
        return np.concatenate([self.blocks[self.node[discs]], self.extra[discs]], axis=2)

    def edges(self, discs: Places, x: FloatArray, weights: FloatArray) -> Edges:
        """|(u₁, u₂)| − u₀ of the slacks u of some discs at x, for Newton's method at their edge."""
        columns = self.columns(discs)
        u = self.right[discs] - columns @ x
        length = np.hypot(u[:, 1], u[:, 2])
        normal = u[:, 1:] / length[:, None]
        slopes = columns[:, 0] - np.einsum("jk,jkx->jx", normal, columns[:, 1:])
        across = normal[:, :1] * columns[:, 2] - normal[:, 1:] * columns[:, 1]
        bends = across * np.sqrt(np.maximum(weights, 0.0) / length)[:, None]
        return Edges(length - u[:, 0], slopes, bends)

    def halves(self, squares: FloatArray) -> FloatArray:
        """A root of the sum of the squares (K, 3, 3) of the discs of every node, (n, 3, 3)."""
        of_nodes = self.sums(squares.reshape(-1, CONE**2)).reshape(-1, CONE, CONE)
        values, vectors = np.linalg.eigh(of_nodes)  # round-off may make one negative
        return np.asarray(np.sqrt(np.maximum(values, 0.0))[:, :, None] * np.swapaxes(vectors, 1, 2))

    def normal_equations(self, scaling: Scaling) -> Solve:
        """The solution of Mᵀ W⁻² M x = right, M all of the coefficients; raises ``LinAlgError``."""
        return by_cholesky(self._normal_matrix(scaling))

    def orthogonal_factor(self, scaling: Scaling) -> Solve:
        """The same equations solved by a triangular factor of W⁻¹ M, where no squaring hides small rows."""
        return _by_orthogonal_factor(self._root(scaling))

    def _root(self, scaling: Scaling) -> FloatArray:
        """Rows R with Rᵀ R = Mᵀ W⁻² M: at most 3 + p of every node, then the rows, then the bound."""
        inverses = scaling.inverses()
        discs = np.concatenate([inverses, inverses @ self.extra], axis=2)
        ends = np.cumsum(np.bincount(self.node, minlength=len(self.blocks)))[:-1]
        of_nodes = np.split(discs[np.argsort(self.node, kind="stable")], ends) if len(self.blocks) else []
        parts = [np.hstack([self.rows, self.rows_extra]) / scaling.of_numbers]
        for own, block in zip(of_nodes, self.blocks, strict=True):
            triangle = np.asarray(np.linalg.qr(_largest_first(own.reshape(-1, own.shape[2])), mode="r"))
            parts.append(np.hstack([triangle[:, :CONE] @ block, triangle[:, CONE:]]))
        if self.norm is not None:
            bound = np.zeros((self.rank + 1, self.rank + len(self.cost)))
            bound[0, self.rank :], bound[1:, : self.rank] = self.norm, np.eye(self.rank)
            parts.append(scaling.inverse_of_large() @ bound)
        return np.vstack(parts)

    def _normal_matrix(self, scaling: Scaling) -> FloatArray:
        """Mᵀ W⁻² M in the lower triangle, from one 3 × 3 block per node."""
        (n, _, rank), p, squares = self.blocks.shape, len(self.cost), scaling.inverse_squares()
        halves = self.halves(squares)
        weights = 1.0 / scaling.of_numbers
        rows, loads = self.rows * weights, self.rows_extra * weights
        stacked = np.vstack([(halves @ self.blocks).reshape(CONE * n, rank), rows])
        normal = np.zeros((rank + p, rank + p), order="F")
        if rank:
            normal[:rank, :rank] = blas.dsyrk(1.0, stacked.T, lower=1)
        pulled = squares @ self.extra
        of_loads = self.sums(pulled.reshape(-1, CONE * p)).reshape(CONE * n, p)
        normal[rank:, :rank] = of_loads.T @ self._flat + loads.T @ rows
        normal[rank:, rank:] = np.tensordot(self.extra, pulled, axes=((0, 1), (0, 1))) + loads.T @ loads
        if self.norm is not None:
            square = scaling.inverse_square_of_large()
            normal[:rank, :rank] += square[1:, 1:]
            normal[rank:, :rank] += np.outer(self.norm, square[0, 1:])
            normal[rank:, rank:] += square[0, 0] * np.outer(self.norm, self.norm)
        return normal


def by_cholesky(normal: FloatArray) -> Solve:
    """Solutions of a positive definite matrix in units of its diagonal; raises ``LinAlgError``."""
    diagonal = np.einsum("ii->i", normal)
    unit = 1.0 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    normal *= unit
    normal *= unit[:, None]
    factor, _ = cho_factor(normal, lower=True, overwrite_a=True, check_finite=False)
    return lambda right: np.asarray(unit * lapack.dpotrs(factor, unit * right, lower=1)[0])


def _by_orthogonal_factor(root: FloatArray) -> Solve:
    """Solutions with rootᵀ root; components outside its row space stay zero. Raises ``LinAlgError``."""
    lengths = np.linalg.norm(root, axis=0)
    unit = 1.0 / np.where(lengths > 0, lengths, 1.0)
    R, order = _triangle(_largest_first(root * unit))
    rank = int(np.count_nonzero(_independent(R)))
    known, R = order[:rank], R[:rank, :rank]

    def solve(right: FloatArray) -> FloatArray:
        found = np.zeros_like(right)
        half = solve_triangular(R, (unit * right)[known], trans=1, check_finite=False)
        found[known] = solve_triangular(R, half, check_finite=False)
        return np.asarray(unit * found)

    return solve


def _triangle(rows: FloatArray) -> tuple[FloatArray, Places]:
    """R with Rᵀ R = (rows P)ᵀ rows P, and the order of the columns that is P.

    Columns are exchanged because of dependent ones; where many are independent they stay in
    place, which takes a quarter of the time.
    """
    count = rows.shape[1]
    if count > MANY_ROWS and len(rows) >= count:
        R = np.asarray(np.linalg.qr(rows, mode="r"))
        if _independent(R).all():
            return R, np.arange(count)
    R, order = qr(rows, mode="r", pivoting=True, check_finite=False)
    return R[:count], order


def _independent(R: FloatArray) -> NDArray[np.bool_]:
    """Which columns of a triangular factor are linearly independent of those before them."""
    sizes = np.abs(np.diag(R))
    return np.asarray(sizes > RANK * len(R) * sizes.max(initial=0.0))


def _largest_first(rows: FloatArray) -> FloatArray:
    """The order of rows in which reflections keep small rows accurate."""
    return np.asarray(rows[np.argsort(-np.abs(rows).max(axis=1, initial=0.0), kind="stable")])
