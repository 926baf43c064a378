"""The exact upper bound by enumeration in fractions: no simplex, nothing of the package but the data."""

from fractions import Fraction
from itertools import combinations
from math import inf, lcm

import numpy as np

from shakedown import Problem

Row = list[Fraction]


def fraction_rows(problem: Problem) -> tuple[list[Row], Row]:
    """[G | d] and g of the problem as stored, straight from the definition."""

    def exact(array: np.ndarray) -> list:
        return [exact(a) for a in array] if np.ndim(array) else Fraction(float(array))

    n, m = problem.n, problem.m
    A, B, f, q, p = (exact(a) for a in (problem.A, problem.B, problem.f, problem.q_w, problem.p_w))
    q0 = [sum(q[k][j] for k in range(m)) / m for j in range(n)]
    p0 = [sum(p[k][j] for k in range(m)) / m for j in range(n)]
    if problem.q_mean is not None:
        q0, p0 = exact(problem.q_mean), exact(problem.p_mean)
    matrix, right = [], []
    for j in range(n):
        for side in (+1, -1):
            d = max(side * (q[k][j] - q0[j]) - f[j] * (p[k][j] - p0[j]) for k in range(m))
            matrix.append([side * A[j][i] - f[j] * B[j][i] for i in range(n)] + [d])
            right.append(f[j] * p0[j] - side * q0[j])
    return matrix, right


def load_factor_range(matrix: list[Row], right: Row) -> tuple[Fraction, Fraction | float] | None:
    """The load factors ≥ 0 with a safe slip, [low, high], or None: Gv + λd ≤ g with v eliminated.

    What remains is λ yᵀd ≤ yᵀg for every y ≥ 0 of smallest support with yᵀG = 0
    (Farkas); of rank at most n, no support has more than n + 1 rows. All of them
    are tried, so degenerate and singular problems need no care of their own.
    """
    low, high = Fraction(0), inf
    matrix, right = whole(matrix, right)
    n = len(matrix[0]) - 1
    for size in range(1, n + 2):
        for subset in combinations(range(len(matrix)), size):
            y = positive_dependence([matrix[i][:n] for i in subset])
            if y is None:
                continue
            d = sum(a * matrix[i][n] for a, i in zip(y, subset, strict=True))
            g = sum(a * right[i] for a, i in zip(y, subset, strict=True))
            if d > 0:
                high = min(high, Fraction(g, d))
            elif d < 0:
                low = max(low, Fraction(g, d))
            elif g < 0:
                return None
    return (low, high) if low <= high else None


def whole(matrix: list[Row], right: Row) -> tuple[list[list[int]], list[int]]:
    """The same rows times their denominators."""
    rows = [[*row, g] for row, g in zip(matrix, right, strict=True)]
    scales = [lcm(*(x.denominator for x in row)) for row in rows]
    found = [[int(x * scale) for x in row] for row, scale in zip(rows, scales, strict=True)]
    return [row[:-1] for row in found], [row[-1] for row in found]


def positive_dependence(rows: list[list[int]]) -> list[int] | None:
    """The only y > 0 (up to a factor) with Σ y_i rows_i = 0; None where there is none, or more than one."""
    columns, diagonal = [list(column) for column in zip(*rows, strict=True)], 1
    for k in range(len(rows) - 1):
        pivot = next((i for i in range(k, len(columns)) if columns[i][k]), None)
        if pivot is None:
            return None
        columns[k], columns[pivot] = columns[pivot], columns[k]
        head = columns[k]
        for i in range(len(columns)):
            if i != k:  # divides without a rest (Bareiss)
                own = columns[i]
                columns[i] = [(head[k] * x - own[k] * y) // diagonal for x, y in zip(own, head, strict=True)]
        diagonal = head[k]
    free, held = columns[len(rows) - 1 :], columns[: len(rows) - 1]
    if any(column[-1] for column in free):
        return None
    y = [-column[-1] if diagonal > 0 else column[-1] for column in held] + [abs(diagonal)]
    return y if min(y) > 0 else None


def solve_fractions(matrix: list[Row], right: Row) -> Row | None:
    """The solution of a square system; None where it is singular."""
    rows = [[*row, x] for row, x in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        pivot = next((i for i in range(k, n) if rows[i][k]), None)
        if pivot is None:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[-1] for row in rows]
