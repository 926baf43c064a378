"""The pieces of work of a verification: recorded, counted, and shown while they are done."""

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from threading import Thread
from typing import Any, NamedTuple, TypeVar

from shakedown.assessment.every_limit import JointLimits
from shakedown.assessment.independent_bounds import SecondBounds, second_bounds
from shakedown.assessment.slip_limit import SlipLimit
from shakedown.assessment.transient_limit import TransientLimit
from shakedown.bounds.enumeration.critical import CriticalLoadFactors, critical_load_factors
from shakedown.bounds.every_state.guarantee_curve import GuaranteeCurve
from shakedown.bounds.uniqueness.friction_thresholds import FrictionThresholds
from shakedown.campaign.recorded_steps import LEISURE, RecordedSteps
from shakedown.ground.errors import Missing, present

CURVE_RADII = (0.0, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # in multiples of max |safe slip|
SHOWN_EVERY = 15.0  # seconds between intermediate pages, or more where writing one takes long

T = TypeVar("T")


class RecordedWork:
    """Pieces of work, recorded where requested, with progress reported."""

    def __init__(
        self,
        steps: RecordedSteps,
        progress: Callable[[int, int], None] | None,
        so_far: Callable[[Any], None] | None,
    ) -> None:
        self.steps, self.progress, self.pieces, self.count = steps, progress, 0, 0
        self.so_far, self._since, self._wait = so_far, time.monotonic(), SHOWN_EVERY

    def show(self, limits: JointLimits, found: Callable[[], Any]) -> None:
        """Show intermediate results, where requested and due; the limits keep what the page has computed."""
        began = time.monotonic()
        if self.so_far is None or began - self._since < self._wait:
            return
        page = found()
        self.so_far(page)
        limits.learn(page.limits)
        self._since = time.monotonic()
        self._wait = max(SHOWN_EVERY, LEISURE * (self._since - began))

    def done(self, step: Callable[[], T]) -> T:
        """The result of a piece of work, computed or read from the record."""
        result = self.steps.done(step)
        self.count += 1
        if self.progress is not None:
            self.progress(self.count, self.pieces)
        return result


class ThreadedSteps:
    """Steps done by threads one after the other, from the first requested one on; or in the calling thread.

    Most of their time is spent in compiled code that releases the lock of the interpreter.
    """

    def __init__(self, steps: Sequence[Callable[[], Any]], threads: int) -> None:
        self.steps, self.threads = steps, threads
        self._ends: dict[int, Future[Any]] = {}

    def result(self, number: int) -> Any:
        """The result of a step; the following ones are started."""
        if self.threads == 1:
            return self.steps[number]()
        if not self._ends:
            self._ends = {k: Future() for k in range(number, len(self.steps))}
            left = iter(self._ends.items())
            for _ in range(self.threads):  # daemons, so that an interrupt does not wait for them
                Thread(target=self._work, args=(left,), daemon=True).start()
        return self._ends[number].result()

    def _work(self, left: Iterator[tuple[int, "Future[Any]"]]) -> None:
        for number, end in left:
            try:
                end.set_result(self.steps[number]())
            except BaseException as error:
                end.set_exception(error)
                return


class OtherEvidence(NamedTuple):
    """The evidence of a verification besides its simulations."""

    second: SecondBounds
    curve: GuaranteeCurve | Missing | None
    critical: CriticalLoadFactors | None
    friction: FrictionThresholds | None
    transient: TransientLimit | Missing | None
    slip: SlipLimit | Missing | None

    def missing(self) -> Iterator[str]:
        """One sentence for each piece of evidence whose solver did not finish."""
        evidence = {"the guarantee curve": self.curve, "λ_T": self.transient, "the slip limit": self.slip}
        for name, found in evidence.items():
            if isinstance(found, Missing):
                yield f"{name} is missing: {found.reason}"


def evidence_steps(limits: JointLimits, budget: int, below: float | None) -> list[Callable[[], Any]]:
    """The pieces of work that compute the evidence besides the simulations and λ_T."""
    problem, subsets = limits.problem, limits.subsets
    few = subsets is not None and subsets <= budget
    absent = "guarantee_curve" in limits.absent
    return [
        lambda: second_bounds(problem, limits.bounds, limits.tolerances),
        lambda: None if absent else limits.curve(CURVE_RADII),
        lambda: critical_load_factors(problem, values=False) if few else None,
        lambda: limits.friction,
        lambda: None if below is None else limits.slip(below),
    ]


def other_evidence(limits: JointLimits, found: Sequence[Any]) -> OtherEvidence:
    """What these pieces of work have found."""
    second, curve, critical, friction, slip = found
    limits.keep("friction", friction)
    return OtherEvidence(second, curve, critical, present(limits.friction), limits.transient, slip)
