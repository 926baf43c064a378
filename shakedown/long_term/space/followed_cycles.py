"""The cycles that a search in space has followed: what they change, how that falls, whether drift lasts.

The size of a change of the state is the energy that it stores.

Where the change per period falls by the same share of the way from period to period, along a line, the way
ends at a fixed point of the map, a known distance ahead. A motion that lingers next to a state and goes on
past it shows itself before: as at a double root its change falls by ever smaller shares. So does one that is
slower by far: its change stays, while that of the fast one falls.

A drift goes on for ever where rigid slip in every period meets no resistance.
"""

from collections import deque
from dataclasses import dataclass
from itertools import pairwise
from math import sqrt
from typing import NamedTuple

import numpy as np

from shakedown.ground.constants import (
    EPS,
    MANY_ROWS,
    MINOR,
    NEGLIGIBLE,
    NOTABLE,
    RESOLVED,
    SIX_DIGITS,
    THREE_DIGITS,
    FloatArray,
    IntArray,
)
from shakedown.ground.status import OPEN
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.law import Layout
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import free_stiffness, rigid_slips
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import CycleRecord, State
from shakedown.motion.viscous_jump import Jump

STATE_ROUND_OFF = 64.0 * EPS  # relative to a state: smaller changes are none


@dataclass(frozen=True)
class Measure:
    """The energy norm of changes of a state, in which rigid slips do not count.

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
    """

    root: FloatArray
    rigid: FloatArray
    slips: FloatArray
    largest: float

    def size(self, change: FloatArray) -> float:
        """The size of a change of the state."""
        seen = self.seen(change)
        return sqrt(seen.dot(seen))  # as np.linalg.norm

    def seen(self, changes: FloatArray) -> FloatArray:
        """R d of changes (…, N), (…, k)."""
        return product(self.root, changes)

    def at_most(self, change: FloatArray) -> float:
        """An upper bound of ``terms``, without the product."""
        return 2.0 * self.largest * float(np.linalg.norm(change))

    def terms(self, change: FloatArray) -> float:
        """‖|R| |d|‖, to which the round-off of a size is relative."""
        return float(np.linalg.norm(np.abs(self.root) @ np.abs(change)))

    def is_rigid(self, change: FloatArray) -> bool:
        """Whether what a change of one slip does to the reactions is undone by what others do."""
        return self.size(change) <= THREE_DIGITS * self.terms(change)

    def without_rigid(self, changes: FloatArray) -> FloatArray:
        """Changes (…, N) without their rigid slip."""
        return np.asarray(changes - changes @ self.rigid @ self.rigid.T)

    def deviation(self, change: FloatArray, expected: FloatArray, size: float) -> float:
        """The deviation of a change from another one of this size, relative to it; rigid slips included."""
        off = self.size(change - expected) / size
        if not self.rigid.shape[1]:
            return off
        return max(off, float(np.linalg.norm(change - expected) / np.linalg.norm(expected)))


def product(root: FloatArray, changes: FloatArray) -> FloatArray:
    """R d of changes (…, N), (…, k): with a large R from the places that change, mostly few."""
    places: IntArray | slice = slice(None)
    if len(root) > MANY_ROWS and changes.any():
        moved = np.flatnonzero(changes.reshape(-1, changes.shape[-1]).any(axis=0))
        few = 4 * len(moved) < changes.shape[-1]
        places = moved if few else slice(moved[0], moved[-1] + 1)  # gaps, the last places, mostly rest
    return np.asarray(changes[..., places] @ root.T[places])


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


# Of the slope before it, which is ½ of that along a square: less is no line, or is not nearer to one.
LINEAR, NEARLY = 0.9, 0.75


class Period(NamedTuple):
    """What a period did.

    Attributes
    ----------
    state : (N,)
        At its end [length].
    change : (N,)
        Of the state [length].
    size
        Of that [energy norm].
    slip : (n,)
        In it [length].
    drift : (r,)
        Rigid slip in it, along each of the orthonormal ones [length].
    signature
        Identifies its contact states.
    """

    state: FloatArray
    change: FloatArray
    size: float
    slip: FloatArray
    drift: FloatArray
    signature: int


