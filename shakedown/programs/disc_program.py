"""Programs over the discs of nodes at many load steps, and the cones that they are made of.

Cones |u₁| ≤ u₀ of three numbers, of one, and a large one, with Nesterov–Todd scaling (F. Alizadeh
and D. Goldfarb, Math. Program. 95, 2003, 3; Y. E. Nesterov and M. J. Todd, Math. Oper. Res. 22, 1997, 1).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import blas, lapack, qr, solve_triangular

from shakedown.ground.constants import CONE, EPS, NOTABLE, ROUND_OFF, SIX_DIGITS, FloatArray


@dataclass(frozen=True)
class Scaling:
    """The scaling W of Nesterov and Todd: W z = W⁻¹ s = ``point``, for a slack s and a multiplier z inside.

    Attributes
    ----------
    cones
        The cones.
    axis : (N,)
        The unit vector w of every cone, w₀² − |w₁|² = 1.
    factor : (c,)
        On a cone W is its factor times the hyperbolic rotation that takes the unit vector to w.
    point : (N,)
        The scaled point.
    """

    cones: "Cones"
    axis: FloatArray
    factor: FloatArray
    point: FloatArray

    @cached_property
    def _back(self) -> FloatArray:
        """The axis of W⁻¹."""
        return self.axis * self.cones.mirror

    def times(self, vector: FloatArray) -> FloatArray:
        """W · vector."""
        return self.factor[self.cones.cone] * self.cones.rotated(self.axis, vector)

    def divided(self, vector: FloatArray) -> FloatArray:
        """W⁻¹ · vector, or · each of several, (c, N)."""
        return np.asarray(self.cones.rotated(self._back, vector) / self.factor[self.cones.cone])

    def inverses(self) -> FloatArray:
        """W⁻¹ on the cones of three numbers, (j, 3, 3)."""
        return _rotation(self.cones.parts(self._back)[0]) / self.factor[: self.cones.triples, None, None]

    def inverse_of_large(self) -> FloatArray:
        """W⁻¹ on the large cone, (q, q)."""
        return np.asarray(_rotation(self.cones.parts(self._back)[2][None])[0] / self.factor[-1])


@dataclass(frozen=True)
class Cones:
    """``triples`` cones of three numbers, ``numbers`` of one, then one of ``large`` numbers, or none for 0.

    Examples
    --------
    >>> cones = Cones(1, 1)
    >>> cones.margin(np.array([5.0, 3.0, 4.0, 2.0])), cones.degree
    (0.0, 2)
    """

    triples: int
    numbers: int
    large: int = 0

    @cached_property
    def degree(self) -> int:
        """The number of cones: what slack · multiplier is divided by for its mean."""
        return self.triples + self.numbers + bool(self.large)

    @cached_property
    def heads(self) -> NDArray[np.intp]:
        """The place of u₀ of every cone, (c,)."""
        return np.flatnonzero(self.unit)

    @cached_property
    def cone(self) -> NDArray[np.intp]:
        """The cone of every number, (N,)."""
        return np.cumsum(self.unit, dtype=np.intp) - 1

    @cached_property
    def unit(self) -> FloatArray:
        """e with e ∘ u = u: 1 at every u₀, else 0."""
        first = np.eye(1, CONE)[0]
        return np.concatenate([np.tile(first, self.triples), np.ones(self.numbers), np.eye(1, self.large)[0]])

    @cached_property
    def mirror(self) -> FloatArray:
        """1 at every u₀, else −1."""
        return 2.0 * self.unit - 1.0

    def parts(self, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The cones of three numbers (j, 3), those of one (k,), the large one (q,), as views."""
        first = CONE * self.triples
        last = first + self.numbers
        return u[:first].reshape(-1, CONE), u[first:last], u[last:]

    def _sums(self, u: FloatArray) -> FloatArray:
        return np.asarray(np.add.reduceat(u, self.heads, axis=-1) if self.degree else u)

    def _lengths(self, u: FloatArray) -> FloatArray:
        return np.sqrt(self._sums(u * u * (self.mirror < 0)))

    def _sizes_of(self, u: FloatArray) -> FloatArray:
        """The root of u₀² − |u₁|², without cancellation."""
        first, length = u[self.heads], self._lengths(u)
        return np.asarray(np.sqrt((first - length) * (first + length)))

    def margin(self, u: FloatArray) -> float:
        """The largest t with u − t e inside."""
        return float(np.min(u[self.heads] - self._lengths(u), initial=np.inf))

    def product(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """u ∘ v, the product of Jordan."""
        found = u[self.heads][self.cone] * v + v[self.heads][self.cone] * u
        found[self.heads] = self._sums(u * v)
        return found

    def quotient(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """x with u ∘ x = v, for u inside."""
        first = self._sums(self.mirror * u * v) / self._sizes_of(u) ** 2
        found = (v - first[self.cone] * u) / u[self.heads][self.cone]
        found[self.heads] = first
        return found

    def rotated(self, axis: FloatArray, u: FloatArray) -> FloatArray:
        """The hyperbolic rotations that take unit vectors to the axes, applied to u, (N,) or (c, N)."""
        along, first, of_axis = self._sums(axis * u * (self.mirror < 0)), u[..., self.heads], axis[self.heads]
        found = u + axis * (first + along / (1.0 + of_axis))[..., self.cone]
        found[..., self.heads] = of_axis * first + along
        return np.asarray(found)

    def reach_from(self, u: FloatArray) -> Callable[[FloatArray], float]:
        """The largest t with u + t · step inside, for u inside; inf where every t is.

        Seen from u as the unit vector a step leaves the cone at 1 / (|step₁| − step₀): the roots of the
        determinant lose that where step and u are parallel.
        """
        sizes = self._sizes_of(u)
        axis = u * self.mirror / sizes[self.cone]

        def reach(step: FloatArray) -> float:
            seen = self.rotated(axis, step)
            nearness = float(np.max((self._lengths(seen) - seen[self.heads]) / sizes, initial=0.0))
            return 1.0 / nearness if nearness > 0 else np.inf

        return reach

    def scaling(self, slack: FloatArray, multiplier: FloatArray) -> Scaling:
        """The scaling in which slack and multiplier are the same point."""
        size_s, size_z = self._sizes_of(slack), self._sizes_of(multiplier)
        s, z = slack / size_s[self.cone], multiplier / size_z[self.cone]
        axis = (s + self.mirror * z) / np.sqrt(2.0 * (1.0 + self._sums(s * z)))[self.cone]
        factor = np.sqrt(size_s / size_z)
        return Scaling(self, axis, factor, factor[self.cone] * self.rotated(axis, multiplier))


def _rotation(axis: FloatArray) -> FloatArray:
    """The hyperbolic rotations to the axes (c, q) as matrices, (c, q, q)."""
    found = np.eye(axis.shape[1]) + axis[:, :, None] * axis[:, None, :] / (1.0 + axis[:, :1, None])
    found[:, 0], found[:, :, 0] = axis, axis
    return np.asarray(found)


FEW = 24_000  # coefficients: of more, one product of all takes longer than one a node

Places = NDArray[np.intp]
Solve = Callable[[FloatArray], FloatArray]


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
    tied
        Of how many nodes, the first ones, y has the last two numbers, two by two.
    to_y : (r, r), optional
        What y is multiplied by before its length is taken.
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
    tied: int = 0
    to_y: FloatArray | float = 1.0

    @property
    def rank(self) -> int:
        """r, the number of entries of y."""
        return self.blocks.shape[2]

    def sums(self, values: FloatArray) -> FloatArray:
        """Values (K, c) of the discs, added up for every node, (n, c)."""
        n, count = len(self.blocks), values.shape[1]
        places = (count * self.node[:, None] + np.arange(count)).ravel()
        return np.asarray(np.bincount(places, values.ravel(), n * count), dtype=float).reshape(n, count)

    @property
    def _untied(self) -> FloatArray:
        """The blocks of the other nodes below each other, (3n − 3 tied, r)."""
        return self.blocks[self.tied :].reshape(CONE * (len(self.blocks) - self.tied), self.rank)

    @cached_property
    def _squared(self) -> FloatArray:
        """The matrix of the squared length that is bounded, (r, r)."""
        return self.to_y.T @ self.to_y if isinstance(self.to_y, np.ndarray) else np.eye(self.rank)

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

    @cached_property
    def in_reactions(self) -> tuple["DiscProgram", FloatArray, FloatArray]:
        """In reactions, the last two numbers of as many nodes as determine y; in y if S is ill-conditioned.

        With it what (y, w) is by (z, w), z = S y, and back.
        In z the discs of a node have two coefficients each in their last two numbers: they add a 2 × 2
        block to the normal equations, and their first number one dense row. That is a third of the work
        in y, and near the end, where W⁻² spans many orders, no large row hides a small one.
        """
        n, r, to_x = len(self.blocks), self.rank, np.eye(len(self.costs))
        if self._few is not None or not 0 < r <= 2 * n:
            return self, to_x, to_x
        factor, pivots, _ = lapack.dgetrf(self.blocks[:, 1:].reshape(2 * n, r))
        place = np.argsort(lapack.dlaswp(np.arange(2.0 * n)[:, None], pivots)[:, 0]).reshape(n, 2)
        kept = place < r
        order = np.argsort(~kept.all(axis=1), kind="stable")
        S = self.blocks[order, 1:][kept[order]]
        inverse, singular = lapack.dtrtri(factor[:r])
        in_order = blas.dtrsm(1.0, factor[:r], np.triu(inverse), side=1, lower=1, diag=1)
        to_y = in_order[:, place[order][kept[order]]]  # its columns were in the order of the pivots
        if singular or not np.linalg.norm(S, 1) * np.linalg.norm(to_y, 1) * SIX_DIGITS < 1.0:
            return self, to_x, to_x
        t, from_x = int(kept.all(axis=1).sum()), to_x.copy()
        to_x[:r, :r], from_x[:r, :r] = to_y, S
        blocks = np.zeros_like(self.blocks)
        blocks[:, 0], blocks[t:, 1:] = self.blocks[order, 0] @ to_y, self.blocks[order[t:], 1:] @ to_y
        blocks[:t, 1:] = np.eye(2 * t, r).reshape(t, 2, r)
        node, rows = np.argsort(order)[self.node], self.rows @ to_y
        return replace(self, blocks=blocks, node=node, rows=rows, tied=t, to_y=to_y), to_x, from_x

    @cached_property
    def _few(self) -> FloatArray | None:
        """All columns, (r + p, N), where they are few: one product takes less time than one a block then."""
        few = len(self.limits) * len(self.costs) <= FEW
        return np.array([self._by_blocks(unit) for unit in np.eye(len(self.costs))]) if few else None

    def times(self, x: FloatArray) -> FloatArray:
        """Discs, rows and bound at x = (y, w)."""
        return self._by_blocks(x) if self._few is None else x @ self._few

    def _by_blocks(self, x: FloatArray) -> FloatArray:
        y, w, t = x[: self.rank], x[self.rank :], self.tied
        numbers = np.empty((len(self.blocks), CONE))
        numbers[:t, 0], numbers[:t, 1:] = self.blocks[:t, 0] @ y, y[: 2 * t].reshape(t, 2)
        numbers[t:] = (self._untied @ y).reshape(-1, CONE)
        discs = numbers[self.node] + (self.loads @ w).reshape(-1, CONE)
        parts = [discs.ravel(), self.rows @ y + self.rows_extra @ w]
        if self.norm is not None:
            parts += [-(self.norm @ w)[None], -np.dot(self.to_y, y)]
        return np.concatenate(parts)

    def transposed(self, z: FloatArray) -> FloatArray:
        """What multipliers of discs, rows and bound add up to."""
        if self._few is not None:
            return self._few @ z
        discs, rows, tail = self.cones.parts(z)
        sums, t = self.sums(discs), self.tied
        y = sums[:t, 0] @ self.blocks[:t, 0] + sums[t:].ravel() @ self._untied + rows @ self.rows
        y[: 2 * t] += sums[:t, 1:].ravel()
        w = discs.ravel() @ self.loads + rows @ self.rows_extra
        if self.norm is not None:
            y, w = y - np.dot(tail[1:], self.to_y), w - tail[0] * self.norm
        return np.concatenate([y, w])

    def columns(self, discs: Places) -> FloatArray:
        """The coefficients of (y, w) in some discs, (a, 3, r + p)."""
        return np.concatenate([self.blocks[self.node[discs]], self.extra[discs]], axis=2)

    def edges(self, discs: Places, u: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gradients (a, N) of |(u₁, u₂)| − u₀ of the slacks u of discs, a root of its weighted curvature."""
        columns = self.columns(discs)
        length = np.hypot(u[:, 1], u[:, 2])
        normal = u[:, 1:] / length[:, None]
        slopes = columns[:, 0] - np.einsum("jk,jkx->jx", normal, columns[:, 1:])
        across = normal[:, :1] * columns[:, 2] - normal[:, 1:] * columns[:, 1]
        bends = across * np.sqrt(np.maximum(weights, 0.0) / length)[:, None]
        return slopes, bends

    def normal_equations(self, scaling: Scaling) -> Solve:
        """The solution of Mᵀ W⁻² M x = right, M all of the coefficients; raises ``LinAlgError``.

        On the cone of the length of y W⁻² = (2 w wᵀ + I − 2 e₀ e₀ᵀ) / factor².
        """
        if self._few is not None:
            root = scaling.divided(self._few)
            return _by_cholesky(root @ root.T)
        r, p, t, R = self.rank, len(self.cost), self.tied, self._factors(scaling)
        parts = [_in_unknowns(R[:t, :1], self.blocks[:t]), _in_unknowns(R[t:], self.blocks[t:])]
        parts.append(self._of_rows(scaling))
        if self.norm is None and (solve := _by_pairs(R[:t, 1:, 1:], np.vstack(parts))):
            return solve
        normal = np.zeros((r + p, r + p), order="F")
        if self.norm is not None:
            w = np.sqrt(2.0) * scaling.axis[-self.cones.large :]
            parts.append(np.append(np.dot(w[1:], self.to_y), -w[0] * self.norm)[None] / scaling.factor[-1])
            normal[:r, :r], normal[r:, r:] = self._squared, np.outer(-self.norm, self.norm)
            normal /= scaling.factor[-1] ** 2
        normal = blas.dsyrk(1.0, np.vstack(parts).T, 1.0, normal, lower=1, overwrite_c=1)
        at = np.hstack([np.arange(2 * t).reshape(t, 2), np.tile(np.arange(r, r + p), (t, 1))])
        np.add.at(normal, (at[:, :, None], at[:, None]), np.swapaxes(R[:t, 1:, 1:], 1, 2) @ R[:t, 1:, 1:])
        return _by_cholesky(normal)

    def orthogonal_factor(self, scaling: Scaling) -> Solve:
        """The same equations solved by a triangular factor of W⁻¹ M, where no squaring hides small rows."""
        parts = [_in_unknowns(self._factors(scaling), self.blocks), self._of_rows(scaling)]
        if self.norm is not None:
            inverse = scaling.inverse_of_large()
            parts.append(np.hstack([np.dot(inverse[:, 1:], self.to_y), np.outer(inverse[:, 0], self.norm)]))
        return _by_orthogonal_factor(np.vstack(parts))

    def _of_rows(self, scaling: Scaling) -> FloatArray:
        """W⁻¹ (y, w) in the rows, (k, r + p)."""
        weights = scaling.factor[self.cones.triples :][: self.cones.numbers]
        return np.hstack([self.rows, self.rows_extra]) / weights[:, None]

    def _factors(self, scaling: Scaling) -> FloatArray:
        """Triangular factors, (n, 3 + p, 3 + p), of W⁻¹ (numbers, w) in the discs of every node."""
        order, inverses = np.argsort(self.node, kind="stable"), scaling.inverses()
        node, n, size = self.node[order], len(self.blocks), CONE + len(self.cost)
        place = np.arange(len(node)) - np.searchsorted(node, node)  # of a disc among those of its node
        of_nodes = np.zeros((n, max(place.max(initial=-1) + 1, size), CONE, size))
        of_nodes[node, place] = np.concatenate([inverses, inverses @ self.extra], axis=2)[order]
        stacked = _large_first(of_nodes.reshape(n, CONE * of_nodes.shape[1], size))
        return np.asarray(np.linalg.qr(stacked, mode="r"))


def _in_unknowns(factors: FloatArray, blocks: FloatArray) -> FloatArray:
    """Rows in (y, w) of factors (n, k, 3 + p) of nodes with these blocks, (n k, r + p)."""
    rows = np.concatenate([factors[..., :CONE] @ blocks, factors[..., CONE:]], axis=2)
    return np.asarray(rows.reshape(-1, rows.shape[2]))


def _by_cholesky(normal: FloatArray) -> Solve:
    """Solutions of a positive definite matrix, of which the lower triangle counts; raises ``LinAlgError``."""
    factor, failed = lapack.dpotrf(normal, lower=1, clean=0, overwrite_a=1)
    if failed:
        raise np.linalg.LinAlgError("the normal equations are not positive definite")
    return lambda right: np.asarray(lapack.dpotrs(factor, right, lower=1)[0])


def _by_pairs(own: FloatArray, rows: FloatArray) -> Solve | None:
    """Solutions of rowsᵀ rows + the squares of triangles (t, 2 + p, 2 + p) in pairs of unknowns and w.

    By one equation a row instead of one an unknown (Woodbury); None where those are no fewer, or where
    round-off would decide.
    """
    t, p, k = len(own), own.shape[2] - 2, len(rows)
    if k >= t + t or not np.all(own[:, [0, 1], [0, 1]]):
        return None
    inverse, ends = np.linalg.inv(own[:, :2, :2]), own[:, :2, 2:].reshape(2 * t, p)
    pairs, others = rows[:, : 2 * t] * inverse[:, [0, 1], [0, 1]].ravel(), rows[:, 2 * t :].copy()
    pairs[:, 1::2] += rows[:, : 2 * t : 2] * inverse[:, 0, 1]
    if not np.einsum("ij,ij->i", pairs, pairs).max(initial=0.0) * ROUND_OFF < NOTABLE:
        return None
    others[:, -p:] -= pairs @ ends
    small = _by_cholesky(blas.dsyrk(1.0, pairs.T, 1.0, np.eye(k, order="F"), trans=1, lower=1, overwrite_c=1))
    along = small(others)
    rest = others.T @ along
    rest[-p:, -p:] += np.einsum("tij,tik->jk", own[:, 2:, 2:], own[:, 2:, 2:])
    last = _by_cholesky(rest)

    def solve(right: FloatArray) -> FloatArray:
        z, w = np.einsum("ti,tij->tj", right[: 2 * t].reshape(t, 2), inverse).ravel(), right[2 * t :].copy()
        w[-p:] -= z @ ends
        w = last(w - (pairs @ z) @ along)
        z -= small(pairs @ z + others @ w) @ pairs + ends @ w[-p:]
        return np.append(np.einsum("tij,tj->ti", inverse, z.reshape(t, 2)), w)

    return solve


def _large_first(rows: FloatArray) -> FloatArray:
    """Rows (…, k, N) in the order of their size, which keeps small ones accurate in an orthogonal factor."""
    order = np.argsort(-np.abs(rows).max(axis=-1, initial=0.0), axis=-1, kind="stable")
    return np.take_along_axis(rows, order[..., None], axis=-2)


def _by_orthogonal_factor(root: FloatArray) -> Solve:
    """Solutions with rootᵀ root; components outside its row space stay zero. Raises ``LinAlgError``."""
    lengths = np.linalg.norm(root, axis=0)
    unit = 1.0 / np.where(lengths > 0, lengths, 1.0)
    R, order = qr(_large_first(root * unit), mode="r", pivoting=True, check_finite=False)
    sizes = np.abs(np.diag(R))
    # a diagonal that is zero to round-off belongs to a column that depends on those before it
    rank = int(np.count_nonzero(sizes > EPS * len(sizes) * sizes.max(initial=0.0)))
    known, R = order[:rank], R[:rank, :rank]

    def solve(right: FloatArray) -> FloatArray:
        found = np.zeros_like(right)
        half = solve_triangular(R, (unit * right)[known], trans=1, check_finite=False)
        found[known] = solve_triangular(R, half, check_finite=False)
        return np.asarray(unit * found)

    return solve
