"""Pieces of work on the workers of a dask cluster; what a lost worker had in hand is done again."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from threading import Timer
from typing import TYPE_CHECKING

from shakedown.campaign.crew import Losses, Work
from shakedown.ground.errors import UsageError
from shakedown.ground.visible_text import visible

if TYPE_CHECKING:
    from distributed import Client

LOGGER = logging.getLogger("shakedown")
SOON = 1.0  # seconds after which somebody who waits is told what for
PATIENCE = 30.0  # seconds to wait for the scheduler, and then for its first worker
IN_HAND = 2  # pieces that each thread of the cluster has at a time


def by_cluster(work: Work, numbers: list[int], address: str) -> Iterator[tuple[int, bytes]]:
    """(number, piece) as they are done, in no particular order.

    Raises
    ------
    UsageError
        If dask.distributed is not installed, or no cluster answers at that address.
    SolverError
        If workers die again and again with nothing done.
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
    with _connected(address) as client:
        running = as_completed(loop=client.loop)
        names: dict[str, int] = {}
        while waiting or names:
            while waiting and len(names) < IN_HAND * max(sum(client.nthreads().values()), 1):
                number = waiting.pop()
                future = client.submit(_one_piece, work, number, pure=False)
                names[future.key] = number
                running.add(future)
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

    with ThreadPoolExecutor(1) as pool:  # there may be a loop in this thread
        try:
            pool.submit(asyncio.run, _answer(address)).result()
        except Exception as error:  # what the many kinds of address raise has nothing in common
            raise OSError(str(error) or type(error).__name__) from None


async def _answer(address: str) -> None:
    from distributed.comm import connect
    from distributed.security import Security

    options = Security().get_connection_args("client")
    comm = await connect(address, timeout=PATIENCE, **options)
    await comm.close()


def _one_piece(work: Work, number: int) -> bytes:
    return work(number)
