"""The tree of all row subsets, walked with the elimination of common prefixes shared (compiled).

A subset is a path of increasing row numbers. Choosing a row eliminates one slip
from all rows that can still follow, once for the whole subtree; a leaf then costs
a short dot product and one division. The pivot is the row's largest entry among the slips that are left; the
load factor is eliminated only by a row in which no slip is left, which gives its value.

Where the largest entry is small, the prefix is *suspect*: it is set aside, with all
its completions, to be examined by other means.

Nothing is allocated in the walk, so it is compiled without counting references
(``_nrt=False``): to count those of a dozen arrays costs as much as the leaves of a call.
"""

from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, combinations
from math import comb, inf
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shakedown.bounds.intersection import NONE, ScaledRows, SubtreeFindings, in_batches, joined, solve_subsets
from shakedown.ground.code_cache import compiled, pipeline
from shakedown.ground.constants import BLOCK, ROUND_OFF, FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import all_cores

Int64Array = NDArray[np.int64]

# Indices into the counters of ``TreeWalk``.
REGULAR, SUSPECTS, VIOLATED = range(3)

SUSPECT = 1e-7  # smaller pivots, in rows of size 1, are left to a method that estimates the condition number
DOUBTFUL = 1e3  # times the tolerance within which a point is solved again before it is judged

linked: Any = partial(njit, no_cpython_wrapper=True, no_cfunc_wrapper=True, **pipeline())
"""Compiles a function that only compiled code calls."""


class TreeWalk(NamedTuple):
    """The data of one walk over the subsets of N of R rows, its state and its findings.

    Attributes
    ----------
    rows : (R, N + 1)
        Rows of size about 1: N − 1 slips, the load factor, the right-hand side.
    feasibility
        Largest violation of a row that a point on the safe region may have, relative
        to the largest terms.
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
        Array for the equations of one subset.
    values
        Receives the load factors of all regular subsets; empty where none is to be kept.
    record : (2,)
        In and out: smallest positive load factor so far, and smallest one on the safe region.
    subsets : (2, N)
        Their rows, where the walk found them; else zero.
    prefixes, lengths : (S, N), (S,)
        Receive the suspect prefixes.
    counters : (3,)
        Number of regular subsets, number of suspect prefixes, and the row found violated last.
    """

    rows: FloatArray
    feasibility: float
    work: FloatArray
    path: Int64Array
    last: Int64Array
    pivots: Int64Array
    known: NDArray[np.bool_]
    level: FloatArray
    x: FloatArray
    square: FloatArray
    values: FloatArray
    record: FloatArray
    subsets: Int64Array
    prefixes: NDArray[np.int32]
    lengths: NDArray[np.int32]
    counters: Int64Array


@linked()
def set_aside(path: Int64Array, length: int, found: TreeWalk) -> None:
    """Store the first ``length`` rows of a path as a suspect."""
    index = found.counters[SUSPECTS]
    for t in range(length):
        found.prefixes[index, t] = path[t]
    found.lengths[index] = length
    found.counters[SUSPECTS] += 1


@linked(fastmath={"contract"}, inline="always", _nrt=False)
def leaves(state: TreeWalk) -> None:
    """The last two rows: one slip and the load factor (or, where that is known, two slips) are left."""
    R, N = state.rows.shape[0], state.rows.shape[1] - 1
    reduced, path, x = state.work[N - 2], state.path, state.x
    known, values, record, counters = state.known[N - 2], state.values, state.record, state.counters
    for row in range(path[N - 2], state.last[N - 2] + 1):
        path[N - 2] = row
        a, b, g = reduced[0, row], reduced[1, row], reduced[2, row]
        own, other, fixed = 0, 1, known
        if known and abs(b) > abs(a):
            a, b = b, a
            own, other = 1, 0
        if abs(a) <= SUSPECT:
            if abs(a) > ROUND_OFF or known or abs(b) <= SUSPECT:
                set_aside(path, N - 1, state)
                continue
            own, other, fixed = 1, 0, True  # no slip is left in the row, so it determines the load factor
            a, b = b, a
        b, g = b / a, g / a
        value = state.level[N - 2] if known else g
        for leaf in range(row + 1, R):
            d = reduced[other, leaf] - b * reduced[own, leaf]
            if abs(d) <= SUSPECT:
                path[N - 1] = leaf
                set_aside(path, N, state)
                continue
            rest = (reduced[2, leaf] - g * reduced[own, leaf]) / d
            if not fixed:
                value = rest
            if values.size:
                values[counters[REGULAR]] = value
            counters[REGULAR] += 1
            if value <= 0.0 or value >= max(record[0], record[1]):
                continue
            path[N - 1] = leaf
            x[own], x[other] = g - b * rest, rest
            _consider(state, value)


