"""Leaps along a linear recurrence of the last changes of the state, and what all leaps have in common.

Every leap predicts what a period does where it ends, and is taken only where that comes true. A leap moves
a joint for good in what no cycle changes; so the more it moves, the better it has to be known.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np

from shakedown.ground.constants import ROUND_OFF, FloatArray
from shakedown.long_term.space.measure import Measure, product

WORTH = 8.0  # periods that a leap must gain at least, as it costs some, and so does its preparation
PRICE = 1e-5  # uncertainty allowed in a leap, relative to the total slip so far
TRIES = 3  # periods after a leap within which its prediction must come true
LONGEST_WAIT = 64  # periods
INDEPENDENT = 10 * ROUND_OFF  # relative to the largest: smaller singular values of the changes are round-off


class Leap(NamedTuple):
    """Where to continue, and a test of whether the leap was right.

    Attributes
    ----------
    start : (N,)
        The state [length].
    fits
        Whether the next period from there, of those in a row, changes the state as predicted.
    error, error_apart
        How far the state may be off, with rigid slip and apart from it [length].
    rate
        Factor per period by which changes shrink.
    """

    start: FloatArray
    fits: Callable[[FloatArray], bool]
    error: float
    error_apart: float
    rate: float


def longer(wait: int) -> int:
    """Periods to wait after a further leap that fails, twice as many as after the one before."""
    return min(2 * wait + 5, LONGEST_WAIT)


@dataclass(frozen=True)
class Recurrence:
    """A sequence x_0, …, x_k that continues with Δ_{j+1} = Σ c_i Δ_{j−r+i}, Δ_j = x_{j+1} − x_j.

    Attributes
    ----------
    last : (N,)
        x_k.
    changes : (r, N)
        The last changes, the newest last.
    weights : (r,)
        c.
    """

    last: FloatArray
    changes: FloatArray
    weights: FloatArray

    def ahead(self, count: int) -> tuple[FloatArray, FloatArray]:
        """The state a number of steps ahead, and the change that follows it."""
        r = len(self.weights)
        # One step: coefficients of the last changes in the coming ones, and in their sum.
        one = np.zeros((r + 1, r + 1))
        one[: r - 1, 1:r] = np.eye(r - 1)
        one[r - 1 :, :r] = self.weights
        one[r, r] = 1.0
        many = np.linalg.matrix_power(one, count)[:, :r]
        return self.last + many[r] @ self.changes, (self.weights @ many[:r]) @ self.changes


def recurrence_of(states: FloatArray, root: FloatArray) -> Recurrence:
    """The recurrence of states x_0, …, x_k, (k + 1, N), that fits the last change best to those before it.

    Where the map is affine on the span of the changes, and the sequence has gone through all of it, it goes
    on exactly so (minimal polynomial extrapolation). What the map leaves alone (linear functions of the state
    that no cycle changes) is kept.

    Parameters
    ----------
    states
        x_0, …, x_k.
    root : (M, N)
        A change Δ counts for ‖root Δ‖.

    Examples
    --------
    >>> states = np.array([[1.0, 0.0], [0.5, 1.0], [0.25, 1.5], [0.125, 1.75]])
    >>> state, change = recurrence_of(states, np.eye(2)).ahead(1)
    >>> state.round(9), change.round(9)
    (array([0.0625, 1.875 ]), array([-0.03125,  0.0625 ]))
    """
    changes = np.diff(states, axis=0)
    seen = product(root, changes)
    seen = seen / (float(np.abs(seen).max()) or 1.0)
    weights = np.linalg.lstsq(seen[:-1].T, seen[-1], rcond=INDEPENDENT)[0]
    return Recurrence(states[-1], changes[1:], weights)


@dataclass
class RecurrenceLeaps:
    """Leaps along a linear recurrence of the last changes, as far as two of them agree.

    Any number of modes, fast and slow, in as many periods ahead as leave something to be seen.

    Attributes
    ----------
    care
        Share of what leaps may be uncertain by otherwise.
    reach, count
        Periods that the next leap goes ahead at most, and that the last one went.
    since, wait
        From which cycle on the next one is tried, and how many after the last that failed.
    missed : (r,)
        Rigid slip by which a period after the leap differs from its prediction [length].
    """

    FEWEST: ClassVar[int] = 5  # states
    AGREE: ClassVar[float] = 1e-4  # largest difference of two recurrences, relative to the leap …
    ROUGHLY: ClassVar[float] = 0.03  # … and where the leap is short compared with the total slip
    ALIKE: ClassVar[float] = 0.1  # relative to the predicted change
    LEFT: ClassVar[float] = 1e-3  # least size of the change after a leap, relative to the last change
    GROWN: ClassVar[float] = 2.0  # and the largest
    FURTHER: ClassVar[int] = 4  # factor on the length after an accepted leap; inverse after a rejected one

    care: float = 1.0
    reach: int = 64
    count: int = 0
    since: int = 0
    wait: int = 0
    missed: FloatArray = field(default_factory=lambda: np.zeros(0))

    def plan(self, window: FloatArray, measure: Measure, cycles: int) -> Leap | None:
        """Leap as far as the recurrences of the last states, and of those one period before, agree."""
        if len(window) < self.FEWEST or cycles < self.since:
            return None
        recurrence, earlier = recurrence_of(window, measure.root), None
        x, now, whole = window[-1], measure.size(recurrence.ahead(0)[1]), measure.size(window[-1])
        found, count = None, int(WORTH)
        while now > 0.0 and count <= self.reach:
            state, change = recurrence.ahead(count)
            way, share = measure.size(state - x), measure.size(change) / now
            if not (0.0 < way < np.inf and self.LEFT <= share <= self.GROWN):  # mostly so: it fades fast
                break
            earlier = earlier or recurrence_of(window[:-1], measure.root)
            other, _ = earlier.ahead(count + 1)
            differ = measure.deviation(other - x, state - x, way)
            allowed = self.care * max(self.AGREE, min(self.ROUGHLY, PRICE * whole / way))
            if not differ <= min(allowed, share):
                break
            found, self.count = (state, share, state - other), count
            count *= 2
        if found is None:
            return None
        (state, share, off), steps = found, iter(range(self.count, self.count + TRIES))

        def fits(change: FloatArray) -> bool:
            missed = change - recurrence.ahead(next(steps))[1]
            self.missed = np.abs(measure.rigid.T @ missed)
            return measure.size(missed) <= self.ALIKE * share * now

        rate = min(share ** (1.0 / self.count), 1.0)
        apart = float(np.abs(measure.without_rigid(off)).max())
        return Leap(state, fits, float(np.abs(off).max()), apart, rate)

    def rigid_error(self, measure: Measure) -> float:
        """Rigid slip that the last leap may be off, as a period at its end was off so much [length]."""
        return float((np.abs(measure.rigid) @ (self.count * self.missed)).max())

    def adapt(self, taken: bool, cycles: int) -> None:
        """Adapt the length of the next leap."""
        self.reach = self.count * self.FURTHER if taken else self.count // self.FURTHER
        if taken:
            self.wait = 0
        elif self.reach < WORTH:
            self.reach, self.wait = int(WORTH) * self.FURTHER, longer(self.wait)
        self.since = cycles + self.wait
