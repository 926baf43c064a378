"""Cycle after cycle, with leaps to the limit of their states, until it is clear what a joint settles into."""

from collections import deque
from dataclasses import dataclass, field, replace
from itertools import islice, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.campaign.recorded_steps import Halt
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import cycles_in_words, nodes_in_words
from shakedown.ground.status import Outcome
from shakedown.joint.rigid_slips import can_drift
from shakedown.long_term.passage import Way
from shakedown.long_term.returning.approach import Approach
from shakedown.long_term.returning.extrapolation import Course, course_of
from shakedown.motion.cycle_record import CycleRecord, Interim, State, Stop
from shakedown.motion.integrator import Evolution
from shakedown.motion.kernels.contact_status import OPEN
from shakedown.motion.viscous_jump import Jump

WINDOW = 7  # states that a limit is worked out from, one period apart
FEWEST = 4  # of them
AGREE = 1e-3  # two limits in a row differ by at most this share of the leap
SETTLED = 0.1  # the rate changes by at most this share of 1 − rate while the changes shrink to a third
PAUSE, SLOW = 4, 0.9  # while the rate still changes: states from try to try, and the rate from which
NEAREST = 8  # periods ahead where the rate still changes, and twice that at least
FADED = 0.125  # of a change: while the rate still changes, no farther than to where so little is foreseen
ALIKE = 0.1  # of a change ahead: by how much it may differ from the one that was foreseen
GROWN = 2.0  # and no farther than to where a change has grown so much
MORE_ALIKE = 0.02  # the same, where the rate still changes
CLEAR = 1e3  # a cycle slips, and drifts, this much more than it is uncertain by
CLEAR_ENOUGH = 30.0  # and this much where the cycles allowed are spent, or it is only the accuracy of a cycle
MOST_LEAPS = 12  # states ahead that are looked at, each twice as far as the last
NEAR = 0.1  # of the noise: a state foreseen this near the limit is there
STILL = 1e-3  # of the noise: slip below it that grows is round-off
VARIES_LITTLE = "the varying part of the loads is next to round-off beside the constant part"
WAIT = 3  # cycles after a leap that led nowhere, doubled every time


@dataclass(frozen=True)
class Rules:
    """When a search ends, and what it takes for nothing.

    Attributes
    ----------
    most_cycles, longest_period
        As for :func:`long_term_state`.
    noise
        How far one cycle may miss for errors of integration [length of the softest node].
    goal
        Distance from the limit at which a state is the long-term state [length of the softest node].
    stiffness : (n,)
        Of every node, relative to the softest, ≥ 1: so much smaller a slip counts for as much.
    blurred
        Whether loads change by next to round-off: what seems at rest then may be none.
    """

    most_cycles: int
    longest_period: int
    noise: float
    goal: float
    stiffness: FloatArray
    blurred: bool = False


@dataclass(frozen=True, eq=False)
class Settled:
    """What a search has found.

    Attributes
    ----------
    outcome, reason
        What, and what it rests on.
    period
        In cycles; 0 where undecided.
    state, start
        At the end of the last period, and at its beginning.
    drift : (dn,)
        Growth of the slip per period [length].
    records
        The cycles of the last period.
    cycles, events
        Followed in all.
    contraction
        Factor per cycle by which the distance to the long-term state shrinks; NaN where undecided.
    return_error
        How far the last period has missed its start, drift apart [length].
    error
        Estimated distance of the state from the long-term state [length].
    way
        What it has passed through before it first leapt.
    jumps
        Those of the cycles that it has followed, also after a leap.
    violation
        Of the friction law in the last period, relative; NaN where that was not looked at.
    stop
        Why the motion ended before its time; None where it did not.
    """

    outcome: Outcome
    reason: str
    period: int
    state: State
    drift: FloatArray
    records: tuple[CycleRecord, ...]
    cycles: int
    events: int
    contraction: float
    return_error: float
    error: float
    start: State
    way: Way
    jumps: tuple[Jump, ...]
    violation: float = np.nan
    stop: Stop | None = None

    def undecided(self, reason: str) -> "Settled":
        """The same, of which nothing can be said."""
        nothing = np.full_like(self.drift, np.nan)
        return replace(
            self, outcome=Outcome.UNDECIDED, reason=reason, period=0, drift=nothing, records=(),
            contraction=np.nan, return_error=np.nan, error=np.nan,
        )  # fmt: skip

    @property
    def signature(self) -> int:
        """Identifies the contact states of one period, whichever of its cycles it begins with."""
        return sum(record.signature for record in self.records) % 2**64


