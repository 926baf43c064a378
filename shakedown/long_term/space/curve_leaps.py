"""Leaps of a motion that changes by little from period to period, always the same way: along a curve.

With F the change per period, the limit is |F| / (1 − rate) away where F falls along a line, and a times
as far where |F| falls like the a-th power of the distance: a is seen from leap to leap (Newton's method
at a multiple root). So slow a sequence of states is one curve, of which every leap shows the tangent at
both ends; how fast it is passed does not matter.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from shakedown.ground.constants import EPS, ERROR_FACTOR, MUCH, THREE_DIGITS, FloatArray
from shakedown.long_term.space.measure import Measure
from shakedown.long_term.space.recurrence_leaps import PRICE, WORTH, Leap


@dataclass(frozen=True)
class CurveStep:
    """A leap along the curve of a motion: a parabola from its start.

    Attributes
    ----------
    left
        How far the limit seemed by the slope of the changes [energy norm].
    length
        How far the leap goes [energy norm].
    tangent, turning, turned_before : (N,)
        The tangent of the curve, by how much it is predicted to turn on the leap, and by how much it turned
        before, all per unit of length.
    expected
        Of the change before the leap in that after it, as predicted …
    share
        … and as found.
    end_tangent : (N,)
        The tangent at the end; None where the change there has not the predicted size.
    """

    left: float
    length: float
    tangent: FloatArray
    turning: FloatArray
    turned_before: FloatArray
    expected: float
    share: float = np.nan
    end_tangent: FloatArray | None = None

    @property
    def turned(self) -> FloatArray:
        """By how much the tangent has turned from one end to the other, per unit of length."""
        assert self.end_tangent is not None
        return np.asarray((self.end_tangent - self.tangent) / self.length)


@dataclass
class CurveLeaps:
    """Leaps of a slow motion by most of the distance to its limit, as far as the last leaps came true.

    Attributes
    ----------
    care
        Share of what leaps may be uncertain by otherwise.
    trust
        A share e^-trust of the distance to the limit remains.
    power
        a.
    since
        From which cycle on the next leap is tried.
    refused
        Whether the last one was not taken.
    step, last
        The leap that is tried, and the last one that was taken.
    fresh
        Whether the tangent where that has ended is still to be corrected by what follows.
    turned : (N,)
        By how much the tangent turned on a leap that was refused for it, per unit of length.
    """

    TRIES: ClassVar[int] = 12
    SLOW: ClassVar[float] = 0.03  # largest relative change of F per period
    STEADY: ClassVar[float] = 0.2  # relative to that: its own change, and the rotation of F
    FADING: ClassVar[float] = 0.8  # factor per period from which on deviations still die away after a leap
    SLACK: ClassVar[float] = 0.3  # deviation of |F| from its prediction that is accepted, relative
    OVERSHOT: ClassVar[float] = 0.125  # relative to the prediction: less means at the limit, or beyond
    AS_EXPECTED: ClassVar[float] = 0.25  # relative to the prediction
    LARGEST_POWER: ClassVar[float] = 8.0
    LONGER: ClassVar[float] = 8.0  # times the last leap, at most
    TRUST: ClassVar[tuple[float, float, float]] = 0.25, 2.0, 7.0  # after failed leaps, at first, at most
    PAUSE: ClassVar[int] = 32  # periods

    care: float = 1.0
    trust: float = TRUST[1]
    power: float = 1.0
    since: int = 0
    refused: bool = False
    step: CurveStep | None = None
    last: CurveStep | None = None
    fresh: bool = False
    turned: FloatArray | None = None

    def plan(self, window: FloatArray, measure: Measure, cycles: int) -> Leap | None:
        """Leap most of the distance to the limit, depending on the success of earlier leaps."""
        if len(window) < 4 or cycles < self.since:
            return None
        changes, last = np.diff(window, axis=0), self.last
        size, slope = measure.size(changes[-1]), self._slope(changes, measure)
        seen = slope is not None
        if slope is None:
            slope = self._slope_since(changes, measure)
        if slope is None:
            return None
        tangent, towards = changes[-1] / size, slope > 0.0
        left = size / max(abs(slope), EPS)
        turning, most = np.zeros_like(tangent), measure.size(window[-1])
        if last is not None:
            turning, most = (tangent - last.tangent) / last.length, min(self.LONGER * last.length, most)
            if seen and self.fresh and towards:
                power = last.length / (last.left - left) if last.left > left else 1.0
                self.power = min(max(power, 1.0), self.LARGEST_POWER)
            self.fresh = False
        if self.turned is not None:
            turning = self.turned
        power = self.power if towards else 1.0
        length = min(-np.expm1(-self.trust) * power * left, most)
        if length < WORTH * size:
            self.trust, self.refused = max(self.trust, self.TRUST[0]), False
            self.since = cycles + self.PAUSE
            return None
        expected = (1.0 - length / (power * left)) ** power if towards else 1.0 + length / left
        before = (tangent - changes[0] / measure.size(changes[0])) / measure.size(window[-1] - window[1])
        self.step = CurveStep(left, length, tangent, turning, before, expected)
        turn = self.care * min(MUCH, max(THREE_DIGITS, PRICE * measure.size(window[-1]) / length))
        return Leap(
            start=window[-1] + length * (tangent + 0.5 * length * turning),
            fits=self._fits(self.step, size * (tangent + length * turning), turn, measure),
            error=0.5 * turn * length * float(np.abs(tangent).max()),
            error_apart=0.5 * turn * length * float(np.abs(measure.without_rigid(tangent)).max()),
            rate=min(1.0, 1.0 - slope),
        )

    def _slope(self, changes: FloatArray, measure: Measure) -> float | None:
        """By how much the change falls per period, relative; None where it is not slow, or nothing tells.

        From the last periods: over as many as it takes to see it beside the errors of the integration.
        """
        sizes, last = [measure.size(change) for change in changes], len(changes) - 1
        if min(sizes) == 0.0:
            return None
        for j in range(1, last // 2 + 1):
            a, b, c = sizes[last - 2 * j], sizes[last - j], sizes[last]
            slope = float(1.0 - (c / a) ** (0.5 / j))
            ends = changes[last] / c, changes[last - j] / b, changes[last - 2 * j] / a
            turned = max(measure.size(ends[0] - ends[1]), measure.size(ends[1] - ends[2]))
            if max(turned, abs(c / b - b / a)) / j <= self.STEADY * abs(slope) <= self.STEADY * self.SLOW:
                return slope
        return None

    def _slope_since(self, changes: FloatArray, measure: Measure) -> float | None:
        """The slope since the last leap, where it is too small to be seen from period to period."""
        if self.last is None or len(changes) < 4 or not 0.0 < self.last.share < 0.9:
            return None
        before, now = measure.size(changes[-2]), measure.size(changes[-1])
        if not (before > 0.0 and now > 0.0):
            return None
        left = self.last.share ** (1.0 / self.power)
        slope = self.power * (1.0 - left) / left * now / self.last.length
        turned = measure.size(changes[-1] / now - changes[-2] / before)
        return slope if turned <= MUCH and slope <= self.SLOW else None

    def _fits(
        self, step: CurveStep, expected: FloatArray, turn: float, measure: Measure
    ) -> Callable[[FloatArray], bool | None]:
        """Whether a change has the predicted direction, and a share of the predicted size."""
        whole, direction, before = measure.size(expected), measure.seen(expected), np.inf
        least = max(self.OVERSHOT * step.expected, step.expected - self.SLACK)

        def fits(change: FloatArray) -> bool | None:
            nonlocal before
            share = float(measure.seen(change) @ direction) / whole**2
            if share == 0.0:
                return None
            off = measure.deviation(change, share * expected, whole) / abs(share)
            fades, before = off <= self.FADING * before, off
            right = least <= share <= step.expected + self.SLACK
            if fades and not (right and off <= turn):
                self.step = replace(step, share=share)
                return False
            end = change / measure.size(change) if right else None
            self.step = replace(step, share=share, end_tangent=end)
            return True if right and off <= turn else None

        return fits

    def rigid_error(self, measure: Measure) -> float:
        """Rigid slip by which a leap that is taken may miss the curve of the motion [length].

        A leap is a parabola through the tangents at its ends; the curve may turn otherwise, as before it.
        """
        step = self.step
        assert step is not None
        otherwise = np.minimum(np.abs(step.turned - step.turned_before), np.abs(step.turned))
        off = step.length**2 * (0.5 * np.abs(step.turned - step.turning) + ERROR_FACTOR / 6.0 * otherwise)
        return float(np.abs(measure.rigid).T.max(axis=1, initial=0.0) @ (np.abs(measure.rigid).T @ off))

    def adapt(self, taken: bool, cycles: int) -> None:
        """Increase or reduce the trust in leaps."""
        step = self.step
        assert step is not None
        if taken:
            if not self.refused and abs(step.share - step.expected) <= self.AS_EXPECTED * step.expected:
                self.trust = min(2.0 * self.trust, self.TRUST[2])
            self.last, self.fresh, self.refused, self.turned = step, True, False, None
            return
        # Where only the direction was wrong, the way there is as far as the tangents at both ends tell.
        turned = None if step.end_tangent is None else step.turned
        if self.turned is not None or turned is None:
            self.trust /= 2.0
        self.turned, self.refused, self.since = turned, True, cycles + 1

    def forget(self) -> None:
        """Forget the last leap, as after one of another kind."""
        self.last, self.power, self.fresh, self.turned = None, 1.0, False, None

    def rigid_correction(self, window: FloatArray, measure: Measure) -> FloatArray | None:
        """Rigid slip by which the last leap missed the curve, by its tangents at both ends; None: unseen.

        Nothing else tells, as cycles are the same wherever the joint stands.
        """
        last, rigid = self.last, measure.rigid
        if not self.fresh or last is None or not rigid.shape[1] or len(window) < 4:
            return None
        changes = np.diff(window, axis=0)
        if self._slope(changes, measure) is None:
            return None
        turned = (changes[-1] / measure.size(changes[-1]) - last.tangent) / last.length
        self.last = replace(last, turning=turned)
        return np.asarray(rigid @ (rigid.T @ (0.5 * last.length**2 * (turned - last.turning))))
