"""Numbered pieces of work on an executor, each handed back as soon as it is done; worker processes."""

import multiprocessing
import pickle
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, nullcontext
from functools import lru_cache, partial
from itertools import islice
from multiprocessing import resource_tracker
from multiprocessing.connection import wait as wait_for
from os import _exit
from threading import Thread, current_thread, main_thread
from typing import Any

from threadpoolctl import threadpool_limits

from shakedown.ground.argument_kinds import check_count
from shakedown.ground.blas_threads import all_cores
from shakedown.ground.errors import SolverError, UsageError

SUBMITTED = (
    256  # pieces that an executor holds at most: more than workers, few enough for memory to stay flat
)
ASK_AGAIN = 1.0  # seconds after which a cluster is asked whether it still works
WANTED = "workers: expected functions that other processes can import (of a module, no lambda)"
GUARD = (
    "workers: expected processes that begin to work, found that they end before; a script has to keep "
    'what it does under if __name__ == "__main__":'
)
DIED = "workers: one died (killed, or out of memory?); what is done is kept where there is an output"


def processes_asked(workers: int | None) -> int:
    """The number of processes, None one for each core; a worker that is in its parent's script leaves."""
    if workers is not None:
        check_count("workers", workers)
    count = all_cores() if workers is None else workers
    if count > 1 and getattr(multiprocessing.current_process(), "_inheriting", False):
        raise SystemExit(1)  # the parent reports it
    return count


def finished(
    work: Callable[[int], Any], numbers: Sequence[int], executor: Executor | None = None, workers: int = 1
) -> Iterator[tuple[int, Any]]:
    """(number, result) of every piece as it is done, in no particular order.

    Parameters
    ----------
    work
        From the number of a piece to its result.
    numbers
        Of the pieces to do.
    executor
        Who does them; it is not shut down.
    workers
        Without one: the number of processes; 1 is this process.

    Raises
    ------
    UsageError
        If the work is none that other processes can import, or they cannot begin with it.
    SolverError
        If a worker dies.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> with ThreadPoolExecutor(2) as threads:
    ...     sorted(finished(lambda number: number**2, range(4), threads))
    [(0, 0), (1, 1), (2, 4), (3, 9)]
    """
    if executor is None and (workers == 1 or len(numbers) < 2):
        yield from ((number, work(number)) for number in numbers)
        return
    if executor is None:
        work = _sent(work)
    with nullcontext(executor) if executor is not None else _processes(min(workers, len(numbers))) as pool:
        running, waiting = dict[Future[Any], int](), iter(numbers)
        try:
            while True:
                for number in islice(waiting, SUBMITTED - len(running)):
                    with _signals_held_back():
                        running[pool.submit(work, number)] = number
                if not running:
                    return
                for future in wait(running, ASK_AGAIN, FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
                if getattr(getattr(pool, "_client", None), "status", "running") != "running":
                    raise BrokenExecutor  # a scheduler of dask is lost, some of whose futures never end then
        except BrokenExecutor:
            raise SolverError(DIED) from None
        finally:
            for future in running:
                future.cancel()


@contextmanager
def _processes(workers: int) -> Iterator[Executor]:
    """Processes that start afresh, with one thread each."""
    sys.warnoptions.append("ignore::UserWarning:multiprocessing.resource_tracker")  # at an interruption
    resource_tracker.ensure_running()
    sys.warnoptions.pop()
    context = multiprocessing.get_context("spawn")  # a fork would copy locks of compiled threads
    pool = ProcessPoolExecutor(workers, context, _begin)
    try:
        with _signals_held_back():
            first = pool.submit(int)
        if isinstance(first.exception(), BrokenExecutor):
            raise UsageError(GUARD)
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


@contextmanager
def _signals_held_back() -> Iterator[None]:
    """A process that begins gets all that it waits for; an interruption comes after."""
    if current_thread() is not main_thread():  # only the main thread receives signals
        yield
        return
    heard: list[int] = []
    ends = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(end, lambda number, _: heard.append(number)) for end in ends]
    try:
        yield
    finally:
        for end, handler in zip(ends, before, strict=True):
            signal.signal(end, handler or signal.SIG_DFL)
    for number in heard:
        signal.raise_signal(number)


def _begin() -> None:
    """Make this process a worker: one thread, deaf to Ctrl-C, gone when its parent is."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent receives it, and ends the worker
    threadpool_limits(1)
    parent = multiprocessing.parent_process()
    assert parent is not None
    Thread(target=lambda: (wait_for([parent.sentinel]), _exit(1)), daemon=True).start()


def _sent(work: Callable[[int], Any]) -> Callable[[int], Any]:
    """Work for other processes, each of which unpickles it once and keeps what it derives from it."""
    try:
        return partial(_done, pickle.dumps(work))
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise UsageError(f"{WANTED}, found one that cannot be sent there ({error})") from None


def _done(pickled: bytes, number: int) -> Any:
    return _received(pickled)(number)


@lru_cache(maxsize=1)
def _received(pickled: bytes) -> Callable[[int], Any]:
    try:
        return pickle.loads(pickled)
    except Exception as error:  # whatever its modules raise
        raise UsageError(f"{WANTED}, found one that cannot be read there ({error})") from None
