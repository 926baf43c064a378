"""A program over discs of few nodes at many load steps, by interior points in its homogeneous form."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import blas, cho_factor, cho_solve

from shakedown.ground.errors import SolverError
from shakedown.ground.status import Status
from shakedown.programs.interior.disc_cones import SIZE, DiscCones, DiscScaling
from shakedown.programs.interior.symmetric_cone import FloatArray, SymmetricCone

ITERATIONS = 80
REACHED = 1e-10  # gap and residuals at which it stops
USABLE = 1e-6  # what they must have reached where round-off ends it earlier
PROVED = 1e-9  # what is left of a proof that there is no solution, or no end, relative to its size
PATIENCE = 4  # iterations that gain nothing, where round-off ends it
REFINEMENTS = 3  # of every solution of the normal equations, at most
SOLVED = 1e-13  # residual, relative, from where on there is nothing to refine
STEP = 0.99  # share of the way to the boundary
SHIFTS = (
    1e-15,
    1e-13,
    1e-11,
    1e-9,
)  # of the normal equations, relative, until round-off leaves them definite


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
        The node of every disc, in increasing order, each at least once.
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
    """

    blocks: FloatArray
    node: NDArray[np.intp]
    extra: FloatArray
    right: FloatArray
    rows: FloatArray
    rows_extra: FloatArray
    rows_right: FloatArray
    cost: FloatArray
    norm: FloatArray | None = None
    offset: float = 0.0

    @property
    def rank(self) -> int:
        """r, how many numbers y has."""
        return self.blocks.shape[2]

    @cached_property
    def starts(self) -> NDArray[np.intp]:
        """The first disc of every node."""
        return np.flatnonzero(np.append(True, np.diff(self.node) > 0))

    @cached_property
    def _flat(self) -> FloatArray:
        """The blocks below each other, (3n, r)."""
        return self.blocks.reshape(-1, self.rank)

    @cached_property
    def cones(self) -> DiscCones:
        """Where the slacks are: the discs, the rows, the bound of the length."""
        return DiscCones(
            len(self.node), SymmetricCone(len(self.rows), 0 if self.norm is None else self.rank + 1)
        )

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
        discs = (self._flat @ y).reshape(-1, SIZE)[self.node] + self.extra @ w
        tail = np.zeros(0) if self.norm is None else -np.append(self.norm @ w, y)
        return np.concatenate([discs.ravel(), self.rows @ y + self.rows_extra @ w, tail])

    def transposed(self, z: FloatArray) -> FloatArray:
        """What multipliers of discs, rows and bound add up to."""
        K, k = len(self.node), len(self.rows)
        discs, rows, tail = np.split(z, [SIZE * K, SIZE * K + k])
        discs = discs.reshape(K, SIZE)
        of_nodes = np.add.reduceat(discs, self.starts)
        y = of_nodes.ravel() @ self._flat + rows @ self.rows
        w = discs.ravel() @ self.extra.reshape(SIZE * K, -1) + rows @ self.rows_extra
        if self.norm is not None:
            y, w = y - tail[1:], w - tail[0] * self.norm
        return np.append(y, w)

    def normal_matrix(self, scaling: DiscScaling) -> FloatArray:
        """Mᵀ W⁻² M in the lower triangle, M all of the coefficients."""
        rank, squares = self.rank, scaling.inverse_squares()
        of_nodes = np.add.reduceat(squares, self.starts)
        values, vectors = np.linalg.eigh(of_nodes)  # round-off may leave one below zero
        halves = np.sqrt(np.maximum(values, 0.0))[:, :, None] * np.swapaxes(vectors, 1, 2)
        weighted = self.rows / scaling.rest.diagonal[:, None]
        stacked = np.vstack([(halves @ self.blocks).reshape(-1, rank), weighted])
        normal = np.zeros((len(self.costs), len(self.costs)), order="F")
        normal[:rank, :rank] = blas.dsyrk(1.0, stacked.T, lower=1)
        weighed = squares @ self.extra
        mixed = np.add.reduceat(weighed, self.starts)
        across = mixed.reshape(-1, mixed.shape[2]).T @ self._flat
        loads = self.rows_extra / scaling.rest.diagonal[:, None]
        normal[rank:, :rank] = across + loads.T @ weighted
        own = np.tensordot(self.extra, weighed, axes=((0, 1), (0, 1)))
        normal[rank:, rank:] = own + loads.T @ loads
        if self.norm is not None:
            square = scaling.rest.inverse_square()
            normal[:rank, :rank] += square[1:, 1:]
            normal[rank:, :rank] += np.outer(self.norm, square[0, 1:])
            normal[rank:, rank:] += square[0, 0] * np.outer(self.norm, self.norm)
        return normal


