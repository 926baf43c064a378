"""Pieces of work on several processes of this machine; a process that dies is replaced."""

import multiprocessing
import os
import pickle
import signal
import tempfile
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import wait as wait_for
from pathlib import Path
from shutil import rmtree
from threading import Thread, current_thread, main_thread

from threadpoolctl import threadpool_limits

from shakedown.campaign.crew import IN_HAND, Losses, Work
from shakedown.ground.errors import UsageError

WANTED = "expected functions that other processes can import (of a module, no lambda)"
GUARD = (
    "workers: expected processes that begin to work, found that they end before; a script has to keep "
    'what it does under if __name__ == "__main__":'
)
WORK, BEGUN = "work", "begun"  # file with the work, and marker that a worker has begun
_folder: Path  # where they are, where this process is a worker
_work: Work | None = None  # the work, once there is a piece of it to do


def by_processes(work: Work, numbers: list[int], workers: int) -> Iterator[tuple[int, bytes]]:
    """(number, piece) as they are done, in no particular order.

    A process that is killed takes the pool with it; the pieces that it had in hand are
    done again by a new one.

    Raises
    ------
    UsageError
        If the work is none that other processes can import, or they cannot begin with it.
    SolverError
        If processes die again and again with nothing done.
    """
    try:
        pickled = pickle.dumps(work)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise UsageError(f"workers: {WANTED}, found one that cannot be sent there ({error})") from None
    todo, losses = dict.fromkeys(numbers), Losses()
    with _folder_with(pickled) as folder:
        while todo:
            try:
                for number, piece in _by_one_pool(folder, list(todo), workers):
                    losses.progress()
                    del todo[number]
                    yield number, piece
            except BrokenProcessPool:
                if not (folder / BEGUN).exists():
                    raise UsageError(GUARD) from None
                losses.another()


@contextmanager
def _folder_with(pickled: bytes) -> Iterator[Path]:
    """A folder that workers read their work from: sending it to one that dies early would hang."""
    with ExitStack() as stack:
        try:
            kept = tempfile.TemporaryDirectory(prefix="shakedown-", ignore_cleanup_errors=True)
            folder = Path(stack.enter_context(kept))
            (folder / WORK).write_bytes(pickled)
        except OSError as error:
            what = error.strerror or error
            raise UsageError(f"workers: cannot be given their work, a temporary file ({what})") from None
        yield folder


def _by_one_pool(folder: Path, numbers: list[int], workers: int) -> Iterator[tuple[int, bytes]]:
    """The same from one pool, until a process of it dies."""
    _start_tracker()
    pool = ProcessPoolExecutor(
        min(workers, len(numbers)),
        mp_context=multiprocessing.get_context("spawn"),  # a fork would copy locks of compiled threads
        initializer=_begin,
        initargs=(folder,),
    )
    running: dict[Future[bytes], int] = {}
    waiting = iter(numbers)
    try:
        while True:
            for number in waiting:
                with _ctrl_c_held_back():
                    running[pool.submit(_one_piece, number)] = number
                if len(running) >= IN_HAND * workers:
                    break
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                yield running.pop(future), future.result()
    finally:
        pool.shutdown(wait=not running, cancel_futures=True)


@contextmanager
def _ctrl_c_held_back() -> Iterator[None]:
    """A process that begins gets all that it waits for; an interruption comes after."""
    if current_thread() is not main_thread():  # only the main thread receives signals
        yield
        return
    heard: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: heard.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)
    if heard:
        signal.raise_signal(signal.SIGINT)


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


def _begin(folder: Path) -> None:
    """Make this process a worker: one thread, deaf to Ctrl-C, gone when its parent is."""
    global _folder
    _folder = folder
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent receives it, and ends the worker
    with suppress(FileNotFoundError):  # interrupted meanwhile, so no work will come
        (folder / BEGUN).touch()
    threadpool_limits(1)
    parent = multiprocessing.parent_process()
    if parent is not None:
        Thread(target=_leave_with, args=(parent.sentinel,), daemon=True).start()


def _leave_with(parent: int) -> None:
    """End this process when the parent ends, however that happens."""
    wait_for([parent])
    rmtree(_folder, ignore_errors=True)
    os._exit(1)


def _one_piece(number: int) -> bytes:
    global _work
    if _work is None:
        try:
            _work = pickle.loads((_folder / WORK).read_bytes())
        except Exception as error:  # whatever its modules raise
            raise UsageError(f"workers: {WANTED}, found one that cannot be read there ({error})") from None
    return _work(number)
