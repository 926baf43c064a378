"""The pieces of work of a verification: recorded, counted, and shown while they are done."""

import functools
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from queue import PriorityQueue
from threading import Thread
from typing import Any, NamedTuple, TypeVar

from shakedown.assessment.every_limit import JointLimits
from shakedown.assessment.independent_bounds import SecondBounds, second_bounds
from shakedown.assessment.runs import MOST_WORK
from shakedown.assessment.slip_limit import SlipLimit
from shakedown.assessment.transient_limit import TransientLimit
from shakedown.bounds.enumeration.critical import CriticalLoadFactors, critical_load_factors
from shakedown.bounds.uniqueness.friction_thresholds import FrictionThresholds
from shakedown.campaign.recorded_steps import LEISURE, RecordedSteps
from shakedown.ground.errors import Missing, present
from shakedown.ground.work_limit import limited_work

SHOWN_EVERY = 15.0  # seconds between intermediate pages, or more where writing one takes long
END = -1, -1  # before all pieces of work

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


class SideBySide:
    """Pieces of work done by threads, the most urgent ones first; with one thread by who asks for them.

    Most of their time is spent in compiled code that releases the lock of the interpreter. Nothing begins
    before the first result is asked for, so that what is recorded is not done again.

    Examples
    --------
    >>> with SideBySide(threads=2) as work:
    ...     one, two = work.add(lambda: 1), work.add(lambda: 2)
    ...     one(), two()
    (1, 2)
    """

    def __init__(self, threads: int) -> None:
        self.threads, self._begun = threads, False
        self._pieces: list[_Piece] = []
        self._waiting: PriorityQueue[tuple[int, int]] = PriorityQueue()  # urgency and number

    def __enter__(self) -> "SideBySide":
        return self

    def __exit__(self, *_: object) -> None:
        for _each in range(self.threads if self._begun else 0):  # each thread ends with its present piece
            self._waiting.put(END)

    def add(self, step: Callable[[], T], urgency: int = 0) -> Callable[[], T]:
        """A piece of work, the more urgent the smaller that number; what gives its result."""
        number = len(self._pieces)
        self._pieces.append(_Piece(step, urgency, Future()))
        if self._begun:
            self._begin(number)
        return functools.partial(self._result, number)

    def _result(self, number: int) -> Any:
        if self.threads == 1:
            return self._pieces[number].step()
        if not self._begun:
            self._begun = True
            for later in range(number, len(self._pieces)):
                self._begin(later)
            for _ in range(self.threads):  # daemons, so that an interrupt does not wait for them
                Thread(target=self._work, daemon=True).start()
        elif not self._pieces[number].is_begun:  # what follows it was asked for before
            self._begin(number)
        return self._pieces[number].end.result()

    def _begin(self, number: int) -> None:
        self._pieces[number].is_begun = True
        self._waiting.put((self._pieces[number].urgency, number))

    def _work(self) -> None:
        while (taken := self._waiting.get()) is not END:
            piece = self._pieces[taken[1]]
            try:
                piece.end.set_result(piece.step())
            except BaseException as error:
                piece.end.set_exception(error)


@dataclass
class _Piece:
    """A piece of work, and what becomes of it."""

    step: Callable[[], Any]
    urgency: int
    end: "Future[Any]"
    is_begun: bool = False


class OtherEvidence(NamedTuple):
    """The evidence of a verification besides its simulations."""

    second: SecondBounds
    critical: CriticalLoadFactors | None
    friction: FrictionThresholds | None
    transient: TransientLimit | Missing | None
    slip: SlipLimit | Missing | None

    def missing(self) -> Iterator[str]:
        """One sentence for each piece of evidence whose solver did not finish."""
        for name, found in {"λ_T": self.transient, "the slip limit": self.slip}.items():
            if isinstance(found, Missing):
                yield f"{name} is missing: {found.reason}"


def limited(step: Callable[[], T], most: float = MOST_WORK) -> Callable[[], T]:
    """A piece of work whose motions take so much at most."""

    def within() -> T:
        with limited_work(most):
            return step()

    return within


def second_step(limits: JointLimits) -> Callable[[], SecondBounds]:
    """The piece of work that finds the bounds by another solver, once they are known."""
    return lambda: second_bounds(limits.problem, limits.bounds, limits.tolerances)


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


def other_evidence(limits: JointLimits, second: SecondBounds, found: Sequence[Any]) -> OtherEvidence:
    """What the second bounds and these pieces of work have found."""
    critical, friction, slip, mesh = found
    limits.keep("friction", friction)
    limits.keep("mesh", mesh)
    return OtherEvidence(second, critical, present(limits.friction), limits.transient, slip)
