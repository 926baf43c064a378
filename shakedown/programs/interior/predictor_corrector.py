"""A dense linear or second-order cone program by interior points: predictor, corrector, one factor each."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import blas, cho_factor, cho_solve, solve_triangular
from scipy.linalg import cholesky as cholesky_factor

from shakedown.programs.interior.symmetric_cone import Scaling, SymmetricCone

FloatArray = NDArray[np.float64]

ITERATIONS = 60
REACHED = 1e-10  # gap and residuals at which it stops
USABLE = 1e-6  # what they must have reached where round-off ends it earlier
PATIENCE = 3  # iterations that gain nothing, where round-off ends it
REFINEMENTS = 1  # of every solution of the normal equations
STEP = 0.99  # share of the way to the boundary


@dataclass(frozen=True)
class InteriorEnd:
    """Where the interior points ended.

    Attributes
    ----------
    x : (N,)
        The solution.
    slack, multipliers : (R,)
        Of the rows: right − M x, and y ≥ 0; the rows of the optimum are those with slack < y in
        the units of the program.
    accuracy
        The largest of gap and residuals, relative.
    """

    x: FloatArray
    slack: FloatArray
    multipliers: FloatArray
    accuracy: float


class Point(NamedTuple):
    """An iterate: x, slacks inside the cone, multipliers inside the cone."""

    x: FloatArray
    s: FloatArray
    y: FloatArray


@dataclass(frozen=True)
class DenseProgram:
    """Minimise cᵀ x subject to M x ≤ right and, with a cone, ‖(x_0, …, x_{r−1})‖ + offset ≤ x_r.

    The rows should have the size 1, and so the right-hand sides.

    Examples
    --------
    >>> square = np.vstack([np.eye(2), -np.eye(2)])
    >>> end = solved(DenseProgram(square, np.ones(4), np.array([-1.0, -2.0])))
    >>> end.x.round(8), np.flatnonzero(end.slack < end.multipliers)
    (array([1., 1.]), array([0, 1]))
    """

    matrix: FloatArray
    right: FloatArray
    cost: FloatArray
    rank: int | None = None
    offset: float = 0.0

    @property
    def cone(self) -> SymmetricCone:
        """Where the slacks are."""
        return SymmetricCone(len(self.right), 0 if self.rank is None else self.rank + 1)

    @property
    def columns(self) -> NDArray[np.intp]:
        """The columns in the order of the second-order cone: the radius, then the vector."""
        return np.zeros(0, np.intp) if self.rank is None else np.append(self.rank, np.arange(self.rank))

    @property
    def limits(self) -> FloatArray:
        """Right-hand sides of the rows and of the cone."""
        if self.rank is None:
            return self.right
        return np.concatenate([self.right, [-self.offset], np.zeros(self.rank)])

    def times(self, x: FloatArray) -> FloatArray:
        """Rows and cone at x."""
        return np.concatenate([self.matrix @ x, -x[self.columns]])

    def transposed(self, y: FloatArray) -> FloatArray:
        """What multipliers of rows and cone add up to."""
        found: FloatArray = self.matrix.T @ y[: len(self.right)]
        found[self.columns] -= y[len(self.right) :]
        return found


def solved(program: DenseProgram) -> InteriorEnd | None:
    """The optimum to about ten digits; None where no optimum is found, be there one or not."""
    with np.errstate(all="ignore"):  # what overflows is no optimum, and is not taken for one
        try:
            return _solved(program)
        except np.linalg.LinAlgError:
            return None


def preconditioned(matrix: FloatArray) -> FloatArray | None:
    """R with RᵀR = MᵀM, an upper factor: in R x the columns are orthonormal; None where M lacks rank."""
    try:
        return np.asarray(cholesky_factor(matrix.T @ matrix), dtype=float)
    except np.linalg.LinAlgError:
        return None


def in_units_of(factor: FloatArray, matrix: FloatArray) -> FloatArray:
    """M R⁻¹."""
    return np.asarray(solve_triangular(factor, matrix.T, trans=1).T, dtype=float)


def _solved(program: DenseProgram) -> InteriorEnd | None:
    cone, point = program.cone, _start(program)
    best, accuracy, idle = point, np.inf, 0
    for _ in range(ITERATIONS):
        reached = _accuracy(program, point)
        idle = 0 if reached < accuracy else idle + 1
        if reached < accuracy:
            best, accuracy = point, reached
        if accuracy <= REACHED or (accuracy <= USABLE and idle >= PATIENCE):
            break
        scaling = cone.scaling(point.s, point.y)
        if not np.all(np.isfinite(scaling.point)):
            break
        try:
            point = _next(program, point, scaling)
        except np.linalg.LinAlgError:
            break
    if accuracy > USABLE:
        return None
    rows = len(program.right)
    return InteriorEnd(best.x, best.s[:rows], best.y[:rows], accuracy)


def _accuracy(program: DenseProgram, point: Point) -> float:
    """The largest of the relative gap and the relative residuals."""
    x, s, y = point
    rows = program.limits - program.times(x) - s
    columns = program.cost + program.transposed(y)
    value = max(abs(float(program.cost @ x)), abs(float(program.limits @ y)), np.finfo(float).tiny)
    shares = (
        float(s @ y) / value,
        float(np.linalg.norm(rows)) / max(1.0, float(np.linalg.norm(program.limits))),
        float(np.linalg.norm(columns)) / max(1.0, float(np.linalg.norm(program.cost))),
    )
    return max(shares) if np.all(np.isfinite(shares)) else np.inf


def _start(program: DenseProgram) -> Point:
    """The least squares of rows and of multipliers, moved into the cone."""
    cone = program.cone
    solve = _normal_equations(program, cone.scaling(cone.unit, cone.unit))
    x = solve(program.transposed(program.limits))
    s, y = program.limits - program.times(x), program.times(solve(-program.cost))
    return Point(x, _inside(cone, s), _inside(cone, y))


def _inside(cone: SymmetricCone, u: FloatArray) -> FloatArray:
    margin = cone.margin(u)
    return u if margin > 0 else u + (1.0 - margin) * cone.unit


def _normal_equations(program: DenseProgram, scaling: Scaling) -> Callable[[FloatArray], FloatArray]:
    """The solution of Mᵀ W⁻² M x = right for any right-hand side."""
    scaled = (program.matrix / scaling.diagonal[:, None]).T  # in Fortran's order, as the product wants it
    normal = blas.dsyrk(1.0, scaled, lower=1)
    if program.rank is not None:
        size = program.rank + 1
        # The radius comes last among the columns.
        of_cone = np.roll(scaling.inverse_square(), -1, axis=(0, 1))
        normal[:size, :size] += np.tril(of_cone)
    factor = cho_factor(normal, lower=True, overwrite_a=True, check_finite=False)

    def solve(right: FloatArray) -> FloatArray:
        x = np.asarray(cho_solve(factor, right, check_finite=False), dtype=float)
        for _ in range(REFINEMENTS):
            rest = right - program.transposed(scaling.divided(scaling.divided(program.times(x))))
            x = x + cho_solve(factor, rest, check_finite=False)
        return x

    return solve


def _next(program: DenseProgram, point: Point, scaling: Scaling) -> Point:
    """One step of Mehrotra: towards the optimum, then with what that step leaves corrected."""
    cone, centre = program.cone, scaling.point
    solve = _normal_equations(program, scaling)
    left = -(program.cost + program.transposed(point.y))
    short = program.limits - program.times(point.x) - point.s

    def step(share: float, target: FloatArray) -> Point:
        """Of the equations M dx + ds = share · short, Mᵀ dy = share · left, λ ∘ (W dy + W⁻¹ ds) = target."""
        wanted = cone.quotient(centre, target)
        right = scaling.divided(scaling.divided(share * short - scaling.times(wanted)))
        dx = solve(share * left + program.transposed(right))
        dy = scaling.divided(scaling.divided(program.times(dx))) - right
        ds = share * short - program.times(dx)  # what x really leaves: W (wanted − W dy) cancels near the end
        return Point(dx, scaling.divided(ds), scaling.times(dy))  # slack and multiplier as scaled

    square = cone.product(centre, centre)
    ahead = step(1.0, -square)
    length = min(1.0, cone.reach(centre, ahead.s), cone.reach(centre, ahead.y))
    sigma = (1.0 - length) ** 3
    mean = float(point.s @ point.y) / cone.degree
    d = step(1.0 - sigma, sigma * mean * cone.unit - square - cone.product(ahead.s, ahead.y))
    length = min(1.0, STEP * min(cone.reach(centre, d.s), cone.reach(centre, d.y)))
    return Point(
        point.x + length * d.x, point.s + length * scaling.times(d.s), point.y + length * scaling.divided(d.y)
    )
