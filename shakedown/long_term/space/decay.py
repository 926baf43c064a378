"""What is left: how the change per period falls on the way, and what slip and drift come to where it ends.

Where the change falls by the same share of the way from period to period, along a line, the way ends at a
fixed point of the map, a known distance ahead. A motion that lingers next to a state and goes on past it
shows itself before: as at a double root its change falls by ever smaller shares. So does one that is slower
by far: its change stays, while that of the fast one falls.
"""

from typing import NamedTuple

import numpy as np

from shakedown.ground.constants import MUCH, NEGLIGIBLE, PER_CENT, RESOLVED, THREE_DIGITS, FloatArray
from shakedown.joint.law import Layout
from shakedown.long_term.space.measure import STATE_ROUND_OFF, Measure

CLEARLY = 4.0  # ratio of two changes from which on they show a slope
# Of the slope before it, which is ½ of that along a square: less is no line, or is not nearer to one.
LINEAR, NEARLY = 0.9, 0.75


class Period(NamedTuple):
    """What a period did.

    Attributes
    ----------
    state : (N,)
        At its end [length].
    change : (N,)
        Of the state [length].
    size
        Of that [energy norm].
    slip : (n,)
        In it [length].
    drift : (r,)
        Rigid slip in it, along each of the orthonormal ones [length].
    """

    state: FloatArray
    change: FloatArray
    size: float
    slip: FloatArray
    drift: FloatArray


class End(NamedTuple):
    """Where the change has fallen to nothing, if all falls in proportion to it.

    Attributes
    ----------
    way, change : (N,)
        The way there, and what the change has not lost by then [length].
    slip : (n,)
        Per period [length].
    drift : (r,)
        Per period [length].
    """

    way: FloatArray
    change: FloatArray
    slip: FloatArray
    drift: FloatArray

    @classmethod
    def of(cls, before: Period, now: Period) -> "End":
        """From two periods."""
        share = now.size / (before.size - now.size)
        way = (now.state - before.state) * share
        pairs = (now.change, before.change), (now.slip, before.slip), (now.drift, before.drift)
        return cls(way, *(after + share * (after - start) for after, start in pairs))


class Decay:
    """Periods on the way of a search, each with half the change of the one before it, or less."""

    def __init__(self) -> None:
        self.periods: list[Period] = []

    def note(self, period: Period) -> None:
        """Keep a period, if the change has fallen; where it has grown, forget those of smaller changes."""
        while self.periods and self.periods[-1].size <= period.size:
            self.periods.pop()
        if not self.periods or period.size <= 0.5 * self.periods[-1].size:
            self.periods.append(period)

    def before(self, now: Period, times: float = CLEARLY) -> Period | None:
        """The last period of so many times the change: by default one that shows a slope."""
        return next((each for each in reversed(self.periods) if 0.0 < each.size >= times * now.size), None)

    def end(self, now: Period) -> End | None:
        """The end of the way; None where no period shows a slope."""
        before = self.before(now)
        return None if before is None else End.of(before, now)

    def to_come(self, now: Period, measure: Measure, lost: float = 0.0) -> FloatArray | None:
        """The way (N,) to where there is no change [length]; None where it falls along no line.

        Changes of up to ``lost`` are round-off [energy norm].
        """
        end = self._end_of_line(now, measure, LINEAR, max(PER_CENT * now.size, lost))
        return None if end is None else end.way

    def comes_to_a_cycle(self, now: Period, measure: Measure, none: float) -> bool:
        """Whether the change falls to none [energy norm], nearer to a line than a square; slip stays."""
        least = max(PER_CENT * now.size, none)
        return self._end_of_line(now, measure, NEARLY, least) is not None and self.slip_lasts(now, PER_CENT)

    def _end_of_line(self, now: Period, measure: Measure, straight: float, none: float) -> End | None:
        """The end of the way, if the change falls along a line to none [energy norm]."""
        before = self.before(now)
        first = None if before is None else self.before(before)
        if before is None or first is None:
            return None
        way, earlier = measure.size(now.state - before.state), measure.size(before.state - first.state)
        if not (before.size - now.size) * earlier >= straight * (first.size - before.size) * way:
            return None
        end, round_off = End.of(before, now), STATE_ROUND_OFF * measure.size(now.state)
        # More falls to another one, far slower: nothing shows where that ends.
        return end if measure.size(end.change) <= none + round_off else None

    def slip_lasts(self, now: Period, share: float = THREE_DIGITS) -> bool:
        """Whether the slip stays where the change falls to nothing, but for a share."""
        end = self.end(now)
        return end is not None and bool(np.abs(end.slip - now.slip).max() <= share * now.slip.max())

    def slip_ends(self, now: Period, none: FloatArray, share: float = MUCH) -> bool:
        """Whether the slip falls to nothing with the change, but for a share, and has done so on the way.

        At every node, as a soft one may hide a stiff one, or to what counts as none, (n,) [length].
        """
        end, before = self.end(now), self.before(now, RESOLVED)
        if end is None or before is None:
            return False
        fallen = bool(now.slip.max() <= MUCH * before.slip.max())
        grown = now.slip > np.maximum(before.slip, THREE_DIGITS * none)  # that leads away from rest
        return fallen and bool((~grown & (np.abs(end.slip) <= np.maximum(share * now.slip, none))).all())

    def drift_lasts(self, now: Period) -> bool:
        """Whether the drift stays where the change falls to nothing."""
        end = self.end(now)
        if end is None:
            return False
        return bool(np.linalg.norm(end.drift - now.drift) <= PER_CENT * np.linalg.norm(now.drift))

    def drift_ends(self, now: Period) -> bool:
        """Whether the drift falls to nothing with the change."""
        end = self.end(now)
        return end is not None and bool(np.linalg.norm(end.drift) <= PER_CENT * np.linalg.norm(now.drift))

    def drift_left(self, now: Period) -> FloatArray:
        """The drift (r,) where the change falls to nothing; that of the period where nothing shows it."""
        end = self.end(now)
        return now.drift if end is None else end.drift

    def farthest(self, now: Period, layout: Layout, measure: Measure, drifts: bool) -> float:
        """How far a node has still to go, as the changes of all fall, and as its own does [length].

        Beside fast ones a slow one may have come no nearer to its end. Rigid drift that lasts does not count.
        """
        before = self.before(now)
        if before is None:
            return 0.0
        gone = now.state - before.state
        apart = (measure.without_rigid(each) for each in (gone, before.change, now.change))
        way, first, last = (layout.ways(each) for each in apart)
        fallen = np.maximum(first - last, NEGLIGIBLE * last)
        own = np.divide(way * last, fallen, out=np.zeros_like(way), where=last > 0.0)
        as_all = (way if drifts else layout.ways(gone)) * now.size / (before.size - now.size)
        return float(np.maximum(own, as_all).max())