class Limit(NamedTuple):
    """The limit state, at which the change per period is extrapolated linearly to zero.

    Attributes
    ----------
    remaining, change : (N,)
        The displacements still to come, and what is left of the change there [length].
    slip : (n,)
        Per period [length].
    drift : (r,)
        Per period [length].
    """

    remaining: FloatArray
    change: FloatArray
    slip: FloatArray
    drift: FloatArray

    @classmethod
    def of(cls, before: Period, now: Period) -> "Limit":
        """From two periods."""
        share = now.size / (before.size - now.size)
        remaining = (now.state - before.state) * share
        pairs = (now.change, before.change), (now.slip, before.slip), (now.drift, before.drift)
        return cls(remaining, *(after + share * (after - start) for after, start in pairs))


class Decay:
    """Periods on the way of a search, each with half the change of the one before it, or less."""

    def __init__(self) -> None:
        self.periods: list[Period] = []

    def note(self, period: Period) -> None:
        """Keep a period, if the change has fallen; where it has grown, forget those of smaller changes."""
        while self.periods and self.periods[-1].size <= period.size:
            self.periods.pop()
        if not self.periods or period.size <= 0.5 * self.periods[-1].size:
            self.periods.append(period)

    def before(self, now: Period, times: float = 4.0) -> Period | None:
        """The last period of so many times the change: by default one that shows a slope."""
        return next((each for each in reversed(self.periods) if 0.0 < each.size >= times * now.size), None)

    def limit(self, now: Period) -> Limit | None:
        """The extrapolated limit; None where no period shows a slope."""
        before = self.before(now)
        return None if before is None else Limit.of(before, now)

    def to_come(self, now: Period, measure: Measure, lost: float = 0.0) -> FloatArray | None:
        """The displacements (N,) up to the limit [length]; None where the change does not fall linearly.

        Changes of up to ``lost`` are round-off [energy norm].
        """
        end = self._limit(now, measure, LINEAR, max(MINOR * now.size, lost))
        return None if end is None else end.remaining

    def comes_to_a_cycle(self, now: Period, measure: Measure, none: float) -> bool:
        """Whether the change falls to none [energy norm], more linearly than quadratically; slip stays."""
        least = max(MINOR * now.size, none)
        return self._limit(now, measure, NEARLY, least) is not None and self.slip_lasts(now, MINOR)

    def _limit(self, now: Period, measure: Measure, straight: float, none: float) -> Limit | None:
        """The limit, if the change falls linearly to none [energy norm]."""
        before = self.before(now)
        first = None if before is None else self.before(before)
        if before is None or first is None:
            return None
        way, earlier = measure.size(now.state - before.state), measure.size(before.state - first.state)
        if not (before.size - now.size) * earlier >= straight * (first.size - before.size) * way:
            return None
        end, round_off = Limit.of(before, now), STATE_ROUND_OFF * measure.size(now.state)
        # More falls to another one, far slower: nothing shows where that ends.
        return end if measure.size(end.change) <= none + round_off else None

    def slip_lasts(self, now: Period, share: float = THREE_DIGITS) -> bool:
        """Whether the slip stays where the change falls to nothing, but for a share."""
        end = self.limit(now)
        return end is not None and bool(np.abs(end.slip - now.slip).max() <= share * now.slip.max())

    def slip_ends(self, now: Period, none: FloatArray, share: float = NOTABLE) -> bool:
        """Whether the slip falls to nothing with the change, but for a share, and has done so on the way.

        At every node, as a soft one may hide a stiff one, or to what counts as none, (n,) [length].
        """
        end, before = self.limit(now), self.before(now, RESOLVED)
        if end is None or before is None:
            return False
        fallen = bool(now.slip.max() <= NOTABLE * before.slip.max())
        grown = now.slip > np.maximum(before.slip, THREE_DIGITS * none)  # that leads away from rest
        return fallen and bool((~grown & (np.abs(end.slip) <= np.maximum(share * now.slip, none))).all())

    def drift_lasts(self, now: Period) -> bool:
        """Whether the drift stays where the change falls to nothing."""
        end = self.limit(now)
        if end is None:
            return False
        return bool(np.linalg.norm(end.drift - now.drift) <= MINOR * np.linalg.norm(now.drift))

    def drift_ends(self, now: Period) -> bool:
        """Whether the drift falls to nothing with the change."""
        end = self.limit(now)
        return end is not None and bool(np.linalg.norm(end.drift) <= MINOR * np.linalg.norm(now.drift))

    def drift_left(self, now: Period) -> FloatArray:
        """The drift (r,) where the change falls to nothing; that of the period where nothing shows it."""
        end = self.limit(now)
        return now.drift if end is None else end.drift

    def farthest(self, now: Period, layout: Layout, measure: Measure, drifts: bool) -> float:
        """How far a node has still to go, as the changes of all fall, and as its own does [length].

        Beside fast ones a slow one may have come no nearer to its end. Rigid drift that lasts does not count.
        """
        before = self.before(now)
        if before is None:
            return 0.0
        gone = now.state - before.state
        apart = (measure.without_rigid(each) for each in (gone, before.change, now.change))
        way, first, last = (layout.slip_distances(each) for each in apart)
        fallen = np.maximum(first - last, NEGLIGIBLE * last)
        own = np.divide(way * last, fallen, out=np.zeros_like(way), where=last > 0.0)
        as_all = (way if drifts else layout.slip_distances(gone)) * now.size / (before.size - now.size)
        return float(np.maximum(own, as_all).max())


