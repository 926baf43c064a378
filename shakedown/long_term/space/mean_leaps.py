"""Leaps of a motion that creeps along a kink of the map of a period: by what it does on average.

There a node slips in one period and rests in some, again and again in the same order, so that no period tells
the next. A mean of many, weighted by a smooth bump, changes no more than the way demands.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, expm1, log
from typing import ClassVar, NamedTuple

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import FOUR_DIGITS
from shakedown.long_term.space.leap_methods import WORTH, Measure, longer
from shakedown.long_term.space.local_map import Period, PeriodStep
from shakedown.long_term.space.slope_leaps import FARTHEST, FarLeaps, Landing


class Mean(NamedTuple):
    """What many periods do.

    Attributes
    ----------
    change : (N,)
        Of the state in one, on average [length].
    after
        Periods from the middle of them to the end of the last.
    start : (N,)
        The state before the last [length].
    last
        That period.
    """

    change: FloatArray
    after: float
    start: FloatArray
    last: PeriodStep

    @property
    def end(self) -> FloatArray:
        """The state after the last (N,) [length]."""
        return np.asarray(self.start + self.last.change)


class MeanTrend(NamedTuple):
    """How the mean change F goes on: its size is an exponential of time, and what turns it fades alike.

    Attributes
    ----------
    change : (N,)
        F at time zero [length].
    growth
        Of its size per period, relative; negative where it fades.
    turning : (N,)
        Change of F per period across it [length].
    """

    change: FloatArray
    growth: float
    turning: FloatArray

    @classmethod
    def between(cls, before: FloatArray, now: FloatArray, periods: float, measure: Measure) -> "MeanTrend":
        """From mean changes (N,) so many periods apart."""
        seen, earlier = measure.seen(now), measure.seen(before)
        share = float(seen @ earlier) / float(seen @ seen)  # of F in F before
        growth = -log(share) / periods if share > 0.0 else 0.0
        return cls(now, growth, (share * now - before) / periods)

    def at(self, time: float) -> FloatArray:
        """F (N,) after a time [length]."""
        return np.asarray(self.change * exp(self.growth * time) + self.turning * _integral(self.growth, time))

    def way(self, since: float, until: float) -> FloatArray:
        """What it adds up to, (N,) [length]."""
        once = _integral(self.growth, until) - _integral(self.growth, since)
        twice = _twice(self.growth, until) - _twice(self.growth, since)
        return np.asarray(self.change * once + self.turning * twice)


def _integral(rate: float, time: float) -> float:
    """Of e^(rate t) over a time from zero on."""
    return time if rate == 0.0 else expm1(rate * time) / rate


def _twice(rate: float, time: float) -> float:
    """The integral of that."""
    if abs(rate * time) <= FOUR_DIGITS:
        return 0.5 * time * time * (1.0 + rate * time / 3.0)
    return (expm1(rate * time) / rate - time) / rate


@dataclass
class OnAverage(FarLeaps):
    """Leaps along the mean change of a period, as that has changed on the last leap.

    Attributes
    ----------
    trend
        Of the mean change after the last leap.
    """

    OVER: ClassVar[int] = 48  # periods of which a mean is
    SETTLE: ClassVar[int] = 16  # after a leap, before that, and at most after it, until …
    ALIKE: ClassVar[int] = 3  # … so many in a row have the same contact states, as at other marks of the way
    LEAPS: ClassVar[int] = 8  # in a row, before others are tried again
    ORDER: ClassVar[int] = 2
    FADES: ClassVar[float] = 2.0  # exponents by which the mean change fades or grows on a leap, at most

    periods: int = 2 * OVER
    trend: MeanTrend | None = None

    def leap(
        self, period: Period, landed: Callable[[FloatArray], None], start: FloatArray, measure: Measure
    ) -> Landing | None:
        """As far as means foresee what comes, leap after leap; None where that is not far.

        Parameters
        ----------
        period
            Follows one.
        landed
            Called with the mean change, (N,) [length], at the end of every leap.
        start
            A state, (N,) [length].
        measure
            What counts of a change.
        """
        here, landing, unsure = self._mean(period, start, 0, measure), None, 0.0
        for _ in range(self.LEAPS):
            if here is None:
                break
            trend = self._onward(here)
            n = min(self.periods, int(self.FADES / abs(trend.growth)) if trend.growth else FARTHEST)
            if n < WORTH:
                break
            way = trend.way(here.after, here.after + n)
            there = self._mean(period, here.end + way, self.SETTLE, measure)
            if there is None:
                self.periods //= 2
                break
            time = here.after + n + self.SETTLE + 0.5 * self.OVER
            sure = min(self.SURE, self.sure(start, measure.size(way), measure))
            strain = measure.misses(there.change, trend.at(time), measure.size(there.change)) / sure
            self.periods = self.next_length(n, strain)
            if not strain <= 1.0:
                break
            landed(there.change)
            unsure += 0.5 * n * float(np.abs(there.change - trend.at(time)).max())
            rate = (measure.size(there.change) / measure.size(here.change)) ** (1.0 / n)
            landing = Landing(there.start, unsure, min(rate, 1.0), there.last.change)
            self.trend = MeanTrend.between(here.change, there.change, time, measure)
            here = there
        if landing is None:
            self.wait = longer(self.wait)
        else:
            self.wait = 0
            period(landing.start)  # so that it is the last
        if self.periods < self.OVER:
            self.periods, self.trend = self.OVER, None
        return landing

    def _onward(self, here: Mean) -> MeanTrend:
        """The trend from a mean on: that of the last leap, if there is one."""
        if self.trend is None:
            return MeanTrend(here.change, 0.0, np.zeros_like(here.change))
        return self.trend._replace(change=here.change)

    def _mean(self, period: Period, state: FloatArray, settle: int, measure: Measure) -> Mean | None:
        """Of many periods from a state on, after some to settle; None where it stops, or does not move."""
        t = (np.arange(self.OVER) + 0.5) / self.OVER
        weights = np.exp(-1.0 / (t * (1.0 - t)))
        weights /= weights.sum()
        change, alike, signature = np.zeros_like(state), 0, -1
        for k in range(-settle, self.OVER + self.SETTLE):
            there = period(state)
            if there is None:
                return None
            start, step = state, there
            state = start + step.change
            if 0 <= k < self.OVER:
                change += weights[k] * step.change
            alike, signature = alike + 1 if step.signature == signature else 1, step.signature
            if k >= self.OVER - 1 and alike >= self.ALIKE:
                break
        if not measure.size(change) > 0.0:
            return None
        return Mean(change, k + 1 - 0.5 * self.OVER, start, step)
