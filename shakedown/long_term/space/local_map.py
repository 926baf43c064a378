"""What a period of a motion changes next to a state: its slopes, and how the way along them is bent."""

from collections.abc import Callable
from dataclasses import dataclass
from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import THREE_DIGITS
from shakedown.long_term.space.leap_methods import Measure

DRIFTS = 2.0**20  # periods: most that a drift is followed at once
BEHIND_IT = 3  # states behind a way that tell how it is bent
SHARES = 0.25, 0.5, 1.0  # of a way, at which its bends are seen; one less for each state behind it
MOST_POWERS = BEHIND_IT + len(SHARES)
PASCAL = np.array([[comb(i, j) for j in range(MOST_POWERS)] for i in range(MOST_POWERS)], dtype=float)


class PeriodStep(NamedTuple):
    """What a period changes of the state, (N,) [length], and what identifies its contact states."""

    change: FloatArray
    signature: int


Period = Callable[[FloatArray], PeriodStep | None]  # from a state on; None where the motion stops


class Moving(NamedTuple):
    """The slips that a map is of, and what follows them.

    Attributes
    ----------
    places : (k,)
        Where the slips of closed nodes that move stand in a state.
    follow : (N, k)
        What each moves of the state: itself, and open nodes, which stay in equilibrium.
    """

    places: NDArray[np.intp]
    follow: FloatArray

    @classmethod
    def of(cls, stiffness: FloatArray, places: NDArray[np.intp], free: NDArray[np.intp]) -> "Moving":
        """By the stiffness (N, N), with the places of slips and gaps of open nodes."""
        follow = np.zeros((len(stiffness), len(places)))
        follow[places, np.arange(len(places))] = 1.0
        if len(free):
            follow[free] = -np.linalg.lstsq(stiffness[np.ix_(free, free)], stiffness[np.ix_(free, places)])[0]
        return cls(places, follow)

    def is_like(self, other: "Moving") -> bool:
        """Whether both are of the same slips, with the same nodes open."""
        return self.follow.shape == other.follow.shape and bool((self.follow == other.follow).all())


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
    moving
        Which slips, and what follows them.
    change : (k,)
        F [length].
    slopes : (k, k)
        D.
    signature
        Of the contact states in the period from u.
    """

    period: Period
    measure: Measure
    start: FloatArray
    moving: Moving
    change: FloatArray
    slopes: FloatArray
    signature: int

    def at(self, y: FloatArray) -> FloatArray:
        """The state u + y."""
        return np.asarray(self.start + self.moving.follow @ y)

    def size(self, y: FloatArray) -> float:
        """Of a change, by energy; inf where it is out of all bounds, as drift of very many periods is."""
        if not np.abs(y).max() <= max(np.abs(self.start).max(), DRIFTS * np.abs(self.change).max()):
            return np.inf
        return self.measure.size(self.at(y) - self.start)

    def linear(self, y: FloatArray) -> FloatArray:
        """F + D y."""
        return np.asarray(self.change + self.slopes @ y)

    def rest(self, y: FloatArray) -> PeriodStep:
        """r(y), (k,), by a period from there; NaN where none can be followed, or where other nodes slip."""
        there = self.period(self.at(y)) if self.size(y) < np.inf else None
        if there is None or self._is_elsewhere(there.change):
            return PeriodStep(np.full_like(y, np.nan), 0)
        return PeriodStep(there.change[self.moving.places] - self.linear(y), there.signature)

    def _is_elsewhere(self, change: FloatArray) -> bool:
        """Whether a clear share of a change is not at these places."""
        other = change - self.moving.follow @ change[self.moving.places]
        return bool(other.any()) and self.measure.size(other) > THREE_DIGITS * self.measure.size(change)

    def seen(self, y: FloatArray, bent: FloatArray) -> "Foresight | None":
        """What a period from u + y changes beside F + D y + bent; None where none can be followed."""
        there = self.period(self.at(y))
        if there is None:
            return None
        return Foresight(there.change, np.asarray(self.moving.follow @ (self.linear(y) + bent)))

    def ahead(self, periods: int, bends: FloatArray, share: float = 1.0) -> FloatArray:
        """y after a share of so many periods, if r = Σ bends[i] sⁱ⁺¹ after the share s of them."""
        k, powers = len(self.change), len(bends) + 1
        one = np.zeros((k + powers, k + powers))  # a period: of y, 1, j, j², …
        one[:k, :k] = np.eye(k) + self.slopes
        one[:k, k] = self.change
        one[:k, k + 1 :] = (bends / float(periods) ** np.arange(1, powers)[:, None]).T
        one[k:, k:] = PASCAL[:powers, :powers]
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(np.linalg.matrix_power(one, int(share * periods))[:k, k])

    def bends(self, periods: int, known: FloatArray, behind: "Behind") -> "Way":
        """What is seen on a way that is bent as far as is known, and what has been seen behind it."""
        shares = SHARES[min(len(behind.shares), len(SHARES) - 1) :]
        seen = [self.rest(self.ahead(periods, known, share)) for share in shares]
        smooth = all(there.signature == self.signature for there in seen)
        here = Behind(np.array(shares), np.array([there.change for there in seen]))
        return self.way(periods, here.joined(behind).bends, smooth and len(behind.shares) == BEHIND_IT)

    def way(self, periods: int, bends: FloatArray, smooth: bool = False) -> "Way":
        """A way with these bends."""
        return Way(bends, smooth, self.ahead(periods, bends), np.zeros_like(self.change))


class Behind(NamedTuple):
    """What r has been, (i, k) [length], at shares of a way, negative where they lie behind its beginning."""

    shares: FloatArray
    rest: FloatArray

    def joined(self, other: "Behind") -> "Behind":
        """Both."""
        return Behind(np.append(self.shares, other.shares), np.vstack([self.rest, other.rest]))

    def first(self, count: int) -> "Behind":
        """The first of them."""
        return Behind(self.shares[:count], self.rest[:count])

    @property
    def bends(self) -> FloatArray:
        """(i, k) so that r = Σ bends[i] sⁱ⁺¹ there."""
        powers = self.shares[:, None] ** np.arange(1, len(self.shares) + 1)
        return np.asarray(np.linalg.solve(powers, self.rest), dtype=float)


class Way(NamedTuple):
    """A way to go.

    Attributes
    ----------
    bends : (i, k)
        Of it.
    smooth
        Whether no contact state changes on it, as far as is seen, and enough lies behind it to foresee it.
    end : (k,)
        y there [length].
    miss : (k,)
        By how much what lies behind it has foreseen another end [length].
    """

    bends: FloatArray
    smooth: bool
    end: FloatArray
    miss: FloatArray


class Foresight(NamedTuple):
    """A change, (N,) [length], and the one that was foreseen."""

    change: FloatArray
    foreseen: FloatArray
