"""Up to which load factor does a given loading history shake down? (thesis §4.3.5)"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from shakedown.errors import UsageError
from shakedown.long_term.find_state import LongTermState, long_term_state
from shakedown.long_term.outcome import Outcome
from shakedown.model.arguments import check_count, checked, checked_initial_slip, is_finite
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.result import Result
from shakedown.programs.blas_threads import on_one_thread
from shakedown.tolerances import DEFAULT, Tolerances

BELOW = (
    0.0,
    1e-6,
    1e-5,
    1e-4,
    2e-4,
    4e-4,
    6e-4,
    8e-4,
    1e-3,
    3e-3,
    1e-2,
    3e-2,
    0.1,
    0.3,
)  # where a proof is sought


@dataclass(frozen=True, eq=False, repr=False)
class TransientLimit(Result):
    """Result of :func:`transient_limit`.

    Attributes
    ----------
    load_factor
        λ_T: the largest load factor found to shake down; NaN where none does.
    low, high
        It shakes down at ``low`` (λ_T) and not at ``high``; ``high`` is infinite
        where everything scanned shakes down, ``low`` NaN where nothing does.
    proved
        The largest load factor at or below ``low`` at which shakedown was proved (the
        motion comes into the energy ball); NaN where no proof was found.
    cycling
        The smallest simulated load factor above ``low`` at which a long-term state
        other than shakedown was found; infinite where there is none.
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
    at_proved
        The long-term state at ``proved``, with its energy margin.
    """

    DOCUMENT: ClassVar[str] = "load_factor low high proved cycling initial_slip scanned outcomes monotone"
    TABLE: ClassVar[str] = "scanned outcomes"

    load_factor: float
    low: float
    high: float
    proved: float
    cycling: float
    initial_slip: FloatArray
    scanned: FloatArray
    outcomes: tuple[Outcome, ...]
    monotone: bool
    at_low: LongTermState | None
    at_high: LongTermState | None
    at_proved: LongTermState | None

    @property
    def interval(self) -> tuple[float, float]:
        """The interval in which λ_T lies: proved to shake down below, found to cycle above."""
        return self.proved, self.cycling


@checked
@on_one_thread
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
    with exact long-term states; everything simulated is reported. A little below the
    limit the shakedown is then proved (:func:`energy_ball`): the nearer to it, the
    later the motion comes into the ball.

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
    >>> 0.731 < limit.proved <= limit.load_factor < limit.cycling
    True
    """
    start = checked_initial_slip(problem, initial_slip)
    top = _top(problem) if largest is None else largest
    if not (is_finite(top) and top > 0):
        raise UsageError(f"largest: expected a positive load factor, found {top!r}")
    top = float(top)
    check_count("steps", steps)
    if not (is_finite(accuracy) and 0 < accuracy < 1):
        raise UsageError(f"accuracy: expected a number between 0 and 1, found {accuracy}")
    runs: dict[float, LongTermState] = {}

    def shakes_down(load_factor: float) -> bool:
        if load_factor not in runs:
            runs[load_factor] = long_term_state(problem, load_factor, start, tolerances=tolerances)
        return runs[load_factor].outcome == Outcome.SHAKEDOWN

    scan = np.linspace(0.0, top, steps + 1)
    good = [k for k, load_factor in enumerate(scan) if shakes_down(float(load_factor))]
    if not good:
        return _limit(start, runs, np.nan, float(scan[0]), None)
    low, high = float(scan[good[-1]]), float(np.append(scan, np.inf)[good[-1] + 1])
    middle = 0.5 * (low + high)
    while np.isfinite(high) and high - low > accuracy * top and low < middle < high:  # floats are finite
        low, high = (middle, high) if shakes_down(middle) else (low, middle)
        middle = 0.5 * (low + high)
    return _limit(start, runs, low, high, _proved_state(problem, low, start, tolerances))


def _proved_state(
    problem: Problem, low: float, start: FloatArray, tolerances: Tolerances
) -> LongTermState | None:
    """The state at the largest of some load factors below ``low`` at which shakedown can be proved."""
    for share in BELOW:
        state = long_term_state(problem, (1.0 - share) * low, start, tolerances=tolerances)
        if state.proved:
            return state
    return None


def _top(problem: Problem) -> float:
    """A little more than the upper bound, so that the scan ends above it."""
    from shakedown.bounds.upper import upper_bound  # LPs are needed only here

    upper = upper_bound(problem)
    if upper.status != "optimal":
        raise UsageError(f"largest: needed because the upper bound is {upper.status}, found none")
    return 1.05 * upper.load_factor


def _limit(
    start: FloatArray,
    runs: dict[float, LongTermState],
    low: float,
    high: float,
    at_proved: LongTermState | None,
) -> TransientLimit:
    scanned = np.array(sorted(runs))
    outcomes = tuple(runs[float(x)].outcome for x in scanned)
    expected = scanned <= low if np.isfinite(low) else np.zeros(len(scanned), dtype=bool)
    return TransientLimit(
        load_factor=low,
        low=low,
        high=high,
        proved=np.nan if at_proved is None else at_proved.load_factor,
        cycling=min((x for x in runs if x > low and _cycles(runs[x])), default=np.inf),
        initial_slip=start,
        scanned=scanned,
        outcomes=outcomes,
        monotone=bool(np.all(np.array([o == Outcome.SHAKEDOWN for o in outcomes]) == expected)),
        at_low=runs.get(low),
        at_high=runs.get(high),
        at_proved=at_proved,
    )


def _cycles(state: LongTermState) -> bool:
    return state.outcome not in (Outcome.SHAKEDOWN, Outcome.UNDECIDED)
