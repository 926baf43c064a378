"""Up to which load factor does a given loading history shake down? (thesis §4.3.5)"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from shakedown.errors import UsageError
from shakedown.long_term.find_state import LongTermState, long_term_state
from shakedown.long_term.outcome import Outcome
from shakedown.model.arguments import check_count, checked_initial_slip
from shakedown.model.problem import FloatArray, Problem
from shakedown.tolerances import DEFAULT, Tolerances


@dataclass(frozen=True)
class TransientLimit:
    """Result of :func:`transient_limit`.

    Attributes
    ----------
    load_factor
        λ_T: the largest load factor found to shake down; NaN where none does.
    low, high
        It shakes down at ``low`` (λ_T) and not at ``high``; ``high`` is infinite
        where everything scanned shakes down, ``low`` NaN where nothing does.
    initial_slip : (n,)
        Slip at the start [length].
    scanned : (s,)
        Load factors simulated, in increasing order.
    outcomes : (s,)
        Long-term state at each.
    monotone
        Whether every scanned load factor below λ_T shakes down and none above it.
    at_low, at_high
        The two long-term states that enclose the limit.
    """

    load_factor: float
    low: float
    high: float
    initial_slip: FloatArray
    scanned: FloatArray
    outcomes: tuple[Outcome, ...]
    monotone: bool
    at_low: LongTermState | None
    at_high: LongTermState | None


def transient_limit(
    problem: Problem,
    initial_slip: ArrayLike | None = None,
    *,
    largest: float | None = None,
    steps: int = 40,
    accuracy: float = 1e-9,
    tolerances: Tolerances = DEFAULT,
) -> TransientLimit:
    """The largest load factor at which the history from an initial slip shakes down (thesis §4.3.5).

    Outcomes need not be monotone in λ. Therefore the range is scanned in equal
    steps and the last change from shakedown to another outcome is bisected, both
    with exact long-term states; everything simulated is reported.

    Parameters
    ----------
    problem
        The joint, its transient load steps and its loading loop.
    initial_slip : (n,), optional
        Slip before the transient [length]; zero by default.
    largest
        Upper end of the scan; by default a little above λ_max, where there is
        one, beyond which nothing shakes down.
    steps
        Number of load factors scanned, beside λ = 0.
    accuracy
        Width of the final interval, relative to ``largest``.
    tolerances
        What counts as zero, as reached and as periodic (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range, or ``largest`` is needed because the
        problem has no finite upper bound.

    Examples
    --------
    >>> import shakedown
    >>> limit = transient_limit(shakedown.example("two-node"), accuracy=1e-4)
    >>> round(limit.load_factor, 3), limit.monotone
    (0.732, True)
    """
    start = checked_initial_slip(problem, initial_slip)
    top = _top(problem) if largest is None else float(largest)
    if not (np.isfinite(top) and top > 0):
        raise UsageError(f"largest: expected a positive load factor, found {top}")
    check_count("steps", steps)
    if not 0 < accuracy < 1:
        raise UsageError(f"accuracy: expected a number between 0 and 1, found {accuracy}")
    runs: dict[float, LongTermState] = {}

    def shakes_down(load_factor: float) -> bool:
        if load_factor not in runs:
            runs[load_factor] = long_term_state(problem, load_factor, start, tolerances=tolerances)
        return runs[load_factor].outcome == Outcome.SHAKEDOWN

    scan = np.linspace(0.0, top, steps + 1)
    good = [k for k, load_factor in enumerate(scan) if shakes_down(float(load_factor))]
    if not good:
        return _limit(start, runs, np.nan, float(scan[0]))
    low = float(scan[good[-1]])
    if good[-1] == steps:
        return _limit(start, runs, low, np.inf)
    high = float(scan[good[-1] + 1])
    while high - low > accuracy * top:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if shakes_down(middle) else (low, middle)
    return _limit(start, runs, low, high)


def _top(problem: Problem) -> float:
    """A little more than the upper bound, so that the scan ends above it."""
    from shakedown.bounds.upper import upper_bound  # LPs are needed only here

    upper = upper_bound(problem)
    if upper.status != "optimal":
        raise UsageError(f"largest: needed because the upper bound is {upper.status}, found none")
    return 1.05 * upper.load_factor


def _limit(start: FloatArray, runs: dict[float, LongTermState], low: float, high: float) -> TransientLimit:
    scanned = np.array(sorted(runs))
    outcomes = tuple(runs[float(x)].outcome for x in scanned)
    expected = scanned <= low if np.isfinite(low) else np.zeros(len(scanned), dtype=bool)
    return TransientLimit(
        load_factor=low,
        low=low,
        high=high,
        initial_slip=start,
        scanned=scanned,
        outcomes=outcomes,
        monotone=bool(np.all(np.array([o == Outcome.SHAKEDOWN for o in outcomes]) == expected)),
        at_low=runs.get(low),
        at_high=runs.get(high),
    )
