"""Pieces of work on several processes of this machine; one that dies is replaced."""

import multiprocessing
import os
import pickle
import signal
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import resource_tracker
from multiprocessing.connection import wait as wait_for
from threading import Thread

from threadpoolctl import threadpool_limits

from shakedown.campaign.crew import Losses, Work
from shakedown.ground.errors import UsageError

WANTED = "expected functions that other processes can import (of a module, no lambda)"
_pickled: bytes  # the work of this process, where it is a worker
_work: Work | None = None  # the same, once there is a piece of it to do


def by_processes(work: Work, numbers: list[int], workers: int) -> Iterator[tuple[int, bytes]]:
    """(number, piece) as they are done, in no particular order.

    A process that is killed takes the pool with it; the pieces that it had in hand are
    done again by a new one.

    Raises
    ------
    UsageError
        If the work is none that other processes can import.
    SolverError
        If processes die again and again with nothing done.
    """
    try:
        pickled = pickle.dumps(work)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise UsageError(f"workers: {WANTED}, found one that cannot be sent there ({error})") from None
    todo, losses = dict.fromkeys(numbers), Losses()
    while todo:
        try:
            for number, piece in _by_one_pool(pickled, list(todo), workers):
                losses.progress()
                del todo[number]
                yield number, piece
        except BrokenProcessPool:
            losses.another()


def _by_one_pool(pickled: bytes, numbers: list[int], workers: int) -> Iterator[tuple[int, bytes]]:
    """The same from one pool, until a process of it dies."""
    _start_tracker()
    pool = ProcessPoolExecutor(
        min(workers, len(numbers)),
        mp_context=multiprocessing.get_context("spawn"),  # a fork would copy locks of compiled threads
        initializer=_begin,
        initargs=(pickled,),
    )
    running: dict[Future[bytes], int] = {}
    waiting = iter(numbers)
    try:
        while True:
            for number in waiting:
                running[pool.submit(_one_piece, number)] = number
                if len(running) >= 2 * workers:
                    break
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                yield running.pop(future), future.result()
    finally:
        pool.shutdown(wait=not running, cancel_futures=True)


def _start_tracker() -> None:
    """Start Python's process that clears up after us; it is not to remark on an interruption."""
    before = os.environ.get("PYTHONWARNINGS")
    quiet = "ignore::UserWarning:multiprocessing.resource_tracker"
    os.environ["PYTHONWARNINGS"] = quiet if not before else f"{before},{quiet}"
    try:
        resource_tracker.ensure_running()
    finally:
        del os.environ["PYTHONWARNINGS"]
        if before is not None:
            os.environ["PYTHONWARNINGS"] = before


def _begin(pickled: bytes) -> None:
    """Make this process a worker: one thread, deaf to Ctrl-C, gone when its parent is."""
    global _pickled
    _pickled = pickled
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent hears it, and ends us
    threadpool_limits(1)
    parent = multiprocessing.parent_process()
    if parent is not None:
        Thread(target=_leave_with, args=(parent.sentinel,), daemon=True).start()


def _leave_with(parent: int) -> None:
    """End this process when the parent ends, however that happens."""
    wait_for([parent])
    os._exit(1)


def _one_piece(number: int) -> bytes:
    global _work
    if _work is None:
        try:
            _work = pickle.loads(_pickled)
        except Exception as error:  # whatever its modules raise
            raise UsageError(f"workers: {WANTED}, found one that cannot be read there ({error})") from None
    return _work(number)
