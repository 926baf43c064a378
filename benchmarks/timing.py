"""Times that can be compared: several runs in one process, taking turns, the median taken."""

import statistics
import time
from collections.abc import Callable
from typing import Any

LEAST = 0.05  # seconds that one run takes at least


def in_turn(
    *functions: Callable[[], Any], least: float | None = None, runs: int = 3
) -> tuple[tuple[float, Any], ...]:
    """Median time of one call of each function [s], and its last result.

    The functions take turns, so that whatever else the machine does slows all of them. A call
    shorter than ``least`` seconds (by default ``LEAST``) is repeated within each run until the run
    is long enough to be timed.
    """
    least = LEAST if least is None else least
    results, repeats = [], []
    for function in functions:
        began = time.perf_counter()
        results.append(function())  # not counted: compiles, fills caches
        once = time.perf_counter() - began
        repeats.append(max(1, min(10_000, int(least / max(once, 1e-7)))))
    times: list[list[float]] = [[] for _ in functions]
    for _ in range(runs):
        for k, function in enumerate(functions):
            began = time.perf_counter()
            for _ in range(repeats[k]):
                results[k] = function()
            times[k].append((time.perf_counter() - began) / repeats[k])
    return tuple((statistics.median(own), result) for own, result in zip(times, results, strict=True))


def median_time(
    function: Callable[[], Any], *, least: float | None = None, runs: int = 3
) -> tuple[float, Any]:
    """Median time of one call [s], and the last result; see :func:`in_turn`."""
    return in_turn(function, least=least, runs=runs)[0]
