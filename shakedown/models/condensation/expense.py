"""What the condensation of a large solid takes, said before it begins."""

import os
import time
from collections.abc import Callable

import numpy as np
from scipy.linalg.blas import dsyrk

from shakedown.ground.errors import ProblemError
from shakedown.models.condensation.fronts import BYTES, FrontElimination

MATRICES = 8  # κ, the blocks of the problem and what the bounds make of them: of its size, at one time
WORTH_SAYING = 20.0  # seconds
LARGEST = 0.9  # share of the machine's memory that may be used
SAMPLE, TRIES = 400, 8  # size of the product that tells how fast the machine is; the fastest of some counts


def announced(plan: FrontElimination, announce: Callable[[str], None] | None) -> None:
    """Say what the elimination takes, if it takes long.

    Raises
    ------
    ProblemError
        If it takes more memory than the machine has.
    """
    kept = len(plan.order) - plan.count
    needed = plan.memory + MATRICES * BYTES * float(kept) ** 2
    seconds = plan.operations / speed()
    what = (
        f"condensing {plan.count} rows to {kept // 3} contact nodes takes about {needed / 2**30:.2g} GiB of "
        f"memory and {_duration(seconds)}"
    )
    there = memory()
    if needed > LARGEST * there:
        raise ProblemError(
            f"K: expected a model that fits into {there / 2**30:.3g} GiB of memory, found that {what}; take "
            "fewer contact nodes or a coarser mesh"
        )
    if announce is not None and seconds > WORTH_SAYING:
        announce(what)


def memory() -> float:
    """Memory of the machine [bytes]; infinite where it is not known."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return float("inf")


def speed() -> float:
    """Multiplications of dense matrices per second on this machine when it is quiet, about."""
    a, fastest = np.ones((SAMPLE, SAMPLE), order="F"), np.inf
    for _ in range(TRIES):
        begin = time.perf_counter()
        dsyrk(1.0, a)
        fastest = min(fastest, time.perf_counter() - begin)
    return float(0.5 * SAMPLE**3 / max(fastest, 1e-6))


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} minutes"
