"""Equations of the nodes that move, and the inverse of their matrix, updated as nodes change state.

Displacements and reactions are stacked as u = (v, w) and r = (q, p), so that
(2.10), (2.11) read r = r_w + κ u. A node that moves adds equations, each named
by the displacement ``col`` that it frees and a coefficient ``coef``:

    backward slip   q − f p = 0     frees v     (col = i, coef = +f)
    forward slip    q + f p = 0     frees v     (col = i, coef = −f)
    separation      q = 0, p = 0    frees v, w  (col = i and n + i, coef = 0)

Row ``col`` of κ, less ``coef`` times row n + ``col``, is the equation's left-hand
side. The matrix of these rows in the freed columns is unsymmetric; its inverse
is kept explicitly and follows a change of state by bordering, in O(a²) for a
equations. The sign of its determinant is kept too: negative means that the
motion, although it satisfies the law, is unstable (chapter VI); zero means that
the matrix is singular and what stands for its inverse must not be used.
"""

from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from shakedown.kernels.gauss_seidel import BACKWARD_SLIP, FORWARD_SLIP, OPEN, STICK
from shakedown.model.problem import FloatArray

SIZE, SIGN, FRESH = 0, 1, 2  # entries of ActiveSet.meta
SINGULAR = 1e-13  # pivot, relative to the terms that it is the difference of, that counts as zero


class ActiveSet(NamedTuple):
    """Equations of the moving nodes and the inverse of their matrix (leading ``meta[SIZE]`` rows)."""

    kappa: FloatArray  # (2n, 2n) contact stiffness
    f: FloatArray  # (n,) friction coefficients
    state: NDArray[np.int64]  # (n,) STICK, BACKWARD_SLIP, FORWARD_SLIP, OPEN
    col: NDArray[np.int64]  # (2n,) freed displacement of each equation
    coef: FloatArray  # (2n,) coefficient of p in each equation
    place: NDArray[np.int64]  # (2n,) equation that frees a displacement, or −1
    inverse: FloatArray  # (2n, 2n)
    meta: NDArray[np.int64]  # number of equations, sign of the determinant, updates since factorized
    row: FloatArray  # (2n,) scratch
    column: FloatArray  # (2n,) scratch


def active_set(kappa: FloatArray, f: FloatArray) -> ActiveSet:
    """All nodes stuck."""
    n = len(f)
    return ActiveSet(
        kappa=np.ascontiguousarray(kappa, dtype=float),
        f=np.array(f, dtype=float),
        state=np.zeros(n, dtype=np.int64),
        col=np.zeros(2 * n, dtype=np.int64),
        coef=np.zeros(2 * n),
        place=np.full(2 * n, -1, dtype=np.int64),
        inverse=np.zeros((2 * n, 2 * n)),
        meta=np.array([0, 1, 0], dtype=np.int64),
        row=np.zeros(2 * n),
        column=np.zeros(2 * n),
    )


@numba.njit(cache=True)
def entry(act: Any, col: int, coef: float, j: int) -> float:
    """Entry of the equation (col, coef) in the column of displacement j."""
    if coef == 0.0:
        return act.kappa[col, j]
    return act.kappa[col, j] - coef * act.kappa[len(act.f) + col, j]


@numba.njit(cache=True, fastmath={"reassoc", "contract"})
def border(act: Any, col: int, coef: float) -> bool:
    """Add one equation; False, and nothing changed, where the matrix would be singular."""
    a, inverse, row, column = act.meta[SIZE], act.inverse, act.row, act.column
    row[:a] = 0.0
    pivot = entry(act, col, coef, col)
    size = abs(pivot)
    for b in range(a):  # row = (new row) M⁻¹
        x = entry(act, col, coef, act.col[b])
        if x != 0.0:
            for c in range(a):
                row[c] += x * inverse[b, c]
    for c in range(a):
        y = entry(act, act.col[c], act.coef[c], col)
        column[c] = y
        pivot -= row[c] * y
        size = max(size, abs(row[c] * y))
    if abs(pivot) <= SINGULAR * size:
        return False
    for b in range(a):  # last column = −M⁻¹ (new column) / pivot
        total = 0.0
        for c in range(a):
            total += inverse[b, c] * column[c]
        inverse[b, a] = -total / pivot
    for b in range(a):
        x = inverse[b, a]
        for c in range(a):
            inverse[b, c] -= x * row[c]
    for c in range(a):
        inverse[a, c] = -row[c] / pivot
    inverse[a, a] = 1.0 / pivot
    act.col[a], act.coef[a], act.place[col] = col, coef, a
    act.meta[SIZE] = a + 1
    act.meta[FRESH] += 1
    if pivot < 0.0:
        act.meta[SIGN] = -act.meta[SIGN]
    return True