@dataclass(frozen=True)
class DiscEnd:
    """How a program ended.

    Attributes
    ----------
    status
        Optimal, infeasible or unbounded.
    y, w : (r,), (p,)
        The solution; the ray of an unbounded program.
    discs, rows : (K, 3), (k,)
        Multipliers in the cones; of an infeasible program those that prove it.
    accuracy
        The largest of the relative gap and the relative residuals.
    """

    status: Status
    y: FloatArray
    w: FloatArray
    discs: FloatArray
    rows: FloatArray
    accuracy: float


class Point(NamedTuple):
    """An iterate: x, slacks and multipliers inside the cones, and the two numbers τ, κ > 0."""

    x: FloatArray
    s: FloatArray
    z: FloatArray
    tau: float
    kappa: float


def solved(program: DiscProgram) -> DiscEnd:
    """The end of a program, to about ten digits.

    In the homogeneous form every program has an optimum: at its end either τ > 0 and (x, s, z) / τ is that
    of the program, or κ > 0, and z proves that there is no solution or x that there is no end.

    Raises
    ------
    SolverError
        If it ends without an answer.

    Examples
    --------
    The largest w such that (1 − y, w) is within a circle of radius 1 about the origin, and |y| ≤ 0.2:

    >>> program = DiscProgram(
    ...     blocks=np.array([[[0.0], [1.0], [0.0]]]), node=np.array([0]),
    ...     extra=np.array([[[0.0], [0.0], [1.0]]]), right=np.array([[1.0, 1.0, 0.0]]),
    ...     rows=np.array([[1.0], [-1.0]]), rows_extra=np.zeros((2, 1)), rows_right=np.array([0.2, 0.2]),
    ...     cost=np.array([-1.0]),
    ... )
    >>> end = solved(program)
    >>> str(end.status), end.y.round(6), end.w.round(6)
    ('optimal', array([0.2]), array([0.6]))
    """
    with np.errstate(all="ignore"):  # what overflows is no end, and is not taken for one
        return _solved(program)


def _solved(program: DiscProgram) -> DiscEnd:
    unit, columns = program.cones.unit, len(program.costs)
    point = Point(np.zeros(columns), unit.copy(), unit.copy(), 1.0, 1.0)
    best, idle = None, 0
    for _ in range(ITERATIONS):
        found = _judged(program, point)
        better = best is None or found.accuracy < best.accuracy
        best, idle = (found, 0) if better or best is None else (best, idle + 1)
        if best.accuracy <= REACHED or (best.accuracy <= USABLE and idle >= PATIENCE):
            break
        try:
            point = _next(program, point)
        except (np.linalg.LinAlgError, ValueError):  # round-off ends it
            break
        if not (np.all(np.isfinite(point.x)) and point.tau > 0 and point.kappa > 0):
            break
    if best is None or best.accuracy > USABLE:
        raise SolverError(f"the program of {len(program.node)} discs ended without an answer")
    return best


def _judged(program: DiscProgram, point: Point) -> DiscEnd:
    """What an iterate says, and how well."""
    x, s, z, tau, _ = point
    value, proved = float(program.costs @ x), -float(program.limits @ z)
    balance, primal = program.transposed(z), program.times(x) + s
    size = 1.0 + float(np.linalg.norm(program.limits)) / np.sqrt(len(program.limits))
    shares = (
        float(np.linalg.norm(primal / tau - program.limits)) / np.sqrt(len(s)) / size,
        float(np.linalg.norm(balance / tau + program.costs)),
        abs(value - proved) / tau / max(1e-3, abs(value) / tau, abs(proved) / tau),
    )
    ends = [(max(shares) if np.all(np.isfinite(shares)) else np.inf, Status.OPTIMAL, tau)]
    if proved > 0 and float(np.linalg.norm(balance)) <= PROVED * proved:
        ends.append((0.0, Status.INFEASIBLE, proved))
    if value < 0 and float(np.linalg.norm(primal)) / np.sqrt(len(s)) <= PROVED * -value:
        ends.append((0.0, Status.UNBOUNDED, -value))
    accuracy, status, unit = min(ends, key=lambda end: end[0])
    K, k, rank = len(program.node), len(program.rows), program.rank
    discs, rows = z[: SIZE * K].reshape(K, SIZE) / unit, z[SIZE * K : SIZE * K + k] / unit
    return DiscEnd(status, x[:rank] / unit, x[rank:] / unit, discs, rows, accuracy)


