"""How the states between cycles close in on a period."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

REMEMBERED = 24  # changes, for their ratios
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
    """

    period: int
    noise: float
    changes: deque[float] = field(default_factory=lambda: deque(maxlen=REMEMBERED))

    def add(self, change: float) -> None:
        """The largest change of an entry of the state over the last period [length]."""
        self.changes.append(change)

    @property
    def change(self) -> float:
        """The last change; inf where there is none yet."""
        return self.changes[-1] if self.changes else np.inf

    @property
    def ratios(self) -> list[float]:
        """Factors from the changes above the noise to those one period later."""
        pairs = zip(self.changes, list(self.changes)[self.period :], strict=False)
        return [max(after, self.noise) / before for before, after in pairs if before > 8 * self.noise]

    @property
    def rate(self) -> float:
        """Factor per period by which the change shrinks: the largest of the last three, from above the noise.

        1 where nothing is known: a sequence that does not shrink has no limit.
        """
        if self.ratios:
            return min(max(self.ratios[-3:]), 1.0)
        return 0.0 if self.known else 1.0

    @property
    def bend(self) -> float:
        """By how much the rate changes while the changes shrink to a third, relative to 1 − rate.

        0 of a geometric approach; of one like 1/k^a it stays at 1/a. inf where nothing is known.
        """
        ratios = self.ratios[-BEND:]
        if len(ratios) < BEND or not self.rate < 1.0:
            return np.inf
        slope = abs(ratios[-1] - ratios[0]) / (BEND - 1)
        return float(slope * self.period / (1.0 - self.rate) ** 2)

    @property
    def known(self) -> bool:
        """Whether two changes a period apart have been compared at least twice."""
        return len(self.changes) > self.period + 1

    @property
    def left(self) -> float:
        """How far the limit is from the last state, if the changes go on shrinking so [length]."""
        return self.change * self.rate / (1.0 - self.rate) if self.rate < 1.0 else np.inf
