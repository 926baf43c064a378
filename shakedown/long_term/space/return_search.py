"""Cycles, with leaps along slow approaches, until the long-term state of a joint is clear."""

from collections import deque
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import (
    FOUR_DIGITS,
    MISJUDGED,
    MUCH,
    NEGLIGIBLE,
    PER_CENT,
    SEVEN_DIGITS,
    SIX_DIGITS,
    THREE_DIGITS,
)
from shakedown.ground.shown_values import cycles_in_words, nodes_in_words
from shakedown.ground.status import OPEN, Outcome
from shakedown.joint.rigid_slips import can_drift, free_stiffness
from shakedown.long_term.passage import FirstCycles
from shakedown.long_term.space.drift import Drift, holds
from shakedown.long_term.space.fading import Fading, Mark
from shakedown.long_term.space.leap_methods import (
    LONGEST_WAIT,
    STATE_ROUND_OFF,
    Ahead,
    Crawl,
    Leap,
    measure_of,
)
from shakedown.long_term.space.local_map import Moving, Period, PeriodStep
from shakedown.long_term.space.mean_leaps import OnAverage
from shakedown.long_term.space.settled import VARIES_LITTLE, ReturnRules, Settled, opened_and_closed
from shakedown.long_term.space.slope_leaps import Along, Landing
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import CycleRecord, State
from shakedown.motion.viscous_jump import Jump

MORE = 3  # budget of extra cycles for slopes, as a multiple of the cycles allowed
STUCK = 200  # cycles after which slopes of a period are measured, one cycle each
WINDOW = 7  # largest number of states one period apart that a leap starts from
# Change per period, relative to its slip, below which a state counts as periodic: the way to rest is at
# least half that slip, and would take 1 / (2 FOR_EVER) periods.
FOR_EVER = 10 * NEGLIGIBLE
APART = 4.0  # times the fading part; twice that separates states on both sides of their limit
NEAR = 1e-5  # what may be left of the way to a cycle along a line, of that so far


class _Before(NamedTuple):
    """Where a leap that is refused goes back to: the state, those before it, and how much was recorded."""

    state: State
    states: deque[State]
    records: list[CycleRecord]
    passed: int
    jumps: int


