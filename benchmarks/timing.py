"""Times that can be compared: several runs in one process, the median taken."""

import statistics
import time
from collections.abc import Callable
from typing import Any


def median_time(function: Callable[[], Any], *, least: float = 0.05, runs: int = 3) -> tuple[float, Any]:
    """Median time of one call [s], and the last result.

    A call shorter than ``least`` seconds is repeated within each run until the
    run is long enough to be timed.
    """
    began = time.perf_counter()
    result = function()  # not counted: compiles, fills caches
    once = time.perf_counter() - began
    repeats = max(1, min(10_000, int(least / max(once, 1e-7))))
    times = []
    for _ in range(runs):
        began = time.perf_counter()
        for _ in range(repeats):
            result = function()
        times.append((time.perf_counter() - began) / repeats)
    return statistics.median(times), result
