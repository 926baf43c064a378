"""How the states between cycles close in on a period."""

from collections import deque
from dataclasses import dataclass, field
from math import inf, nan

REMEMBERED = 24  # changes, for their ratios
STEADY = 12  # ratios in a row …
ALIKE = 0.1  # … that differ by no more than this share of 1 − rate
BEND = 5  # ratios that tell whether the rate is settled


@dataclass
class Approach:
    """The changes of the state over one period, cycle after cycle, and the rate at which they shrink.

    Attributes
    ----------
    period
        In cycles.
    noise
        Changes up to this size are errors of the integration [length].
    before
        Rate until one is seen below the noise: that before a leap.
    """

    period: int
    noise: float
    before: float = 0.0
    changes: deque[float] = field(default_factory=lambda: deque(maxlen=REMEMBERED))
    _shrinking: deque[float] = field(init=False)  # change by change of those one period later; NaN: unknown
    _all_shrinking: deque[float] = field(init=False)  # the same, below the noise too
    _ratios: list[float] | None = None
    _rate: float | None = None

    def __post_init__(self) -> None:
        self._shrinking = deque(maxlen=max(REMEMBERED - self.period, 0))
        self._all_shrinking = deque(maxlen=STEADY)

    def add(self, change: float) -> None:
        """The largest change of an entry of the state over the last period [length]."""
        self._ratios = self._rate = None
        if len(self.changes) >= self.period:
            before = self.changes[-self.period]
            self._shrinking.append(max(change, self.noise) / before if before > 8 * self.noise else nan)
            self._all_shrinking.append(change / before if before > 0.0 else nan)
        self.changes.append(change)

    @property
    def change(self) -> float:
        """The last change; inf where there is none yet."""
        return self.changes[-1] if self.changes else inf

    @property
    def ratios(self) -> list[float]:
        """Factors from the changes above the noise to those one period later.

        Below it only where so many in a row are alike that nothing is to be seen of any noise.
        """
        if self._ratios is None:
            self._ratios = [ratio for ratio in self._shrinking if ratio == ratio] or self._steady
        return self._ratios

    @property
    def _steady(self) -> list[float]:
        """Ratios of changes below the noise, where they are alike; else none."""
        last = list(self._all_shrinking)
        if len(last) < STEADY or not max(last) - min(last) <= ALIKE * (1.0 - max(last)):
            return []
        return last

    @property
    def rate(self) -> float:
        """Factor per period by which the change shrinks: the largest of the last three, from above the noise.

        1 where nothing is known: a sequence that does not shrink has no limit. 0 where noise is all there is.
        """
        if self._rate is None:
            seen = min(max(self.ratios[-3:]), 1.0) if self.ratios else 0.0
            waits = not self.ratios and len(self._all_shrinking) < STEADY
            self._rate = self.before if waits and self.known else seen if self.known or self.ratios else 1.0
        return self._rate

    @property
    def bend(self) -> float:
        """By how much the rate changes while the changes shrink to a third, relative to 1 − rate.

        0 of a geometric approach; of one like 1/k^a it stays at 1/a. inf where nothing is known.
        """
        ratios = self.ratios[-BEND:]
        if len(ratios) < BEND or not self.rate < 1.0:
            return inf
        slope = abs(ratios[-1] - ratios[0]) / (BEND - 1)
        return float(slope * self.period / (1.0 - self.rate) ** 2)

    @property
    def departs(self) -> bool:
        """Whether the changes grow, as where a state is left that was nearly the limit."""
        return self.rate == 1.0 and len(self.ratios) >= BEND

    @property
    def known(self) -> bool:
        """Whether two changes a period apart have been compared at least twice."""
        return len(self.changes) > self.period + 1

    @property
    def left(self) -> float:
        """How far the limit is from the last state, if the changes go on shrinking so [length]."""
        return self.change * self.rate / (1.0 - self.rate) if self.rate < 1.0 else inf
