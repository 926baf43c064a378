"""Linear complementarity problems by Lemke's method with the lexicographic rule."""

from typing import Any

import numba
import numpy as np

FOUND, RAY, LIMIT_REACHED = 0, 1, 2


@numba.njit(cache=True)
def lemke(M: Any, b: Any, max_pivots: int) -> Any:
    """z ≥ 0 with y = M z + b ≥ 0 and zᵀ y = 0 (Cottle, Pang & Stone, algorithms 4.4.5 and 4.9.3).

    Parameters
    ----------
    M : (k, k)
    b : (k,)
    max_pivots
        Give up after so many pivots.

    Returns
    -------
    status
        FOUND; RAY, which for matrices outside the classes that Lemke's method
        processes does not prove that there is no solution; LIMIT_REACHED.
    z : (k,)

    Examples
    --------
    >>> status, z = lemke(np.array([[2.0, 1.0], [0.0, 1.0]]), np.array([-3.0, -1.0]), 100)
    >>> status == FOUND, z
    (True, array([1., 1.]))
    """
    k = len(b)
    z = np.zeros(k)
    if k == 0 or b.min() >= 0.0:
        return FOUND, z
    # Columns: y (k), z (k), covering variable, right-hand side. y − M z − z0 = b.
    table = np.zeros((k, 2 * k + 2))
    basis = np.arange(k)
    for i in range(k):
        table[i, i] = 1.0
        table[i, k : 2 * k] = -M[i]
        table[i, 2 * k] = -1.0
        table[i, 2 * k + 1] = b[i]
    row = 0  # most negative b; of equal ones the lexicographically smallest row is the last
    for i in range(1, k):
        if b[i] <= b[row]:
            row = i
    entering = 2 * k
    for _ in range(max_pivots):
        leaving = basis[row]
        exchange(table, row, entering)
        basis[row] = entering
        if leaving == 2 * k:
            for i in range(k):
                if k <= basis[i] < 2 * k:
                    z[basis[i] - k] = max(table[i, 2 * k + 1], 0.0)
            return FOUND, z
        entering = leaving + k if leaving < k else leaving - k
        row = leaving_row(table, basis, entering)
        if row < 0:
            return RAY, z
    return LIMIT_REACHED, z


@numba.njit(cache=True)
def exchange(table: Any, row: int, column: int) -> None:
    """Gauss–Jordan step on one entry of the table."""
    table[row] /= table[row, column]
    for i in range(len(table)):
        if i != row and table[i, column] != 0.0:
            table[i] -= table[i, column] * table[row]


@numba.njit(cache=True)
def leaving_row(table: Any, basis: Any, entering: int) -> int:
    """Row of the lexicographically smallest ratio, −1 where the column has no positive entry.

    The covering variable leaves whenever it may.
    """
    k, row = len(table), -1
    small = 1e-11 * np.abs(table[:, entering]).max()
    for i in range(k):
        if table[i, entering] > small and (row < 0 or smaller_ratio(table, i, row, entering)):
            row = i
    if row < 0:
        return row
    best = table[row, 2 * k + 1] / table[row, entering]
    for i in range(k):
        if basis[i] == 2 * k and table[i, entering] > small:
            ratio = table[i, 2 * k + 1] / table[i, entering]
            if ratio <= best + 1e-13 * abs(best):
                return i
    return row


@numba.njit(cache=True)
def smaller_ratio(table: Any, i: int, row: int, entering: int) -> bool:
    """Whether row i, divided by its entering entry, is lexicographically smaller than ``row``."""
    k = len(table)
    order = 2 * k + 1
    for step in range(k + 1):  # right-hand side first, then the columns of the inverse basis
        column = order if step == 0 else step - 1
        a, b = table[i, column] / table[i, entering], table[row, column] / table[row, entering]
        if abs(a - b) > 1e-13 * max(abs(a), abs(b)):
            return a < b
    return False
