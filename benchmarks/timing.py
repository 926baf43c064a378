"""Times that can be compared: several runs in one process, the median taken."""

import statistics
import time
from collections.abc import Callable
from typing import Any

from threadpoolctl import threadpool_limits

LEAST = 0.05  # seconds that one run takes at least


def in_turn(*functions: Callable[[], Any], runs: int = 3) -> tuple[tuple[float, Any], ...]:
    """Median processor time of one call of each function [s], and its last result.

    The functions take turns, with one thread for linear algebra, and only what the processor
    spends on this process counts: what else the machine does changes little. Of functions that
    run on several cores, all cores count.
    """
    with threadpool_limits(limits=1, user_api="blas"):
        return _medians(functions, time.process_time, LEAST, runs)


def median_time(function: Callable[[], Any], *, runs: int = 3) -> tuple[float, Any]:
    """Median time of one call [s] on the clock, and the last result."""
    return _medians((function,), time.perf_counter, LEAST, runs)[0]


def _medians(
    functions: tuple[Callable[[], Any], ...], clock: Callable[[], float], least: float, runs: int
) -> tuple[tuple[float, Any], ...]:
    """A call shorter than ``least`` seconds is repeated within each run until that can be timed."""
    results, repeats = [], []
    for function in functions:
        began = clock()
        results.append(function())  # not counted: compiles, fills caches
        repeats.append(max(1, min(10_000, int(least / max(clock() - began, 1e-7)))))
    times: list[list[float]] = [[] for _ in functions]
    for _ in range(runs):
        for k, function in enumerate(functions):
            began = clock()
            for _ in range(repeats[k]):
                results[k] = function()
            times[k].append((clock() - began) / repeats[k])
    return tuple((statistics.median(own), result) for own, result in zip(times, results, strict=True))
