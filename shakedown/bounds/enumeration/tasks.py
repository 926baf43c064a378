"""The tree of row subsets, cut into tasks, walked by several threads, with its suspects examined."""

from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import chain, combinations, islice
from math import comb, inf

import numpy as np

from shakedown.bounds.enumeration.intersection import (
    LISTED,
    NONE,
    ScaledRows,
    SubtreeFindings,
    in_batches,
    joined,
    solve_subsets,
)
from shakedown.bounds.enumeration.walk_kernel import REGULAR, SUSPECTS, Walk, walk
from shakedown.ground.constants import BLOCK
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import all_cores


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
    found = Walk(
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
        regular=regular,
        degenerate=0,
        degenerate_rows=[],
        smallest_positive=(found.record[0] * unit, best) if any(best) else NONE,
        smallest_feasible=(found.record[1] * unit, safest) if any(safest) else NONE,
        load_factors=found.values[:regular] * unit,
    )
    prefixes = zip(found.prefixes[:suspects].tolist(), found.lengths[:suspects].tolist(), strict=True)
    return joined([piece, *_examined(tree, [tuple(path[:length]) for path, length in prefixes])])


def _examined(tree: Tree, suspects: list[tuple[int, ...]]) -> Iterator[SubtreeFindings]:
    """Suspect prefixes: singular as they stand, or else all their completions solved in batches."""
    doubtful = list[Iterator[tuple[int, ...]]]()
    count, columns = tree.rows.matrix.shape
    for prefix in suspects:
        rest = combinations(range(_first_after(prefix), count), columns - len(prefix))
        extensions = map(prefix.__add__, rest)
        whole = len(prefix) == columns
        spectrum = np.ones(1) if whole else np.linalg.svd(tree.rows.matrix[list(prefix)], compute_uv=False)
        if spectrum[-1] > tree.tolerances.degeneracy * spectrum[0]:
            doubtful.append(extensions)
        else:
            listed = list(islice(extensions, LISTED))
            yield SubtreeFindings(0, completions(tree.rows, prefix), listed, NONE, NONE, np.empty(0))
    for chunk in in_batches(chain.from_iterable(doubtful)):
        yield solve_subsets(np.array(chunk), tree.rows, tree.tolerances, values=tree.values)