@linked(fastmath={"contract"})
def _looks_safe(state: TreeWalk) -> bool:
    """Put back the eliminated slips and look for a violated row, first where one was found last time.

    ``x`` starts with the last two unknowns.
    """
    rows, x, work, path, pivots = state.rows, state.x, state.work, state.path, state.pivots
    R, N, counters = rows.shape[0], rows.shape[1] - 1, state.counters
    for depth in range(N - 3, -1, -1):
        pivot, row, width = pivots[depth], path[depth], N - depth
        total = work[depth, width, row]
        for c in range(width - 1, pivot, -1):
            x[c] = x[c - 1]
            total -= work[depth, c, row] * x[c]
        for c in range(pivot):
            total -= work[depth, c, row] * x[c]
        x[pivot] = total / work[depth, pivot, row]
    tolerance, largest = DOUBTFUL * state.feasibility, 0.0
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
def _consider(state: TreeWalk, value: float) -> None:
    """Solve a promising subset from scratch; keep it if it breaks a record."""
    rows, record, x = state.rows, state.record, state.x
    if value >= record[0] and not _looks_safe(state):
        return
    R, N = rows.shape[0], rows.shape[1] - 1
    spread = _solved(rows, state.path, state.square, x)
    if not spread > 0.0:
        return
    size = 0.0
    for c in range(N):
        size = max(size, abs(x[c]))
    if x[N - 1] <= 2.0**-52 * N * size / spread:  # zero to round-off
        return
    if x[N - 1] < record[0]:
        record[0] = x[N - 1]
        for c in range(N):
            state.subsets[0, c] = state.path[c]
    if x[N - 1] < record[1]:
        largest = size
        for i in range(R):
            largest = max(largest, abs(rows[i, N]))
        for i in range(R):
            if _excess(rows, i, x) > state.feasibility * largest:
                return
        record[1] = x[N - 1]
        for c in range(N):
            state.subsets[1, c] = state.path[c]


@linked()
def _solved(rows: FloatArray, path: Int64Array, m: FloatArray, x: FloatArray) -> float:
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


@partial(compiled, nogil=True, fastmath={"contract"}, _nrt=False)
def walk(state: TreeWalk, prefix: Int64Array) -> None:
    """Visit every completion of a prefix of fewer than N rows.

    Every turn moves the path on in the order of the tree, or up: it ends after as many
    turns as there are prefixes, and one more for each to leave it.
    """
    work, path, last, pivots, known, level = state[2:8]
    R, N, given = work.shape[2], path.size, prefix.size
    depth, entered = 0, False
    while depth >= 0:
        if not entered:
            path[depth], last[depth] = path[depth - 1] + 1 if depth else 0, R - N + depth
            if depth < given:
                path[depth] = last[depth] = prefix[depth]
            entered = True
            if N - depth == 2:
                leaves(state)
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
                set_aside(path, max(depth + 1, given), state)
                path[depth] += 1
                continue
            level[depth + 1] = (
                level[depth] if known[depth] else work[depth, width, row] / work[depth, pivot, row]
            )
            pivots[depth] = pivot
            _eliminate(work, depth, pivot, row)
            depth, entered = depth + 1, False


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
def _eliminate(work: FloatArray, depth: int, pivot: int, row: int) -> None:
    """Eliminate one column from all rows that can follow."""
    R = work.shape[2]
    scale = 1.0 / work[depth, pivot, row]
    target = 0
    for c in range(work.shape[0] - depth + 1):
        if c == pivot:
            continue
        step = work[depth, c, row] * scale
        for i in range(row + 1, R):
            work[depth + 1, target, i] = work[depth, c, i] - step * work[depth, pivot, i]
        target += 1


@dataclass(frozen=True)
class Tree:
    """A tree of row subsets.

    Attributes
    ----------
    rows
        The 2n rows.
    values
        Whether all load factors are kept.
    feasible_below
        Points on the safe region are looked for below this load factor only.
    tolerances
        What counts as degenerate and as safe.
    """

    rows: ScaledRows
    values: bool = False
    feasible_below: float = inf
    tolerances: Tolerances = DEFAULT


