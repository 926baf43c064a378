"""The pieces of work of a verification, done by threads beside each other, and what they find."""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, NamedTuple, Protocol, TypeVar

from shakedown.assessment.every_limit import JointLimits
from shakedown.assessment.independent_bounds import SecondBounds
from shakedown.assessment.runs import MOST_WORK
from shakedown.assessment.slip_limit import SlipLimit
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.enumeration.critical import CriticalLoadFactors, critical_load_factors
from shakedown.ground.errors import Missing
from shakedown.ground.work_limit import limited_work

T = TypeVar("T")


class Begin(Protocol):
    """Takes a piece of work and returns what waits for its result."""

    def __call__(self, step: Callable[[], T], /) -> Callable[[], T]: ...


@contextmanager
def side_by_side(threads: int) -> Iterator[Begin]:
    """Pieces of work done by threads in their order; with one thread each when its result is asked for.

    Most of their time is spent in compiled code that releases the lock of the interpreter.

    Examples
    --------
    >>> with side_by_side(threads=2) as begin:
    ...     one, two = begin(lambda: 1), begin(lambda: 2)
    ...     one(), two()
    (1, 2)
    """
    if threads == 1:
        yield lambda step: step
        return
    pool = ThreadPoolExecutor(threads)
    try:
        yield lambda step: pool.submit(step).result
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


class OtherEvidence(NamedTuple):
    """The evidence of a verification besides its simulations."""

    second: SecondBounds
    critical: CriticalLoadFactors | None
    transient: Bound | Missing | None
    slip: SlipLimit | Missing | None

    def missing(self) -> Iterator[str]:
        """One sentence for each piece of evidence whose solver did not finish."""
        for name, found in {"λ_T": self.transient, "the slip limit": self.slip}.items():
            if isinstance(found, Missing):
                yield f"{name} is missing: {found.reason}"


def limited(step: Callable[[], T]) -> Callable[[], T]:
    """A piece of work whose motions take ``MOST_WORK`` at most."""

    def within() -> T:
        with limited_work(MOST_WORK):
            return step()

    return within


def evidence_steps(limits: JointLimits, budget: int, below: float | None) -> list[Callable[[], Any]]:
    """The pieces of work that compute the evidence besides the simulations, λ_T and the second bounds."""
    problem, subsets = limits.problem, limits.subsets
    few = subsets is not None and subsets <= budget
    return [
        lambda: critical_load_factors(problem, values=False) if few else None,
        lambda: limits.friction,
        lambda: None if below is None else limits.slip(below),
        lambda: limits.mesh,
    ]