Solver = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


def _newton_equations(program: DiscProgram, scaling: DiscScaling) -> Solver:
    """(dx, dz) of Mᵀ dz = first and M dx − W² dz = second."""
    factor = _factor(program.normal_matrix(scaling))

    def inverse_square(u: FloatArray) -> FloatArray:
        return scaling.divided(scaling.divided(u))

    def solve(first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
        right = first + program.transposed(inverse_square(second))
        dx = np.asarray(factor(right), dtype=float)
        dz = inverse_square(program.times(dx) - second)
        for _ in range(REFINEMENTS):
            rest = first - program.transposed(dz)
            if np.linalg.norm(rest) <= SOLVED * np.linalg.norm(right):
                break
            more = factor(rest)
            dx, dz = dx + more, dz + inverse_square(program.times(more))
        return dx, dz

    return solve


def _factor(normal: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Solutions of a positive definite matrix in units of its diagonal, shifted as little as it takes."""
    diagonal = np.einsum("ii->i", normal)
    unit = 1.0 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    normal *= unit
    normal *= unit[:, None]
    for shift in SHIFTS:
        shifted = normal.copy(order="F")
        np.einsum("ii->i", shifted)[:] += shift
        try:
            factor = cho_factor(shifted, lower=True, overwrite_a=True, check_finite=False)
        except np.linalg.LinAlgError:
            continue
        return lambda right: unit * cho_solve(factor, unit * right, check_finite=False)
    raise np.linalg.LinAlgError("the normal equations are not positive definite")


def _next(program: DiscProgram, point: Point) -> Point:
    """One step of Mehrotra in the homogeneous form."""
    cones, c, h = program.cones, program.costs, program.limits
    x, s, z, tau, kappa = point
    scaling = cones.scaling(s, z)
    solve, centre = _newton_equations(program, scaling), scaling.point
    left = program.transposed(z) + c * tau
    short = s + program.times(x) - h * tau
    open_ = kappa + float(c @ x) + float(h @ z)
    x1, z1 = solve(-c, h)
    slope = -kappa / tau + float(c @ x1) + float(h @ z1)

    def step(share: float, target: FloatArray, product: float) -> Point:
        wanted = scaling.times(cones.quotient(centre, target))
        x2, z2 = solve(-share * left, wanted - share * short)
        dtau = (product / tau - share * open_ - float(c @ x2) - float(h @ z2)) / slope
        dx, dz = x2 + dtau * x1, z2 + dtau * z1
        ds = h * dtau - share * short - program.times(dx)
        return Point(dx, scaling.divided(ds), scaling.times(dz), dtau, -(product + kappa * dtau) / tau)

    def reach(d: Point) -> float:
        numbers = [-u / du for u, du in ((tau, d.tau), (kappa, d.kappa)) if du < 0]
        return min(cones.reach(centre, d.s), cones.reach(centre, d.z), *numbers, np.inf)

    square = cones.product(centre, centre)
    mean = (float(s @ z) + tau * kappa) / (cones.degree + 1)
    ahead = step(1.0, square, tau * kappa)
    sigma = (1.0 - min(1.0, reach(ahead))) ** 3
    target = square + cones.product(ahead.s, ahead.z) - sigma * mean * cones.unit
    d = step(1.0 - sigma, target, tau * kappa + ahead.tau * ahead.kappa - sigma * mean)
    length = min(1.0, STEP * reach(d))
    return Point(
        x + length * d.x,
        s + length * scaling.times(d.s),
        z + length * scaling.divided(d.z),
        tau + length * d.tau,
        kappa + length * d.kappa,
    )
