"""The tree of all row subsets, walked with the elimination of common prefixes shared (compiled).

A subset is a path of increasing row numbers. Choosing a row eliminates one slip
from all rows that can still follow, once for the whole subtree; the last three rows
share their cross products, so that a leaf costs two short dot products and one
division. The pivot is the row's largest entry among the slips that are left; the
load factor is eliminated only by a row in which no slip is left, which gives its value.

Where the largest entry is small, the prefix is *suspect*: it is set aside, with all
its completions, to be examined by other means.

Nothing is allocated in the walk, so it is compiled without counting references
(``_nrt=False``): to count those of a dozen arrays costs as much as the leaves of a call.
"""

from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shakedown.ground.code_cache import compiled, pipeline
from shakedown.ground.constants import ROUND_OFF, FloatArray

IntArray = NDArray[np.int64]

# Indices into the counters of ``Found``.
REGULAR, SUSPECTS, STORED, VIOLATED = range(4)

SUSPECT = 1e-7  # smaller pivots, in rows of size 1, are left to a method that estimates the condition number
DOUBTFUL = 1e3  # times the tolerance within which a point is solved again before it is judged

linked: Any = partial(njit, no_cpython_wrapper=True, no_cfunc_wrapper=True, **pipeline())
"""Compiles a function that only compiled code calls."""


class WalkSearch(NamedTuple):
    """The settings of the walk.

    Attributes
    ----------
    rows : (R, N + 1)
        Rows of size about 1: N − 1 slips, the load factor, the right-hand side.
    one_pair
        Only the paths 0, 1, then one of every further two rows.
    feasibility
        Largest violation of a row that a point on the safe region may have, relative
        to the largest terms.
    cut
        Load factors above it are stored; at +inf none is.
    """

    rows: FloatArray
    one_pair: bool
    feasibility: float
    cut: float


class WalkElimination(NamedTuple):
    """The state of the walk: the rows chosen, and all others after elimination.

    Attributes
    ----------
    work : (N, N + 1, R)
        At every depth, column by column, the rows without the slips eliminated so far.
    path, last : (N,)
        The row chosen at every depth, and the last one that can be.
    pivots : (N,)
        The column eliminated at every depth.
    known, level : (N + 1,)
        Whether the load factor is eliminated above a depth, and its value.
    x : (N,)
        Array for one point.
    square : (N, N + 1)
        Arrays for the equations of one subset.
    """

    work: FloatArray
    path: IntArray
    last: IntArray
    pivots: IntArray
    known: NDArray[np.bool_]
    level: FloatArray
    x: FloatArray
    square: FloatArray


class Suspects(NamedTuple):
    """Receives the suspect prefixes (S, N) and their lengths (S,), as far as it reaches; counts them all."""

    prefixes: IntArray
    lengths: IntArray
    counters: IntArray


class WalkFindings(NamedTuple):
    """The findings of the walk.

    Attributes
    ----------
    values
        Receives the load factors above the cut, as far as it reaches.
    record : (2,)
        In and out: smallest positive load factor so far, and smallest one on the safe region.
    subsets : (2, N)
        Their rows, where the walk found them; else zero.
    counters : (4,)
        Number of regular subsets, suspect prefixes, load factors above the cut, and the
        row found violated last.
    """

    values: FloatArray
    record: FloatArray
    subsets: IntArray
    counters: IntArray


class Whole(NamedTuple):
    """The data of one walk."""

    search: WalkSearch
    state: WalkElimination
    found: WalkFindings
    suspects: Suspects


class Limits(NamedTuple):
    """The last row that can stand third from the end, the number of rows given, and the cut."""

    last: int
    given: int
    cut: float


@linked()
def set_aside(path: IntArray, length: int, suspects: Suspects) -> None:
    """Store the first ``length`` rows of a path as a suspect, up to capacity; count it in any case."""
    index = suspects.counters[SUSPECTS]
    if index < suspects.lengths.size:
        for t in range(length):
            suspects.prefixes[index, t] = path[t]
        suspects.lengths[index] = length
    suspects.counters[SUSPECTS] += 1


