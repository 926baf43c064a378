"""How much work motions may take, counted in operations and not by the clock: the same on every machine."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

import numpy as np

BY_BLAS = 0.1  # time of an operation of dense linear algebra, relative to one of a loop


@dataclass
class WorkLimit:
    """Multiplications and additions that motions may take, and have taken; 1e9 take a second or less."""

    allowed: float = np.inf
    taken: float = 0.0


_PRESENT: ContextVar[WorkLimit | None] = ContextVar("present work limit", default=None)


@contextmanager
def limited_work(allowed: float) -> Iterator[WorkLimit]:
    """Limit what motions take in all while a block runs, in this thread; what is within is counted apart.

    Examples
    --------
    >>> with limited_work(10.0) as limit:
    ...     count_work(6)
    ...     print(work_is_left())
    ...     count_work(6)
    ...     print(work_is_left(), limit.taken)
    True
    False 12.0
    """
    limit = WorkLimit(allowed)
    before = _PRESENT.set(limit)
    try:
        yield limit
    finally:
        _PRESENT.reset(before)


def count_work(operations: float) -> None:
    """Count so many operations."""
    limit = _PRESENT.get()
    if limit is not None:
        limit.taken += operations


def work_is_left() -> bool:
    """Whether less than is allowed has been taken."""
    limit = _PRESENT.get()
    return limit is None or limit.taken < limit.allowed


@contextmanager
def work_again() -> Iterator[WorkLimit]:
    """As much work as the present limit allows, once more: for the numbers of what is found."""
    limit = _PRESENT.get()
    with limited_work(np.inf if limit is None else limit.allowed) as again:
        yield again
