"""What a part of all row subsets gave, and how parts are put together."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from math import inf

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.enumeration.intersection import Batch
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import BATCH

Candidate = tuple[float, tuple[int, ...]]
NONE: Candidate = (inf, ())


@dataclass(frozen=True)
class SubtreeFindings:
    """What part of the tree gave.

    Attributes
    ----------
    regular
        Number of subsets with a load factor.
    degenerate
        Number of subsets without one.
    degenerate_rows
        Some of them (or all, if few).
    smallest_positive, smallest_feasible
        (load factor, rows) of the smallest positive one, and of the smallest on the safe region.
    load_factors
        Those above the cut, where asked for.
    """

    regular: int
    degenerate: int
    degenerate_rows: list[tuple[int, ...]]
    smallest_positive: Candidate
    smallest_feasible: Candidate
    load_factors: FloatArray

    @property
    def subsets(self) -> int:
        """Number of subsets worked through."""
        return self.regular + self.degenerate


def in_batches(subsets: Iterator[tuple[int, ...]]) -> Iterator[list[tuple[int, ...]]]:
    """The same subsets, ``BATCH`` at a time."""
    return iter(lambda: list(islice(subsets, BATCH)), [])


def batch_piece(batch: Batch, cut: float, listed: int) -> SubtreeFindings:
    """The report on subsets that were solved in a batch."""
    singular = np.flatnonzero(~batch.regular)
    kept = batch.load_factor[batch.regular & (batch.load_factor > cut)] if cut < inf else np.empty(0)
    return SubtreeFindings(
        regular=int(batch.regular.sum()),
        degenerate=singular.size,
        degenerate_rows=[tuple(batch.subsets[i].tolist()) for i in singular[:listed]],
        smallest_positive=_smallest(batch, batch.positive),
        smallest_feasible=_smallest(batch, batch.positive & batch.feasible),
        load_factors=kept,
    )


def _smallest(batch: Batch, admitted: NDArray[np.bool_]) -> Candidate:
    """(load factor, rows) of the smallest admitted value of a batch."""
    if not admitted.any():
        return NONE
    i = int(np.argmin(np.where(admitted, batch.load_factor, inf)))
    return float(batch.load_factor[i]), tuple(batch.subsets[i].tolist())


def joined(parts: list[SubtreeFindings]) -> SubtreeFindings:
    """Several pieces as one."""
    return SubtreeFindings(
        regular=sum(part.regular for part in parts),
        degenerate=sum(part.degenerate for part in parts),
        degenerate_rows=[subset for part in parts for subset in part.degenerate_rows],
        smallest_positive=min((part.smallest_positive for part in parts), default=NONE),
        smallest_feasible=min((part.smallest_feasible for part in parts), default=NONE),
        load_factors=np.concatenate([part.load_factors for part in parts]) if parts else np.empty(0),
    )
