"""What a search for the long-term state goes by, and the cycles that it has followed."""

from collections import deque
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from shakedown.ground.constants import FloatArray
from shakedown.ground.status import OPEN
from shakedown.long_term.space.decay import Period
from shakedown.long_term.space.measure import Measure, measure_of
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import CycleRecord, State
from shakedown.motion.viscous_jump import Jump

WINDOW = 7  # largest number of states one period apart that a leap starts from


@dataclass(frozen=True)
class SearchRules:
    """When a search ends, and what it neglects.

    Attributes
    ----------
    most_cycles, longest_period
        As for :func:`long_term_state`.
    noise
        How far one cycle may miss for errors of integration [length of the softest node].
    stiffness : (n,)
        Of every node, relative to the softest, ≥ 1: so much smaller a slip counts for as much.
    blurred
        Whether loads change by next to round-off: what seems at rest then may be none.
    """

    most_cycles: int
    longest_period: int
    noise: float
    stiffness: FloatArray
    blurred: bool = False


class Position(NamedTuple):
    """Where a leap that is refused goes back to: the state, those before it, and how much was recorded."""

    state: State
    states: deque[State]
    records: list[CycleRecord]
    passed: int
    jumps: int


class FollowedCycles:
    """Cycles followed one by one, which leaps may interrupt.

    Parameters
    ----------
    motion
        The joint, at the start of a cycle.
    longest_period
        Of a long-term state, in cycles.

    Attributes
    ----------
    records, states
        Of the last cycles; the states between them since the last leap.
    passed
        The cycles before the first leap, with the states at their ends.
    jumps
        Those of the cycles followed, also after a leap.
    count, events, probes
        Cycles and events followed in all, and how many of the cycles only showed slopes.
    leaps
        How many were taken.
    error
        Sum of the errors of integration, which what no cycle changes keeps [length].
    """

    def __init__(self, motion: Evolution, longest_period: int) -> None:
        self.motion, self.layout = motion, motion.problem.layout
        self.measure: Measure = measure_of(motion.problem)
        self.start = motion.state.u
        self.records: deque[CycleRecord] = deque(maxlen=2 * longest_period + 1)
        self.states: deque[State] = deque([motion.state], maxlen=WINDOW * longest_period + 1)
        self.passed: list[tuple[CycleRecord, State]] = []
        self.jumps: list[Jump] = []
        self.count = self.events = self.probes = self.leaps = 0
        self.error = 0.0

    def follow(self, cycles: int = 1) -> bool:
        """Follow some cycles; False where the motion stops."""
        for _ in range(cycles):
            record = self.motion.cycle()
            if record is None:
                return False
            self.count, self.events = self.count + 1, self.events + record.events
            self.error += record.error
            self.records.append(record)
            self.jumps += record.jumps
            self.states.append(self.motion.state)
            if not self.leaps:
                self.passed.append((record, self.states[-1]))
        return True

    def go_to(self, state: State) -> None:
        """Go on from another state."""
        self.motion.state, self.states = state, deque([state], maxlen=self.states.maxlen)

    def position(self) -> Position:
        """Where the motion is."""
        return Position(self.motion.state, self.states, list(self.records), len(self.passed), len(self.jumps))

    def go_back(self, position: Position) -> None:
        """Go back there."""
        del self.jumps[position.jumps :]
        self.motion.state, self.states = position.state, position.states
        self.records = deque(position.records, maxlen=self.records.maxlen)

    def change(self, period: int) -> FloatArray:
        """The change of the state over the last period of so many cycles, (N,) [length]."""
        return np.asarray(self.states[-1].u - self.states[-1 - period].u)

    def slip(self, first: int, last: int) -> FloatArray:
        """The slip of the nodes in cycles counted back from the last, (n,) [length]."""
        return np.sum([self.records[-k].slip for k in range(first, last + 1)], axis=0)

    def last(self, period: int) -> Period:
        """What the last period did."""
        change, state = self.change(period), self.states[-1].u
        size, drift = self.measure.size(change), self.measure.rigid.T @ change
        return Period(state, change, size, self.slip(1, period), drift)

    def window(self, period: int) -> FloatArray:
        """The last states one period apart with the same nodes open, (k, N)."""
        states = [self.states[k] for k in range(-1, -len(self.states) - 1, -period)][:WINDOW]
        opened = states[0].contact == OPEN
        return np.array([state.u for state in reversed(states) if ((state.contact == OPEN) == opened).all()])

    def to_come(self, period: int, rate: float | None, drifts: bool = False) -> tuple[float, float]:
        """What later periods may add to a state, as changes fade, and by which factor per cycle they do.

        Twice the sum of a geometric series, node by node: changes like 1/k² sum to as much. Rigid drift does
        not count.

        Parameters
        ----------
        period
            In cycles.
        rate
            Factor per cycle, where leaps have shown it.
        drifts
            Whether the joint ratchets.
        """
        states = [self.states[k].u for k in range(-1, -len(self.states) - 1, -period)][:3]
        if drifts:
            states = [self.measure.without_rigid(u) for u in states]
        changes = [np.abs(later - before) for later, before in pairwise(states)]
        last, before = changes[0], changes[-1]
        falls = np.divide(last, before, out=np.ones_like(last), where=before > last)
        rates = np.where(last > 0.0, falls, 0.0) if rate is None else np.full_like(last, rate**period)
        most = np.divide(2.0, 1.0 - rates, out=np.full_like(last, float(self.count)), where=rates < 1.0)
        return float((last * most).max()), float(rates[np.argmax(last)]) ** (1.0 / period)


def signatures(records: list[CycleRecord]) -> list[int]:
    """What identifies the contact states of cycles."""
    return [record.signature for record in records]
