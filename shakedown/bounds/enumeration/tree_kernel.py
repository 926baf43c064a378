"""The tree of all row subsets, walked with the elimination of common prefixes shared (compiled).

A subset is a path of increasing row numbers. Choosing a row eliminates one slip
from all rows that can still follow, once for the whole subtree; the last three rows
share their cross products, so that a leaf costs two short dot products and one
division. The pivot is the row's largest entry among the slips that are left; the
load factor is eliminated only by a row in which no slip is left, which gives its value.

Where the largest entry is small, the prefix is *suspect*: it is set aside, with all
its completions, to be examined by other means.
"""

from functools import partial

import numpy as np

from shakedown.bounds.enumeration.leaf_kernel import SUSPECT, leaves, linked, set_aside, triples
from shakedown.bounds.enumeration.walk_state import IntArray, Limits, WalkElimination, Whole
from shakedown.ground.code_cache import compiled
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import ROUND_OFF


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