@linked()
def _keep(value: float, values: FloatArray, counters: IntArray) -> None:
    """Store a load factor above the cut, up to capacity; count it in any case."""
    if counters[STORED] < values.size:
        values[counters[STORED]] = value
    counters[STORED] += 1


@linked(fastmath={"contract"}, inline="always", _nrt=False)
def leaves(whole: Whole) -> None:
    """The last two rows: one slip and the load factor (or, where that is known, two slips) are left."""
    search, state, found = whole.search, whole.state, whole.found
    R, N = search.rows.shape[0], search.rows.shape[1] - 1
    reduced, path, x = state.work[N - 2], state.path, state.x
    known, cut, one_pair = state.known[N - 2], search.cut, search.one_pair
    record, counters = found.record, found.counters
    for row in range(path[N - 2], state.last[N - 2] + 1):
        path[N - 2] = row
        a, b, g = reduced[0, row], reduced[1, row], reduced[2, row]
        own, other, fixed = 0, 1, known
        if known and abs(b) > abs(a):
            a, b = b, a
            own, other = 1, 0
        if abs(a) <= SUSPECT:
            if abs(a) > ROUND_OFF or known or abs(b) <= SUSPECT:
                set_aside(path, N - 1, whole.suspects)
                continue
            own, other, fixed = 1, 0, True  # no slip is left in the row, so it determines the load factor
            a, b = b, a
        b, g = b / a, g / a
        value = state.level[N - 2] if known else g
        first, end = row + 1, R
        if one_pair:
            first, end = (1, 2) if N == 2 else (2 * N - 4, 2 * N - 2)
        for leaf in range(first, end):
            d = reduced[other, leaf] - b * reduced[own, leaf]
            if abs(d) <= SUSPECT:
                path[N - 1] = leaf
                set_aside(path, N, whole.suspects)
                continue
            rest = (reduced[2, leaf] - g * reduced[own, leaf]) / d
            if not fixed:
                value = rest
            counters[REGULAR] += 1
            if value > cut:
                _keep(value, found.values, counters)
            if value <= 0.0 or value >= max(record[0], record[1]):
                continue
            path[N - 1] = leaf
            x[own], x[other] = g - b * rest, rest
            _consider(whole, value, N - 3)


@linked(fastmath={"contract"}, _nrt=False)
def triples(
    work: FloatArray,
    path: IntArray,
    record: FloatArray,
    counters: IntArray,
    values: FloatArray,
    limits: Limits,
    whole: Whole,
) -> None:
    """The last three rows, with two slips and the load factor left: Cramer's rule.

    With the cross product of the first two rows (of their slips and load factor, and of
    their slips and right-hand side), every third row costs two dot products and a division.
    If the path is given up to the second of them, only that one is tried. The arrays of
    every leaf are handed down one by one: to take them out of ``whole`` costs as much as a leaf.
    """
    R, N = work.shape[2], path.size
    a, b, d, g = work[N - 3, 0], work[N - 3, 1], work[N - 3, 2], work[N - 3, 3]
    for i in range(path[N - 3], limits.last + 1):
        path[N - 3] = i
        first, stop = i + 1, R - 1
        if limits.given >= N - 1:
            first, stop = path[N - 2], path[N - 2] + 1
        for j in range(first, stop):
            m = a[i] * b[j] - a[j] * b[i]
            s, t = b[i] * d[j] - b[j] * d[i], d[i] * a[j] - d[j] * a[i]
            size = max(abs(m), abs(s), abs(t))
            path[N - 2] = j
            if size <= SUSPECT:
                set_aside(path, N - 1, whole.suspects)
                continue
            u, w = b[i] * g[j] - b[j] * g[i], g[i] * a[j] - g[j] * a[i]
            for k in range(j + 1, R):
                below = s * a[k] + t * b[k] + m * d[k]
                if abs(below) <= SUSPECT * size:
                    path[N - 1] = k
                    set_aside(path, N, whole.suspects)
                    continue
                value = (u * a[k] + w * b[k] + m * g[k]) / below
                counters[REGULAR] += 1
                if value > limits.cut:
                    _keep(value, values, counters)
                if value <= 0.0 or value >= max(record[0], record[1]):
                    continue
                path[N - 1] = k
                _two_slips(work[N - 3], path, value, whole.state.x)
                _consider(whole, value, N - 4)


