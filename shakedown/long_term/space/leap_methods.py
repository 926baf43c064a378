"""Leaps from the last states of a motion to those that it would reach many periods later.

Both ways to leap foresee what a period does where they lead, and hold on to it only where it does so.
A leap moves a joint for good in what no cycle changes; so the more it moves, the better it has to be known.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import sqrt
from typing import ClassVar, NamedTuple

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS, MISJUDGED, MUCH, NEGLIGIBLE, THREE_DIGITS
from shakedown.joint.derived import once_per_problem
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import free_stiffness, rigid_slips
from shakedown.long_term.space.extrapolation import recurrence_of, seen_by

WORTH = 8.0  # periods that a leap must gain at least, as it costs some, and so does its preparation
PRICE = 1e-5  # uncertainty allowed in a leap, relative to the total slip so far
REMEMBERED = 64  # sizes of changes
STATE_ROUND_OFF = 64.0 * EPS  # relative to a state: smaller changes are none
LONGEST_WAIT = 64  # periods


@dataclass(frozen=True)
class Measure:
    """A measure for changes of a state: the energy that they store, in which rigid slips do not count.

    Attributes
    ----------
    root : (M, N)
        By columns: RᵀR = κ in units of a power of two: a change d has the size ‖R d‖ [√(force × length)].
    rigid : (N, r)
        Slips that change no reaction, orthonormal: cycles are the same wherever these stand.
    slips : (n,)
        √ of the largest stiffness of each node, whose slip counts for what it would store.
    largest
        ‖R‖, of all entries.
    known
        The sizes of the last changes.
    """

    root: FloatArray
    rigid: FloatArray
    slips: FloatArray
    largest: float
    known: dict[bytes, float] = field(default_factory=dict, repr=False)

    @property
    def directions(self) -> int:
        """Of the slip of a node."""
        return self.root.shape[1] // len(self.slips) - 1

    def size(self, change: FloatArray) -> float:
        """The size of a change of the state; the last ones are kept, each being needed several times."""
        change = np.ascontiguousarray(change)
        found = self.known.get(key := change.tobytes())
        if found is None:
            seen = self.seen(change)
            found = sqrt(seen.dot(seen))  # as np.linalg.norm
            if len(self.known) >= REMEMBERED:
                self.known.clear()
            self.known[key] = found
        return found

    def seen(self, changes: FloatArray) -> FloatArray:
        """R d of changes (…, N), (…, k)."""
        return seen_by(self.root, changes)

    def at_most(self, change: FloatArray) -> float:
        """An upper bound of ``terms``, without the product."""
        return 2.0 * self.largest * float(np.linalg.norm(change))

    def terms(self, change: FloatArray) -> float:
        """‖|R| |d|‖, to which the round-off of a size is relative."""
        return float(np.linalg.norm(np.abs(self.root) @ np.abs(change)))

    def is_rigid(self, change: FloatArray) -> bool:
        """Whether what a change of one slip does to the reactions is undone by what others do."""
        return self.size(change) <= THREE_DIGITS * self.terms(change)

    def apart(self, change: FloatArray) -> float:
        """The largest entry of a change, rigid slip apart [length]."""
        return float(np.abs(change - self.rigid @ (self.rigid.T @ change)).max())

    def misses(self, change: FloatArray, foreseen: FloatArray, size: float) -> float:
        """The deviation of a change from another one of this size, relative to it; rigid slips included."""
        off = self.size(change - foreseen) / size
        if not self.rigid.shape[1]:
            return off
        return max(off, float(np.linalg.norm(change - foreseen) / np.linalg.norm(foreseen)))


@once_per_problem
def measure_of(problem: Problem) -> Measure:
    """The measure for changes of the states of a joint."""
    stiffness, layout = free_stiffness(problem), problem.layout
    # In a unit of its own, as roots of odd powers of two are rounded.
    stiffness = np.ldexp(stiffness, -np.frexp(np.diag(stiffness).max())[1])
    if problem.C is None:  # gaps stay zero
        stiffness[layout.gaps] = stiffness[:, layout.gaps] = 0.0
    diagonal = np.diag(stiffness)
    own = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(0.5 * (stiffness + stiffness.T) / own / own[:, None])
    kept = values > NEGLIGIBLE * values[-1]
    motions = rigid_slips(problem).motions
    rigid = np.zeros((layout.size, motions.shape[1]))
    rigid[layout.slips] = np.linalg.qr(motions)[0] if motions.shape[1] else motions
    stiffest = diagonal[layout.slips].reshape(problem.n, -1).max(axis=1)
    root = np.asfortranarray(np.sqrt(values[kept])[:, None] * vectors[:, kept].T * own)
    return Measure(root, rigid, np.sqrt(stiffest), float(np.linalg.norm(root)))


class Leap(NamedTuple):
    """Where to continue, and a test of whether the leap was right.

    Attributes
    ----------
    start : (N,)
        The state [length].
    fits
        Whether the next period from there, of those in a row, changes the state as foreseen; None: hopeless.
    unsure, apart
        How far the state may be off, with rigid slip and apart from it [length].
    rate
        Factor per period by which changes shrink.
    """

    start: FloatArray
    fits: Callable[[FloatArray], bool | None]
    unsure: float
    apart: float
    rate: float


@dataclass
class Ahead:
    """Leaps along a linear recurrence of the last changes, as far as two of them agree.

    Any number of modes, fast and slow, in as many periods ahead as leave something to be seen.
    """

    TRIES: ClassVar[int] = 3  # periods after a leap within which the prediction must come true
    FEWEST: ClassVar[int] = 5  # states
    AGREE: ClassVar[float] = 1e-4  # largest difference of two recurrences, relative to the leap …
    ROUGHLY: ClassVar[float] = 0.03  # … and where the leap is short compared with the total slip
    ALIKE: ClassVar[float] = 0.1  # relative to the predicted change
    LEFT: ClassVar[float] = 1e-3  # least size of the change after a leap, relative to the last change
    GROWN: ClassVar[float] = 2.0  # and the largest
    FURTHER: ClassVar[int] = 4  # factor on the length after an accepted leap; inverse after a rejected one

    care: float = 1.0  # share of what leaps may be unsure by otherwise
    reach: int = 64
    wait: int = 0
    since: int = 0
    count: int = 0
    missed: FloatArray = field(default_factory=lambda: np.zeros(0))  # of rigid slip, in a period after a leap

    def plan(self, window: FloatArray, measure: Measure, cycles: int) -> Leap | None:
        """Leap as far as the recurrences of the last states, and of those one period before, agree."""
        if len(window) < self.FEWEST or cycles < self.since:
            return None
        root, size = measure.root, measure.size
        recurrence, earlier = recurrence_of(window, root), None
        x, now, whole = window[-1], size(recurrence.change), size(window[-1])
        found, count = None, int(WORTH)
        while now > 0.0 and count <= self.reach:
            state, change = recurrence.ahead(count)
            way, share = size(state - x), size(change) / now
            if not (0.0 < way < np.inf and self.LEFT <= share <= self.GROWN):  # mostly so: it fades fast
                break
            earlier = earlier or recurrence_of(window[:-1], root)
            other, _ = earlier.ahead(count + 1)
            differ = measure.misses(other - x, state - x, way)
            if differ > self.care * max(self.AGREE, min(self.ROUGHLY, PRICE * whole / way)):
                break
            if not differ <= share:
                break
            found, self.count = (state, share, state - other), count
            count *= 2
        if found is None:
            return None
        (state, share, off), steps = found, iter(range(self.count, self.count + self.TRIES))

        def fits(change: FloatArray) -> bool:
            missed = change - recurrence.ahead(next(steps))[1]
            self.missed = np.abs(measure.rigid.T @ missed)
            return size(missed) <= self.ALIKE * share * now

        rate = min(share ** (1.0 / self.count), 1.0)
        return Leap(state, fits, float(np.abs(off).max()), measure.apart(off), rate)

    def adrift(self, measure: Measure) -> float:
        """Rigid slip that the last leap may be off, as a period at its end was off so much [length]."""
        return float((np.abs(measure.rigid) @ (self.count * self.missed)).max())

    def heed(self, taken: bool, cycles: int) -> None:
        """Adapt the length of the next leap."""
        self.reach = self.count * self.FURTHER if taken else self.count // self.FURTHER
        if taken:
            self.wait = 0
        elif self.reach < WORTH:
            self.reach, self.wait = int(WORTH) * self.FURTHER, longer(self.wait)
        self.since = cycles + self.wait


def longer(wait: int) -> int:
    """Periods to wait after a further leap that fails, twice as many as after the one before."""
    return min(2 * wait + 5, LONGEST_WAIT)


class Site(NamedTuple):
    """The start of a leap of a crawling motion, and its result.

    Attributes
    ----------
    left
        How far its limit seemed by the slope of the changes [energy norm].
    gone
        How far the leap went [energy norm].
    toward, turning : (N,)
        The direction, per unit of way, and by how much it was thought to turn on it, per unit of way.
    share
        Of the change before it in that after it.
    """

    left: float
    gone: float
    toward: FloatArray
    turning: FloatArray
    share: float


@dataclass
class Crawl:
    """Leaps of a motion that changes by little from period to period, always the same way: along a curve.

    With F the change per period, the limit is |F| / (1 − rate) away where F falls along a line, and a times
    as far where |F| falls like the a-th power of the distance: a is seen from leap to leap (Newton's method
    at a multiple root). So slow a sequence of states is one curve, of which every leap tells the tangent at
    both ends; how fast it is passed does not matter.
    """

    TRIES: ClassVar[int] = 12
    SLOW: ClassVar[float] = 0.03  # largest relative change of F per period
    STEADY: ClassVar[float] = 0.2  # relative to that: its own change, and the rotation of F
    FADING: ClassVar[float] = 0.8  # factor per period from which on deviations still die away after a leap
    SLACK: ClassVar[float] = 0.3  # deviation of |F| from its prediction that is accepted, relative
    OVERSHOT: ClassVar[float] = 0.125  # relative to the prediction: less means at the limit, or beyond
    AS_FORESEEN: ClassVar[float] = 0.25  # relative to the prediction
    MOST_BEND: ClassVar[float] = 8.0  # exponent
    LONGER: ClassVar[float] = 8.0  # times the last leap, at most
    TRUST: ClassVar[tuple[float, float, float]] = 0.25, 2.0, 7.0  # after failed leaps, at first, at most
    PAUSE: ClassVar[int] = 32  # periods

    care: float = 1.0  # share of what leaps may be unsure by otherwise
    trust: float = TRUST[1]  # a share e^-trust of the distance remains
    bend: float = 1.0
    refused: bool = False
    since: int = 0
    site: Site | None = None
    fresh: bool = False  # whether the tangent at the end of the last leap has not been seen
    planned: Site | None = None
    foreseen: float = 1.0
    seen: FloatArray | None = None  # direction of the change after the last leap, if its size was right
    bending: FloatArray | None = None  # by how much the direction turns before a leap, per unit of way
    turned: FloatArray | None = (
        None  # per unit of way: by how much the direction turned on a leap refused for it
    )

    def plan(self, window: FloatArray, measure: Measure, cycles: int) -> Leap | None:
        """Leap most of the distance to the limit, depending on the success of earlier leaps."""
        if len(window) < 4 or cycles < self.since:
            return None
        changes = np.diff(window, axis=0)
        size, slope = measure.size(changes[-1]), self._slope(changes, measure)
        seen = slope is not None
        if slope is None:
            slope = self._slope_since(changes, measure)
        if slope is None:
            return None
        toward, forward, site = changes[-1] / size, slope > 0.0, self.site
        left = size / max(abs(slope), np.finfo(float).eps)
        turning, most = np.zeros_like(toward), measure.size(window[-1])
        if site is not None:
            turning, most = (toward - site.toward) / site.gone, min(self.LONGER * site.gone, most)
            if seen and self.fresh and forward:
                bend = site.gone / (site.left - left) if site.left > left else 1.0
                self.bend = min(max(bend, 1.0), self.MOST_BEND)
            self.fresh = False
        if self.turned is not None:
            turning = self.turned
        bend = self.bend if forward else 1.0
        gone = min(-np.expm1(-self.trust) * bend * left, most)
        if gone < WORTH * size:
            self.trust, self.refused = max(self.trust, self.TRUST[0]), False
            self.since = cycles + self.PAUSE
            return None
        self.foreseen = (1.0 - gone / (bend * left)) ** bend if forward else 1.0 + gone / left
        self.planned = Site(left, gone, toward, turning, np.nan)
        passed = measure.size(window[-1] - window[1])
        self.bending = (toward - changes[0] / measure.size(changes[0])) / passed
        turn = self.care * min(MUCH, max(THREE_DIGITS, PRICE * measure.size(window[-1]) / gone))
        return Leap(
            start=window[-1] + gone * (toward + 0.5 * gone * turning),
            fits=self._fits(size * (toward + gone * turning), turn, measure),
            unsure=0.5 * turn * gone * float(np.abs(toward).max()),
            apart=0.5 * turn * gone * measure.apart(toward),
            rate=min(1.0, 1.0 - slope),
        )

    def _slope(self, changes: FloatArray, measure: Measure) -> float | None:
        """By how much the change falls per period, relative; None where it does not crawl, or nothing tells.

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
        if self.site is None or len(changes) < 4 or not 0.0 < self.site.share < 0.9:
            return None
        before, now = measure.size(changes[-2]), measure.size(changes[-1])
        if not (before > 0.0 and now > 0.0):
            return None
        left = self.site.share ** (1.0 / self.bend)
        slope = self.bend * (1.0 - left) / left * now / self.site.gone
        turned = measure.size(changes[-1] / now - changes[-2] / before)
        return slope if turned <= MUCH and slope <= self.SLOW else None

    def _fits(
        self, foreseen: FloatArray, turn: float, measure: Measure
    ) -> Callable[[FloatArray], bool | None]:
        """Whether a change has the predicted direction, and a share of the predicted size."""
        whole, direction, self.seen = measure.size(foreseen), measure.seen(foreseen), None
        before = np.inf

        def fits(change: FloatArray) -> bool | None:
            nonlocal before
            assert self.planned is not None
            share = float(measure.seen(change) @ direction) / whole**2
            if share == 0.0:
                return None
            off = measure.misses(change, share * foreseen, whole) / abs(share)
            fading, before = off <= self.FADING * before, off
            self.planned = self.planned._replace(share=share)
            least = max(self.OVERSHOT * self.foreseen, self.foreseen - self.SLACK)
            right = least <= share <= self.foreseen + self.SLACK
            if right and off <= turn:
                self.seen = change / measure.size(change)
                return True
            if fading:
                return False
            self.seen = change / measure.size(change) if right else None
            return None

        return fits

    def adrift(self, measure: Measure) -> float:
        """Rigid slip by which a leap that is taken may miss the curve of the motion [length].

        A leap is a parabola through the directions at its ends; the curve may turn otherwise, as before it.
        """
        assert self.planned is not None
        assert self.seen is not None
        assert self.bending is not None
        _, gone, toward, turning, _ = self.planned
        turned = (self.seen - toward) / gone
        otherwise = np.minimum(np.abs(turned - self.bending), np.abs(turned))
        off = gone**2 * (0.5 * np.abs(turned - turning) + MISJUDGED / 6.0 * otherwise)
        return float(np.abs(measure.rigid).T.max(axis=1, initial=0.0) @ (np.abs(measure.rigid).T @ off))

    def heed(self, taken: bool, cycles: int) -> None:
        """Increase or reduce the trust in leaps."""
        assert self.planned is not None
        learnt, self.turned = self.turned is None and self.seen is not None, None
        if not taken:
            if self.seen is not None:  # the way there is as far as the directions at both ends tell
                self.turned = (self.seen - self.planned.toward) / self.planned.gone
            self.trust, self.refused, self.since = self.trust / (1.0 if learnt else 2.0), True, cycles + 1
            return
        self.site, self.fresh = self.planned, True
        if not self.refused and abs(self.site.share - self.foreseen) <= self.AS_FORESEEN * self.foreseen:
            self.trust = min(2.0 * self.trust, self.TRUST[2])
        self.refused = False

    def forget(self) -> None:
        """Forget the last leap, as after one of another kind."""
        self.site, self.bend, self.fresh, self.turned = None, 1.0, False, None

    def rigid_miss(self, window: FloatArray, measure: Measure) -> FloatArray | None:
        """Rigid slip by which the last leap missed the curve, by its tangents at both ends; None: unseen.

        Nothing else tells, as cycles are the same wherever the joint stands.
        """
        site, rigid = self.site, measure.rigid
        if not self.fresh or site is None or not rigid.shape[1] or len(window) < 4:
            return None
        changes = np.diff(window, axis=0)
        if self._slope(changes, measure) is None:
            return None
        toward = changes[-1] / measure.size(changes[-1])
        off = 0.5 * site.gone * (toward - site.toward - site.gone * site.turning)
        self.site = site._replace(turning=(toward - site.toward) / site.gone)
        return np.asarray(rigid @ (rigid.T @ off))
