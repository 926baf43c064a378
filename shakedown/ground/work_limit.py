"""How much work motions may take, and on how many threads."""

import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache, wraps
from typing import Any

import numpy as np

from shakedown.ground.constants import P, T

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


def work_again() -> AbstractContextManager[WorkLimit]:
    """As much work as the present limit allows, once more: for the numbers of what is found."""
    limit = _PRESENT.get()
    return limited_work(np.inf if limit is None else limit.allowed)


def on_one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Limit the threads of BLAS to one while the function runs.

    Examples
    --------
    >>> from threadpoolctl import threadpool_info
    >>> @on_one_thread
    ... def threads():
    ...     return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}
    >>> threads()
    {1}
    """

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> T:
        with threads_of_blas(1):
            return function(*args, **kwargs)

    return limited


def threads_of_blas(count: int) -> Any:
    """Limit the threads of BLAS to a number while a block runs."""
    return _libraries().limit(limits=count, user_api="blas")


@cache
def _libraries() -> Any:
    """The libraries of NumPy and SciPy with threads, found once, as that takes a millisecond or two."""
    import scipy.linalg  # noqa: F401 -- loads code, as the next line: not before there is work
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def all_cores() -> int:
    """How many cores this process may use.

    Examples
    --------
    >>> all_cores() >= 1
    True
    """
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
