"""The conditions of the energy ball in exact arithmetic, for the numbers as they are stored."""

from fractions import Fraction
from math import isqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from shakedown.bounds.exact_rows import exact_rows
from shakedown.ground.float_array import FloatArray
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips

if TYPE_CHECKING:
    from flint import fmpq_mat

DIGITS = 2**80  # denominator to which a square root is rounded up


class Products(NamedTuple):
    """B_i A⁻¹ B_iᵀ, B_i A⁻¹ A_iᵀ and A_i A⁻¹ A_iᵀ of a node, of any generalised inverse.

    The last two are B_ii and A_ii but for pinned nodes, where round-off makes a difference.
    """

    pressure: Fraction
    mixed: Fraction
    own: Fraction


class ExactBall:
    """Exact rows and exact γ² of a problem, against which slips and radii are checked.

    Slips are those relative to the pinned nodes, zero there.

    Nothing is rounded: stored numbers are fractions, square roots are avoided by
    comparing squares. ``regular`` is False where A as stored is not exactly positive
    semi-definite, where B reaches outside its range, or where it is not clear whether the
    body floats: then nothing is proved. What is pinned of a floating body plays no part.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> exact = ExactBall(shakedown.example("two-node"), transient=False)
    >>> centre = np.array([0.0336, 1.3412])
    >>> exact.holds(0.66, centre, 20.0), exact.holds(0.66, centre, 30.0)
    (True, False)
    """

    def __init__(self, problem: Problem, *, transient: bool) -> None:
        self.n = problem.n
        self._f = [Fraction(f) for f in problem.f.tolist()]
        self._A, self._B = _fractions(problem.A), _fractions(problem.B)
        rows = exact_rows(problem)
        self._rows = [
            ([Fraction(x) / rows.factors[i] for x in row], Fraction(right) / rows.factors[i])
            for i, (row, right) in enumerate(zip(rows.matrix, rows.right, strict=True))
        ]
        self._transient = self._least_transient(problem) if transient else None
        products = _products(problem)
        self.regular = products is not None and all(f > 0 for f in self._f)
        self._spread_squares = [] if products is None else self._clipped(products)

    def holds(self, load_factor: float, slip: FloatArray, radius: float | Fraction) -> bool:
        """Whether every row at a slip keeps more than the slack of a ball: f γ R < margin, exactly."""
        if not self.regular:
            return False
        v, factor, square = exact_vector(slip), Fraction(load_factor), Fraction(radius) ** 2
        for i, (row, right) in enumerate(self._rows):
            locked = sum((G * x for G, x in zip(row, v, strict=False)), Fraction(0))
            margins = [right - locked - row[-1] * factor]
            if self._transient is not None:
                margins.append(self._transient[i] - locked)
            least = min(margins)
            if least <= 0 or least**2 <= self._spread_squares[i] * square:
                return False
        return True

    def radius_to(self, slip: FloatArray, start: FloatArray, distance: float) -> Fraction:
        """A fraction just above the energy distance between two slips, plus a distance."""
        e = [a - b for a, b in zip(exact_vector(slip), exact_vector(start), strict=True)]
        square = sum(
            (x * sum((a * y for a, y in zip(row, e, strict=True)), Fraction(0)))
            for x, row in zip(e, self._A, strict=True)
        )
        return root_above(Fraction(square)) + Fraction(distance)

    def _clipped(self, products: list[Products]) -> list[Fraction]:
        """(f γ)² of every row: c = B_ii / A_ii, but not beyond ±1/f."""
        found = []
        for f, (S, mixed, own) in zip(self._f, products, strict=True):
            coupled = f * mixed
            for sign in (1, -1):
                if sign * coupled > own:  # ‖f B_i ∓ A_i‖²
                    found.append(f * f * S - 2 * sign * coupled + own)
                else:
                    found.append(f * f * S - (coupled * coupled / own if own else 0))
        return found

    def _least_transient(self, problem: Problem) -> list[Fraction] | None:
        if problem.q_transient is None or problem.p_transient is None or not len(problem.q_transient):
            return None
        q, p = (np.array(_fractions(part)) for part in (problem.q_transient, problem.p_transient))
        least: list[Fraction] = Law(np.array(self._f)).cone(q, p).min(axis=0).tolist()
        return least


def exact_vector(values: FloatArray) -> list[Fraction]:
    """Stored numbers (n,) as exact fractions."""
    return [Fraction(x) for x in values.tolist()]


def _fractions(matrix: FloatArray) -> list[list[Fraction]]:
    return [exact_vector(row) for row in matrix]


def root_above(square: Fraction) -> Fraction:
    """The square root of a fraction, rounded up."""
    if square <= 0:
        return Fraction(0)
    size = Fraction(2) ** ((square.numerator.bit_length() - square.denominator.bit_length()) // 2)
    whole = square / size**2 * DIGITS**2
    return Fraction(isqrt(int(whole)) + 1, DIGITS) * size


def _products(problem: Problem) -> list[Products] | None:
    """Products of every node; None where A and B do not fit, or where rigid slips are not clear."""
    from flint import fmpq, fmpq_mat  # not needed where only floats are used

    rigid, n = rigid_slips(problem), problem.n
    kept = [j for j in range(n) if j not in rigid.pinned]
    stacked = np.vstack([problem.A[kept][:, kept], problem.B[:, kept], problem.A[:, kept]])
    table = [[fmpq(*x.as_integer_ratio()) for x in row] for row in stacked.tolist()]
    k, zero = len(kept), fmpq(0)
    rows_B, rows_A = table[k : k + n], table[k + n :]
    if rigid.doubt or (k and not _semidefinite(fmpq_mat(table[:k]))):
        return None
    pivots: list[int] = []
    if k:
        reduced, rank = fmpq_mat(table).transpose().rref()
        pivots = [next(j for j in range(len(table)) if reduced[i, j] != 0) for i in range(rank)]
    if any(j >= k for j in pivots):
        return None  # some row of B is outside the range of A

    def product(row: "list[fmpq]", column: int) -> Fraction:
        """row · A⁻¹ · (a further row)."""
        value = sum((row[j] * reduced[i, column] for i, j in enumerate(pivots)), zero)
        return Fraction(int(value.p), int(value.q))

    return [
        Products(product(rows_B[i], k + i), product(rows_B[i], k + n + i), product(rows_A[i], k + n + i))
        for i in range(n)
    ]


def _semidefinite(A: "fmpq_mat") -> bool:
    """Whether no eigenvalue is negative: the signs of the characteristic polynomial alternate (Descartes)."""
    n = A.nrows()
    coefficients = A.charpoly().coeffs()
    return all(c * (-1) ** (n - k) >= 0 for k, c in enumerate(coefficients))
