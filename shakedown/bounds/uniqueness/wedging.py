"""Wedging: slips locked in without any load (thesis §4.3.2)."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from shakedown.bounds.uniqueness.scaled_stiffness import ScaledStiffness
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, ROUND_OFF, SIX_DIGITS, THREE_DIGITS
from shakedown.joint.result import Result
from shakedown.programs.program import INF, Program
from shakedown.programs.solver import solve

LARGEST_PROBLEM = 100  # nodes
PROGRAMS = 60  # linear programs that one search may take
QUICK = 16  # of them just below the last slip that wedges; the others halve the bracket
LARGEST = 1e8  # friction up to which a wedged state is looked for
NO_REACTION = 100 * ROUND_OFF  # reactions, relative to the terms of their sum, that count as zero
HIDDEN = "round-off hides whether a wedged state exists"
NOT_SEARCHED = f"a wedged state is looked for up to {LARGEST_PROBLEM} nodes only"


@dataclass(frozen=True, eq=False, repr=False)
class Wedging(Result):
    """The friction coefficient from which on a joint can hold itself wedged.

    Attributes
    ----------
    low, high
        Below ``low`` no slip v ≠ 0 has |A v| ≤ f B v, for ``high`` the wedging slip
        has; infinite where none has for any friction, or was not looked for.
    slip : (n,)
        The wedging slip: locked-in slip, scaled to max |v| = 1; NaN where there is none.
    programs
        Linear programs solved.
    reason
        Why only an interval is known; empty where the threshold is.
    """

    low: float
    high: float
    slip: FloatArray
    programs: int = 0
    reason: str = ""

    @property
    def value(self) -> float:
        """The threshold; NaN where only an interval is known."""
        return np.nan if self.reason else self.high


def wedging_threshold(stiffness: ScaledStiffness, safe: float) -> Wedging:
    """Smallest t for which some v ≠ 0 satisfies |A v| ≤ t φ B v, by linear programs in v with Σ B v = 1.

    A bracket: above it a wedging slip, below it a program without solution. Each such slip gives
    an upper value t = max |A v|_j / (φ B v)_j, as a rule far below the friction it was
    looked for at, so that the next program stands just below it (Dinkelbach's method);
    where that does not end soon, the programs halve the bracket.

    Parameters
    ----------
    stiffness
        The joint.
    safe
        A factor on φ below which no wedged state is known to exist, such as the
        threshold of uniqueness.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> from shakedown.bounds.uniqueness.scaled_stiffness import scaled_stiffness
    >>> one = scaled_stiffness(shakedown.example("one-node"), np.ones(1), shakedown.Tolerances())
    >>> round(wedging_threshold(one, 0.0).value, 6)
    2.0
    """
    unit, none = stiffness.friction_unit, np.full(stiffness.n, np.nan)
    if not stiffness.weighted.any():
        return Wedging(np.inf, np.inf, none)
    if stiffness.n > LARGEST_PROBLEM:  # the programs would take minutes
        return Wedging(safe / unit, np.inf, none, reason=NOT_SEARCHED)
    search = Bracket(stiffness, safe)
    search.close()
    if search.slip is None:
        reason = "" if search.low >= search.largest else HIDDEN
        return Wedging(np.inf if not reason else search.low / unit, np.inf, none, search.programs, reason)
    slip = search.slip / np.abs(search.slip).max()
    gap = "" if search.closed else f"the search ended after {search.programs} programs with an interval"
    return Wedging(min(search.low, search.high) / unit, search.high / unit, slip, search.programs, gap)


class Bracket:
    """Two factors on φ that enclose the wedging threshold, drawn together by linear programs.

    Parameters
    ----------
    stiffness
        The joint.
    safe
        A factor below which there is no wedged state.

    Attributes
    ----------
    low, high
        Without and with a wedged state.
    slip : (n,)
        The wedged state at ``high``; None before one is found.
    programs
        Linear programs solved.
    largest
        Up to where a wedged state is looked for.
    """

    def __init__(self, stiffness: ScaledStiffness, safe: float) -> None:
        self.stiffness, self.low, self.high = stiffness, safe, np.inf
        self.slip: FloatArray | None = None
        self.programs, self.spare = 0, np.ones(stiffness.n)
        self.ways = slips_held_by_friction(stiffness)
        self.least = NEGLIGIBLE * np.abs(stiffness.A).max() / np.abs(stiffness.weighted).max()
        self.largest = LARGEST * self.least / NEGLIGIBLE

    @property
    def closed(self) -> bool:
        """Whether the two factors agree, or there is a wedged state for any friction."""
        return self.low >= self.high * (1 - SIX_DIGITS) or self.high <= self.least

    def close(self) -> None:
        """Find a wedged state for large friction, then ever smaller friction for one."""
        if self.low < self.largest and self._lowered(self.largest):
            self._raise_low(self._lower_high())

    def _lower_high(self) -> float:
        """Lower ``high``; returns the largest factor at which no wedging slip was found."""
        below, quick = max(self.low, self.least), True
        while self.programs < PROGRAMS and below < self.high * (1 - NEGLIGIBLE):
            factor = min(self.high if quick else np.sqrt(self.high * below), self.high * (1 - NEGLIGIBLE))
            lowered = self._lowered(factor)
            if not lowered and not quick:
                below = factor  # even if only round-off spoils the slip, and `low` stays
            below = max(below, self.low)
            quick = quick and lowered and self.programs < QUICK
        return below

    def _raise_low(self, top: float) -> None:
        """Prove more, where round-off spoilt the wedging slips up to ``top``."""
        while self.programs < PROGRAMS and self.low < top * (1 - NEGLIGIBLE) and not self.closed:
            factor = np.sqrt(max(self.low, self.least) * top)
            self._lowered(factor)
            if self.low < factor:
                top = factor

    def _lowered(self, factor: float) -> bool:
        """Whether there is a wedged state at a factor; draws the bracket together."""
        self.programs += 1
        slip, violation = wedged_slip(self.stiffness, factor, self.spare, self.ways)
        if violation > ROUND_OFF:
            self.low = max(self.low, factor)
            return False
        used = friction_used(self.stiffness, slip)
        if not used < self.high:
            return False
        self.high, self.slip = used, slip
        pressure = np.abs(self.stiffness.weighted @ slip)
        # so that every program has a solution
        self.spare = np.maximum(pressure / pressure.max(), THREE_DIGITS)
        return True


def friction_used(stiffness: ScaledStiffness, slip: FloatArray) -> float:
    """Smallest t with |A v| ≤ t φ B v for a given v; infinite where there is none."""
    A, B = stiffness.A, stiffness.weighted
    q, p = np.abs(A @ slip), B @ slip
    no_q, no_p = NO_REACTION * (np.abs(A) @ np.abs(slip)), NO_REACTION * (np.abs(B) @ np.abs(slip))
    pressed = p > no_p
    idle = (q <= no_q) & (p >= -no_p)
    ratios = np.where(pressed, q / np.where(pressed, p, 1.0), np.where(idle, 0.0, np.inf))
    return float(ratios.max())


def slips_held_by_friction(stiffness: ScaledStiffness) -> FloatArray:
    """The slips v, as columns, with (A v)_i = 0 wherever no slip gives node i a friction limit: (φ B)_i = 0.

    As a row of a program |(A v)_i| ≤ 0 would be left to its tolerance.
    """
    unlimited = ~stiffness.weighted.any(axis=1)
    return np.asarray(null_space(stiffness.A[unlimited])) if unlimited.any() else np.eye(stiffness.n)


def wedged_slip(
    stiffness: ScaledStiffness, factor: float, weights: FloatArray, ways: FloatArray
) -> tuple[FloatArray, float]:
    """The v with Σ B v = 1 that violates |A v| ≤ t φ B v least, and by how much (negative: to spare).

    v is a sum of the columns ``ways``. What is to spare is measured by weights, one per row. With the
    pressures φ B v of a wedging slip it is how far friction can fall, which makes the next overshoot most.
    All stiffnesses are divided by their size, so that v and the violation are numbers near 1.
    """
    limited = stiffness.weighted.any(axis=1)
    free = ways.copy()
    free[list(stiffness.pinned)] = 0.0  # no friction limit knows the rigid slips
    A, B = stiffness.A[limited] @ free, factor * stiffness.weighted[limited] @ free
    size = np.maximum(np.abs(A).max(axis=1, initial=0.0), np.abs(B).max(axis=1, initial=0.0))
    size = np.where(size > 0, size, 1.0)[:, None]
    A, B, row = A / size, B / size, -weights[limited, None]
    pressure = stiffness.B.sum(axis=0) @ free / np.abs(stiffness.B).max()
    matrix = np.vstack([np.hstack([A - B, row]), np.hstack([-A - B, row]), [[*pressure, 0.0]]])
    left, right = (np.append(np.full(len(matrix) - 1, end), 1.0) for end in (-INF, 0.0))
    found = solve(Program(matrix, right, cost=np.append(np.zeros(ways.shape[1]), 1.0), left=left))
    if not found.optimal:  # no slip presses the nodes together at all
        return np.full(stiffness.n, np.nan), np.inf
    return ways @ found.x[:-1], float(found.x[-1])
