"""The conditions of the energy ball in exact arithmetic, for the numbers as they are stored."""

from fractions import Fraction
from math import isqrt
from typing import TYPE_CHECKING

from shakedown.model.problem import FloatArray, Problem
from shakedown.programs.exact_rows import exact_rows

if TYPE_CHECKING:
    from flint import fmpq_mat

DIGITS = 2**80  # to which a square root is rounded up


class ExactBall:
    """Exact rows and exact γ² of a problem, against which slips and radii are checked.

    Nothing is rounded: stored numbers are fractions, square roots are avoided by
    comparing squares. ``regular`` is False where A as stored is not exactly positive
    semi-definite, or where B reaches outside its range (a floating body with the
    round-off of its assembly): then nothing is proved.

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
        squares = _complements(problem)
        self.regular = squares is not None and all(f > 0 for f in self._f)
        self._spread_squares = [] if squares is None else self._clipped(squares)

    def holds(self, load_factor: float, slip: FloatArray, radius: float | Fraction) -> bool:
        """Whether every row at a slip keeps more than the room of a ball: f γ R < margin, exactly."""
        if not self.regular:
            return False
        v, factor, square = _vector(slip), Fraction(load_factor), Fraction(radius) ** 2
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
        e = [a - b for a, b in zip(_vector(slip), _vector(start), strict=True)]
        square = sum(
            (x * sum((a * y for a, y in zip(row, e, strict=True)), Fraction(0)))
            for x, row in zip(e, self._A, strict=True)
        )
        return _root_above(Fraction(square)) + Fraction(distance)

    def _clipped(self, squares: list[Fraction]) -> list[Fraction]:
        """(f γ)² of every row: c = B_ii / A_ii, but not beyond ±1/f."""
        found = []
        for i, (f, S) in enumerate(zip(self._f, squares, strict=True)):
            own, coupled = self._A[i][i], f * self._B[i][i]
            for sign in (1, -1):
                if sign * coupled > own:  # ‖f B_i ∓ A_i‖²
                    found.append(f * f * S - 2 * sign * coupled + own)
                else:
                    found.append(f * f * S - (coupled * coupled / own if own else 0))
        return found

    def _least_transient(self, problem: Problem) -> list[Fraction] | None:
        if problem.q_transient is None or problem.p_transient is None or not len(problem.q_transient):
            return None
        least = []
        for i, f in enumerate(self._f):
            q, p = (_vector(part[:, i]) for part in (problem.q_transient, problem.p_transient))
            least += [min(f * b - sign * a for a, b in zip(q, p, strict=True)) for sign in (1, -1)]
        return least


def _vector(values: FloatArray) -> list[Fraction]:
    return [Fraction(x) for x in values.tolist()]


def _fractions(matrix: FloatArray) -> list[list[Fraction]]:
    return [_vector(row) for row in matrix]


def _root_above(square: Fraction) -> Fraction:
    """The square root of a fraction, rounded up."""
    if square <= 0:
        return Fraction(0)
    size = Fraction(2) ** ((square.numerator.bit_length() - square.denominator.bit_length()) // 2)
    whole = square / size**2 * DIGITS**2
    return Fraction(isqrt(int(whole)) + 1, DIGITS) * size


def _complements(problem: Problem) -> list[Fraction] | None:
    """B_i A⁻¹ B_iᵀ of every node, of any generalised inverse; None where A and B are not of the kind."""
    from flint import fmpq, fmpq_mat  # a plain sweep of floats does not need it

    n = problem.n
    numbers = ([fmpq(*x.as_integer_ratio()) for x in M.ravel().tolist()] for M in (problem.A, problem.B))
    A, B = (fmpq_mat(n, n, entries) for entries in numbers)
    if not _semidefinite(A):
        return None
    both = fmpq_mat([[*left, *right] for left, right in zip(A.tolist(), B.transpose().tolist(), strict=True)])
    reduced, rank = both.rref()
    pivots = [next(j for j in range(2 * n) if reduced[k, j] != 0) for k in range(rank)]
    if any(j >= n for j in pivots):
        return None  # some row of B is outside the range of A
    found = []
    for i in range(n):
        value = sum((B[i, j] * reduced[k, n + i] for k, j in enumerate(pivots)), B[0, 0] * 0)
        found.append(Fraction(int(value.p), int(value.q)))
    return found


def _semidefinite(A: "fmpq_mat") -> bool:
    """Whether no eigenvalue is negative: the signs of the characteristic polynomial alternate (Descartes)."""
    n = A.nrows()
    coefficients = A.charpoly().coeffs()
    return all(c * (-1) ** (n - k) >= 0 for k, c in enumerate(coefficients))