def pieces(tree: Tree, threads: int | None = None) -> Iterator[SubtreeFindings]:
    """Walk the whole tree; the pieces come in order, and each is complete.

    Parameters
    ----------
    tree
        What to walk.
    threads
        Number of threads; all cores by default.
    """
    workers = threads or all_cores()
    waiting: deque[Future[SubtreeFindings]] = deque()
    with ThreadPoolExecutor(workers) as pool:
        try:
            for prefix, size in tasks(tree.rows):
                waiting.append(pool.submit(walk_piece, tree, prefix, size))
                if len(waiting) > 2 * workers:
                    piece = waiting.popleft().result()
                    tree = replace(tree, feasible_below=min(tree.feasible_below, piece.smallest_feasible[0]))
                    yield piece
            yield from (future.result() for future in waiting)
        finally:
            for future in waiting:
                future.cancel()


def tasks(rows: ScaledRows) -> Iterator[tuple[tuple[int, ...], int]]:
    """Prefixes whose subtrees have at most ``BLOCK`` subsets, in order, with their sizes."""
    count, columns = rows.matrix.shape
    waiting: list[tuple[int, ...]] = [()]
    while waiting:  # every prefix is taken once, and none of a whole subset has children
        prefix = waiting.pop()
        size = completions(rows, prefix)
        if size <= BLOCK:
            yield prefix, size
        else:
            last = count - columns + len(prefix)
            waiting += [(*prefix, child) for child in range(last, _first_after(prefix) - 1, -1)]


def _first_after(prefix: tuple[int, ...]) -> int:
    """The first row that can follow a prefix."""
    return prefix[-1] + 1 if prefix else 0


def completions(rows: ScaledRows, prefix: tuple[int, ...]) -> int:
    """Number of subsets that begin with a prefix."""
    count, columns = rows.matrix.shape
    return comb(count - _first_after(prefix), columns - len(prefix))


def walk_piece(tree: Tree, prefix: tuple[int, ...], size: int) -> SubtreeFindings:
    """Walk one subtree and examine the suspects that it set aside."""
    rows, unit = tree.rows, tree.rows.column_scale[-1]
    R, N = rows.matrix.shape
    path, last, pivots = np.zeros((3, N), dtype=np.int64)
    path[: len(prefix)] = prefix
    found = TreeWalk(
        rows=np.column_stack([rows.matrix, rows.right]),
        feasibility=tree.tolerances.feasibility,
        work=np.empty((N, N + 1, R)),
        path=path,
        last=last,
        pivots=pivots,
        known=np.zeros(N + 1, dtype=np.bool_),
        level=np.zeros(N + 1),
        x=np.empty(N),
        square=np.empty((N, N + 1)),
        values=np.empty(size if tree.values else 0),
        record=np.array([inf, tree.feasible_below / unit]),
        subsets=np.zeros((2, N), dtype=np.int64),
        prefixes=np.empty((size, N), dtype=np.int32),
        lengths=np.empty(size, dtype=np.int32),
        counters=np.zeros(3, dtype=np.int64),
    )
    found.work[0] = found.rows.T
    walk(found, np.array(prefix, dtype=np.int64))
    best, safest = (tuple(subset) for subset in found.subsets.tolist())
    regular, suspects = found.counters[[REGULAR, SUSPECTS]].tolist()
    piece = SubtreeFindings(
        subsets=0,
        regular=regular,
        smallest_positive=(found.record[0] * unit, best) if any(best) else NONE,
        smallest_feasible=(found.record[1] * unit, safest) if any(safest) else NONE,
        load_factors=found.values[:regular] * unit,
    )
    prefixes = zip(found.prefixes[:suspects].tolist(), found.lengths[:suspects].tolist(), strict=True)
    suspect = [tuple(path[:length]) for path, length in prefixes]
    return replace(joined([piece, *_examined(tree, suspect)]), subsets=size)


def _examined(tree: Tree, suspects: list[tuple[int, ...]]) -> Iterator[SubtreeFindings]:
    """All completions of suspect prefixes that are not singular as they stand, solved in batches."""
    doubtful = list[Iterator[tuple[int, ...]]]()
    count, columns = tree.rows.matrix.shape
    for prefix in suspects:
        whole = len(prefix) == columns
        spectrum = np.ones(1) if whole else np.linalg.svd(tree.rows.matrix[list(prefix)], compute_uv=False)
        if spectrum[-1] > tree.tolerances.degeneracy * spectrum[0]:
            rest = combinations(range(_first_after(prefix), count), columns - len(prefix))
            doubtful.append(map(prefix.__add__, rest))
    for chunk in in_batches(chain.from_iterable(doubtful)):
        yield solve_subsets(np.array(chunk), tree.rows, tree.tolerances, values=tree.values)
