"""Leaps over many periods: along a linear recurrence of the last changes, and along the map of a period.

Every leap predicts what a period does where it ends, and is taken only where that comes true. A leap moves
a joint for good in what no cycle changes; so the more it moves, the better it has to be known.

Of a motion that changes in several slow ways at once the map of a period is followed by its slopes. Such a
leap goes the way that the motion goes, as far as the map is seen to bend on it. It assumes no limit, so that
a motion that lingers where it might have come to rest is followed through.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import comb
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import EPS, MINOR, NEGLIGIBLE, NOTABLE, ROUND_OFF, THREE_DIGITS, FloatArray
from shakedown.long_term.space.followed_cycles import STATE_ROUND_OFF, Measure, Period, product

LEAST_GAIN = 8.0  # periods that a leap must gain at least, as it costs some, and so does its preparation
LEAP_ERROR = 1e-5  # uncertainty allowed in a leap, relative to the total slip so far
TRIES = 3  # periods after a leap within which its prediction must come true


class Leap(NamedTuple):
    """Where to continue, and a test of whether the leap was right.

    Attributes
    ----------
    start : (N,)
        The state [length].
    fits
        Whether the next period from there, of those in a row, changes the state as predicted.
    error, error_apart
        How far the state may be off, with rigid slip and apart from it [length].
    rate
        Factor per period by which changes shrink.
    """

    start: FloatArray
    fits: Callable[[FloatArray], bool]
    error: float
    error_apart: float
    rate: float


def longer(wait: int) -> int:
    """Periods to wait after a further leap that fails, twice as many as after the one before."""
    return min(2 * wait + 5, 64)  # periods


def recurrence_of(states: FloatArray, root: FloatArray) -> Callable[[int], tuple[FloatArray, FloatArray]]:
    """How states x_0, …, x_k go on: the state a number of steps ahead, and the change that follows it, (N,).

    By the recurrence Δ_{j+1} = Σ c_i Δ_{j−r+i} of the changes Δ_j = x_{j+1} − x_j that fits the last one best
    to those before it. Where the map is affine on the span of the changes, and the sequence has gone through
    all of it, it goes on exactly so (minimal polynomial extrapolation). What the map leaves alone (linear
    functions of the state that no cycle changes) is kept.

    Parameters
    ----------
    states : (k + 1, N)
        x_0, …, x_k.
    root : (M, N)
        A change Δ counts for ‖root Δ‖.

    Examples
    --------
    >>> states = np.array([[1.0, 0.0], [0.5, 1.0], [0.25, 1.5], [0.125, 1.75]])
    >>> state, change = recurrence_of(states, np.eye(2))(1)
    >>> state.round(9), change.round(9)
    (array([0.0625, 1.875 ]), array([-0.03125,  0.0625 ]))
    """
    changes = np.diff(states, axis=0)
    seen = product(root, changes)
    seen = seen / (float(np.abs(seen).max()) or 1.0)
    # relative to the largest: smaller singular values of the changes are round-off
    weights = np.linalg.lstsq(seen[:-1].T, seen[-1], rcond=10 * ROUND_OFF)[0]
    r, last_changes = len(weights), changes[1:]
    # One step: coefficients of the last changes in the coming ones, and in their sum.
    one = np.zeros((r + 1, r + 1))
    one[: r - 1, 1:r] = np.eye(r - 1)
    one[r - 1 :, :r] = weights
    one[r, r] = 1.0

    def ahead(count: int) -> tuple[FloatArray, FloatArray]:
        many = np.linalg.matrix_power(one, count)[:, :r]
        return states[-1] + many[r] @ last_changes, (weights @ many[:r]) @ last_changes

    return ahead


@dataclass
class RecurrenceLeaps:
    """Leaps along a linear recurrence of the last changes, as far as two of them agree.

    Any number of modes, fast and slow, in as many periods ahead as leave something to be seen.

    Attributes
    ----------
    care
        Share of what leaps may be uncertain by otherwise.
    reach, count
        Periods that the next leap goes ahead at most, and that the last one went.
    since, wait
        From which cycle on the next one is tried, and how many after the last that failed.
    missed : (r,)
        Rigid slip by which a period after the leap differs from its prediction [length].
    """

    FEWEST: ClassVar[int] = 5  # states
    AGREE: ClassVar[float] = 1e-4  # largest difference of two recurrences, relative to the leap …
    ROUGHLY: ClassVar[float] = 0.03  # … and where the leap is short compared with the total slip
    ALIKE: ClassVar[float] = 0.1  # relative to the predicted change
    LEFT: ClassVar[float] = 1e-3  # least size of the change after a leap, relative to the last change
    GROWN: ClassVar[float] = 2.0  # and the largest
    FURTHER: ClassVar[int] = 4  # factor on the length after an accepted leap; inverse after a rejected one

    care: float = 1.0
    reach: int = 64
    count: int = 0
    since: int = 0
    wait: int = 0
    missed: FloatArray = field(default_factory=lambda: np.zeros(0))

    def plan(self, window: FloatArray, measure: Measure, cycles: int) -> Leap | None:
        """Leap as far as the recurrences of the last states, and of those one period before, agree."""
        if len(window) < self.FEWEST or cycles < self.since:
            return None
        ahead, earlier = recurrence_of(window, measure.root), None
        x, now, whole = window[-1], measure.size(ahead(0)[1]), measure.size(window[-1])
        found, count = None, int(LEAST_GAIN)
        while now > 0.0 and count <= self.reach:
            state, change = ahead(count)
            way, share = measure.size(state - x), measure.size(change) / now
            if not (0.0 < way < np.inf and self.LEFT <= share <= self.GROWN):  # mostly so: it fades fast
                break
            earlier = earlier or recurrence_of(window[:-1], measure.root)
            other, _ = earlier(count + 1)
            differ = measure.deviation(other - x, state - x, way)
            allowed = self.care * max(self.AGREE, min(self.ROUGHLY, LEAP_ERROR * whole / way))
            if not differ <= min(allowed, share):
                break
            found, self.count = (state, share, state - other), count
            count *= 2
        if found is None:
            return None
        (state, share, off), steps = found, iter(range(self.count, self.count + TRIES))

        def fits(change: FloatArray) -> bool:
            missed = change - ahead(next(steps))[1]
            self.missed = np.abs(measure.rigid.T @ missed)
            return measure.size(missed) <= self.ALIKE * share * now

        rate = min(share ** (1.0 / self.count), 1.0)
        apart = float(np.abs(measure.without_rigid(off)).max())
        return Leap(state, fits, float(np.abs(off).max()), apart, rate)

    def rigid_error(self, measure: Measure) -> float:
        """Rigid slip that the last leap may be off, as a period at its end was off so much [length]."""
        return float((np.abs(measure.rigid) @ (self.count * self.missed)).max())

    def adapt(self, taken: bool, cycles: int) -> None:
        """Adapt the length of the next leap."""
        self.reach = self.count * self.FURTHER if taken else self.count // self.FURTHER
        if taken:
            self.wait = 0
        elif self.reach < LEAST_GAIN:
            self.reach, self.wait = int(LEAST_GAIN) * self.FURTHER, longer(self.wait)
        self.since = cycles + self.wait


COMPARABLE = 8.0  # so many times the length of a leap before it, or that share, they show how it is bent
TESTED = 0.75, 1.0  # shares of a way at which its polynomial is put to the test
MOST_EARLIER = 3  # samples of the remainder from before a leap
SHARES = 0.25, 0.5, 1.0  # of a way, at which the remainder is sampled; one less for each earlier sample
MOST_POWERS = MOST_EARLIER + len(SHARES)
PASCAL = np.array([[comb(i, j) for j in range(MOST_POWERS)] for i in range(MOST_POWERS)], dtype=float)


Follow = Callable[[FloatArray], Period | None]  # a period from a state on; None where the motion stops


def moved_by_slips(stiffness: FloatArray, places: NDArray[np.intp], free: NDArray[np.intp]) -> FloatArray:
    """What the slips at some places of a state move of it, (N, k).

    Themselves, and the slips and gaps of open nodes at the places ``free``, which stay in equilibrium.
    """
    moves = np.zeros((len(stiffness), len(places)))
    moves[places, np.arange(len(places))] = 1.0
    if len(free):
        moves[free] = -np.linalg.lstsq(stiffness[np.ix_(free, free)], stiffness[np.ix_(free, places)])[0]
    return moves


class Samples(NamedTuple):
    """What the remainder r is, (i, k) [length], at shares of a way, negative where they lie before it."""

    shares: FloatArray
    values: FloatArray

    def first(self, count: int) -> "Samples":
        """The first of them."""
        return Samples(self.shares[:count], self.values[:count])

    def polynomial(self) -> FloatArray:
        """Coefficients b, (i, k), so that r = Σ b_i sⁱ⁺¹ there."""
        powers = self.shares[:, None] ** np.arange(1, len(self.shares) + 1)
        return np.asarray(np.linalg.solve(powers, self.values), dtype=float)


@dataclass(frozen=True)
class LocalMap:
    """What a period changes next to a state u: F(u + y) = F + D y + r(y), for changes y of some slips.

    Attributes
    ----------
    follow
        Follows one.
    measure
        What counts of a change.
    start : (N,)
        u [length].
    places : (k,), moves : (N, k)
        Where the slips stand in a state, and what each moves of it (:func:`moved_by_slips`).
    change : (k,)
        F [length].
    slopes : (k, k)
        D.
    signature
        Of the contact states in the period from u.
    """

    follow: Follow
    measure: Measure
    start: FloatArray
    places: NDArray[np.intp]
    moves: FloatArray
    change: FloatArray
    slopes: FloatArray
    signature: int

    def at(self, y: FloatArray) -> FloatArray:
        """The state u + y."""
        return np.asarray(self.start + self.moves @ y)

    def size(self, y: FloatArray) -> float:
        """Of a change, by energy; inf where it is out of all bounds, as drift of very many periods is."""
        # most periods that a drift is followed at once
        if not np.abs(y).max() <= max(np.abs(self.start).max(), 2.0**20 * np.abs(self.change).max()):
            return np.inf
        return self.measure.size(self.at(y) - self.start)

    def linear(self, y: FloatArray) -> FloatArray:
        """F + D y."""
        return np.asarray(self.change + self.slopes @ y)

    def remainder(self, y: FloatArray) -> tuple[FloatArray, bool]:
        """r(y), (k,), by a period from there, and whether it has the same contact states.

        NaN where none can be followed, or where other nodes slip.
        """
        there = self.follow(self.at(y)) if self.size(y) < np.inf else None
        if there is not None:
            other = there.change - self.moves @ there.change[self.places]
            if not other.any() or self.measure.size(other) <= THREE_DIGITS * self.measure.size(there.change):
                same = there.signature == self.signature
                return there.change[self.places] - self.linear(y), same
        return np.full_like(y, np.nan), False

    def sampled(self, periods: int, polynomial: FloatArray, earlier: Samples) -> tuple[Samples, bool]:
        """The remainder sampled on a way so many periods long, and earlier; whether no contact state changes.

        Parameters
        ----------
        periods
            The length of the way.
        polynomial
            The remainder as far as it is known, which tells where the way leads.
        earlier
            Samples from before it.
        """
        shares = SHARES[min(len(earlier.shares), len(SHARES) - 1) :]
        seen = [self.remainder(self.ahead(periods, polynomial, share)) for share in shares]
        values = np.vstack([[remainder for remainder, _ in seen], earlier.values])
        return Samples(np.append(shares, earlier.shares), values), all(same for _, same in seen)

    def ahead(self, periods: int, polynomial: FloatArray, share: float = 1.0) -> FloatArray:
        """y after a share of so many periods, if r = Σ b_i sⁱ⁺¹ after the share s of them."""
        k, powers = len(self.change), len(polynomial) + 1
        one = np.zeros((k + powers, k + powers))  # a period: of y, 1, j, j², …
        one[:k, :k] = np.eye(k) + self.slopes
        one[:k, k] = self.change
        one[:k, k + 1 :] = (polynomial / float(periods) ** np.arange(1, powers)[:, None]).T
        one[k:, k:] = PASCAL[:powers, :powers]
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(np.linalg.matrix_power(one, int(share * periods))[:k, k])


@dataclass
class SlopeLeaps:
    """Leaps along the map of a period: its slopes, and its remainder as states on the way show it.

    Attributes
    ----------
    care
        Share of what leaps may be uncertain by otherwise.
    periods
        How far the next one is tried to go.
    since, wait
        From which cycle on the next one is tried, and how many after the last that led nowhere.
    starts, gone, end
        The maps where the last leaps began, after how many periods; those gone in all, and to which state.
    """

    MOST_SLIPS: ClassVar[int] = 64  # of moving nodes: each takes a period to see its slope
    SURE: ClassVar[float] = 0.03  # of the change at the end of a leap: what it may miss
    AT_EASE: ClassVar[float] = 0.3  # strain that is aimed at: what is missed, relative to what may be …
    ORDER: ClassVar[int] = 5  # … as this power of the length of a leap, at least, it grows
    TIMES: ClassVar[tuple[float, ...]] = 0.25, 0.5, 2.0  # as long: least, most after a failure, most
    SWEEPS: ClassVar[int] = 8  # in which the remainder is sampled, each on the way that the last one leads …
    SHRINKS: ClassVar[float] = 0.5  # … while they change it so much less than two sweeps before, and never …
    BENT: ClassVar[float] = 0.5  # … by more than this, relative
    LEFT: ClassVar[float] = 1e-3  # of the change: less of it counts as none
    GROWN: ClassVar[float] = 4.0  # and most: nodes may begin and cease to slip between what is looked at

    care: float = 1.0
    periods: int = int(LEAST_GAIN)
    since: int = 0
    wait: int = 0
    starts: deque[tuple[LocalMap, int]] = field(default_factory=lambda: deque(maxlen=16))
    gone: int = 0
    end: FloatArray = field(default_factory=lambda: np.zeros(0))

    def leap(
        self, local: LocalMap, first: Period, at_leap_end: Callable[[], None]
    ) -> tuple[float, float] | None:
        """As far as what it predicts comes true, again and again by the same slopes; None if that is not far.

        The period that is followed last begins where the leap ends. Returned are how far that state may be
        off [length], and the factor per period by which changes shrink.

        Parameters
        ----------
        local, first
            The map next to a state, whose slopes are not known yet, and the period from that state.
        at_leap_end
            Called at every state that was predicted, after the period from there.
        """
        size = local.measure.size
        if self.starts and size(local.start - self.end) > LEAST_GAIN * size(first.change):
            self.starts.clear()  # the last leap has not ended here, but for a few periods
        known = self._with_slopes(local)
        taken, error = None, 0.0
        while known is not None and self.periods >= LEAST_GAIN:
            found, strain = self._leap_end(known, self.periods)
            if found is not None:
                end, off, rate = found
                at_leap_end()
                error, self.wait = error + off, 0
                taken = error, rate
                self.starts.append((known, self.gone))
                self.gone, self.end, known = self.gone + self.periods, end.start, end
            self.periods = self._next_length(self.periods, strain, found is None)
            if found is None and taken is not None:
                local.follow(known.start)  # so that it is the last
            if strain > self.AT_EASE and taken is not None:
                break
        if taken is None:
            self.wait = longer(self.wait)
            self.starts.clear()
        self.periods = max(self.periods, int(LEAST_GAIN))
        return taken

    def _next_length(self, periods: int, strain: float, failed: bool) -> int:
        """How many periods to try next, after a leap of so many with this strain."""
        least, less, more = self.TIMES
        times = (self.AT_EASE / max(strain, EPS)) ** (1.0 / self.ORDER)
        # most periods that a leap goes ahead
        return min(int(periods * min(max(times, least), less if failed else more)), 2**40)

    def _allowed(self, start: FloatArray, way: float, measure: Measure) -> float:
        """What the change at the end of a leap may miss, relative to the change at its beginning."""
        return self.care * max(THREE_DIGITS, LEAP_ERROR * measure.size(start) / way)

    def _with_slopes(self, local: LocalMap) -> LocalMap | None:
        """The map next to a state, by a period from each of the states next to it; None where one stops."""
        start, places, moves, measure = local.start, local.places, local.moves, local.measure
        # finite-difference step for slopes, relative to all slip; at least round-off of the state
        most = 10.0 * NEGLIGIBLE * measure.size(start)
        least = STATE_ROUND_OFF * float(np.abs(start).max())
        sizes = np.maximum(most / np.linalg.norm(measure.root @ moves, axis=0), least)
        slopes = np.zeros_like(local.slopes)
        # A little behind the nodes that creep on: they slip in all the states next to it.
        toward = local.change.reshape(-1, len(start) // len(measure.slips) - 1)
        away = np.linalg.norm(toward, axis=1, keepdims=True)
        # four times as far behind as states are moved
        behind = start - moves @ (4.0 * sizes * (toward / np.where(away > 0.0, away, 1.0)).ravel())
        here, base = start, local.change
        there = local.follow(behind)
        if there is not None and there.signature == local.signature:
            here, base = behind, there.change[places]
        for k, place in enumerate(places):
            # factors of the step, tried until both points have the same contact states: no kink between them
            for share in (1.0, -1.0, 1e-2, -1e-2, 1e-4):
                moved = here + share * sizes[k] * moves[:, k]
                there = local.follow(moved)
                if there is None:
                    return None
                slopes[:, k] = (there.change[places] - base) / (moved[place] - here[place])
                if there.signature == local.signature:
                    break
        rigid = measure.rigid[places]
        if np.linalg.norm(rigid) ** 2 > rigid.shape[1] * (1.0 - THREE_DIGITS):  # all nodes move
            slopes -= (slopes @ rigid) @ rigid.T
        return replace(local, slopes=slopes)

    def _leap_end(self, local: LocalMap, periods: int) -> tuple[tuple[LocalMap, float, float] | None, float]:
        """So many periods ahead, or None, and the strain: what is missed there, relative to what may be.

        The map there, how far it may be off [length], and the factor per period by which changes shrink.
        """
        found, strain = self._polynomial(local, periods, self._earlier(local, periods)), 0.0
        if found is None:
            return None, np.inf
        polynomial, missed = found
        end = local.ahead(periods, polynomial)
        now, way, change = local.size(local.change), local.size(end), local.change
        allowed, error, left = self._allowed(local.start, way, local.measure), 0.0, now
        if missed is not None:
            strain = NOTABLE * local.size(missed) / way / allowed
            error = NOTABLE * float(np.abs(missed).max())
        for share in TESTED if missed is None else TESTED[-1:]:
            if not strain <= 1.0:
                return None, strain
            y = end if share == 1.0 else local.ahead(periods, polynomial, share)
            there = local.follow(local.at(y))
            if there is None:
                return None, np.inf
            remainder = share ** np.arange(1, len(polynomial) + 1) @ polynomial
            predicted = local.moves @ (local.linear(y) + remainder)
            left = max(local.measure.size(there.change), self.LEFT * now)
            deviation = local.measure.deviation(there.change, predicted, left)
            strain = max(strain, deviation / min(self.SURE, allowed * now / left))
            error = max(error, float(np.abs(there.change - predicted).max()) * way / now)
            change = there.change[local.places]
        if left > self.GROWN * now or not strain <= 1.0:
            return None, strain
        rate = min((left / now) ** (1.0 / periods), 1.0)
        return (replace(local, start=local.at(end), change=change), error, rate), strain

    def _polynomial(
        self, local: LocalMap, periods: int, earlier: Samples
    ) -> tuple[FloatArray, FloatArray | None] | None:
        """The remainder on the way so many periods ahead, sampled in sweeps; None where it does not converge.

        Where no contact state changes on it, as far as is seen, and enough lies before it to predict it, also
        by how much that has predicted another end, (k,) [length].
        """
        polynomial = earlier.polynomial()
        end = first_end = local.ahead(periods, polynomial)
        off = [np.inf, np.inf]
        for _ in range(self.SWEEPS):
            before, (samples, smooth) = end, local.sampled(periods, polynomial, earlier)
            polynomial, smooth = samples.polynomial(), smooth and len(earlier.shares) == MOST_EARLIER
            end = local.ahead(periods, polynomial)
            size = local.size(end)
            if not 0.0 < size < np.inf:
                return None
            off.append(local.size(end - before) / size)
            if not off[-1] <= self.BENT:  # what lies before misleads, unless something begins or ends to slip
                return self._polynomial(local, periods, earlier.first(0)) if smooth else None
            converged = off[-1] <= MINOR * self._allowed(local.start, size, local.measure)
            if converged or off[-1] > self.SHRINKS * off[-3]:
                break
        if not off[-1] <= self.SURE:
            return None
        return polynomial, end - first_end if smooth else None

    def _earlier(self, local: LocalMap, periods: int) -> Samples:
        """What the states at which the last leaps began show of the remainder."""
        shares, values = [], []
        for before, gone in reversed(self.starts):
            back = (self.gone - gone) / periods
            alike = np.array_equal(before.moves, local.moves)  # slips, and open nodes
            if alike and 1.0 / COMPARABLE <= back <= COMPARABLE:
                shares.append(-back)
                values.append(before.change - local.linear((before.start - local.start)[local.places]))
        return Samples(np.array(shares), np.array(values).reshape(-1, len(local.change))).first(MOST_EARLIER)
