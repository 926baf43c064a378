"""The tree of all row subsets, walked with the elimination of common prefixes shared (compiled).

A subset is a path of increasing row numbers. Choosing a row eliminates one slip
from all rows that can still follow, once for the whole subtree; the last three rows
share their cross products, so that a leaf costs two short dot products and one
division. The pivot is the row's largest entry among the slips that are left; the
load factor is eliminated only by a row in which no slip is left, which gives its value.

Where the largest entry is small, the prefix is *suspect*: it is set aside, with all
its completions, to be examined by other means.
"""

import numpy as np
from numba import njit

from shakedown.enumeration.leaf_kernel import ABSENT, SUSPECT, IntArray, leaves, set_aside, triples
from shakedown.model.problem import FloatArray


@njit(nogil=True, cache=True, fastmath={"contract"})
def walk(
    rows: FloatArray,
    prefix: IntArray,
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
    """Visit every completion of a prefix.

    Parameters
    ----------
    rows : (R, N + 1)
        Rows of size about 1: N − 1 slips, the load factor, the right-hand side.
    prefix : (k,)
        The first k row numbers, k < N.
    one_pair
        Visit only paths 0, 1, then one of every further two rows.
    tolerance
        Largest violation of a row that a point on the safe region may have, relative
        to the largest terms.
    cut
        Load factors above it are stored in ``values``, as far as it reaches; at +inf none is.
    suspects : (S, N), lengths : (S,)
        Receives the suspect prefixes and their lengths, as far as they reach.
    record : (2,)
        In and out: smallest positive load factor so far, and smallest one on the safe region.
    best_rows, safest_rows : (N,)
        Their subsets.
    counters : (6,)
        Receives the number of regular subsets, suspect prefixes, stored values,
        whether either record was improved, and the row found violated last.
    """
    R, N = rows.shape[0], rows.shape[1] - 1
    work = np.empty((N, N + 1, R))
    for c in range(N + 1):
        for i in range(R):
            work[0, c, i] = rows[i, c]
    path = np.zeros(N, dtype=np.int64)
    last = np.zeros(N, dtype=np.int64)
    pivots = np.zeros(N, dtype=np.int64)
    x = np.empty(N)
    known = np.zeros(N + 1, dtype=np.bool_)
    level = np.zeros(N + 1)
    depth = 0
    path[0], last[0] = _children(0, -1, R, N, one_pair)
    if prefix.size > 0:
        path[0] = prefix[0]
        last[0] = prefix[0]
    while depth >= 0:
        if path[depth] > last[depth]:
            depth -= 1
            if depth >= 0:
                path[depth] += 1
            continue
        width = N - depth
        if width == 3 and not one_pair and not known[depth]:
            triples(
                rows,
                work,
                path,
                pivots,
                x,
                last[depth],
                prefix.size,
                tolerance,
                cut,
                values,
                suspects,
                lengths,
                record,
                best_rows,
                safest_rows,
                counters,
            )
            depth -= 1
            if depth >= 0:
                path[depth] += 1
            continue
        if width == 2:
            leaves(
                rows,
                work,
                path,
                pivots,
                x,
                last[depth],
                known[depth],
                level[depth],
                one_pair,
                tolerance,
                cut,
                values,
                suspects,
                lengths,
                record,
                best_rows,
                safest_rows,
                counters,
            )
            depth -= 1
            if depth >= 0:
                path[depth] += 1
            continue
        row = path[depth]
        slips = width if known[depth] else width - 1
        pivot = 0
        size = abs(work[depth, 0, row])
        for c in range(1, slips):
            entry = abs(work[depth, c, row])
            if entry > size:
                pivot, size = c, entry
        known[depth + 1], level[depth + 1] = known[depth], level[depth]
        if size <= SUSPECT:
            if size <= ABSENT and not known[depth] and abs(work[depth, width - 1, row]) > SUSPECT:
                pivot = width - 1
                known[depth + 1] = True
                level[depth + 1] = work[depth, width, row] / work[depth, width - 1, row]
            else:
                for t in range(depth + 1, prefix.size):  # the walk of another prefix must not count it again
                    path[t] = prefix[t]
                set_aside(path, max(depth + 1, prefix.size), suspects, lengths, counters)
                path[depth] += 1
                continue
        pivots[depth] = pivot
        first = row + 1 if not one_pair else (row + 1 if depth == 0 else 2 * depth)
        scale = 1.0 / work[depth, pivot, row]
        target = 0
        for c in range(width + 1):
            if c == pivot:
                continue
            step = work[depth, c, row] * scale
            for i in range(first, R):
                work[depth + 1, target, i] = work[depth, c, i] - step * work[depth, pivot, i]
            target += 1
        depth += 1
        path[depth], last[depth] = _children(depth, row, R, N, one_pair)
        if depth < prefix.size:
            path[depth] = prefix[depth]
            last[depth] = prefix[depth]


@njit(nogil=True, cache=True, inline="always")
def _children(depth: int, previous: int, R: int, N: int, one_pair: bool) -> tuple[int, int]:
    """First and last row that can stand at a depth."""
    if one_pair:
        if depth < 2:
            return depth, depth
        return 2 * depth - 2, 2 * depth - 1
    return previous + 1, R - N + depth