WINDOW = 7  # largest number of states one period apart that a leap starts from


@dataclass(frozen=True)
class SearchRules:
    """When a search ends, and what it neglects.

    Attributes
    ----------
    most_cycles, longest_period
        As for :func:`long_term_state`.
    noise
        How far one cycle may miss for errors of integration [length of the softest node].
    stiffness : (n,)
        Of every node, relative to the softest, ≥ 1: so much smaller a slip counts for as much.
    blurred
        Whether loads change by next to round-off: what seems at rest then may be none.
    """

    most_cycles: int
    longest_period: int
    noise: float
    stiffness: FloatArray
    blurred: bool = False


class Position(NamedTuple):
    """Where a leap that is refused goes back to: the state, those before it, and how much was recorded."""

    state: State
    states: deque[State]
    records: list[CycleRecord]
    passed: int
    jumps: int


class FollowedCycles:
    """Cycles followed one by one, which leaps may interrupt.

    Parameters
    ----------
    motion
        The joint, at the start of a cycle.
    longest_period
        Of a long-term state, in cycles.

    Attributes
    ----------
    records, states
        Of the last cycles; the states between them since the last leap.
    passed
        The cycles before the first leap, with the states at their ends.
    jumps
        Those of the cycles followed, also after a leap.
    count, events, probes
        Cycles and events followed in all, and how many of the cycles only showed slopes.
    leaps
        How many were taken.
    error
        Sum of the errors of integration, which what no cycle changes keeps [length].
    """

    def __init__(self, motion: Evolution, longest_period: int) -> None:
        self.motion, self.layout = motion, motion.problem.layout
        self.measure: Measure = measure_of(motion.problem)
        self.start = motion.state.u
        self.records: deque[CycleRecord] = deque(maxlen=2 * longest_period + 1)
        self.states: deque[State] = deque([motion.state], maxlen=WINDOW * longest_period + 1)
        self.passed: list[tuple[CycleRecord, State]] = []
        self.jumps: list[Jump] = []
        self.count = self.events = self.probes = self.leaps = 0
        self.error = 0.0

    def follow(self, cycles: int = 1) -> bool:
        """Follow some cycles; False where the motion stops."""
        for _ in range(cycles):
            record = self.motion.cycle()
            if record is None:
                return False
            self.count, self.events = self.count + 1, self.events + record.events
            self.error += record.error
            self.records.append(record)
            self.jumps += record.jumps
            self.states.append(self.motion.state)
            if not self.leaps:
                self.passed.append((record, self.states[-1]))
        return True

    def go_to(self, state: State) -> None:
        """Go on from another state."""
        self.motion.state, self.states = state, deque([state], maxlen=self.states.maxlen)

    def position(self) -> Position:
        """Where the motion is."""
        return Position(self.motion.state, self.states, list(self.records), len(self.passed), len(self.jumps))

    def go_back(self, position: Position) -> None:
        """Go back there."""
        del self.jumps[position.jumps :]
        self.motion.state, self.states = position.state, position.states
        self.records = deque(position.records, maxlen=self.records.maxlen)

    def change(self, period: int) -> FloatArray:
        """The change of the state over the last period of so many cycles, (N,) [length]."""
        return np.asarray(self.states[-1].u - self.states[-1 - period].u)

    def slip(self, first: int, last: int) -> FloatArray:
        """The slip of the nodes in cycles counted back from the last, (n,) [length]."""
        return np.sum([self.records[-k].slip for k in range(first, last + 1)], axis=0)

    def last(self, period: int) -> Period:
        """What the last period did."""
        change, state = self.change(period), self.states[-1].u
        size, drift = self.measure.size(change), self.measure.rigid.T @ change
        signature = sum(signatures(list(self.records)[-period:]))
        return Period(state, change, size, self.slip(1, period), drift, signature)

    def window(self, period: int) -> FloatArray:
        """The last states one period apart with the same nodes open, (k, N)."""
        states = [self.states[k] for k in range(-1, -len(self.states) - 1, -period)][:WINDOW]
        opened = states[0].contact == OPEN
        return np.array([state.u for state in reversed(states) if ((state.contact == OPEN) == opened).all()])

    def to_come(self, period: int, rate: float | None, drifts: bool = False) -> tuple[float, float]:
        """What later periods may add to a state, as changes fade, and by which factor per cycle they do.

        Twice the sum of a geometric series, node by node: changes like 1/k² sum to as much. Rigid drift does
        not count.

        Parameters
        ----------
        period
            In cycles.
        rate
            Factor per cycle, where leaps have shown it.
        drifts
            Whether the joint ratchets.
        """
        states = [self.states[k].u for k in range(-1, -len(self.states) - 1, -period)][:3]
        if drifts:
            states = [self.measure.without_rigid(u) for u in states]
        changes = [np.abs(later - before) for later, before in pairwise(states)]
        last, before = changes[0], changes[-1]
        falls = np.divide(last, before, out=np.ones_like(last), where=before > last)
        rates = np.where(last > 0.0, falls, 0.0) if rate is None else np.full_like(last, rate**period)
        most = np.divide(2.0, 1.0 - rates, out=np.full_like(last, float(self.count)), where=rates < 1.0)
        return float((last * most).max()), float(rates[np.argmax(last)]) ** (1.0 / period)