@linked()
def _two_slips(reduced: FloatArray, path: IntArray, value: float, x: FloatArray) -> None:
    """The two slips left, once the load factor is known, from the two rows that determine them best."""
    N = path.size
    i, j, k = path[N - 3], path[N - 2], path[N - 1]
    a, b, d, g = reduced[0], reduced[1], reduced[2], reduced[3]
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


@linked(fastmath={"contract"})
def _looks_safe(search: WalkSearch, state: WalkElimination, counters: IntArray, deepest: int) -> bool:
    """Put back the eliminated slips and look for a violated row, first where one was found last time.

    ``x`` starts with the last unknowns, those that depths beyond ``deepest`` leave.
    """
    rows, x, work, path, pivots = search.rows, state.x, state.work, state.path, state.pivots
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
    tolerance, largest = DOUBTFUL * search.feasibility, 0.0
    for c in range(N):
        largest = max(largest, abs(x[c]))
    for k in range(R):
        i = counters[VIOLATED] + k
        if i >= R:
            i -= R
        if _excess(rows, i, x) > tolerance * (largest + abs(rows[i, N])):
            counters[VIOLATED] = i
            return False
    return True


@linked(fastmath={"contract"})
def _excess(rows: FloatArray, i: int, x: FloatArray) -> float:
    """By how much a point violates a row."""
    N = rows.shape[1] - 1
    excess = -rows[i, N]
    for c in range(N):
        excess += rows[i, c] * x[c]
    return excess


@linked()
def _consider(whole: Whole, value: float, deepest: int) -> None:
    """Solve a promising subset from scratch; keep it if it breaks a record."""
    search, state, found = whole.search, whole.state, whole.found
    rows, record = search.rows, found.record
    if value >= record[0] and not _looks_safe(search, state, found.counters, deepest):
        return
    R, N = rows.shape[0], rows.shape[1] - 1
    x = state.x
    spread = _solved(rows, state.path, state.square, x)
    if not spread > 0.0:
        return
    size = 0.0
    for c in range(N):
        size = max(size, abs(x[c]))
    if x[N - 1] <= 2.0**-52 * size / spread:  # zero to round-off
        return
    if x[N - 1] < record[0]:
        record[0] = x[N - 1]
        for c in range(N):
            found.subsets[0, c] = state.path[c]
    if x[N - 1] < record[1]:
        largest = size
        for i in range(R):
            largest = max(largest, abs(rows[i, N]))
        for i in range(R):
            if _excess(rows, i, x) > search.feasibility * largest:
                return
        record[1] = x[N - 1]
        for c in range(N):
            found.subsets[1, c] = state.path[c]


@linked()
def _solved(rows: FloatArray, path: IntArray, m: FloatArray, x: FloatArray) -> float:
    """Solve one subset for ``x`` by partial pivoting; gives the smallest pivot relative to the largest."""
    N = rows.shape[1] - 1
    for t in range(N):
        for c in range(N + 1):
            m[t, c] = rows[path[t], c]
    least, most = np.inf, 0.0
    for k in range(N):
        p = k
        for i in range(k + 1, N):
            if abs(m[i, k]) > abs(m[p, k]):
                p = i
        if m[p, k] == 0.0:
            return 0.0
        if p != k:
            for c in range(k, N + 1):
                m[k, c], m[p, c] = m[p, c], m[k, c]
        least, most = min(least, abs(m[k, k])), max(most, abs(m[k, k]))
        for i in range(k + 1, N):
            factor = m[i, k] / m[k, k]
            for c in range(k + 1, N + 1):
                m[i, c] -= factor * m[k, c]
    for i in range(N - 1, -1, -1):
        total = m[i, N]
        for c in range(i + 1, N):
            total -= m[i, c] * x[c]
        x[i] = total / m[i, i]
    return least / most


