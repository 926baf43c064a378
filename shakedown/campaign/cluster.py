"""Pieces of work on the workers of a dask cluster; the pieces of a lost worker are repeated."""

from __future__ import annotations

import inspect
import logging
import time
from asyncio import CancelledError
from collections.abc import Iterator
from concurrent.futures import CancelledError as FutureCancelled
from contextlib import contextmanager
from threading import Timer
from typing import TYPE_CHECKING, Any

from shakedown.campaign import worker_versions
from shakedown.campaign.crew import IN_HAND, Losses, Work
from shakedown.ground.errors import SolverError, UsageError
from shakedown.ground.visible_text import visible

if TYPE_CHECKING:
    from distributed import Client

LOGGER = logging.getLogger("shakedown")
SOON = 1.0  # seconds after which a message tells what the call waits for, and between checks of the workers
PATIENCE = 30.0  # seconds to wait for the scheduler, and then for its first worker
WINK = 0.01  # seconds between checks of finished pieces
SAME = "scheduler: expected workers with the versions of this process"
# Runs on workers without the package, too: only standard names are sent.
ASK = "[exec(text, namespace), namespace['versions']()][1]"


def by_cluster(work: Work, numbers: list[int], address: str) -> Iterator[tuple[int, bytes]]:
    """(number, piece) as they are done, in no particular order.

    Raises
    ------
    UsageError
        If dask.distributed is not installed, no cluster answers at that address, or a worker
        there has other versions than this process, or no such package.
    SolverError
        If workers die again and again with nothing done, or the scheduler is lost.
    """
    try:
        from distributed import as_completed
        from distributed.scheduler import KilledWorker
    except ImportError:
        raise UsageError(
            "scheduler: expected dask.distributed to be installed, found none "
            "(pip install 'shakedown-bounds[cluster]')"
        ) from None
    losses, waiting = Losses(), list(reversed(numbers))
    with _while_there(address), _connected(address) as client:
        running, checked = as_completed(loop=client.loop), set[str]()
        names: dict[str, int] = {}
        while waiting or names:
            threads = _threads(client, checked)
            while waiting and len(names) < IN_HAND * max(threads, 1):
                number = waiting.pop()
                future = client.submit(_one_piece, work, number, worker_versions.versions(), pure=False)
                names[future.key] = number
                running.add(future)
            looked = time.monotonic()
            while not running.has_ready():
                time.sleep(WINK)
                if time.monotonic() - looked > SOON or client.status != "running":
                    _threads(client, checked)
                    looked = time.monotonic()
            future = next(running)
            number = names.pop(future.key)
            try:
                piece = future.result()
            except KilledWorker:
                losses.another()
                waiting.append(number)
                continue
            losses.progress()
            yield number, piece


@contextmanager
def _while_there(address: str) -> Iterator[None]:
    """Say in one line that the scheduler is gone; the client has a traceback for it in its log."""
    log = logging.getLogger("distributed.client")
    level = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    except (CancelledError, FutureCancelled, OSError):
        lost = f"the dask scheduler at {address} was lost in the middle of the work"
        raise SolverError(f"scheduler: {lost}; what is done is recorded where there is an output") from None
    finally:
        log.setLevel(level)


def _threads(client: Client, checked: set[str]) -> int:
    """How many threads the cluster has; workers that are new are asked first what they compute with."""
    if client.status != "running":  # it tries to reconnect for as long as nobody answers
        raise ConnectionError
    threads = client.nthreads()
    if new := sorted(threads.keys() - checked):
        asked = {"text": inspect.getsource(worker_versions), "namespace": {"__name__": "worker_versions"}}
        said: dict[str, Any] = client.run(eval, ASK, asked, workers=new, on_error="return")
        for place in new:
            _check_versions(place, said.get(place))
        checked.update(new)
    return sum(threads.values())


def _check_versions(place: str, found: Any) -> None:
    """Raise ``UsageError`` where a worker does not compute with what this process computes with."""
    expected = worker_versions.versions()
    if not isinstance(found, dict):
        raise UsageError(f"scheduler: expected the worker at {place} to say its versions, found {found!r}")
    differing = [name for name, here in expected.items() if found.get(name) != here]
    if differing:
        told = ", ".join(f"{name} {found.get(name)} for {expected[name]}" for name in differing)
        raise UsageError(f"{SAME}, found at {place} {told}")


def _connected(address: str) -> Client:
    """A connection to the scheduler, with at least one worker behind it; says so where that takes a while."""
    saying = Timer(SOON, LOGGER.warning, ["scheduler: trying to reach %s and its workers", visible(address)])
    saying.daemon = True
    saying.start()
    try:
        from distributed import Client

        _check_that_it_answers(address)
        client = Client(address, timeout=PATIENCE, set_as_default=False)
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            client.close()
            raise UsageError(f"scheduler: expected workers at {address}, found none") from None
        return client
    except (OSError, ValueError) as error:
        if isinstance(error, UsageError):
            raise
        raise UsageError(f"scheduler: expected a dask scheduler at {address}, found none ({error})") from None
    finally:
        saying.cancel()


def _check_that_it_answers(address: str) -> None:
    """Raise ``OSError`` unless something does: a client that cannot connect leaves noise behind."""
    import asyncio
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(1) as pool:  # this thread may have an event loop
        try:
            pool.submit(asyncio.run, _answer(address)).result()
        except Exception as error:  # different kinds of address raise unrelated exceptions
            raise OSError(str(error) or type(error).__name__) from None


async def _answer(address: str) -> None:
    from distributed.comm import connect
    from distributed.security import Security

    options = Security().get_connection_args("client")
    comm = await connect(address, timeout=PATIENCE, **options)
    await comm.close()


def _one_piece(work: Work, number: int, expected: dict[str, str]) -> bytes:
    """A piece; a worker that has joined since is as the others are, or says so."""
    if worker_versions.versions() != expected:
        raise UsageError(f"{SAME}, found another one that has joined")
    return work(number)
