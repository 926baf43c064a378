"""A place for compiled code; where there is none, the kernels are compiled anew in every run."""

import logging
from typing import Any, cast

import numba
from numba.core.dispatcher import Dispatcher

from shakedown.ground.errors import UsageError


def ensure_code_can_be_compiled() -> bool:
    """Let kernels that ask for a cache be compiled also where numba finds no place for one.

    Numba looks for a folder that it can write: ``NUMBA_CACHE_DIR``, ``__pycache__``
    beside the source, the user's own cache. Where the package is read-only and the
    user has no home, it refuses to define the kernels at all. Then they are defined
    without a cache, and a line of the log says so.

    Raises
    ------
    UsageError
        If ``NUMBA_DISABLE_JIT`` is set: the kernels hold states that only compiled code knows.

    Returns
    -------
    bool
        Whether there is a place for compiled code.
    """
    if cast(Any, numba.config).DISABLE_JIT:
        raise UsageError("NUMBA_DISABLE_JIT: expected it unset, as the motion is followed by compiled code")
    try:
        numba.njit(cache=True)(_asks_for_a_cache)
    except RuntimeError:  # numba: no locator available
        cast(Any, Dispatcher).enable_caching = _without_cache
        logging.getLogger("shakedown").warning(
            "no place for compiled code: it is compiled anew in every run, which takes about half a minute; "
            "set NUMBA_CACHE_DIR to a folder that can be written"
        )
        return False
    return True


def _asks_for_a_cache() -> None:
    """Defined, never called and so never compiled."""


def _without_cache(_: object) -> None:
    """In place of ``Dispatcher.enable_caching``: a dispatcher starts without a cache."""