def elimination(rows: FloatArray, prefix: IntArray) -> WalkElimination:
    """The state with only the prefix chosen and nothing eliminated."""
    R, N = rows.shape[0], rows.shape[1] - 1
    work = np.empty((N, N + 1, R))
    work[0] = rows.T
    path = np.zeros(N, dtype=np.int64)
    path[: prefix.size] = prefix
    last, pivots = np.zeros((2, N), dtype=np.int64)
    more = np.empty(N), np.empty((N, N + 1))
    return WalkElimination(work, path, last, pivots, np.zeros(N + 1, dtype=np.bool_), np.zeros(N + 1), *more)


@partial(compiled, nogil=True, fastmath={"contract"}, _nrt=False)
def walk(whole: Whole, prefix: IntArray) -> None:
    """Visit every completion of a prefix of fewer than N rows.

    Every turn moves the path on in the order of the tree, or up: it ends after as many
    turns as there are prefixes, and one more for each to leave it.
    """
    work, path, last, pivots, known, level = whole.state[:6]
    values, record, _, counters = whole.found
    R, N, given, one_pair, cut = (
        work.shape[2],
        path.size,
        prefix.size,
        whole.search.one_pair,
        whole.search.cut,
    )
    depth, entered = 0, False
    while depth >= 0:
        if not entered:
            path[depth], last[depth] = _children(depth, path[depth - 1] if depth else -1, R, N, one_pair)
            if depth < given:
                path[depth] = last[depth] = prefix[depth]
            entered = True
            if N - depth == 3 and not one_pair and not known[depth]:
                if given == N - 1:
                    path[N - 2] = prefix[N - 2]
                triples(work, path, record, counters, values, Limits(last[depth], given, cut), whole)
                path[depth] = last[depth] + 1
            elif N - depth == 2:
                leaves(whole)
                path[depth] = last[depth] + 1
        elif path[depth] > last[depth]:
            depth -= 1
            if depth >= 0:
                path[depth] += 1
        else:
            row, width = path[depth], N - depth
            pivot, known[depth + 1] = _pivot(work, depth, row, width, known[depth])
            if pivot < 0:
                for t in range(depth + 1, given):  # the walk of another prefix must not count it again
                    path[t] = prefix[t]
                set_aside(path, max(depth + 1, given), whole.suspects)
                path[depth] += 1
                continue
            level[depth + 1] = (
                level[depth] if known[depth] else work[depth, width, row] / work[depth, pivot, row]
            )
            pivots[depth] = pivot
            _eliminate(work, depth, pivot, row, 2 * depth if one_pair and depth else row + 1)
            depth, entered = depth + 1, False


@linked(inline="always")
def _children(depth: int, previous: int, R: int, N: int, one_pair: bool) -> tuple[int, int]:
    """First and last row that can stand at a depth."""
    if one_pair:
        if depth < 2:
            return depth, depth
        return 2 * depth - 2, 2 * depth - 1
    return previous + 1, R - N + depth


@linked(_nrt=False)
def _pivot(work: FloatArray, depth: int, row: int, width: int, known: bool) -> tuple[int, bool]:
    """The largest entry of a row to eliminate, −1 if it is too small, and whether λ is known then."""
    pivot, size = 0, abs(work[depth, 0, row])
    for c in range(1, width if known else width - 1):
        entry = abs(work[depth, c, row])
        if entry > size:
            pivot, size = c, entry
    if size > SUSPECT:
        return pivot, known
    if size > ROUND_OFF or known or abs(work[depth, width - 1, row]) <= SUSPECT:
        return -1, known
    return width - 1, True


@linked(fastmath={"contract"}, _nrt=False)
def _eliminate(work: FloatArray, depth: int, pivot: int, row: int, first: int) -> None:
    """Eliminate one column from all rows that can follow, from ``first`` on."""
    R = work.shape[2]
    scale = 1.0 / work[depth, pivot, row]
    target = 0
    for c in range(work.shape[0] - depth + 1):
        if c == pivot:
            continue
        step = work[depth, c, row] * scale
        for i in range(first, R):
            work[depth + 1, target, i] = work[depth, c, i] - step * work[depth, pivot, i]
        target += 1