class ReturnSearch:
    """Search for the long-term state of a motion, from its present state.

    Parameters
    ----------
    motion
        The joint, at the start of a cycle.
    rules
        When to end.
    care
        What leaps may be unsure by, as a share of what they may be otherwise.
    """

    def __init__(self, motion: Evolution, rules: ReturnRules, care: float = 1.0) -> None:
        self.motion, self.rules, self.layout = motion, rules, motion.problem.layout
        self.measure = measure_of(motion.problem)
        self.none = rules.noise / rules.stiffness  # slip (n,) that counts as none [length]
        longest = rules.longest_period
        self.records: deque[CycleRecord] = deque(maxlen=2 * longest + 1)
        self.states: deque[State] = deque([motion.state], maxlen=WINDOW * longest + 1)  # since the last leap
        self.repeated = [0] * longest  # by period: cycles in a row that end where the one a period before did
        self.cycles = self.events = self.leaps = self.looked = 0
        self.gathered = 0.0  # errors of integration, which what no cycle changes keeps
        self.rate, self.unsure = np.nan, 0.0  # per cycle; uncertainty left by leaps …
        self.apart = 0.0  # … the same without rigid slip, of what drifts on …
        self.adrift = 0.0  # … and in rigid slip, as cycles are the same wherever the joint stands
        self.begun = motion.state.u
        self.rest_foretold = self.cycle_foretold = 0  # cycle from which on it is foreseen
        self.period, self.crawl, self.ahead, self.along = 1, Crawl(care), Ahead(care), Along(care)
        self.average = OnAverage(care)
        self.fadings = [Fading() for _ in range(longest)]  # by period
        self.mean: Mark | None = None  # what the last leap has come to, if on average
        self.passed: list[tuple[CycleRecord, State]] = []  # before the first leap
        self.jumps: list[Jump] = []

    def settle(self) -> Settled:
        """Follow cycles until the outcome is clear, the motion stops or the cycles allowed are spent."""
        while self.cycles < self.rules.most_cycles + min(self.looked, MORE * self.rules.most_cycles):
            if not self._cycle():
                stop = self.motion.stop
                return self._undecided(stop.reason if stop else "the motion cannot be followed")
            found = self._verdict_at_rest() or self._verdict_for_ever()
            if found is not None:
                return found
            self._leap()
        spent = f"no periodic state within {self.rules.most_cycles} cycles"
        return self._verdict_in_round_off() or self._undecided(spent)

    def _cycle(self) -> bool:
        record = self.motion.cycle()
        if record is None:
            return False
        self.cycles, self.events = self.cycles + 1, self.events + record.events
        self.gathered += record.error
        self.records.append(record)
        self.jumps += record.jumps
        self.states.append(self.motion.state)
        if not self.leaps:
            self.passed.append((record, self.motion.state))
        return True

    def _change(self, period: int) -> FloatArray:
        """The change of the state over the last period."""
        return np.asarray(self.states[-1].u - self.states[-1 - period].u)

    def _slip(self, first: int, last: int) -> FloatArray:
        """The slip of the nodes in cycles, counted back from the last."""
        return np.sum([self.records[-k].slip for k in range(first, last + 1)], axis=0)

    def _faded(self, period: int) -> tuple[Fading, Mark]:
        """What has faded on the way, and what the last period has done, or periods do on average."""
        if self.mean is not None and period == 1:
            return self.fadings[0], self.mean
        return self.fadings[period - 1], self._mark(period)

    def _mark(self, period: int) -> Mark:
        """What the last period has done."""
        change, state = self._change(period), self.states[-1].u
        size = self.measure.size(change)
        return Mark(state, change, size, self._slip(1, period), self.measure.rigid.T @ change)

    def _verdict_at_rest(self) -> Settled | None:
        """Whether nothing slips any more: exactly for one cycle, or for two within the accuracy."""
        last = list(self.records)[-2:]
        most = [float((record.slip * self.rules.stiffness).max()) for record in last]
        exact = most[-1] == 0.0 and not self._change(1).any()
        noise = self.rules.noise
        if not exact and (len(last) < 2 or max(most) > noise or self._grows()):
            return None
        if self.leaps and not exact and most[1] > THREE_DIGITS * noise and self._to_come(1)[0] > noise:
            return None
        breathing = np.flatnonzero(last[-1].opened & last[-1].closed)
        if breathing.size:
            nodes = nodes_in_words(breathing)
            return self._found(
                Outcome.SEPARATION, f"no frictional slip, but opening and closing every cycle: {nodes}", 1
            )
        if self.rules.blurred and not exact:
            return self._undecided(VARIES_LITTLE)
        how = "in the last cycle" if exact else "beyond the accuracy in the last two cycles"
        return self._found(Outcome.SHAKEDOWN, f"no frictional slip {how}{self._way()}", 1)

    def _grows(self) -> bool:
        """Whether a node has slipped more than in the cycle before, which leads away from rest.

        Node by node, as another's slip may hide it. Slip far below the noise that grows is round-off.
        """
        before, now = (self.records[-k].slip for k in (2, 1))
        return bool((now > np.maximum(before, THREE_DIGITS * self.none)).any())

    def _way(self) -> str:
        """The known cycles that led to the last state."""
        return "; approach extrapolated" if self.leaps else ""

    def _verdict_for_ever(self) -> Settled | None:
        """Cyclic slip or ratchetting with the shortest period over which states repeat, up to rigid slips."""
        most = min(self.rules.longest_period, len(self.states) - 1)
        u = np.array([self.states[-1 - q].u for q in range(most + 1)])
        changes = np.linalg.norm(self.measure.seen(u[0] - u[1:]), axis=1)
        self._find_rhythm(u)
        small = FOR_EVER * np.linalg.norm(self._slip(1, most) * self.measure.slips)
        round_off, least = STATE_ROUND_OFF * self.measure.at_most(u[0]), changes.min()
        if least <= small + round_off:  # a product with the whole stiffness, mostly not needed
            round_off = STATE_ROUND_OFF * self.measure.terms(u[0])
        if least > small + round_off:
            self.repeated = [0] * self.rules.longest_period
            return self._verdict_of_approach()
        for p in range(1, most + 1):
            slip = self._slip(1, p)
            size = float(np.linalg.norm(slip * self.measure.slips))
            slips = float((slip * self.rules.stiffness).max()) > self.rules.noise
            if not slips or changes[p - 1] > max(FOR_EVER * size, round_off):
                self.repeated[p - 1] = 0
                continue
            self.repeated[p - 1] += 1
            if self.repeated[p - 1] > p and changes[: p - 1].min(initial=np.inf) > self._left(p):
                found = self._verdict_of_period(p, slip)
                if found is not None:
                    return found
        return self._verdict_of_approach()

    def _verdict_of_approach(self) -> Settled | None:
        """The outcome where the change falls along a line to a cycle that is next to the state."""
        p = 1 if self.mean is not None else self.period
        if not self.leaps or len(self.states) <= p:
            return None
        fading, now = self._faded(p)
        left = self._share_left(fading.to_come(now, self.measure))
        if fading.slip_ends(now, self.none) and not self.records[-1].opened.any():
            if left <= FOUR_DIGITS and not self.rest_foretold:
                self.rest_foretold = self.cycles
            if left <= SEVEN_DIGITS or self._is_unseen(now):
                return self._slip_fades()
        slip = float(np.linalg.norm(now.slip * self.measure.slips))
        if now.size > SIX_DIGITS * slip:
            return None
        if left <= NEAR and fading.slip_lasts(now):
            return self._verdict_of_period(p, now.slip)
        if not fading.comes_to_a_cycle(now, self.measure, FOR_EVER * slip):
            self.cycle_foretold = 0
        elif not self.cycle_foretold:
            self.cycle_foretold = self.cycles
        elif self.cycle_foretold <= self.cycles - STUCK:
            return self._verdict_of_period(p, now.slip, long_foreseen=True)
        return None

    def _verdict_in_round_off(self) -> Settled | None:
        """Rest, where the slip falls to none with changes that are round-off of the state."""
        if not self.leaps or len(self.states) < 2 or self.records[-1].opened.any():
            return None
        fading, now = self._faded(1)
        lost = STATE_ROUND_OFF * self.measure.terms(now.state)
        near = now.size <= lost and self._share_left(fading.to_come(now, self.measure, lost)) <= PER_CENT
        return self._slip_fades() if near and fading.slip_ends(now, self.none, 0.0) else None

    def _slip_fades(self) -> Settled:
        """Rest, as it is foreseen."""
        return self._found(Outcome.SHAKEDOWN, f"slip fades away with the changes{self._way()}", 1)

    def _share_left(self, ahead: FloatArray | None) -> float:
        """The largest share that is left of the way of a node, but for ways that count as none; ∞ if untold.

        Relative to its own way since the search began, as another one may have gone far and may hide it.
        """
        if ahead is None:
            return np.inf
        left, come = self.layout.ways(ahead), self.layout.ways(self.states[-1].u - self.begun)
        counts = left > self.none
        return float((left[counts] / np.maximum(come, self.none)[counts]).max(initial=0.0))

    def _is_unseen(self, now: Mark) -> bool:
        """Whether rest has long been foreseen, and no node changes by more than the accuracy of motion."""
        long = 0 < self.rest_foretold <= self.cycles - STUCK
        return long and bool((self.layout.ways(now.change) <= self.none).all())

    def _awaits(self) -> bool:
        """Whether states have begun to repeat that no verdict has been asked of."""
        return any(0 < times <= p for p, times in enumerate(self.repeated, start=1))

    def _left(self, p: int) -> float:
        """How far the states of a period may still move together, as changes fade [energy norm]."""
        last, before = (self.measure.size(self.states[-1 - k].u - self.states[-1 - k - p].u) for k in (0, p))
        periods = before / (before - last) if before > last else np.inf
        return APART * last * min(periods, self.rules.most_cycles)

    def _verdict_of_period(self, p: int, slip: FloatArray, long_foreseen: bool = False) -> Settled | None:
        """The outcome where the same slip occurs in every period of p cycles, if that is clear.

        Long foreseen is a cycle whose end the leaps do not come nearer to.
        """
        most, every = float(slip.max()), cycles_in_words(p)
        clear = THREE_DIGITS * float((slip * self.rules.stiffness).max())
        error = max(record.error for record in list(self.records)[-p:])
        fading, now = self._faded(p)
        differs = np.abs(self._slip(p + 1, 2 * p) - slip).max() > THREE_DIGITS * most
        if error > clear or differs or fading.slip_ends(now, self.none):
            return None
        lasts = f"slip per {every} constant{self._way()}"
        floats = can_drift(self.motion.problem)
        drift = self._drift(p, fading, now, error) if floats else None
        walks = drift is not None and drift.of_a_node()
        if np.abs(now.change).max() <= SIX_DIGITS * most and not walks:
            return self._found(Outcome.CYCLIC_SLIP, lasts, p)
        ends = long_foreseen and fading.drift_ends(now)
        held = not floats or self._is_held(p, slip) or ends
        if held and (long_foreseen or fading.slip_lasts(now)):
            return self._found(Outcome.CYCLIC_SLIP, lasts, p)
        if walks or (drift is not None and (drift.of_all() or fading.drift_lasts(now))):
            return self._found(Outcome.RATCHETTING, f"drift per {every} constant{self._way()}", p)
        return None

    def _drift(self, p: int, fading: Fading, now: Mark, error: float) -> Drift:
        """The drift of the last period of p cycles, each known to an error [length]."""
        last, before = self._change(p), self.states[-1 - p].u - self.states[-1 - 2 * p].u
        known = p * error + STATE_ROUND_OFF * float(np.abs(self.states[-1].u).max())
        lasts = fading.drift_lasts(now) if now is self.mean else None
        stiffness, left = free_stiffness(self.motion.problem), fading.drift_left(now)
        return Drift(self.layout, stiffness, self.measure, self.none, now, left, last, before, known, lasts)

    def _is_held(self, p: int, slip: FloatArray) -> bool:
        """Whether nodes that stick, or all but stick, leave no room for a rigid slip, while none opens."""
        opens = bool(opened_and_closed(tuple(self.records)[-p:])[0].any())
        if opens or not self.measure.rigid.shape[1]:  # a body that moves only where nodes open
            return not opens
        return holds(self.layout, self.measure.rigid, slip, self.none)

    def _find_rhythm(self, u: FloatArray) -> None:
        """The period after which changes recur, where those of consecutive cycles differ."""
        changes = self.measure.seen(u[:-1] - u[1:])
        apart = np.linalg.norm(changes[0] - changes[1:], axis=1)
        if len(apart) < self.rules.longest_period - 1:
            return
        before, self.period = self.period, 1
        if apart.size and apart[0] > MUCH * np.linalg.norm(changes[0]):
            alike = np.flatnonzero(apart <= MUCH * apart[0])
            self.period = int(alike[0]) + 1 if alike.size else 1
        if self.period != before:
            self.crawl.forget()

    def _window(self) -> FloatArray:
        """The last states one period apart with the same nodes open."""
        states = [self.states[k] for k in range(-1, -len(self.states) - 1, -self.period)][:WINDOW]
        opened = states[0].contact == OPEN
        return np.array([state.u for state in reversed(states) if ((state.contact == OPEN) == opened).all()])

    def _leap(self) -> None:
        """Leap to where the last states lead, and stay if a period from there does what was predicted."""
        window = self._window()
        if self._comes_back(window):
            return
        stuck = self.cycles >= STUCK and not self._awaits() and len(window) > 1
        if stuck and ((self.cycles >= self.along.since and self._go_along()) or self._go_on_average()):
            return
        missed = self.crawl.rigid_miss(window, self.measure)
        if missed is not None:
            window = window + missed
            self.states = deque([State(s.u + missed, s.contact) for s in self.states], self.states.maxlen)
            self.motion.state = self.states[-1]
        for way in (self.crawl, self.ahead):
            leap = way.plan(window, self.measure, self.cycles)
            if leap is not None:
                self._take(way, leap)
                return

    def _comes_back(self, window: FloatArray) -> bool:
        """Whether the last change undoes the previous one along other contact states: no smooth map."""
        p, changes = self.period, self.measure.seen(np.diff(window[-3:], axis=0))
        if len(changes) < 2 or changes[0] @ changes[1] >= 0.0:
            return False
        records = list(self.records)
        return _signatures(records[-p:]) != _signatures(records[-2 * p : -p])

    def _take(self, way: Crawl | Ahead, leap: Leap) -> None:
        """Follow a leap; stay where its prediction fails."""
        before, p = self._begin_leap(len(self.records)), self.period
        u, contact = leap.start.copy(), before.state.contact
        u[self.layout.gaps][contact != OPEN] = 0.0
        self._go_to(State(u, contact))
        taken: bool | None = False
        for _ in range(way.TRIES):
            taken = leap.fits(self._change(p)) if all(self._cycle() for _ in range(p)) else None
            if taken is not False:
                break
        if taken:
            self.adrift += way.adrift(self.measure)
            turned = self._turned(before)
            leap = leap._replace(unsure=max(leap.unsure, turned), apart=max(leap.apart, turned))
        self._end_leap(before, leap if taken else None)
        if taken and way is self.ahead:
            self.crawl.forget()
        way.heed(bool(taken), self.cycles)

    def _begin_leap(self, last: int) -> _Before:
        """Remember where a leap begins; it may jump where the last cycles did.

        A jump may take minutes to follow, and is not foreseen where cycles had none.
        """
        records = list(self.records)
        self.fadings[self.period - 1].note(self._mark(self.period))
        self.motion.may_jump = any(record.jumps for record in records[-last:])
        return _Before(self.motion.state, self.states, records, len(self.passed), len(self.jumps))

    def _go_to(self, state: State) -> None:
        """Go on from another state."""
        self.motion.state, self.states = state, deque([state], maxlen=self.states.maxlen)

    def _end_leap(self, before: _Before, leap: Leap | Landing | None) -> None:
        """Count a leap that is taken; go back from one that is not."""
        self.motion.may_jump = True
        del self.passed[before.passed :]
        if leap is None:
            del self.jumps[before.jumps :]
            self.motion.state, self.states = before.state, before.states
            self.records = deque(before.records, maxlen=self.records.maxlen)
            return
        self.leaps, self.mean = self.leaps + 1, None
        kinks, apart = self._passed_kinks(before), leap.apart if isinstance(leap, Leap) else leap.unsure
        self.unsure, self.apart = self.unsure + max(leap.unsure, kinks), self.apart + max(apart, kinks)
        self.rate = leap.rate ** (1.0 / self.period)
        self.repeated = [0] * self.rules.longest_period

    def _passed_kinks(self, before: _Before) -> float:
        """What is open of nodes that began or ceased to slip on a leap, nobody saw where [length]."""
        p = self.period
        slipped = np.sum([record.slip for record in before.records[-p:]], axis=0) > 0.0
        changed = self.layout.slips_of(np.flatnonzero(slipped != (self._slip(1, p) > 0.0)))
        moved = self.states[0].u - before.state.u
        return MISJUDGED * float(np.abs(moved[changed]).max(initial=0.0))

    def _turned(self, before: _Before) -> float:
        """By how much a leap may miss a way that turns where contact states change, unseen [length]."""
        p, size = self.period, self.measure.size
        earlier, later = before.records[-p:], list(self.records)[-p:]
        if _signatures(earlier) == _signatures(later):
            return 0.0
        changes = before.states[-1].u - before.states[-1 - p].u, self._change(p)
        start, end = (change / (size(change) or 1.0) for change in changes)
        return size(self.states[0].u - before.state.u) * float(np.abs(end - start).max())

    def _go_along(self) -> bool:
        """Leap by the slopes of a period, if few nodes move."""
        p, contact = self.period, self.motion.state.contact
        free = self.layout.of_nodes(np.flatnonzero(contact == OPEN))
        places = self.layout.slips_of(np.flatnonzero((self._slip(1, p) > 0.0) & (contact != OPEN)))
        if not 0 < len(places) <= self.along.MOST_SLIPS:
            return False
        moving = Moving.of(free_stiffness(self.motion.problem), places, free)
        start, first = self.states[-1 - p].u, self._last_step()

        def landed() -> None:
            self.fadings[p - 1].note(self._mark(p))

        self._look_ahead(
            self.along,
            lambda period: self.along.leap(period, landed, start, first, moving, self.measure),
        )
        return True

    def _go_on_average(self) -> bool:
        """Leap by what periods do on average, if contact states change from one to the next."""
        if self.along.wait < LONGEST_WAIT or self.cycles < self.average.since:
            return False
        if len(set(_signatures(list(self.records)))) == 1:
            return False
        self.period, start, mean = 1, self.states[-1].u, self.mean

        def landed(change: FloatArray) -> None:
            nonlocal mean
            size, drift = self.measure.size(change), self.measure.rigid.T @ change
            mean = self._mark(1)._replace(change=change, size=size, drift=drift)
            self.fadings[0].note(mean)

        self._look_ahead(self.average, lambda period: self.average.leap(period, landed, start, self.measure))
        self.mean = mean
        return True

    def _last_step(self) -> PeriodStep:
        """What the last period has changed."""
        p = self.period
        return PeriodStep(self._change(p), sum(record.signature for record in list(self.records)[-p:]))

    def _look_ahead(self, way: Along | OnAverage, leap: Callable[[Period], Landing | None]) -> None:
        """Leap by periods that are followed to see what they do, from states that are not passed through."""
        before, p, contact = self._begin_leap(self.period), self.period, self.motion.state.contact
        cycles, gathered = self.cycles, self.gathered

        def period(start: FloatArray) -> PeriodStep | None:
            self._go_to(State(start, contact))
            return self._last_step() if all(self._cycle() for _ in range(p)) else None

        landing = leap(period)
        self.gathered = gathered
        self._end_leap(before, landing)
        way.since, self.looked = self.cycles + way.wait, self.looked + self.cycles - cycles
        if landing is not None:
            self.crawl.forget()

    def _to_come(self, period: int, drifts: bool = False) -> tuple[float, float]:
        """What later periods may add to a state, as changes fade, and by which factor per cycle they do.

        Twice the sum of a geometric series, node by node: changes like 1/k² sum to as much. Rigid drift does
        not count.
        """
        states = [self.states[k].u for k in range(-1, -len(self.states) - 1, -period)][:3]
        if drifts:
            states = [u - self.measure.rigid @ (self.measure.rigid.T @ u) for u in states]
        changes = [np.abs(later - before) for later, before in pairwise(states)]
        last, before = changes[0], changes[-1]
        falls = np.divide(last, before, out=np.ones_like(last), where=before > last)
        rates = np.full_like(last, self.rate**period) if self.leaps else np.where(last > 0.0, falls, 0.0)
        most = np.divide(2.0, 1.0 - rates, out=np.full_like(last, float(self.cycles)), where=rates < 1.0)
        return float((last * most).max()), float(rates[np.argmax(last)]) ** (1.0 / period)

    def _farthest(self, period: int, drifts: bool) -> float:
        """How far a node has still to go, as the changes of all fall, and as its own does [length].

        Beside fast ones a slow one may have come no nearer to its end. Rigid drift that lasts does not count.
        """
        fading, now = self._faded(period)
        before = fading.clearly_before(now)
        if before is None:
            return 0.0
        rigid, gone = self.measure.rigid, now.state - before.state
        way, first, last = (
            self.layout.ways(each - rigid @ (rigid.T @ each)) for each in (gone, before.change, now.change)
        )
        fallen = np.maximum(first - last, NEGLIGIBLE * last)
        own = np.divide(way * last, fallen, out=np.zeros_like(way), where=last > 0.0)
        as_all = (way if drifts else self.layout.ways(gone)) * now.size / (before.size - now.size)
        return float(np.maximum(own, as_all).max())

    def _found(self, outcome: Outcome, reason: str, period: int) -> Settled:
        """The answer; for a cycle the period is followed again from the end of the search."""
        (left, rate), start = self._to_come(period, outcome == Outcome.RATCHETTING), self.motion.state
        goes_on = outcome in (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING)
        if goes_on and self.leaps:
            left = max(left, MISJUDGED * self._farthest(period, outcome == Outcome.RATCHETTING))
        if goes_on and not all(self._cycle() for _ in range(period)):
            stop = self.motion.stop
            return self._undecided(f"{stop.reason if stop else 'no more cycles'}, after {reason}")
        moved, unsure, adrift = self._change(period), self.unsure, self.adrift
        drift = np.zeros_like(moved)
        if outcome == Outcome.RATCHETTING:  # where it stands on its way tells nothing
            drift, unsure, adrift = moved, self.apart, 0.0
        return Settled(
            outcome=outcome,
            reason=reason,
            period=period,
            state=self.motion.state,
            drift=drift[self.layout.slips],
            records=tuple(list(self.records)[-period:]),
            cycles=self.cycles,
            events=self.events,
            contraction=rate,
            return_error=float(np.abs(moved - drift).max()),
            error=max(left, self.rules.noise) + self.gathered + unsure + adrift,
            adrift=adrift,
            start=start,
            first_cycles=self._passed_through,
            jumps=tuple(self.jumps),
            looked=self.looked,
        )

    @property
    def _passed_through(self) -> FirstCycles:
        """The states passed through before the first leap."""
        records, states = tuple(record for record, _ in self.passed), [state for _, state in self.passed]
        opened = np.array([state.contact == OPEN for state in states])
        return FirstCycles(records, opened, states[-1] if states else self.motion.state)

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
            adrift=np.nan,
            start=state,
            first_cycles=self._passed_through,
            jumps=tuple(self.jumps),
            looked=self.looked,
            stop=self.motion.stop,
        )


def _signatures(records: list[CycleRecord]) -> list[int]:
    """What identifies the contact states of cycles."""
    return [record.signature for record in records]
