"""Many pieces of work: here, on processes or a cluster, each kept in a file as soon as it is done.

The work is a picklable function from the numbers 0 … count − 1 to arrays by name, the same ones whenever and
wherever it is called; ``settings`` says what they depend on::

    with run_pieces(work, count, settings=…, output="map.npz", resume=True, workers=4) as pieces:
        ...  # write the result whole

Until the block ends the pieces are NPZ files in ``map.npz.parts``, named by a hash of all that they depend on
and their number; what a killed run left there is read when it is resumed. Make each about a second of work.
The file that results depends neither on who did the work nor on how often it was interrupted.
"""

import json
import logging
import multiprocessing
import os
import pickle
import platform
import re
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent import futures
from concurrent.futures import Executor
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from functools import cache, lru_cache, partial
from hashlib import sha256
from importlib.metadata import version
from itertools import islice
from multiprocessing import resource_tracker
from multiprocessing.connection import wait as wait_for
from pathlib import Path
from threading import Thread, current_thread, main_thread
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from shakedown.files.atomic_write import PART, locked, pieces_beside, refusing
from shakedown.ground.argument_kinds import check_count
from shakedown.ground.errors import ProblemError, ShakedownError, SolverError, UsageError, not_installed
from shakedown.ground.shown_values import visible
from shakedown.ground.work_limit import all_cores
from shakedown.joint.problem import Problem

TIMEOUT = 30.0  # seconds, of the connection to the scheduler, and then of its first worker


@contextmanager
def cluster_executor(address: str | None) -> Iterator[Executor | None]:
    """The executor of the dask cluster whose scheduler has this address; None where none is given.

    Raises
    ------
    UsageError
        If dask.distributed is not installed, no cluster answers at that address, or a worker
        there has other versions than this process, or no such package.
    SolverError
        If workers die again and again, or the scheduler is lost.
    """
    if address is None:
        yield None
        return
    try:
        from distributed.scheduler import KilledWorker
    except ImportError:
        raise UsageError(not_installed("scheduler", "dask.distributed", "cluster")) from None
    log = logging.getLogger("distributed.client")  # it has a traceback for a scheduler that is gone
    level = log.level
    log.setLevel(logging.CRITICAL)
    client = _connected(address)
    try:
        for place, found in client.run(versions, on_error="return").items():  # or an error
            if found != versions():
                expected = f"scheduler: expected workers with {versions()}"
                raise UsageError(f"{expected}, as this process has, found at {place} {found!r}")
        yield client.get_executor(pure=False)
    except KilledWorker:
        raise SolverError("scheduler: workers died one after the other (killed, or out of memory?)") from None
    except Exception as error:  # a future of dask that is lost while it ends raises whatever it likes
        if isinstance(error, UsageError) or client.status == "running":
            raise
        lost = f"the dask scheduler at {address} was lost in the middle of the work"
        raise SolverError(f"scheduler: {lost}; what is done is kept where there is an output") from None
    finally:
        client.close()
        log.setLevel(level)


@cache
def versions() -> dict[str, str]:
    """By name the version of Python and of what results depend on, and a checksum of the package's own code.

    Examples
    --------
    >>> list(versions())[1:]
    ['shakedown-bounds', 'numpy', 'scipy', 'numba', 'clarabel', 'Python']
    """
    from shakedown.ground.code_cache import hash_of_sources  # loads the compiler

    packages = ("shakedown-bounds", "numpy", "scipy", "numba", "clarabel")
    found = {"the code of shakedown": hash_of_sources(Path(__file__).parents[1])[:12]}
    return found | {name: version(name) for name in packages} | {"Python": platform.python_version()}


