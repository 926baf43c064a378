"""Leaps of a motion that changes in several slow ways at once: along the map of a period, by its slopes.

A leap goes the way that the motion goes, as far as the map is seen to bend on it. It assumes no limit, so
that a motion that lingers where it might have come to rest is followed through.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, PER_CENT, THREE_DIGITS
from shakedown.long_term.space.leap_methods import PRICE, STATE_ROUND_OFF, WORTH, Measure, longer

# Finite-difference step for slopes, relative to all slip (energy norm): at most PER_CENT of the last leap, at
# least round-off of the state.
PROBE = 10.0 * NEGLIGIBLE
# Factors of the step, tried until both points have the same contact states (no kink between them).
TRIED = 1.0, -1.0, 1e-2, -1e-2, 1e-4
BEHIND = 4.0  # times as far as states are moved
FARTHEST = 2**40  # periods: most that a leap goes ahead
DRIFTS = 2.0**20  # periods: most that a drift is followed at once


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
        """r(y), by a period from there; NaN where none can be followed."""
        there = self.period(self.at(y)) if self.size(y) < np.inf else None
        return np.full_like(y, np.nan) if there is None else there.change[self.places] - self.linear(y)

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
    """

    start: FloatArray
    unsure: float
    rate: float


@dataclass
class Along:
    """Leaps along the map of a period: its slopes, and what states on the way tell of its bends.

    Attributes
    ----------
    care
        Share of what leaps may be unsure by otherwise.
    periods
        How far the next one is tried to go.
    way
        How far the last one went [energy norm]; 0: none.
    since, wait
        From which cycle on the next one is tried, and how many after the last that led nowhere.
    """

    MOST_SLIPS: ClassVar[int] = 64  # of moving nodes: each takes a period to see its slope
    BENT: ClassVar[float] = 0.5  # of the way: what slopes alone may miss it by
    SURE: ClassVar[float] = 0.03  # of the way, and of the change there: what bends may miss them by
    LEFT: ClassVar[float] = 1e-3  # of the change: less of it is not told from none
    FARTHER: ClassVar[int] = 2  # times as far after a leap that went as far as was tried

    care: float = 1.0
    periods: int = int(WORTH)
    way: float = 0.0
    since: int = 0
    wait: int = 0

    def leap(
        self, period: Period, start: FloatArray, first: PeriodStep, places: NDArray[np.intp], measure: Measure
    ) -> Landing | None:
        """As far as what it foresees comes; None where that is not far.

        Parameters
        ----------
        period
            Follows one.
        start, first
            A state, (N,) [length], and the period from there.
        places : (k,)
            Where the slips of the nodes that move stand in it.
        measure
            What counts of a change.
        """
        local = self._seen(period, start, first, places, measure)
        periods = self.periods if local is not None else 0
        while local is not None and periods >= WORTH:
            found = self._landing(local, periods)
            if found is not None:
                more = self.FARTHER if periods == self.periods else 1
                self.periods, self.wait = min(more * periods, FARTHEST), 0
                self.way = measure.size(found.start - start)
                return found
            periods //= 2
        self.periods, self.way, self.wait = int(WORTH), 0.0, longer(self.wait)
        return None

    def _seen(
        self, period: Period, start: FloatArray, first: PeriodStep, places: NDArray[np.intp], measure: Measure
    ) -> LocalMap | None:
        """The map next to a state, from a period of each of the states next to it."""
        most = min(PROBE * measure.size(start), PER_CENT * self.way or np.inf)
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
        return LocalMap(period, measure, start, places, change, slopes)

    def _landing(self, local: LocalMap, periods: int) -> Landing | None:
        """So many periods ahead; None where what comes there is not what was foreseen."""
        size, none = local.size, np.zeros((1, len(local.change)))
        straight = local.ahead(periods, none)
        bends = local.bends(periods, none, (0.5, 1.0))
        bent = local.ahead(periods, bends)
        if not size(bent - straight) <= self.BENT * size(bent) < np.inf:
            return None
        bends = local.bends(periods, bends, (0.25, 0.5, 1.0))
        y = local.ahead(periods, bends)
        way, now = size(y), size(local.change)
        if not size(y - bent) <= self.SURE * way < np.inf:
            return None
        there = local.period(local.at(y))
        if there is None:
            return None
        foreseen = np.zeros_like(local.start)
        foreseen[local.places] = local.linear(y) + bends.sum(axis=0)
        left = max(local.measure.size(there.change), self.LEFT * now)
        sure = self.care * max(THREE_DIGITS, PRICE * local.measure.size(local.start) / way)
        if not local.measure.misses(there.change, foreseen, left) <= min(self.SURE, sure * now / left):
            return None
        unsure = float(np.abs(there.change - foreseen).max()) * way / now
        return Landing(local.at(y), unsure, min((left / now) ** (1.0 / periods), 1.0))
