"""Leaps of a motion that changes in several slow ways at once: along the map of a period, by its slopes.

A leap goes the way that the motion goes, as far as the map is seen to bend on it. It assumes no limit, so
that a motion that lingers where it might have come to rest is followed through.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, PER_CENT, RESOLVED, THREE_DIGITS
from shakedown.long_term.space.leap_methods import PRICE, STATE_ROUND_OFF, WORTH, Measure, longer

# Finite-difference step for slopes, relative to all slip (energy norm); at least round-off of the state.
PROBE = 10.0 * NEGLIGIBLE
# Factors of the step, tried until both points have the same contact states (no kink between them).
TRIED = 1.0, -1.0, 1e-2, -1e-2, 1e-4
BEHIND = 4.0  # times as far as states are moved
FARTHEST = 2**40  # periods: most that a leap goes ahead
DRIFTS = 2.0**20  # periods: most that a drift is followed at once
TRAIL = 16  # states at which leaps began that are remembered
# Shares of a way at which its bends are seen, at first and later, and at which they are put to the test.
ROUGHLY, FINELY, TESTED = (0.5, 1.0), (0.25, 0.5, 1.0), (0.75, 1.0)


class PeriodStep(NamedTuple):
    """What a period changes of the state, (N,) [length], and what identifies its contact states."""

    change: FloatArray
    signature: int


Period = Callable[[FloatArray], PeriodStep | None]  # from a state on; None where the motion stops


@dataclass(frozen=True)
class LocalMap:
    """What a period changes next to a state u: F(u + y) = F + D y + r(y), for changes y of some slips.

    Attributes
    ----------
    period
        Follows one.
    measure
        What counts of a change.
    start : (N,)
        u [length].
    places : (k,)
        Where the slips stand in u.
    change : (k,)
        F [length].
    slopes : (k, k)
        D.
    """

    period: Period
    measure: Measure
    start: FloatArray
    places: NDArray[np.intp]
    change: FloatArray
    slopes: FloatArray

    def at(self, y: FloatArray) -> FloatArray:
        """The state u + y."""
        state = self.start.copy()
        state[self.places] += y
        return state

    def size(self, y: FloatArray) -> float:
        """Of a change, by energy; inf where it is out of all bounds, as drift of very many periods is."""
        if not np.abs(y).max() <= max(np.abs(self.start).max(), DRIFTS * np.abs(self.change).max()):
            return np.inf
        return self.measure.size(self.at(y) - self.start)

    def linear(self, y: FloatArray) -> FloatArray:
        """F + D y."""
        return np.asarray(self.change + self.slopes @ y)

    def rest(self, y: FloatArray) -> FloatArray:
        """r(y), by a period from there; NaN where none can be followed, or where other nodes slip."""
        there = self.period(self.at(y)) if self.size(y) < np.inf else None
        if there is None or self._is_elsewhere(there.change):
            return np.full_like(y, np.nan)
        return there.change[self.places] - self.linear(y)

    def _is_elsewhere(self, change: FloatArray) -> bool:
        """Whether a clear share of a change is not at these places."""
        other = change.copy()
        other[self.places] = 0.0
        return bool(other.any()) and self.measure.size(other) > THREE_DIGITS * self.measure.size(change)

    def seen(self, y: FloatArray, bent: FloatArray) -> "Foresight | None":
        """What a period from u + y changes beside F + D y + bent; None where none can be followed."""
        there = self.period(self.at(y))
        if there is None:
            return None
        foreseen = np.zeros_like(self.start)
        foreseen[self.places] = self.linear(y) + bent
        return Foresight(there.change, foreseen)

    def ahead(self, periods: int, bends: FloatArray, share: float = 1.0) -> FloatArray:
        """y after a share of so many periods, if r = Σ bends[i] sⁱ⁺¹ after the share s of them."""
        k = len(self.change)
        one = np.zeros((k + 4, k + 4))  # a period: of y, 1, j, j², j³
        one[:k, :k] = np.eye(k) + self.slopes
        one[:k, k] = self.change
        for power, bend in enumerate(bends, 1):
            one[:k, k + power] = bend / float(periods) ** power
        one[k:, k:] = [[1, 0, 0, 0], [1, 1, 0, 0], [1, 2, 1, 0], [1, 3, 3, 1]]
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(np.linalg.matrix_power(one, int(share * periods))[:k, k])

    def bends(self, periods: int, known: FloatArray, shares: tuple[float, ...]) -> FloatArray:
        """Bends (i, k) by what is seen after some shares of a way that is bent as far as is known."""
        seen = np.array([self.rest(self.ahead(periods, known, share)) for share in shares])
        powers = np.array(shares)[:, None] ** np.arange(1, len(shares) + 1)
        return np.linalg.solve(powers, seen)


class Foresight(NamedTuple):
    """A change, (N,) [length], and the one that was foreseen."""

    change: FloatArray
    foreseen: FloatArray


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
class Along:
    """Leaps along the map of a period: its slopes, and what states on the way tell of its bends.

    Attributes
    ----------
    care
        Share of what leaps may be unsure by otherwise.
    periods
        How far the next one is tried to go.
    trail
        States at which leaps began, with their first period.
    since, wait
        From which cycle on the next one is tried, and how many after the last that led nowhere.
    """

    MOST_SLIPS: ClassVar[int] = 64  # of moving nodes: each takes a period to see its slope
    SWEEPS: ClassVar[int] = 8  # in which bends are seen, each time on the way that the last ones lead …
    SHRINKS: ClassVar[float] = 0.5  # … while they change it so much less than two sweeps before, and never …
    BENT: ClassVar[float] = 0.5  # … by more than this, relative
    SURE: ClassVar[float] = 0.03  # of the way, and of the change there: what bends may miss them by
    LEFT: ClassVar[float] = 1e-3  # of the change: less of it is not told from none
    GROWN: ClassVar[float] = 4.0  # and most: nodes may begin and cease to slip between what is looked at
    FARTHER: ClassVar[int] = 2  # times as far after a leap that went as far as was tried

    care: float = 1.0
    periods: int = int(WORTH)
    trail: deque[tuple[FloatArray, PeriodStep]] = field(default_factory=lambda: deque(maxlen=TRAIL))
    since: int = 0
    wait: int = 0

    def leap(
        self,
        period: Period,
        landed: Callable[[], None],
        start: FloatArray,
        first: PeriodStep,
        places: NDArray[np.intp],
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
        places : (k,)
            Where the slips of the nodes that move stand in it.
        measure
            What counts of a change.
        """
        local = self._seen(period, start, first, places, measure)
        landing, unsure, tried = None, 0.0, self.periods
        while local is not None and tried >= WORTH:
            found = self._landing(local, tried)
            if found is not None:
                landed()
                unsure += found.unsure
                landing, self.wait = found._replace(unsure=unsure), 0
                if tried < self.periods:
                    self.periods = tried
                    break
                self.periods = tried = min(self.FARTHER * tried, FARTHEST)
                local = replace(local, start=found.start, change=found.change)
            elif landing is not None:
                period(landing.start)  # so that it is the last
                break
            else:
                tried //= 2
        if landing is None:
            self.periods, self.wait = int(WORTH), longer(self.wait)
        return landing

    def _seen(
        self, period: Period, start: FloatArray, first: PeriodStep, places: NDArray[np.intp], measure: Measure
    ) -> LocalMap | None:
        """The map next to a state, from a period of each of the states next to it."""
        most = PROBE * measure.size(start)
        least = STATE_ROUND_OFF * float(np.abs(start).max())
        sizes = np.maximum(most / np.linalg.norm(measure.root[:, places], axis=0), least)
        change, slopes = first.change[places], np.zeros((len(places), len(places)))
        # A little behind the nodes that creep on: they slip in all the states next to it.
        toward = change.reshape(-1, measure.directions)
        away = np.linalg.norm(toward, axis=1, keepdims=True)
        ways = (toward / np.where(away > 0.0, away, 1.0)).ravel()
        behind = start.copy()
        behind[places] -= BEHIND * sizes * ways
        here, base = start, first
        there = period(behind)
        if there is not None and there.signature == first.signature:
            here, base = behind, there
        for k, place in enumerate(places):
            for share in TRIED:
                moved = here.copy()
                moved[place] += share * sizes[k]
                there = period(moved)
                if there is None:
                    return None
                slopes[:, k] = (there.change - base.change)[places] / (moved[place] - here[place])
                if there.signature == first.signature:
                    break
        rigid = measure.rigid[places]
        if np.linalg.norm(rigid) ** 2 > rigid.shape[1] * (1.0 - THREE_DIGITS):  # all nodes move
            slopes -= (slopes @ rigid) @ rigid.T
        slopes += self._by_trail(slopes, start, first, places, measure)
        self.trail.append((start, first))
        return LocalMap(period, measure, start, places, change, slopes)

    def _by_trail(
        self,
        slopes: FloatArray,
        start: FloatArray,
        first: PeriodStep,
        places: NDArray[np.intp],
        measure: Measure,
    ) -> FloatArray:
        """What slopes (k, k) lack along the way from an earlier state, if that tells more than probes."""
        root, far = measure.root[:, places], RESOLVED * PROBE * measure.size(start)
        for state, there in reversed(self.trail):
            way = (start - state)[places]
            seen = root @ way
            if there.signature == first.signature and seen @ seen > far**2:
                missed = (first.change - there.change)[places] - slopes @ way
                return np.outer(missed, root.T @ seen) / (seen @ seen)
        return np.zeros_like(slopes)

    def _landing(self, local: LocalMap, periods: int) -> Landing | None:
        """So many periods ahead; None where what comes there is not what was foreseen."""
        bends = self._bends(local, periods)
        if bends is None:
            return None
        y, now = local.ahead(periods, bends), local.size(local.change)
        way, change, left, missed = local.size(y), local.change, now, 0.0
        sure = self._sure(local, way)
        for share in TESTED:
            y = local.ahead(periods, bends, share)
            seen = local.seen(y, share ** np.arange(1, len(bends) + 1) @ bends)
            if seen is None:
                return None
            left = max(local.measure.size(seen.change), self.LEFT * now)
            allowed = min(self.SURE, sure * now / left)
            if left > self.GROWN * now or not local.measure.misses(*seen, left) <= allowed:
                return None
            missed = max(missed, float(np.abs(seen.change - seen.foreseen).max()))
            change = seen.change[local.places]
        return Landing(local.at(y), missed * way / now, min((left / now) ** (1.0 / periods), 1.0), change)

    def _bends(self, local: LocalMap, periods: int) -> FloatArray | None:
        """Those of the way so many periods ahead, by sweep after sweep; None where they do not settle."""
        bends = np.zeros((1, len(local.change)))
        y, off = local.ahead(periods, bends), [np.inf, np.inf]
        for sweep in range(self.SWEEPS):
            bends = local.bends(periods, bends, FINELY if sweep else ROUGHLY)
            before, y = y, local.ahead(periods, bends)
            way = local.size(y)
            if not 0.0 < way < np.inf:
                return None
            off.append(local.size(y - before) / way)
            if not off[-1] <= self.BENT:
                return None
            if off[-1] <= PER_CENT * self._sure(local, way) or off[-1] > self.SHRINKS * off[-3]:
                break
        return bends if off[-1] <= self.SURE else None

    def _sure(self, local: LocalMap, way: float) -> float:
        """What the change at the end of a leap may miss, relative to the change at its beginning."""
        return self.care * max(THREE_DIGITS, PRICE * local.measure.size(local.start) / way)