def _connected(address: str) -> Any:
    """A client of the scheduler, with at least one worker behind it."""
    import asyncio  # needed of a cluster alone

    from distributed import Client

    tried = "scheduler: trying to reach %s and its workers"
    logging.getLogger("shakedown").warning(tried, visible(address))
    client = None
    try:
        with futures.ThreadPoolExecutor(1) as thread:  # this one may have an event loop
            thread.submit(asyncio.run, _answer(address)).result()
        client = Client(address, timeout=TIMEOUT, set_as_default=False)
        client.wait_for_workers(1, timeout=TIMEOUT)
    except Exception as error:  # different kinds of address raise unrelated exceptions
        if client is not None:
            client.close()
            raise UsageError(f"scheduler: expected workers at {address}, found none") from None
        found = str(error) or type(error).__name__
        raise UsageError(f"scheduler: expected a dask scheduler at {address}, found none ({found})") from None
    return client


async def _answer(address: str) -> None:
    """Raise unless something answers in time: a client would wait for it without end."""
    from distributed.comm import connect
    from distributed.security import Security

    await (await connect(address, timeout=TIMEOUT, **Security().get_connection_args("client"))).close()


Arrays = dict[str, NDArray[Any]]
Progress = Callable[[int, int], None]

ASK_AGAIN = 1.0  # seconds after which a cluster is asked whether it still works
WANTED = "workers: expected functions that other processes can import (of a module, no lambda)"
GUARD = (
    "workers: expected processes that begin to work, found that they end before; a script has to keep "
    'what it does under if __name__ == "__main__":'
)


@contextmanager
def run_pieces(
    work: Callable[[int], Arrays],
    count: int,
    *,
    settings: object = None,
    output: str | os.PathLike[str] | None = None,
    resume: bool = False,
    executor: Executor | None = None,
    workers: int | None = 1,
    progress: Progress | None = None,
) -> Iterator[list[Arrays]]:
    """Do the pieces 0 … count − 1, and hand their arrays over.

    Parameters
    ----------
    work
        A picklable function from the number of a piece to its arrays: the same ones whenever and wherever.
    count
        How many pieces there are.
    settings
        Everything that the arrays depend on, but for the version: what it looks like tells runs apart.
    output
        The file that will be made of them: until the block ends well, they are files in ``OUTPUT.parts``.
    resume
        Whether to go on with those that an earlier run left there.
    executor
        Who works (any of ``concurrent.futures``); it is not shut down.
    workers
        Without one: the number of processes, None one for each core; 1 is this process.
    progress
        Called as ``progress(done, count)`` at the start and after each piece.

    Raises
    ------
    UsageError
        If an unfinished run is there and is not to be resumed, another run is writing it, a file cannot be
        written, or processes cannot begin to work.
    SolverError
        If a worker dies.
    """
    workers = processes_asked(workers if executor is None else 1)
    report = progress or (lambda done, count: None)
    run = sha256(repr((version("shakedown-bounds"), settings)).encode()).hexdigest()[:16]
    with _folder(output, resume, run) as folder:
        pieces = {} if folder is None else _kept(folder, run, count)
        report(len(pieces), count)
        todo = [number for number in range(count) if number not in pieces]
        for number, arrays in finished(work, todo, executor, workers):
            if folder is not None:
                _keep(folder, f"{run}-{number}.npz", arrays)
            pieces[number] = arrays
            report(len(pieces), count)
        yield [pieces[number] for number in range(count)]


def _keep(folder: Path, name: str, arrays: Arrays) -> None:
    """Write a piece; its file is there whole or not at all, but after a crash of the system."""
    with refusing(str(folder)):
        with open(unfinished := folder / f".{name}{PART}", "wb") as file:
            np.savez(file, allow_pickle=False, **arrays)
        os.replace(unfinished, folder / name)


def _kept(folder: Path, run: str, count: int) -> dict[int, Arrays]:
    """The pieces of a run whose files are whole, by number; says how many, and where."""
    found, files = dict[int, Arrays](), _pieces(folder)
    for number in range(count):
        with suppress(ProblemError):
            found[number] = read_arrays(folder / f"{run}-{number}.npz")
    if files:
        others = f"; {n} others there do not fit" if (n := len(files) - len(found)) else ""
        message = f"goes on from {len(found)} of {count} pieces in {visible(str(folder))}{others}"
        logging.getLogger("shakedown").warning(message)
    return found


