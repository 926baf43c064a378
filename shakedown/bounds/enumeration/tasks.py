"""The tree of row subsets, cut into tasks, walked by several threads, with its suspects examined."""

from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import chain, combinations, islice
from math import comb, inf

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.enumeration.intersection import (
    NONE,
    ScaledRows,
    SubtreeFindings,
    in_batches,
    joined,
    solve_subsets,
)
from shakedown.bounds.enumeration.walk_kernel import (
    REGULAR,
    STORED,
    SUSPECTS,
    Suspects,
    WalkFindings,
    WalkSearch,
    Whole,
    elimination,
    walk,
)
from shakedown.ground.constants import BATCH, BLOCK
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import all_cores


@dataclass(frozen=True)
class Tree:
    """A tree of row subsets.

    Attributes
    ----------
    rows
        The 2n rows.
    one_pair
        Only the subsets 0, 1, then one of every further two rows.
    cut
        Load factors above it are kept; inf keeps none.
    feasible_below
        Points on the safe region are looked for below this load factor only.
    listed
        How many degenerate subsets a piece lists.
    tolerances
        What counts as degenerate and as safe.
    """

    rows: ScaledRows
    one_pair: bool = False
    cut: float = inf
    feasible_below: float = inf
    listed: int = 1000
    tolerances: Tolerances = DEFAULT

    def solved(self, subsets: NDArray[np.intp]) -> SubtreeFindings:
        """Some subsets, solved as a batch."""
        return solve_subsets(subsets, self.rows, self.tolerances, cut=self.cut, listed=self.listed)


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
            for prefix, size in tasks(tree):
                waiting.append(pool.submit(walk_piece, tree, prefix, size))
                if len(waiting) > 2 * workers:
                    piece = waiting.popleft().result()
                    tree = replace(tree, feasible_below=min(tree.feasible_below, piece.smallest_feasible[0]))
                    yield piece
            yield from (future.result() for future in waiting)
        finally:
            for future in waiting:
                future.cancel()


def tasks(tree: Tree) -> Iterator[tuple[tuple[int, ...], int]]:
    """Prefixes whose subtrees have at most ``BLOCK`` subsets, in order, with their sizes."""
    waiting: list[tuple[int, ...]] = [()]
    while waiting:  # every prefix is taken once, and none of a whole subset has children
        prefix = waiting.pop()
        size = completions(tree, prefix)
        if size <= BLOCK:
            yield prefix, size
        else:
            waiting += [(*prefix, child) for child in reversed(range(*child_range(tree, prefix)))]


def child_range(tree: Tree, prefix: tuple[int, ...]) -> tuple[int, int]:
    """First row, and one past the last, that can follow a prefix."""
    count, columns = tree.rows.matrix.shape
    depth = len(prefix)
    if tree.one_pair:
        return (depth, depth + 1) if depth < 2 else (2 * depth - 2, 2 * depth)
    return (prefix[-1] + 1 if prefix else 0), count - columns + depth + 1


def completions(tree: Tree, prefix: tuple[int, ...]) -> int:
    """Number of subsets that begin with a prefix."""
    count, columns = tree.rows.matrix.shape
    if tree.one_pair:
        return 2 ** (columns - max(len(prefix), 2))
    return comb(count - child_range(tree, prefix)[0], columns - len(prefix))


def walk_piece(tree: Tree, prefix: tuple[int, ...], size: int) -> SubtreeFindings:
    """Walk one subtree and examine the suspects that it set aside."""
    unit = tree.rows.column_scale[-1]
    found, suspects = _walked(tree, prefix, size)
    best, safest = (tuple(subset) for subset in found.subsets.tolist())
    count = int(found.counters[SUSPECTS])
    piece = SubtreeFindings(
        regular=int(found.counters[REGULAR]),
        degenerate=0,
        degenerate_rows=[],
        smallest_positive=(found.record[0] * unit, best) if any(best) else NONE,
        smallest_feasible=(found.record[1] * unit, safest) if any(safest) else NONE,
        load_factors=found.values[: found.counters[STORED]] * unit,
    )
    prefixes = zip(suspects.prefixes[:count].tolist(), suspects.lengths[:count].tolist(), strict=True)
    return joined([piece, *_examined(tree, [tuple(rows[:length]) for rows, length in prefixes])])


def _walked(tree: Tree, prefix: tuple[int, ...], size: int) -> tuple[WalkFindings, Suspects]:
    """Walk one subtree; a second time, with capacity for all of them, where there are many suspects."""
    rows, unit = tree.rows, tree.rows.column_scale[-1]
    columns = rows.matrix.shape[1]
    augmented = np.column_stack([rows.matrix, rows.right])
    search = WalkSearch(augmented, tree.one_pair, tree.tolerances.feasibility, tree.cut / unit)
    given, capacity = np.array(prefix, dtype=np.int64), BATCH
    for _ in range(2):
        counters = np.zeros(4, dtype=np.int64)
        found = WalkFindings(
            values=np.empty(size if tree.cut < inf else 0),
            record=np.array([inf, tree.feasible_below / unit]),
            subsets=np.zeros((2, columns), dtype=np.int64),
            counters=counters,
        )
        suspects = Suspects(
            np.zeros((capacity, columns), dtype=np.int64), np.zeros(capacity, dtype=np.int64), counters
        )
        walk(Whole(search, elimination(augmented, given), found, suspects), given)
        if counters[SUSPECTS] <= capacity:
            break
        capacity = int(counters[SUSPECTS])
    return found, suspects


def _examined(tree: Tree, suspects: list[tuple[int, ...]]) -> Iterator[SubtreeFindings]:
    """Suspect prefixes: singular as they stand, or else all their completions solved in batches."""
    doubtful = list[tuple[int, ...]]()
    for prefix in suspects:
        whole = len(prefix) == tree.rows.matrix.shape[1]
        spectrum = np.ones(1) if whole else np.linalg.svd(tree.rows.matrix[list(prefix)], compute_uv=False)
        if spectrum[-1] > tree.tolerances.degeneracy * spectrum[0]:
            doubtful.append(prefix)
        else:
            listed = list(islice(_extensions(tree, prefix), tree.listed))
            yield SubtreeFindings(0, completions(tree, prefix), listed, NONE, NONE, np.empty(0))
    for chunk in in_batches(chain.from_iterable(_extensions(tree, prefix) for prefix in doubtful)):
        yield tree.solved(np.array(chunk))


def _extensions(tree: Tree, prefix: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    count, columns = tree.rows.matrix.shape
    if not tree.one_pair:
        for rest in combinations(range(child_range(tree, prefix)[0], count), columns - len(prefix)):
            yield (*prefix, *rest)
    elif len(prefix) == columns:
        yield prefix
    else:
        for child in range(*child_range(tree, prefix)):
            yield from _extensions(tree, (*prefix, child))
