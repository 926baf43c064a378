"""Leaps of a motion that changes in several slow ways at once: along the map of a period, by its slopes.

A leap goes the way that the motion goes, as far as the map is seen to bend on it. It assumes no limit, so
that a motion that lingers where it might have come to rest is followed through.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import ClassVar, NamedTuple

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS, MUCH, NEGLIGIBLE, PER_CENT, RESOLVED, THREE_DIGITS
from shakedown.long_term.space.leap_methods import PRICE, STATE_ROUND_OFF, WORTH, Measure, longer
from shakedown.long_term.space.local_map import BEHIND_IT, Behind, LocalMap, Moving, Period, PeriodStep, Way

# Finite-difference step for slopes, relative to all slip (energy norm); at least round-off of the state.
PROBE = 10.0 * NEGLIGIBLE
# Factors of the step, tried until both points have the same contact states (no kink between them).
TRIED = 1.0, -1.0, 1e-2, -1e-2, 1e-4
BEHIND = 4.0  # times as far as states are moved
FARTHEST = 2**40  # periods: most that a leap goes ahead
TRAIL = 16  # states at which leaps began that are remembered
NEXT_TO_IT = 8.0  # so many times the length of a leap behind it, or that share, they tell how it is bent
TESTED = 0.75, 1.0  # shares of a way at which its bends are put to the test


class Waypoint(NamedTuple):
    """Where a leap began: a state (N,), the change (k,) in a period from there of moving slips, and when."""

    state: FloatArray
    change: FloatArray
    moving: Moving
    periods: int


class Landing(NamedTuple):
    """Where to go on from.

    Attributes
    ----------
    start : (N,)
        The state [length]; the period from there is the last that was followed.
    unsure
        How far it may be off [length].
    rate
        Factor per period by which changes shrink.
    change : (k,)
        Of the slips that the map is of, in that period [length].
    """

    start: FloatArray
    unsure: float
    rate: float
    change: FloatArray


@dataclass
class FarLeaps:
    """How far leaps go whose end is foreseen from what periods do on the way and before it.

    Attributes
    ----------
    care
        Share of what leaps may be unsure by otherwise.
    periods
        How far the next one is tried to go.
    since, wait
        From which cycle on the next one is tried, and how many after the last that led nowhere.
    """

    SURE: ClassVar[float] = 0.03  # of the change at the end of a leap: what it may miss
    AT_EASE: ClassVar[float] = 0.3  # strain that is aimed at: what is missed, relative to what may be …
    ORDER: ClassVar[int]  # … as this power of the length of a leap, at least, it grows
    TIMES: ClassVar[tuple[float, ...]] = 0.25, 0.5, 2.0  # as long: least, most after a failure, most

    care: float = 1.0
    periods: int = int(WORTH)
    since: int = 0
    wait: int = 0

    def next_length(self, periods: int, strain: float, failed: bool = False) -> int:
        """How many periods to try next, after a leap of so many with this strain."""
        least, less, more = self.TIMES
        times = (self.AT_EASE / max(strain, EPS)) ** (1.0 / self.ORDER)
        return min(int(periods * min(max(times, least), less if failed else more)), FARTHEST)

    def sure(self, start: FloatArray, way: float, measure: Measure) -> float:
        """What the change at the end of a leap may miss, relative to the change at its beginning."""
        return self.care * max(THREE_DIGITS, PRICE * measure.size(start) / way)


@dataclass
class Along(FarLeaps):
    """Leaps along the map of a period: its slopes, and what states on the way tell of its bends.

    Attributes
    ----------
    trail
        States at which slopes were seen, with their first period.
    path, gone, end
        Where the last leaps began, how many periods they have gone in all, and to which state.
    """

    MOST_SLIPS: ClassVar[int] = 64  # of moving nodes: each takes a period to see its slope
    SWEEPS: ClassVar[int] = 8  # in which bends are seen, each time on the way that the last ones lead …
    SHRINKS: ClassVar[float] = 0.5  # … while they change it so much less than two sweeps before, and never …
    BENT: ClassVar[float] = 0.5  # … by more than this, relative
    LEFT: ClassVar[float] = 1e-3  # of the change: less of it is not told from none
    GROWN: ClassVar[float] = 4.0  # and most: nodes may begin and cease to slip between what is looked at
    ORDER: ClassVar[int] = 5

    trail: deque[tuple[FloatArray, PeriodStep]] = field(default_factory=lambda: deque(maxlen=TRAIL))
    path: deque[Waypoint] = field(default_factory=lambda: deque(maxlen=TRAIL))
    gone: int = 0
    end: FloatArray = field(default_factory=lambda: np.zeros(0))

    def leap(
        self,
        period: Period,
        landed: Callable[[], None],
        start: FloatArray,
        first: PeriodStep,
        moving: Moving,
        measure: Measure,
    ) -> Landing | None:
        """As far as what it foresees comes, again and again by the same slopes; None where that is not far.

        Parameters
        ----------
        period
            Follows one.
        landed
            Called at every state that was foreseen, after the period from there.
        start, first
            A state, (N,) [length], and the period from there.
        moving
            The slips of the nodes that move, and what follows them.
        measure
            What counts of a change.
        """
        if self.path and not self._follows(start, first, measure):
            self.path.clear()
        local = self._seen(period, start, first, moving, measure)
        landing, unsure = None, 0.0
        while local is not None and self.periods >= WORTH:
            found, strain = self._landing(local, self.periods)
            if found is not None:
                landed()
                unsure += found.unsure
                landing, self.wait = found._replace(unsure=unsure), 0
                self.path.append(Waypoint(local.start, local.change, moving, self.gone))
                self.gone, self.end = self.gone + self.periods, found.start
                local = replace(local, start=found.start, change=found.change)
            self.periods = self.next_length(self.periods, strain, found is None)
            if found is None and landing is not None:
                period(landing.start)  # so that it is the last
            if strain > self.AT_EASE and landing is not None:
                break
        if landing is None:
            self.wait = longer(self.wait)
            self.path.clear()
        self.periods = max(self.periods, int(WORTH))
        return landing

    def _follows(self, start: FloatArray, first: PeriodStep, measure: Measure) -> bool:
        """Whether a state is where the last leap has ended, but for a few periods."""
        return measure.size(start - self.end) <= WORTH * measure.size(first.change)

    def _seen(
        self, period: Period, start: FloatArray, first: PeriodStep, moving: Moving, measure: Measure
    ) -> LocalMap | None:
        """The map next to a state, from a period of each of the states next to it."""
        places, follow = moving
        most = PROBE * measure.size(start)
        least = STATE_ROUND_OFF * float(np.abs(start).max())
        sizes = np.maximum(most / np.linalg.norm(measure.root @ follow, axis=0), least)
        change, slopes = first.change[places], np.zeros((len(places), len(places)))
        # A little behind the nodes that creep on: they slip in all the states next to it.
        toward = change.reshape(-1, measure.directions)
        away = np.linalg.norm(toward, axis=1, keepdims=True)
        ways = (toward / np.where(away > 0.0, away, 1.0)).ravel()
        behind = start - follow @ (BEHIND * sizes * ways)
        here, base = start, first
        there = period(behind)
        if there is not None and there.signature == first.signature:
            here, base = behind, there
        for k, place in enumerate(places):
            for share in TRIED:
                moved = here + share * sizes[k] * follow[:, k]
                there = period(moved)
                if there is None:
                    return None
                slopes[:, k] = (there.change - base.change)[places] / (moved[place] - here[place])
                if there.signature == first.signature:
                    break
        rigid = measure.rigid[places]
        if np.linalg.norm(rigid) ** 2 > rigid.shape[1] * (1.0 - THREE_DIGITS):  # all nodes move
            slopes -= (slopes @ rigid) @ rigid.T
        slopes += self._by_trail(slopes, start, first, moving, measure)
        self.trail.append((start, first))
        return LocalMap(period, measure, start, moving, change, slopes, first.signature)

    def _by_trail(
        self,
        slopes: FloatArray,
        start: FloatArray,
        first: PeriodStep,
        moving: Moving,
        measure: Measure,
    ) -> FloatArray:
        """What slopes (k, k) lack along the way from an earlier state, if that tells more than probes."""
        places, root = moving.places, measure.root @ moving.follow
        far = RESOLVED * PROBE * measure.size(start)
        for state, there in reversed(self.trail):
            way = (start - state)[places]
            seen = root @ way
            if there.signature == first.signature and seen @ seen > far**2:
                missed = (first.change - there.change)[places] - slopes @ way
                return np.outer(missed, root.T @ seen) / (seen @ seen)
        return np.zeros_like(slopes)

    def _landing(self, local: LocalMap, periods: int) -> tuple[Landing | None, float]:
        """So many periods ahead, or None, and the strain: what is missed there, relative to what may be."""
        way, strain = self._bent(local, periods, self._behind(local, periods)), 0.0
        if way is None:
            return None, np.inf
        now, size, change = local.size(local.change), local.size(way.end), local.change
        sure, unsure, left = self.sure(local.start, size, local.measure), 0.0, now
        if way.smooth:
            strain, unsure = MUCH * local.size(way.miss) / size / sure, MUCH * float(np.abs(way.miss).max())
        for share in TESTED[-1:] if way.smooth else TESTED:
            if not strain <= 1.0:
                return None, strain
            y = way.end if share == 1.0 else local.ahead(periods, way.bends, share)
            seen = local.seen(y, share ** np.arange(1, len(way.bends) + 1) @ way.bends)
            if seen is None:
                return None, np.inf
            left = max(local.measure.size(seen.change), self.LEFT * now)
            strain = max(strain, local.measure.misses(*seen, left) / min(self.SURE, sure * now / left))
            unsure = max(unsure, float(np.abs(seen.change - seen.foreseen).max()) * size / now)
            change = seen.change[local.moving.places]
        if left > self.GROWN * now or not strain <= 1.0:
            return None, strain
        rate = min((left / now) ** (1.0 / periods), 1.0)
        return Landing(local.at(way.end), unsure, rate, change), strain

    def _bent(self, local: LocalMap, periods: int, behind: Behind) -> Way | None:
        """The way so many periods ahead, by sweep after sweep; None where its bends do not settle."""
        way = foreseen = local.way(periods, behind.bends)
        off = [np.inf, np.inf]
        for _ in range(self.SWEEPS):
            before, way = way, local.bends(periods, way.bends, behind)
            size = local.size(way.end)
            if not 0.0 < size < np.inf:
                return None
            off.append(local.size(way.end - before.end) / size)
            if not off[-1] <= self.BENT:  # what lies behind misleads, unless something begins or ends to slip
                return self._bent(local, periods, behind.first(0)) if way.smooth else None
            if (
                off[-1] <= PER_CENT * self.sure(local.start, size, local.measure)
                or off[-1] > self.SHRINKS * off[-3]
            ):
                break
        return way._replace(miss=way.end - foreseen.end) if off[-1] <= self.SURE else None

    def _behind(self, local: LocalMap, periods: int) -> Behind:
        """What the states at which the last leaps began tell of the bends of a way."""
        shares, rests = [], []
        for point in reversed(self.path):
            back = (self.gone - point.periods) / periods
            if 1.0 / NEXT_TO_IT <= back <= NEXT_TO_IT and point.moving.is_like(local.moving):
                shares.append(-back)
                rests.append(point.change - local.linear((point.state - local.start)[local.moving.places]))
        return Behind(np.array(shares), np.array(rests).reshape(-1, len(local.change))).first(BEHIND_IT)
