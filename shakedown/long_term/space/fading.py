"""How the change per period falls along the way of a search, and what slip and drift come to where it ends.

Where the change falls by the same share of the way from mark to mark, along a line, the way ends at a fixed
point of the map, a known distance ahead. A motion that lingers next to a state and goes on past it shows
itself before: as at a double root its change falls by ever smaller shares. So does one that is slower by far:
its change stays, while that of the fast one falls.
"""

from typing import NamedTuple

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import MUCH, PER_CENT, RESOLVED, THREE_DIGITS
from shakedown.long_term.space.leap_methods import STATE_ROUND_OFF, Measure

CLEARLY = 4.0  # ratio of two changes from which on they tell a slope
# Of the slope before it, which is ½ of that along a square: less is no line, or is not nearer to one.
LINEAR, NEARLY = 0.9, 0.75


class Mark(NamedTuple):
    """A state on the way.

    Attributes
    ----------
    state : (N,)
        At the end of a period [length].
    change : (N,)
        In the period that ends there [length].
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
    """Change (N,), slip (n,) and drift (r,) of a mark [length], where its change has fallen to nothing."""

    change: FloatArray
    slip: FloatArray
    drift: FloatArray


class Fading:
    """Marks on the way of a search, each with half the change of the one before it, or less."""

    def __init__(self) -> None:
        self.marks: list[Mark] = []

    def note(self, mark: Mark) -> None:
        """Set a mark, if the change has fallen; where it has grown, forget those of smaller changes."""
        while self.marks and self.marks[-1].size <= mark.size:
            self.marks.pop()
        if not self.marks or mark.size <= 0.5 * self.marks[-1].size:
            self.marks.append(mark)

    def to_come(self, now: Mark, measure: Measure, lost: float = 0.0) -> FloatArray | None:
        """The way (N,) to where there is no change [length]; None where it falls along no line.

        Changes of up to ``lost`` are round-off [energy norm].
        """
        before = self._line(now, measure, LINEAR, max(PER_CENT * now.size, lost))
        return None if before is None else _way(now, before)

    def clearly_before(self, now: Mark) -> Mark | None:
        """The last mark that tells a slope."""
        return self._before(now, CLEARLY)

    def comes_to_a_cycle(self, now: Mark, measure: Measure, none: float) -> bool:
        """Whether the change falls to none [energy norm], nearer to a line than a square; slip stays."""
        least = max(PER_CENT * now.size, none)
        return self._line(now, measure, NEARLY, least) is not None and self.slip_lasts(now, PER_CENT)

    def _line(self, now: Mark, measure: Measure, straight: float, none: float) -> Mark | None:
        """The mark before, if the change falls along a line from there to none [energy norm]."""
        before = self._before(now, CLEARLY)
        first = None if before is None else self._before(before, CLEARLY)
        if before is None or first is None:
            return None
        way, earlier = measure.size(now.state - before.state), measure.size(before.state - first.state)
        if not (before.size - now.size) * earlier >= straight * (first.size - before.size) * way:
            return None
        end, round_off = _end(now, before), STATE_ROUND_OFF * measure.size(now.state)
        # More falls to another one, far slower: nothing tells where that ends.
        return before if measure.size(end.change) <= none + round_off else None

    def slip_lasts(self, now: Mark, share: float = THREE_DIGITS) -> bool:
        """Whether the slip stays where the change falls to nothing, but for a share."""
        end = self._foreseen(now)
        return end is not None and bool(np.abs(end.slip - now.slip).max() <= share * now.slip.max())

    def slip_ends(self, now: Mark, none: FloatArray, share: float = MUCH) -> bool:
        """Whether the slip falls to nothing with the change, but for a share, and has done so on the way.

        At every node, as a soft one may hide a stiff one, or to what counts as none, (n,) [length].
        """
        end, before = self._foreseen(now), self._before(now, RESOLVED)
        if end is None or before is None:
            return False
        fallen = now.slip.max() <= MUCH * before.slip.max()
        grown = now.slip > np.maximum(before.slip, THREE_DIGITS * none)  # that leads away from rest
        return fallen and bool((~grown & (np.abs(end.slip) <= np.maximum(share * now.slip, none))).all())

    def drift_lasts(self, now: Mark) -> bool:
        """Whether the drift stays where the change falls to nothing."""
        end = self._foreseen(now)
        if end is None:
            return False
        return bool(np.linalg.norm(end.drift - now.drift) <= PER_CENT * np.linalg.norm(now.drift))

    def drift_ends(self, now: Mark) -> bool:
        """Whether the drift falls to nothing with the change."""
        end = self._foreseen(now)
        return end is not None and bool(np.linalg.norm(end.drift) <= PER_CENT * np.linalg.norm(now.drift))

    def drift_left(self, now: Mark) -> FloatArray:
        """The drift (r,) where the change falls to nothing; that of the mark where nothing tells."""
        end = self._foreseen(now)
        return now.drift if end is None else end.drift

    def _before(self, mark: Mark, times: float) -> Mark | None:
        """The last mark of so many times the change."""
        return next((each for each in reversed(self.marks) if 0.0 < each.size >= times * mark.size), None)

    def _foreseen(self, now: Mark) -> End | None:
        """The end of the way, told by the last mark that tells a slope; None where there is none."""
        before = self._before(now, CLEARLY)
        return None if before is None else _end(now, before)


def _way(now: Mark, before: Mark) -> FloatArray:
    """The way (N,) to where there is no change, if that falls along a line from mark to mark [length]."""
    return (now.state - before.state) * (now.size / (before.size - now.size))


def _end(now: Mark, before: Mark) -> End:
    """The end of the way, if change, slip and drift fall in proportion to the size of the change."""
    share = now.size / (before.size - now.size)
    pairs = (now.change, before.change), (now.slip, before.slip), (now.drift, before.drift)
    return End(*(after + share * (after - start) for after, start in pairs))
