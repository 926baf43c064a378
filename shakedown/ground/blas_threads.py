"""Numbers of threads: one for linear algebra, one per core for repeated work.

In matrices of the size of a contact the threads of linear algebra mostly wait for each other.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, wraps
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from threadpoolctl import LibController

P = ParamSpec("P")
T = TypeVar("T")


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


@contextmanager
def threads_of_blas(count: int) -> Iterator[None]:
    """Limit the threads of BLAS to a number while a block runs."""
    counts = [(library, library.get_num_threads()) for library in _libraries()]
    others = [(library, threads) for library, threads in counts if threads != count]
    try:
        for library, _ in others:
            library.set_num_threads(count)
        yield
    finally:
        for library, threads in others:
            library.set_num_threads(threads)


@cache
def _libraries() -> "list[LibController]":
    """The BLAS libraries of NumPy and SciPy, found once, as that takes a millisecond or two."""
    import scipy.linalg  # noqa: F401 -- loads code, as the next line: not before there is work
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController().select(user_api="blas").lib_controllers


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
