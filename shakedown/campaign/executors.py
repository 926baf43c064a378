"""Numbered pieces of work on an executor, each handed back as soon as it is done; worker processes."""

import multiprocessing
import pickle
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import ExitStack, contextmanager
from functools import cache
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

IN_HAND = 2  # pieces that an executor holds for each of its workers, so that memory stays flat
WORKERS = 32  # of an executor that does not tell
ASK_AGAIN = 1.0  # seconds after which an executor is asked whether it still works
WANTED = "workers: expected functions that other processes can import (of a module, no lambda)"
GUARD = (
    "workers: expected processes that begin to work, found that they end before; a script has to keep "
    'what it does under if __name__ == "__main__":'
)
DIED = "workers: one died (killed, or out of memory?); what is done is kept where there is an output"
_pickled: bytes  # the work, where this process is a worker


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
    with ExitStack() as stack:
        pool = executor or stack.enter_context(_processes(work, min(workers, len(numbers))))
        call = work if executor is not None else _one_piece
        running, waiting = dict[Future[Any], int](), iter(numbers)
        try:
            while True:
                for number in islice(waiting, max(IN_HAND * _workers_of(pool) - len(running), 0)):
                    with _signals_held_back():
                        running[pool.submit(call, number)] = number
                if not running:
                    return
                for future in wait(running, ASK_AGAIN, FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
        except BrokenExecutor:
            raise SolverError(DIED) from None
        finally:
            for future in running:
                future.cancel()


def _workers_of(executor: Executor) -> int:
    """How many pieces are done at a time; asked again and again, as clusters grow, and are lost."""
    if client := getattr(executor, "_client", None):  # dask
        if client.status != "running":  # some of its futures never end then
            raise BrokenExecutor
        return max(sum(client.nthreads().values()), 1)
    return int(getattr(executor, "_max_workers", 0) or getattr(executor, "num_workers", WORKERS))  # of MPI


@contextmanager
def _processes(work: Callable[[int], Any], workers: int) -> Iterator[Executor]:
    """Processes that start afresh with this work, and one thread each."""
    try:
        pickled = pickle.dumps(work)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise UsageError(f"{WANTED}, found one that cannot be sent there ({error})") from None
    context = multiprocessing.get_context("spawn")  # a fork would copy locks of compiled threads
    sys.warnoptions.append("ignore::UserWarning:multiprocessing.resource_tracker")  # at an interruption
    resource_tracker.ensure_running()
    sys.warnoptions.pop()
    first = context.Process(target=int)  # sending work to processes that end before they read it would hang
    with _signals_held_back():
        first.start()
    first.join()
    if first.exitcode:
        raise UsageError(GUARD)
    pool = ProcessPoolExecutor(workers, context, _begin, (pickled,))
    try:
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


def _begin(pickled: bytes) -> None:
    """Make this process a worker: one thread, deaf to Ctrl-C, gone when its parent is."""
    global _pickled
    _pickled = pickled
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent receives it, and ends the worker
    threadpool_limits(1)
    parent = multiprocessing.parent_process()
    assert parent is not None
    Thread(target=lambda: (wait_for([parent.sentinel]), _exit(1)), daemon=True).start()


@cache
def _work() -> Callable[[int], Any]:
    try:
        return pickle.loads(_pickled)
    except Exception as error:  # whatever its modules raise
        raise UsageError(f"{WANTED}, found one that cannot be read there ({error})") from None


def _one_piece(number: int) -> Any:
    return _work()(number)