@contextmanager
def _folder(output: str | os.PathLike[str] | None, resume: bool, run: str) -> Iterator[Path | None]:
    """The folder of the pieces, which no other run writes; at a good end those of this run are removed.

    It goes where it is empty: the pieces of a stopped run with other settings stay.
    """
    if output is None:
        yield None
        return
    path = Path(pieces_beside(output))
    with ExitStack() as stack:
        with refusing(str(path)):
            if not resume and path.is_dir() and _pieces(path):
                raise UsageError(f"{path}: an unfinished run is kept there; resume it, or remove that folder")
            path.mkdir(exist_ok=True)
            if os.name == "posix":  # others open no folders
                handle = os.open(path, os.O_RDONLY)
                stack.callback(os.close, handle)
                if not locked(handle):
                    raise UsageError(f"{path}: another run is writing there")
        try:
            yield path
            with suppress(OSError):
                for file in (*_pieces(path, run), *path.glob(f".*{PART}")):
                    file.unlink(missing_ok=True)
        finally:
            with suppress(OSError):
                path.rmdir()


def _pieces(folder: Path, run: str = "[0-9a-f]{16}") -> list[Path]:
    """The files of the pieces in a folder, of one run or of all."""
    # of a piece: the checksum of its run's settings, its number
    return [file for file in folder.iterdir() if re.fullmatch(rf"{run}-[0-9]+\.npz", file.name)]


def read_arrays(path: Path) -> Arrays:
    """The arrays of an NPZ file of ``numpy.savez``; nothing is unpickled.

    Raises
    ------
    ProblemError
        If it is none, or damaged.
    """
    try:
        if not path.is_file():  # a device, or what nobody writes to, would be read without end
            raise ProblemError("expected a file")
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return dict(arrays)
    except Exception as error:  # whatever damaged bytes raise
        raise ProblemError(f"{path}: expected a piece of this run, found a damaged one ({error})") from None


def text_of(arrays: Arrays) -> Any:
    """What :func:`as_text` made a piece of."""
    return json.loads(str(arrays["text"]))


def as_text(value: Any) -> Arrays:
    """A piece that JSON can hold, NaN and infinities too; floats come back to the last bit."""
    return {"text": np.array(json.dumps(value, default=int))}  # whole numbers of NumPy


def function_stamp(make: Callable[..., Problem], *first: object) -> str:
    """Its name, and the fingerprint of what it makes of its first arguments: it may have been changed.

    Examples
    --------
    >>> import shakedown
    >>> function_stamp(shakedown.example, "two-node")[:40]
    'shakedown.files.npz.example 3053854690ce'
    """
    try:
        made = make(*first)
        found = made.fingerprint if isinstance(made, Problem) else type(made).__name__
    except ShakedownError as error:  # no such joint is an answer, too
        found = str(error)
    return f"{getattr(make, '__module__', '')}.{getattr(make, '__qualname__', repr(make))} {found}"


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
        running, waiting = dict[futures.Future[Any], int](), iter(numbers)
        try:
            while True:
                # pieces that an executor holds at most: more than workers; memory stays flat
                for number in islice(waiting, 256 - len(running)):
                    with _signals_held_back():
                        running[pool.submit(work, number)] = number
                if not running:
                    return
                for future in futures.wait(running, ASK_AGAIN, futures.FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
                # some futures of dask never end once their scheduler is lost
                if getattr(getattr(pool, "_client", None), "status", "running") != "running":
                    raise futures.BrokenExecutor
        except futures.BrokenExecutor:
            raise SolverError(
                "workers: one died (killed, or out of memory?); what is done is kept where there is an output"
            ) from None
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
    pool = futures.ProcessPoolExecutor(workers, context, _begin)
    try:
        with _signals_held_back():
            first = pool.submit(int)
        if isinstance(first.exception(), futures.BrokenExecutor):
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
    Thread(target=lambda: (wait_for([parent.sentinel]), os._exit(1)), daemon=True).start()


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
