"""The workers of a dask cluster as an executor; the pieces of a lost worker are repeated there."""

import asyncio
import logging
import platform
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from shakedown.ground.errors import SolverError, UsageError
from shakedown.ground.shown_values import visible

PATIENCE = 30.0  # seconds to wait for the scheduler, and then for its first worker
SAME = "scheduler: expected workers with the versions of this process"


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
        raise UsageError(
            "scheduler: expected dask.distributed to be installed, found none (pip install "
            "'shakedown-bounds[cluster]')"
        ) from None
    log = logging.getLogger("distributed.client")  # it has a traceback for a scheduler that is gone
    level = log.level
    log.setLevel(logging.CRITICAL)
    client = _connected(address)
    try:
        yield _Checked(client)
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


class _Checked(Executor):
    """The executor of a client on workers with the versions of this process, also those that join later."""

    def __init__(self, client: Any) -> None:
        self._client, self._executor = client, client.get_executor(pure=False)
        for place, found in client.run(_differing, versions(), on_error="return").items():
            if found:  # what differs, or an error
                raise UsageError(
                    f"{SAME}, found at {place} {found if isinstance(found, str) else repr(found)}"
                )

    def submit(self, *call: Any, **named: Any) -> Future[Any]:
        if self._client.status != "running":  # it tries to connect again, for half a minute
            raise CancelledError
        found: Future[Any] = self._executor.submit(_checked_call, versions(), *call, **named)
        return found


def _checked_call(expected: dict[str, str], /, *call: Any, **named: Any) -> Any:
    if found := _differing(expected):
        raise UsageError(f"{SAME}, found where another one has joined {found}")
    return call[0](*call[1:], **named)


def _differing(expected: dict[str, str]) -> str:
    """The versions here that are not those expected; empty where all are."""
    pairs = {name: (versions().get(name), wanted) for name, wanted in expected.items()}
    return ", ".join(
        f"{name} {found} for {wanted}" for name, (found, wanted) in pairs.items() if found != wanted
    )


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
    from distributed import Client

    tried = "scheduler: trying to reach %s and its workers"
    logging.getLogger("shakedown").warning(tried, visible(address))
    client = None
    try:
        with ThreadPoolExecutor(1) as thread:  # this one may have an event loop
            thread.submit(asyncio.run, _answer(address)).result()
        client = Client(address, timeout=PATIENCE, set_as_default=False)
        client.wait_for_workers(1, timeout=PATIENCE)
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

    await (await connect(address, timeout=PATIENCE, **Security().get_connection_args("client"))).close()
