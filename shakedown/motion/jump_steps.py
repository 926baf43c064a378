"""How long the implicit steps of a jump are: only its path counts, not how fast it is passed.

A jump leaves a state that is all but in equilibrium: slowly at first, then at speeds that grow like a power
of the way, or exponentially. An implicit step is accepted where it is straight enough, and aims at the
farthest of a fixed sequence of distances that the speeds so far let it reach. So it hardly matters where a
motion began, whether it was put out of balance by 1e-9 or by 2e-9: its steps soon end at the same places,
and a jump that comes again in every cycle repeats.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from math import floor, inf, log, sqrt
from typing import NamedTuple

from shakedown.ground.round_off import SETTLED

ACCURACY = 0.01  # accepted departure of a step from a straight path, relative to the motion so far
CHANGING = 0.4  # length of a step in which nodes change their contact states, relative to the motion so far
RUNG = 1.5  # ratio of the distances aimed at; speeds like the third power of the way let a step reach that
FASTER = 4.0  # how much faster the motion is expected to be at the end of a step, at most
LONGER = 5.0  # how much longer a step lasts than the one before, at most
AIMED = 0.8  # of the length at which a step would be just straight enough


class Stride(NamedTuple):
    """What a step has done.

    Attributes
    ----------
    way, speed
        Its length [length], and that per duration.
    motion
        How far it ends from the beginning of the motion [length].
    turn
        By how much its direction differs from that of the step before.
    changes
        Whether a node has changed its contact state.
    """

    way: float
    speed: float
    motion: float
    turn: float
    changes: bool

    @property
    def bend(self) -> float:
        """Departure from a straight path, relative to the accepted one."""
        return self.turn * self.way / (ACCURACY * self.motion)


class Speeds(NamedTuple):
    """A parabola of the speed over the way: its value here, and slopes by differences over the last step."""

    now: float
    slope: float = 0.0
    curve: float = 0.0
    length: float = 0.0

    def after(self, way: float) -> float:
        """The speed after a further way."""
        return self.now + way * (self.slope + self.curve * (way + self.length))


@dataclass
class StepLengths:
    """The duration of the next step of a motion.

    Attributes
    ----------
    length
        Scale of the scene [length].
    duration
        Of the next step.
    size
        Of displacements [length].
    idle
        How many steps have moved no more than their round-off.
    passed
        Ways at the ends of the last steps, three at most, with the speeds there.
    """

    length: float
    duration: float
    size: float
    idle: int = 0
    passed: list[tuple[float, float]] = field(default_factory=list)

    def shorten(self, factor: float = 0.5) -> None:
        """Try the step again, shorter."""
        self.duration *= min(max(0.1, factor), 0.5)

    def accepts(self, stride: Stride) -> bool:
        """Whether a step is straight enough; sets the duration of the next, or of a shorter one instead."""
        if self.passed and stride.bend > 1.0:
            self.shorten(AIMED / sqrt(stride.bend))
            return False
        if self.passed and stride.changes and stride.way > CHANGING * stride.motion:
            self.shorten()
            return False
        before = self.passed[-1][0] if self.passed else 0.0
        self.passed = [*self.passed[-2:], (before + stride.way, stride.speed)]
        self.duration = self._next(stride)
        return True

    def _next(self, last: Stride) -> float:
        """The duration in which the next step will end where it is to end; longer where none is seen."""
        if last.way <= SETTLED * self.size:  # speeds are round-off
            self.idle += 1
            return LONGER * self.duration
        straight = AIMED * last.way / sqrt(last.bend) if last.bend > 0.0 else inf
        longest, speeds, way = LONGER * self.duration, self._speeds_ahead(), 0.0
        rung = floor(log(last.motion / self.length) / log(RUNG) + 0.5)
        while True:
            rung += 1
            further = self.length * RUNG**rung - last.motion
            speed = speeds.after(further)
            reached = 0.0 < speed <= FASTER * last.speed and further <= longest * speed
            if way and not (reached and further <= straight):
                break
            way = further
            if not reached:
                break
        way = min(way, straight)
        speed = speeds.after(way)
        return min(way / speed, longest) if speed > 0.0 else longest

    def _speeds_ahead(self) -> "Speeds":
        """What the last speeds let expect: the parabola through them where they grow faster and faster."""
        slopes = list[float]()
        for (before, slow), (at, fast) in pairwise(self.passed):
            if at == before:
                return Speeds(self.passed[-1][1])
            slopes.append((fast - slow) / (at - before))
        way, speed = self.passed[-1]
        if not slopes:
            return Speeds(speed)
        curve = max(slopes[-1] - slopes[0], 0.0) / (way - self.passed[0][0]) if slopes[-1] > 0.0 else 0.0
        return Speeds(speed, slopes[-1], curve, way - self.passed[-2][0])