@dataclass
class _Memory:
    """The states between cycles since the start or the last leap, and how they close in, by period."""

    rules: Rules
    weights: FloatArray
    rate: float  # per cycle, before the leap
    states: deque[FloatArray] = field(init=False)
    open_sets: deque[bytes] = field(init=False)
    back: list[Approach] = field(init=False)
    drifting: list[Approach] = field(init=False)
    slipping: list[Approach] = field(init=False)

    def __post_init__(self) -> None:
        longest = self.rules.longest_period
        self.states, self.open_sets = (deque(maxlen=(WINDOW + 2) * longest + 1) for _ in range(2))
        self.back, self.drifting, self.slipping = (
            [Approach(p, self.rules.noise, self.rate**p) for p in range(1, longest + 1)] for _ in range(3)
        )
        self.slipped: deque[FloatArray] = deque(maxlen=2 * longest + 1)  # since the start, every node

    def slip(self, slip: FloatArray) -> None:
        """What every node has slipped in one more cycle."""
        self.slipped.append(self.slipped[-1] + slip if self.slipped else slip)
        total = self.slipped
        for slipping in self.slipping[: (len(total) - 1) // 2]:
            p = slipping.period
            change = (total[-1] - total[-1 - p]) - (total[-1 - p] - total[-1 - 2 * p])
            slipping.add(float((np.abs(change) * self.rules.stiffness).max()))

    def add(self, state: State) -> None:
        """The state after one more cycle."""
        self.states.append(state.u)
        self.open_sets.append((state.contact == OPEN).tobytes())
        last = np.array([*islice(reversed(self.states), 2 * len(self.back) + 1)])  # the newest first
        over = last[0] - last[1 : len(self.back) + 1]
        for approach, change in zip(
            self.back, np.abs(over * self.weights).max(axis=1).tolist(), strict=False
        ):
            approach.add(change)
        twice = (len(last) - 1) // 2
        before = last[1 : twice + 1] - last[2 : 2 * twice + 1 : 2]
        drifts = np.abs((over[:twice] - before) * self.weights).max(axis=1).tolist()
        for drifting, change in zip(self.drifting, drifts, strict=False):
            drifting.add(change)

    def size(self, change: FloatArray) -> float:
        """Of a change of the state, a stiff node's counting for more."""
        return float((np.abs(change) * self.weights).max())

    def over(self, period: int) -> FloatArray:
        """The change of the state over the last period."""
        return np.asarray(self.states[-1] - self.states[-1 - period])

    def window(self, period: int, skipped: int = 0) -> FloatArray | None:
        """States one period apart up to so many periods ago, with the same nodes open; None if too few."""
        ends = range(len(self.states) - 1 - skipped * period, -1, -period)
        chosen = [k for k in list(ends)[:WINDOW] if self.open_sets[k] == self.open_sets[-1]]
        return np.array([self.states[k] for k in reversed(chosen)]) if len(chosen) >= FEWEST else None


class ReturnSearch:
    """Search for the long-term state of a motion, from its present state.

    Parameters
    ----------
    motion
        The joint, at the start of a cycle.
    rules
        When to end.
    """

    def __init__(self, motion: Evolution, rules: Rules) -> None:
        self.motion, self.rules, self.layout = motion, rules, motion.problem.layout
        self.records: deque[CycleRecord] = deque(maxlen=FEWEST * rules.longest_period)
        self.cycles = self.events = 0
        self.leapt = 0  # cycles that leaps went over
        self.gathered = 0.0  # errors of integration, which what no cycle changes keeps
        self.rate, self.unsure, self.led_by = np.nan, 0.0, "after leaps along the approach"
        self.weights = np.ones(len(motion.state.u))  # a gap counts as it is
        self.weights[self.layout.slips] = np.repeat(
            rules.stiffness, self.layout.slip_size // len(rules.stiffness)
        )
        self.wait, self.next_leap = WAIT, 0
        self.passed: list[tuple[CycleRecord, State]] = []  # before the first leap
        self.jumps: list[Jump] = []
        self._start_anew()

    def _start_anew(self) -> None:
        self.memory = _Memory(self.rules, self.weights, self.rate if np.isfinite(self.rate) else 0.0)
        self.memory.add(self.motion.state)

    def settle(self, halt: Halt | None = None) -> Settled:
        """Follow cycles until the outcome is clear, the motion stops or the cycles allowed are spent."""
        if halt is not None and halt.found is not None:
            standing, interim = halt.found
            vars(self).update(standing)
            self.motion.go_on(interim)
        while self.cycles < self.rules.most_cycles:
            if not self._cycle():
                stop = self.motion.stop
                return self._undecided(stop.reason if stop else "the motion cannot be followed")
            found = self._at_rest() or self._periodic(self.rules.goal)
            if found is not None:
                return found
            followed = self.cycles
            if self.cycles >= self.next_leap:
                self._leap()
            if halt is not None and self.cycles == followed:  # a state leapt to is followed once before
                halt.note(self._standing)
        found = self._periodic(goal=np.inf)
        return found or self._undecided(f"no periodic state within {cycles_in_words(self.rules.most_cycles)}")

    def _standing(self) -> tuple[dict[str, Any], Interim]:
        """How far the search has got, and the motion."""
        given = ("motion", "rules", "layout")
        return {k: v for k, v in vars(self).items() if k not in given}, self.motion.interim()

    def _cycle(self) -> bool:
        record = self.motion.cycle()
        if record is None:
            return False
        self.cycles, self.events = self.cycles + 1, self.events + record.events
        self.gathered += record.error
        self.records.append(record)
        self.jumps += record.jumps
        if not self.leapt:
            self.passed.append((record, self.motion.state))
        self.memory.slip(record.slip)
        self.memory.add(self.motion.state)
        return True

    def _at_rest(self) -> Settled | None:
        """Nothing slips any more: for one cycle exactly, or for two within the accuracy."""
        last = list(self.records)[-2:]
        slips = [float((record.slip * self.rules.stiffness).max()) for record in last]
        exact = slips[-1] == 0.0 and self.memory.back[0].change == 0.0
        noise = self.rules.noise
        if not exact and (len(last) < 2 or max(slips) > noise or slips[1] > max(slips[0], STILL * noise)):
            return None  # what grows below the noise leads away
        breathing = np.flatnonzero(last[-1].opened & last[-1].closed)
        if breathing.size:
            nodes = nodes_in_words(breathing)
            return self._found(
                Outcome.SEPARATION, f"no frictional slip, but opening and closing every cycle: {nodes}", 1
            )
        if self.rules.blurred and not exact:
            return self._undecided(VARIES_LITTLE)
        return self._found(Outcome.SHAKEDOWN, f"no frictional slip {self._how_clear(exact)}{self._way()}", 1)

    def _to_come(self) -> float:
        """What later cycles may add to a state at rest within the accuracy, as the last two changes fade.

        Twice the sum of a geometric series: changes like 1/k² sum to as much.
        """
        last = [*self.memory.states][-3:]
        changes = [self.memory.size(after - before) for before, after in pairwise(last)]
        if changes[-1] == 0.0:
            return 0.0
        fading, most = 1.0 - changes[-1] / max(changes), self.cycles + self.leapt
        return changes[-1] * (min(most, 2.0 / fading) if fading > 0.0 else most)

    def _how_clear(self, exact: bool) -> str:
        return "in the last cycle" if exact else "beyond the accuracy in the last two cycles"

    def _way(self) -> str:
        """What is known of the way to the last state."""
        return "" if not self.unsure else f", {self.led_by}"

    def _periodic(self, goal: float) -> Settled | None:
        """Cyclic slip or ratchetting of the shortest period that is clear, and known so well."""
        memory = self.memory
        for back, drifting, slipping in zip(memory.back, memory.drifting, memory.slipping, strict=True):
            p = back.period
            if len(self.records) < 2 * p or not back.known or not slipping.known:
                continue
            error, drift_error = (max(approach.left, self.rules.noise) for approach in (back, drifting))
            far = back.change > CLEAR * max(drift_error, self.rules.goal)
            if error > goal and not (drifting.known and drift_error <= goal and far):
                continue
            records = list(self.records)[-p:]
            slip = float((np.sum([record.slip for record in records], axis=0) * self.rules.stiffness).max())
            left = max(back.left, slipping.left)  # one that fades away is no cycle
            sure = goal == np.inf or (back.ratios and slipping.ratios and CLEAR * left < slip)
            clear = CLEAR_ENOUGH if sure else CLEAR
            steady = clear * max(error, slipping.left) < slip
            shorter = any(other.change <= clear * error for other in memory.back[: p - 1])
            if shorter:
                continue
            if error <= goal and steady:
                self._note(back)
                return self._found(Outcome.CYCLIC_SLIP, f"the same slip every {cycles_in_words(p)}", p)
            if drifting.known and drift_error <= goal and far and can_drift(self.motion.problem):
                self._note(drifting)
                return self._found(Outcome.RATCHETTING, f"the same drift every {cycles_in_words(p)}", p)
        return None

    def _note(self, approach: Approach) -> None:
        """Keep the rate of an approach; after a leap, which leaves no approach to see, the one before it."""
        if approach.rate > 0.0 or not np.isfinite(self.rate):
            self.rate = approach.rate ** (1 / approach.period)

    def _leap(self) -> None:
        """Go on from where the last states lead, as far as cycles on the way there do what was foreseen."""
        waits = len(self.memory.states) % PAUSE > 0
        for approach in self.memory.back:
            p = approach.period
            if (waits or approach.rate < SLOW) and approach.bend > SETTLED:
                continue
            if not (self._worthwhile(approach) or approach.departs):
                continue
            window, before = self.memory.window(p), self.memory.window(p, 1)
            if window is None or before is None:
                continue
            leap = self._to_the_limit if approach.bend <= SETTLED else self._on_the_way
            if leap(approach, course_of(window), course_of(before)):
                return

    def _to_the_limit(self, approach: Approach, course: Course, earlier: Course) -> bool:
        """Leap towards the limit where the last two courses agree on it."""
        limit = course.limit
        way = self.memory.size(limit - course.last)
        differ = self.memory.size(limit - earlier.limit)
        if not (np.isfinite(way) and way > self.rules.noise and differ <= AGREE * way):
            return False
        unsure, counts = differ + approach.bend * way, [2**k for k in range(1, MOST_LEAPS + 1)]
        if self._follow(course, approach, counts, ALIKE):
            self.unsure += unsure
            self.led_by = "at the limit of a geometric approach"
        return True

    def _on_the_way(self, approach: Approach, course: Course, earlier: Course) -> bool:
        """Leap as far as the last two courses agree, where the rate still changes: the limit is not known."""
        differs = dict[int, float]()
        for count in (NEAREST * 2**k for k in range(MOST_LEAPS)):
            (state, change), (other, _) = course.ahead(count), earlier.ahead(count + 1)
            way, differ = self.memory.size(state - course.last), self.memory.size(state - other)
            left = self.memory.size(change)
            if not (differ <= AGREE * way and FADED * approach.change <= left <= GROWN * approach.change):
                break
            differs[count] = differ
        if len(differs) < 2:
            return False
        reached = self._follow(course, approach, [*differs], MORE_ALIKE)
        self.unsure += differs.get(reached, 0.0)
        return True

    def _worthwhile(self, approach: Approach) -> bool:
        """Whether leaps, each twice as far as the last, are less work than period after period."""
        if not 0.0 < approach.rate < 1.0 or approach.left <= self.rules.goal or approach.bend == np.inf:
            return False
        periods = np.log(self.rules.goal / approach.left) / np.log(approach.rate)
        return bool(periods > FEWEST + np.log2(periods + 1))

    def _follow(self, course: Course, approach: Approach, counts: list[int], alike: float) -> int:
        """Look at one period from the states so many periods ahead: the search goes on after the last.

        How far ahead that is; 0 where the first has not done what was foreseen.
        """
        here, memory, records, passed = self.motion.state, self.memory, list(self.records), len(self.passed)
        p, rate, reached, last = approach.period, approach.rate, None, 0
        for count in counts:
            start, change = course.ahead(count)
            jumps, size, off = len(self.jumps), memory.size(change), self._off(start, change, p, here)
            if not off <= alike * size + self.rules.noise:
                del self.jumps[jumps:]
                break
            reached, last = self.motion.state, count
            if rate < 1.0 and size * rate / (1.0 - rate) <= NEAR * self.rules.noise:
                break
        del self.passed[passed:]
        if reached is None:
            self.motion.state, self.memory = here, memory
            self.records = deque(records, maxlen=self.records.maxlen)
            self.wait *= 2
            self.next_leap = self.cycles + self.wait
            return 0
        self.motion.state = reached
        self.leapt += last * p
        self.rate, self.wait = rate ** (1 / p) if rate < 1.0 else self.rate, WAIT
        self._start_anew()
        self.next_leap = self.cycles + FEWEST * p
        return last

    def _off(self, start: FloatArray, change: FloatArray, p: int, like: State) -> float:
        """By how much one period from a state, with the same nodes open as in another, misses a change."""
        u = start.copy()
        u[self.layout.gaps][like.contact != OPEN] = 0.0
        self.motion.state = State(u, like.contact)
        # A jump, which may take minutes to follow, is not foreseen where the cycles before had none.
        self.motion.may_jump = any(record.jumps for record in self.records)
        followed = all(self._cycle() for _ in range(p))
        self.motion.may_jump = True
        if not followed:
            return np.inf
        return self.memory.size(self.motion.state.u - u - change)

    def _found(self, outcome: Outcome, reason: str, period: int) -> Settled:
        """The answer; of a cycle the period is followed once more from where the search has ended."""
        left, back, start = 0.0, self.memory.back[period - 1], self.motion.state
        if outcome == Outcome.SHAKEDOWN:
            left = self._to_come()
        if outcome in (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING):
            left = back.left if outcome == Outcome.CYCLIC_SLIP else 0.0
            if not all(self._cycle() for _ in range(period)):
                stop = self.motion.stop
                return self._undecided(f"{stop.reason if stop else 'no more cycles'}, after {reason}")
        moved = self.memory.over(period)
        drift = moved if outcome == Outcome.RATCHETTING else np.zeros_like(moved)
        return Settled(
            outcome=outcome,
            reason=reason,
            period=period,
            state=self.motion.state,
            drift=drift[self.layout.slips],
            records=tuple(list(self.records)[-period:]),
            cycles=self.cycles,
            events=self.events,
            contraction=self.rate if np.isfinite(self.rate) else 0.0 if back.rate == 1.0 else back.rate,
            return_error=float(np.abs(moved - drift).max()),
            error=max(left, self.rules.noise) + self.gathered + self.unsure,
            start=start,
            way=self._passed_through,
            jumps=tuple(self.jumps),
        )

    @property
    def _passed_through(self) -> Way:
        """What was passed through before the first leap."""
        records, states = tuple(record for record, _ in self.passed), [state for _, state in self.passed]
        opened = np.array([state.contact == OPEN for state in states])
        return Way(records, opened, states[-1] if states else self.motion.state)

    def _undecided(self, reason: str) -> Settled:
        state = self.motion.state
        return Settled(
            outcome=Outcome.UNDECIDED,
            reason=reason,
            period=0,
            state=state,
            drift=np.full(self.layout.slip_size, np.nan),
            records=(),
            cycles=self.cycles,
            events=self.events,
            contraction=np.nan,
            return_error=np.nan,
            error=np.nan,
            start=state,
            way=self._passed_through,
            jumps=tuple(self.jumps),
            stop=self.motion.stop,
        )


def opened_and_closed(records: tuple[CycleRecord, ...]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether each node was open, and whether it was closed, for some time of these cycles."""
    return (
        np.any([record.opened for record in records], axis=0),
        np.any([record.closed for record in records], axis=0),
    )