def signatures(records: list[CycleRecord]) -> list[int]:
    """What identifies the contact states of cycles."""
    return [record.signature for record in records]


def drift_goes_on(
    cycles: FollowedCycles, p: int, left: FloatArray, none: FloatArray, error: float
) -> tuple[bool, bool]:
    """Whether the rigid slip of a node goes on, and whether all that changes does so and is a rigid slip.

    Of a node: by a share of its own slip that counts, as a slow change of others, in which no rigid slip is,
    may hide it. Of all: by more than the error, no less than before. Either is expected to stay for the most
    part.

    Parameters
    ----------
    cycles, p
        What was followed; the period is the last p cycles.
    left : (r,)
        Of the drift, where the change falls to nothing [length].
    none : (n,)
        Slip of each node that counts as none [length].
    error
        Of the slips in a cycle [length].
    """
    layout, measure, now = cycles.layout, cycles.measure, cycles.last(p)
    before = cycles.states[-1 - p].u - cycles.states[-1 - 2 * p].u
    known = p * error + STATE_ROUND_OFF * float(np.abs(now.state).max())
    last = float(np.abs(now.change).max())
    same = np.abs(now.change - before).max() <= SIX_DIGITS * last + known
    stays = 2.0 * np.linalg.norm(left) >= np.linalg.norm(now.drift)
    of_all = bool(stays and last > known and same and measure.is_rigid(now.change))
    kappa, rigid, sizes = free_stiffness(cycles.motion.problem), measure.rigid, layout.slip_distances
    drift = rigid @ now.drift
    size = sizes(drift)
    counts = size > np.maximum(np.maximum(SIX_DIGITS * now.slip, none), known)
    same_of_nodes = sizes(drift - rigid @ (rigid.T @ before)) <= SIX_DIGITS * size + known
    free = sizes(kappa @ now.change) <= THREE_DIGITS * sizes(np.abs(kappa) @ np.abs(now.change))
    stay = 2.0 * sizes(rigid @ left) >= size
    return bool((counts & stay & same_of_nodes & free).any()), of_all


def is_held(layout: Layout, rigid: FloatArray, slip: FloatArray, none: FloatArray) -> bool:
    """Whether the nodes that stick, or all but stick, leave no room for a rigid slip.

    Parameters
    ----------
    layout
        Of the state.
    rigid : (N, r)
        Orthonormal rigid slips, at least one.
    slip, none : (n,)
        How far each node slips in a period, and what counts as none [length].
    """
    least = SIX_DIGITS * float(slip.max())
    stuck = np.flatnonzero(slip <= np.minimum(least, none))
    room = np.linalg.svd(rigid[layout.slips_of(stuck)], compute_uv=False)
    held = len(room) == rigid.shape[1] and room[-1] > NEGLIGIBLE
    return bool(held and slip[stuck].max() <= least * room[-1])