@numba.njit(cache=True)
def strike(act: Any, col: int) -> bool:
    """Remove the equation that frees ``col``; False where the rest of the matrix is singular."""
    k, a, inverse = act.place[col], act.meta[SIZE] - 1, act.inverse
    pivot = inverse[k, k]
    largest = 0.0
    for b in range(a + 1):
        largest = max(largest, abs(inverse[b, k]), abs(inverse[k, b]))
    if abs(pivot) <= SINGULAR * largest:
        return False
    if k != a:
        for b in range(a + 1):
            inverse[k, b], inverse[a, b] = inverse[a, b], inverse[k, b]
        for b in range(a + 1):
            inverse[b, k], inverse[b, a] = inverse[b, a], inverse[b, k]
        act.col[k], act.coef[k] = act.col[a], act.coef[a]
        act.place[act.col[k]] = k
    for b in range(a):
        x = inverse[b, a] / pivot
        if x != 0.0:
            for c in range(a):
                inverse[b, c] -= x * inverse[a, c]
    act.place[col] = -1
    act.meta[SIZE] = a
    act.meta[FRESH] += 1
    if pivot < 0.0:
        act.meta[SIGN] = -act.meta[SIGN]
    return True


@numba.njit(cache=True)
def factorize(act: Any) -> bool:
    """Set up the equations of the present states afresh; False where their matrix is singular.

    Gauss–Jordan elimination with row exchanges.
    """
    n, a = len(act.f), 0
    act.place[:] = -1
    for i in range(n):
        if act.state[i] != STICK:
            act.col[a], act.coef[a], act.place[i] = i, slip_coefficient(act, i), a
            a += 1
        if act.state[i] == OPEN:
            act.col[a], act.coef[a], act.place[n + i] = n + i, 0.0, a
            a += 1
    act.meta[SIZE], act.meta[SIGN], act.meta[FRESH] = a, 1, 0
    matrix, inverse = np.empty((a, a)), act.inverse
    for b in range(a):
        for c in range(a):
            matrix[b, c] = entry(act, act.col[b], act.coef[b], act.col[c])
            inverse[b, c] = 1.0 if b == c else 0.0
    for k in range(a):
        best = k
        for b in range(k + 1, a):
            if abs(matrix[b, k]) > abs(matrix[best, k]):
                best = b
        size = np.abs(act.kappa[act.col[k]]).max()
        if abs(matrix[best, k]) <= SINGULAR * size:
            act.meta[SIGN] = 0
            return False
        if best != k:
            for c in range(a):
                matrix[k, c], matrix[best, c] = matrix[best, c], matrix[k, c]
                inverse[k, c], inverse[best, c] = inverse[best, c], inverse[k, c]
            act.meta[SIGN] = -act.meta[SIGN]
        pivot = matrix[k, k]
        if pivot < 0.0:
            act.meta[SIGN] = -act.meta[SIGN]
        for c in range(a):
            matrix[k, c] /= pivot
            inverse[k, c] /= pivot
        for b in range(a):
            x = matrix[b, k]
            if b != k and x != 0.0:
                for c in range(a):
                    matrix[b, c] -= x * matrix[k, c]
                    inverse[b, c] -= x * inverse[k, c]
    return True


@numba.njit(cache=True)
def slip_coefficient(act: Any, i: int) -> float:
    """Coefficient of p in the tangential equation of node i in its present state."""
    if act.state[i] == BACKWARD_SLIP:
        return act.f[i]
    if act.state[i] == FORWARD_SLIP:
        return -act.f[i]
    return 0.0


@numba.njit(cache=True)
def change_states(act: Any, wanted: Any) -> bool:
    """Move every node to its wanted state; False where the new matrix is singular.

    Equations are removed first, so that a load reversal, where most slipping
    nodes stop at once, gets cheaper with every node. A matrix that was singular
    leaves no inverse to update.
    """
    n, sound = len(act.f), act.meta[SIGN] != 0
    for i in range(n):
        if wanted[i] != act.state[i] and act.state[i] != STICK and sound:
            if act.state[i] == OPEN:
                sound = strike(act, n + i)
            sound = sound and strike(act, i)
    for i in range(n):
        if wanted[i] != act.state[i]:
            act.state[i] = wanted[i]
            if wanted[i] != STICK and sound:
                sound = border(act, i, slip_coefficient(act, i))
                if wanted[i] == OPEN:
                    sound = sound and border(act, n + i, 0.0)
    return sound or factorize(act)


@numba.njit(cache=True, fastmath={"reassoc", "contract"})
def solve(act: Any, residual: Any, change: Any) -> None:
    """Displacements ``change`` (2n,) that cancel the residuals (2n,: q then p) of the active equations."""
    n, a = len(act.f), act.meta[SIZE]
    change[:] = 0.0
    for b in range(a):
        col, coef = act.col[b], act.coef[b]
        x = residual[col]
        if coef != 0.0:
            x -= coef * residual[n + col]
        act.column[b] = x
    for b in range(a):
        total = 0.0
        for c in range(a):
            total -= act.inverse[b, c] * act.column[c]
        change[act.col[b]] = total


@numba.njit(cache=True)
def add_product(act: Any, change: Any, reaction: Any) -> None:
    """reaction += κ change, skipping displacements that do not change."""
    for j in range(len(change)):
        x = change[j]
        if x != 0.0:
            for k in range(len(reaction)):
                reaction[k] += x * act.kappa[j, k]


@numba.njit(cache=True)
def largest_residual(act: Any, reaction: Any) -> float:
    """Largest |residual| of the active equations [force]."""
    n, largest = len(act.f), 0.0
    for b in range(act.meta[SIZE]):
        col, coef = act.col[b], act.coef[b]
        x = reaction[col]
        if coef != 0.0:
            x -= coef * reaction[n + col]
        largest = max(largest, abs(x))
    return largest
