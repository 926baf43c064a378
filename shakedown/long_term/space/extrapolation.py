"""Leaps ahead of slow approaches, and what they leave uncertain."""

from math import nan

import numpy as np

from shakedown.ground.constants import ERROR_FACTOR, NOTABLE, FloatArray
from shakedown.ground.status import OPEN
from shakedown.joint.rigid_slips import free_stiffness
from shakedown.long_term.space import leaps
from shakedown.long_term.space.followed_cycles import Decay, FollowedCycles, Period, Position, signatures
from shakedown.motion.method import State

SLOW_AFTER = 200  # cycles after which slopes of a period are measured, one cycle each


class Leaps:
    """Leaps over many periods at once, taken where a period at their end does what was predicted.

    Parameters
    ----------
    cycles
        The cycles followed.
    longest_period
        Of a long-term state, in cycles.
    care
        What leaps may be uncertain by, as a share of what they may be otherwise.

    Attributes
    ----------
    period
        The cycles after which changes recur.
    decays
        How the change has decayed on the way, by period.
    rate
        Factor per cycle by which changes shrink; NaN before the first leap.
    error, error_apart, rigid_error
        What the leaps leave uncertain: in all but rigid slip that no cycle depends on, in what drifts on, and
        in that rigid slip [length].
    """

    def __init__(self, cycles: FollowedCycles, longest_period: int, care: float) -> None:
        self.cycles, self.layout, self.measure = cycles, cycles.layout, cycles.measure
        self.longest_period, self.period = longest_period, 1
        self.recurrence, self.slopes = leaps.RecurrenceLeaps(care), leaps.SlopeLeaps(care)
        self.decays = [Decay() for _ in range(longest_period)]
        self.rate, self.error, self.error_apart, self.rigid_error = nan, 0.0, 0.0, 0.0

    def last(self) -> tuple[Decay, Period]:
        """How the change has decayed on the way, and what the last period did."""
        return self.decays[self.period - 1], self.cycles.last(self.period)

    def find_period(self, u: FloatArray) -> None:
        """The period after which changes recur, where those of consecutive cycles differ.

        Parameters
        ----------
        u : (k, N)
            The last states, the newest first.
        """
        changes = self.measure.seen(u[:-1] - u[1:])
        apart = np.linalg.norm(changes[0] - changes[1:], axis=1)
        if len(apart) < self.longest_period - 1:
            return
        self.period = 1
        if apart.size and apart[0] > NOTABLE * np.linalg.norm(changes[0]):
            alike = np.flatnonzero(apart <= NOTABLE * apart[0])
            self.period = int(alike[0]) + 1 if alike.size else 1

    def try_one(self, by_slopes: bool) -> bool:
        """Leap to where the last states lead; whether the leap was taken.

        Parameters
        ----------
        by_slopes
            Whether periods may be followed from states next to the last one, to see slopes.
        """
        cycles, window, before = self.cycles, self.cycles.window(self.period), self.cycles.leaps
        if self._turns_back(window):
            return False
        by_slopes = by_slopes and SLOW_AFTER <= cycles.count >= self.slopes.since and len(window) > 1
        if not (by_slopes and self._leap_by_slopes()):
            leap = self.recurrence.plan(window, self.measure, cycles.count)
            if leap is not None:
                self._try(leap)
        return cycles.leaps > before

    def _turns_back(self, window: FloatArray) -> bool:
        """Whether the last change undoes the previous one along other contact states: no smooth map."""
        p, changes = self.period, self.measure.seen(np.diff(window[-3:], axis=0))
        if len(changes) < 2 or changes[0] @ changes[1] >= 0.0:
            return False
        records = list(self.cycles.records)
        return signatures(records[-p:]) != signatures(records[-2 * p : -p])

    def _try(self, leap: leaps.Leap) -> None:
        """Follow a leap; stay where its prediction comes true."""
        cycles, p, taken, tries = self.cycles, self.period, False, leaps.TRIES
        before = self._begin(len(cycles.records))
        u, contact = leap.start.copy(), before.state.contact
        u[self.layout.gaps][contact != OPEN] = 0.0
        cycles.go_to(State(u, contact))
        while not taken and tries and cycles.follow(p):
            taken, tries = leap.fits(cycles.change(p)), tries - 1
        if taken:
            self.rigid_error += self.recurrence.rigid_error(self.measure)
            turned = self._turned(before)
            self._take(before, max(leap.error, turned), max(leap.error_apart, turned), leap.rate)
        else:
            self._refuse(before)
        self.recurrence.adapt(taken, cycles.count)

    def _leap_by_slopes(self) -> bool:
        """Leap by the slopes of a period; False where no node moves, or too many."""
        cycles, p, contact = self.cycles, self.period, self.cycles.states[-1].contact
        free = self.layout.of_nodes(np.flatnonzero(contact == OPEN))
        places = self.layout.slips_of(np.flatnonzero((cycles.slip(1, p) > 0.0) & (contact != OPEN)))
        if not 0 < len(places) <= self.slopes.MOST_SLIPS:
            return False
        start, first = cycles.states[-1 - p].u, cycles.last(p)
        before, count, error = self._begin(p), cycles.count, cycles.error

        def period(state: FloatArray) -> Period | None:
            cycles.go_to(State(state, contact))
            return cycles.last(p) if cycles.follow(p) else None

        def at_leap_end() -> None:
            self.decays[p - 1].note(cycles.last(p))

        moves = leaps.moved_by_slips(free_stiffness(cycles.motion.problem), places, free)
        change, unknown = first.change[places], np.zeros((len(places), len(places)))
        local = leaps.LocalMap(period, self.measure, start, places, moves, change, unknown, first.signature)
        leap_end = self.slopes.leap(local, first, at_leap_end)
        cycles.error = error  # of states that are not passed through
        if leap_end is None:
            self._refuse(before)
        else:
            error, rate = leap_end
            self._take(before, error, error, rate)
        self.slopes.since = cycles.count + self.slopes.wait
        cycles.probes += cycles.count - count
        return True

    def _begin(self, last: int) -> Position:
        """Where a leap begins; on it the state may jump where it did in so many of the last cycles.

        A jump may take minutes to follow, and is not expected where cycles had none.
        """
        decay, now = self.last()
        decay.note(now)
        self.cycles.motion.may_jump = any(record.jumps for record in list(self.cycles.records)[-last:])
        return self.cycles.position()

    def _refuse(self, before: Position) -> None:
        """Go back to where a leap began."""
        self.cycles.motion.may_jump = True
        del self.cycles.passed[before.passed :]
        self.cycles.go_back(before)

    def _take(self, before: Position, error: float, error_apart: float, rate: float) -> None:
        """Count a leap."""
        self.cycles.motion.may_jump = True
        del self.cycles.passed[before.passed :]
        self.cycles.leaps += 1
        kinks = self._passed_kinks(before)
        self.error += max(error, kinks)
        self.error_apart += max(error_apart, kinks)
        self.rate = rate ** (1.0 / self.period)

    def _passed_kinks(self, before: Position) -> float:
        """What is uncertain of nodes that began or ceased to slip on a leap, nobody saw where [length]."""
        p = self.period
        slipped = np.sum([record.slip for record in before.records[-p:]], axis=0) > 0.0
        changed = self.layout.slips_of(np.flatnonzero(slipped != (self.cycles.slip(1, p) > 0.0)))
        moved = self.cycles.states[0].u - before.state.u
        return ERROR_FACTOR * float(np.abs(moved[changed]).max(initial=0.0))

    def _turned(self, before: Position) -> float:
        """By how much a leap may miss a way that turns where contact states change, unseen [length]."""
        p, size = self.period, self.measure.size
        if signatures(before.records[-p:]) == signatures(list(self.cycles.records)[-p:]):
            return 0.0
        changes = before.states[-1].u - before.states[-1 - p].u, self.cycles.change(p)
        start, end = (change / (size(change) or 1.0) for change in changes)
        return size(self.cycles.states[0].u - before.state.u) * float(np.abs(end - start).max())
