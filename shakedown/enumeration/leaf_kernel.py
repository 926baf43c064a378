"""The last rows of a subset: its load factor, and the records that it may break (compiled)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shakedown.model.problem import FloatArray

IntArray = NDArray[np.int64]

SUSPECT = 1e-7  # smaller pivots, in rows of size 1, are left to a method that sees the condition number
ABSENT = 1e-13  # entries that round-off leaves of zero

# Indices into the counters that a walk returns.
REGULAR, SUSPECTS, STORED, BEST_FOUND, SAFEST_FOUND, VIOLATED = range(6)


@njit(nogil=True, cache=True)
def set_aside(path: IntArray, length: int, suspects: IntArray, lengths: IntArray, counters: IntArray) -> None:
    """Store the first ``length`` rows of a path as a suspect, while there is room; count it in any case."""
    index = counters[SUSPECTS]
    if index < lengths.size:
        for t in range(length):
            suspects[index, t] = path[t]
        lengths[index] = length
    counters[SUSPECTS] += 1


@njit(nogil=True, cache=True, fastmath={"contract"})
def leaves(
    rows: FloatArray,
    work: FloatArray,
    path: IntArray,
    pivots: IntArray,
    x: FloatArray,
    last: int,
    known: bool,
    level: float,
    one_pair: bool,
    tolerance: float,
    cut: float,
    values: FloatArray,
    suspects: IntArray,
    lengths: IntArray,
    record: FloatArray,
    best_rows: IntArray,
    safest_rows: IntArray,
    counters: IntArray,
) -> None:
    """The last two rows: one slip and the load factor (or, where that is known, two slips) are left."""
    R, N = rows.shape[0], rows.shape[1] - 1
    reduced = work[N - 2]
    for row in range(path[N - 2], last + 1):
        path[N - 2] = row
        a, b, g = reduced[0, row], reduced[1, row], reduced[2, row]
        first, end = row + 1, R
        if one_pair:
            first, end = (1, 2) if N == 2 else (2 * N - 4, 2 * N - 2)
        solves_level = False
        if known and abs(b) > abs(a):
            a, b = b, a
            own, other = 1, 0
        else:
            own, other = 0, 1
        if abs(a) <= SUSPECT:
            if abs(a) <= ABSENT and not known and abs(b) > SUSPECT:
                solves_level = True
                own, other = 1, 0
                a, b = b, a
            else:
                set_aside(path, N - 1, suspects, lengths, counters)
                continue
        ratio = 1.0 / a
        value = g * ratio if solves_level else level
        b *= ratio
        g *= ratio
        for leaf in range(first, end):
            d = reduced[other, leaf] - b * reduced[own, leaf]
            if abs(d) <= SUSPECT:
                path[N - 1] = leaf
                set_aside(path, N, suspects, lengths, counters)
                continue
            if not (known or solves_level):
                value = (reduced[2, leaf] - g * reduced[own, leaf]) / d
            counters[REGULAR] += 1
            if value > cut:
                if counters[STORED] < values.size:
                    values[counters[STORED]] = value
                counters[STORED] += 1
            if value <= 0.0:
                continue
            if value >= record[0]:
                if value >= record[1]:
                    continue
                z = (reduced[2, leaf] - g * reduced[own, leaf]) / d
                x[own], x[other] = g - b * z, z
                if not _looks_safe(rows, work, path, pivots, x, N - 3, tolerance, counters):
                    continue
            path[N - 1] = leaf
            _consider(rows, path, tolerance, record, best_rows, safest_rows, counters)


@njit(nogil=True, cache=True, fastmath={"contract"})
def triples(
    rows: FloatArray,
    work: FloatArray,
    path: IntArray,
    pivots: IntArray,
    x: FloatArray,
    last: int,
    fixed: int,
    tolerance: float,
    cut: float,
    values: FloatArray,
    suspects: IntArray,
    lengths: IntArray,
    record: FloatArray,
    best_rows: IntArray,
    safest_rows: IntArray,
    counters: IntArray,
) -> None:
    """The last three rows, with two slips and the load factor left: Cramer's rule.

    With the cross product of the first two rows (of their slips and load factor, and of
    their slips and right-hand side), every third row costs two dot products and a division.
    """
    R, N = rows.shape[0], rows.shape[1] - 1
    a, b, d, g = work[N - 3, 0], work[N - 3, 1], work[N - 3, 2], work[N - 3, 3]
    for i in range(path[N - 3], last + 1):
        path[N - 3] = i
        stop = R - 1 if fixed < N - 1 else path[N - 2] + 1
        for j in range(i + 1, stop):
            m = a[i] * b[j] - a[j] * b[i]
            s, t = b[i] * d[j] - b[j] * d[i], d[i] * a[j] - d[j] * a[i]
            size = max(abs(m), abs(s), abs(t))
            path[N - 2] = j
            if size <= SUSPECT:
                set_aside(path, N - 1, suspects, lengths, counters)
                continue
            u, w = b[i] * g[j] - b[j] * g[i], g[i] * a[j] - g[j] * a[i]
            for k in range(j + 1, R):
                below = s * a[k] + t * b[k] + m * d[k]
                if abs(below) <= SUSPECT * size:
                    path[N - 1] = k
                    set_aside(path, N, suspects, lengths, counters)
                    continue
                value = (u * a[k] + w * b[k] + m * g[k]) / below
                counters[REGULAR] += 1
                if value > cut:
                    if counters[STORED] < values.size:
                        values[counters[STORED]] = value
                    counters[STORED] += 1
                if value <= 0.0 or value >= max(record[0], record[1]):
                    continue
                path[N - 1] = k
                if value >= record[0]:
                    _two_slips(a, b, d, g, i, j, k, value, x)
                    if not _looks_safe(rows, work, path, pivots, x, N - 4, tolerance, counters):
                        continue
                _consider(rows, path, tolerance, record, best_rows, safest_rows, counters)


@njit(nogil=True, cache=True)
def _two_slips(
    a: FloatArray,
    b: FloatArray,
    d: FloatArray,
    g: FloatArray,
    i: int,
    j: int,
    k: int,
    value: float,
    x: FloatArray,
) -> None:
    """The two slips left, once the load factor is known, from the two rows that determine them best."""
    p, q, best = i, j, abs(a[i] * b[j] - a[j] * b[i])
    if abs(a[i] * b[k] - a[k] * b[i]) > best:
        q, best = k, abs(a[i] * b[k] - a[k] * b[i])
    if abs(a[j] * b[k] - a[k] * b[j]) > best:
        p, q = j, k
    right_p, right_q = g[p] - d[p] * value, g[q] - d[q] * value
    minor = a[p] * b[q] - a[q] * b[p]
    x[0] = (right_p * b[q] - right_q * b[p]) / minor
    x[1] = (a[p] * right_q - a[q] * right_p) / minor
    x[2] = value


@njit(nogil=True, cache=True, fastmath={"contract"})
def _looks_safe(
    rows: FloatArray,
    work: FloatArray,
    path: IntArray,
    pivots: IntArray,
    x: FloatArray,
    deepest: int,
    tolerance: float,
    counters: IntArray,
) -> bool:
    """Put back the eliminated slips and look for a violated row, first where one was found last time.

    ``x`` starts with the last unknowns, those that depths beyond ``deepest`` leave.
    """
    R, N = rows.shape[0], rows.shape[1] - 1
    for depth in range(deepest, -1, -1):
        pivot, row, width = pivots[depth], path[depth], N - depth
        total = work[depth, width, row]
        for c in range(width - 1, pivot, -1):
            x[c] = x[c - 1]
            total -= work[depth, c, row] * x[c]
        for c in range(pivot):
            total -= work[depth, c, row] * x[c]
        x[pivot] = total / work[depth, pivot, row]
    allowed = 0.0
    for c in range(N):
        allowed = max(allowed, abs(x[c]))
    allowed *= 1e3 * tolerance
    for k in range(R):
        i = counters[VIOLATED] + k
        if i >= R:
            i -= R
        excess = -rows[i, N]
        for c in range(N):
            excess += rows[i, c] * x[c]
        if excess > allowed + 1e3 * tolerance * abs(rows[i, N]):
            counters[VIOLATED] = i
            return False
    return True


@njit(nogil=True, cache=True)
def _consider(
    rows: FloatArray,
    path: IntArray,
    tolerance: float,
    record: FloatArray,
    best_rows: IntArray,
    safest_rows: IntArray,
    counters: IntArray,
) -> None:
    """Solve a promising subset from scratch; keep it if it breaks a record."""
    R, N = rows.shape[0], rows.shape[1] - 1
    x, spread = _solved(rows, path)
    if not spread > 0.0:
        return
    size = np.abs(x).max()
    if x[N - 1] <= 2.0**-52 * size / spread:  # zero to round-off
        return
    if x[N - 1] < record[0]:
        record[0] = x[N - 1]
        best_rows[:] = path
        counters[BEST_FOUND] = 1
    if x[N - 1] < record[1]:
        largest = 0.0
        for i in range(R):
            largest = max(largest, abs(rows[i, N]))
        allowed = tolerance * max(size, largest)
        for i in range(R):
            excess = -rows[i, N]
            for c in range(N):
                excess += rows[i, c] * x[c]
            if excess > allowed:
                return
        record[1] = x[N - 1]
        safest_rows[:] = path
        counters[SAFEST_FOUND] = 1


@njit(nogil=True, cache=True)
def _solved(rows: FloatArray, path: IntArray) -> tuple[FloatArray, float]:
    """Solution of one subset by partial pivoting, and the smallest pivot relative to the largest."""
    N = rows.shape[1] - 1
    m = np.empty((N, N + 1))
    for t in range(N):
        m[t] = rows[path[t]]
    least, most = np.inf, 0.0
    for k in range(N):
        p = k
        for i in range(k + 1, N):
            if abs(m[i, k]) > abs(m[p, k]):
                p = i
        if m[p, k] == 0.0:
            return m[:, N].copy(), 0.0
        if p != k:
            for c in range(k, N + 1):
                m[k, c], m[p, c] = m[p, c], m[k, c]
        least, most = min(least, abs(m[k, k])), max(most, abs(m[k, k]))
        for i in range(k + 1, N):
            factor = m[i, k] / m[k, k]
            for c in range(k + 1, N + 1):
                m[i, c] -= factor * m[k, c]
    x = np.empty(N)
    for i in range(N - 1, -1, -1):
        total = m[i, N]
        for c in range(i + 1, N):
            total -= m[i, c] * x[c]
        x[i] = total / m[i, i]
    return x, least / most
