"""The tree of row subsets, cut into tasks, walked by several threads, with its suspects examined."""

import os
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import combinations, islice
from math import comb, inf

import numpy as np
from numpy.typing import NDArray

from shakedown.enumeration.findings import NONE, Piece, batch_piece, joined
from shakedown.enumeration.intersection import ScaledRows, solve_subsets
from shakedown.enumeration.leaf_kernel import REGULAR, STORED, SUSPECTS
from shakedown.enumeration.tree_kernel import walk
from shakedown.tolerances import DEFAULT

TASK = 1 << 20  # subsets of one task: a tenth of a second, so that progress is seen and interrupts heard
SAMPLE = 10_000  # subsets timed to foretell how long all of them would take
SUSPECTS_EXPECTED = 1 << 12
BATCH = 4096


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
    """

    rows: ScaledRows
    one_pair: bool = False
    cut: float = inf
    feasible_below: float = inf
    listed: int = 1000


def pieces(tree: Tree, threads: int | None = None) -> Iterator[Piece]:
    """Walk the whole tree; the pieces come in order, and each is complete.

    Parameters
    ----------
    tree
        What to walk.
    threads
        Number of threads; all cores by default.
    """
    workers = threads or os.cpu_count() or 1
    waiting: deque[Future[Piece]] = deque()
    with ThreadPoolExecutor(workers) as pool:
        try:
            for prefix, size in tasks(tree):
                waiting.append(pool.submit(walk_piece, tree, prefix, size))
                if len(waiting) > 2 * workers:
                    piece = waiting.popleft().result()
                    tree = replace(tree, feasible_below=min(tree.feasible_below, piece.smallest_feasible[0]))
                    yield piece
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()


def tasks(tree: Tree) -> Iterator[tuple[tuple[int, ...], int]]:
    """Prefixes whose subtrees have at most ``TASK`` subsets, in order, with their sizes."""
    waiting: list[tuple[int, ...]] = [()]
    while waiting:
        prefix = waiting.pop()
        size = completions(tree, prefix)
        if size <= TASK:
            yield prefix, size
        else:
            waiting += [(*prefix, child) for child in reversed(range(*child_range(tree, prefix)))]


def typical_task(tree: Tree) -> tuple[tuple[int, ...], int]:
    """A small task to judge the time by: one row of every node, as far as that goes."""
    prefix: tuple[int, ...] = ()
    while (size := completions(tree, prefix)) > SAMPLE:
        first, end = child_range(tree, prefix)
        prefix = (*prefix, min(first + 1, end - 1))
    return prefix, size


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


def walk_piece(tree: Tree, prefix: tuple[int, ...], size: int) -> Piece:
    """Walk one subtree; examine what the walk set aside."""
    rows, unit = tree.rows, tree.rows.column_scale[-1]
    columns = rows.matrix.shape[1]
    augmented = np.column_stack([rows.matrix, rows.right])
    values = np.empty(size if tree.cut < inf else 0)
    room = SUSPECTS_EXPECTED
    while True:
        suspects, lengths = np.zeros((room, columns), dtype=np.int64), np.zeros(room, dtype=np.int64)
        record = np.array([inf, tree.feasible_below / unit])
        best, safest = np.zeros((2, columns), dtype=np.int64)
        counters = np.zeros(6, dtype=np.int64)
        walk(
            augmented,
            np.array(prefix, dtype=np.int64),
            tree.one_pair,
            DEFAULT.feasibility,
            tree.cut / unit,
            values,
            suspects,
            lengths,
            record,
            best,
            safest,
            counters,
        )
        if counters[SUSPECTS] <= room:
            break
        room = int(counters[SUSPECTS])
    found = Piece(
        subsets=int(counters[REGULAR]),
        degenerate=0,
        degenerate_rows=[],
        smallest_positive=(record[0] * unit, tuple(best.tolist())) if best.any() else NONE,
        smallest_feasible=(record[1] * unit, tuple(safest.tolist())) if safest.any() else NONE,
        load_factors=values[: counters[STORED]] * unit,
    )
    count = int(counters[SUSPECTS])
    return joined([found, *_examined_all(tree, suspects[:count], lengths[:count])])


def _examined_all(tree: Tree, suspects: NDArray[np.int64], lengths: NDArray[np.int64]) -> Iterator[Piece]:
    """Whole suspect subsets in batches, shorter suspect prefixes one by one."""
    whole = suspects[lengths == suspects.shape[1]]
    for start in range(0, len(whole), BATCH):
        yield batch_piece(solve_subsets(whole[start : start + BATCH], tree.rows), tree.cut, tree.listed)
    for prefix, length in zip(suspects, lengths, strict=True):
        if length < suspects.shape[1]:
            yield _examined(tree, tuple(prefix[:length].tolist()))


def _examined(tree: Tree, prefix: tuple[int, ...]) -> Piece:
    """A suspect prefix: singular as it stands, or else all its completions solved one by one."""
    rows, size = tree.rows, completions(tree, prefix)
    spectrum = np.linalg.svd(rows.matrix[list(prefix)], compute_uv=False)
    if spectrum[-1] <= DEFAULT.degeneracy * spectrum[0]:
        listed = [tuple(subset) for subset in islice(_extensions(tree, prefix), tree.listed)]
        return Piece(size, size, listed, NONE, NONE, np.empty(0))
    subsets = _extensions(tree, prefix)
    parts = []
    while chunk := list(islice(subsets, BATCH)):
        parts.append(batch_piece(solve_subsets(np.array(chunk), rows), tree.cut, tree.listed))
    return joined(parts)


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
