"""Load factors up to which the given history shakes down, or slips no farther than allowed."""

from bisect import bisect_left
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cache
from math import inf, isfinite, nan, nextafter
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from shakedown.bounds.bound_result import Bound, Evidence
from shakedown.bounds.registry import takes_long
from shakedown.bounds.upper import upper_bound
from shakedown.ground.argument_kinds import check_count
from shakedown.ground.constants import CYCLES, FOUR_DIGITS, MOST_ENTRIES, SIX_DIGITS, THREE_DIGITS, FloatArray
from shakedown.ground.errors import Missing, UsageError, attempt
from shakedown.ground.shown_values import down
from shakedown.ground.status import Outcome, Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import on_one_thread
from shakedown.joint.arguments import checked, checked_initial_slip, is_finite
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.motion_start import SURELY_BELOW as CERTAIN
from shakedown.long_term.motion_start import MotionStart, bound_of_start
from shakedown.long_term.simulation import SlipCriterion, check_slip_below, slip_criterion
from shakedown.long_term.state import LongTermState

SCANNED = 20  # load factors besides λ = 0; fixed, so that a joint has one λ_T
BELOW = (  # shares below λ_T at which a proof is sought
    0.0, 1e-6, 1e-5, 1e-4, 2e-4, 4e-4, 6e-4, 8e-4, 1e-3, 2e-3, 5e-3, 1e-2, 1.5e-2, 2e-2, 3e-2, 0.1, 0.3,
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class ScannedHistory(Evidence):
    """What only λ_T has, the largest load factor at which one history was found to shake down.

    The bound is infeasible where it does at no load factor scanned. Where it does at every one, the load
    factor is the last of these, and the status undecided.

    Attributes
    ----------
    low, high
        It shakes down at ``low`` (λ_T) and not at ``high``; ``high`` is infinite
        where everything scanned shakes down, ``low`` NaN where nothing does.
    proved
        The largest load factor at or below ``low`` at which shakedown was proved (the motion comes
        into an energy ball, or into a state from which its total slip is bounded); NaN where no proof was
        found. The proof is for this load factor only, not for smaller ones.
    cycling
        The smallest simulated load factor above ``low`` at which a long-term state
        other than shakedown was found: cyclic slip, ratchetting, or separation, where nodes
        open and close and none slips in contact (``outcomes`` says which); infinite where there
        is none.
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
    def followed(self) -> dict[str, Any]:
        """What is proved by following cycles: at which load factor, after how many cycles.

        NaN and None where nothing is.
        """
        state = self.at_proved
        cycles = None if state is None else state.proof_found.cycles
        return {"load_factor": self.proved, "cycles": cycles, "proved": state is not None}


def of_joint(limits: Any) -> Bound | Missing | None:
    """λ_T of a joint whose limits are computed (``registry.BOUNDS``); None without a finite λ_max."""
    end = scan_end(limits.upper)
    if end is None:
        return None
    limits.note_what_is_known()
    history, long = history_of(limits), takes_long(limits.problem)
    if long and not limits.open_nodes:
        history.runs[end] = limits.slip_beyond(end, history.start, CYCLES)[0].settled
    usual = FOUR_DIGITS if long else SIX_DIGITS  # following it takes seconds, longer near λ_T
    return attempt(scanned_limit, history, end, SCANNED, limits.accuracy or usual)


@checked
@on_one_thread
def transient_limit(
    problem: Problem,
    initial_slip: ArrayLike | None = None,
    *,
    open_nodes: Iterable[int] = (),
    largest: float | None = None,
    steps: int = SCANNED,
    accuracy: float = 1e-9,
    tolerances: Tolerances = DEFAULT,
) -> Bound:
    """The largest load factor at which the simulated motion from an initial slip shakes down (thesis §4.3.5).

    Outcomes need not be monotone in λ. Therefore the range is scanned in equal
    steps and the last change from shakedown to another outcome is bisected, both
    with exact long-term states; everything simulated is reported. A little below the
    limit the shakedown is then proved (:func:`energy_ball`, :func:`accumulated_bound` after some cycles), at
    that load factor: the nearer to the limit, the more cycles it takes. Of a load domain the corners are
    followed in the order given, which is one path of many.

    With two tangential directions a state may be undecided after the cycles allowed: towards such a load
    factor the change is not narrowed down beyond a thousandth of the scan.

    Parameters
    ----------
    problem
        The joint, its transient load steps and its loading loop.
    initial_slip : (n,), optional
        Slip before the transient [length]; zero by default.
    open_nodes
        Nodes that are open at the start, as for :func:`evolve`.
    largest
        Upper end of the scan; by default a little above λ_max (that of the zone, with
        nodes open), where there is one, beyond which nothing shakes down.
    steps
        Number of load factors scanned, beside λ = 0. ``verify`` and ``sweep`` scan as many.
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
    start, opened = checked_initial_slip(problem, initial_slip), tuple(open_nodes)
    top = _end(problem, opened, tolerances) if largest is None else largest
    if top is None:
        raise UsageError("largest: expected a load factor, as λ_max is not finite and positive, found none")
    return scanned_limit(History(problem, start, opened, tolerances), top, steps, accuracy)


@dataclass(frozen=True)
class History:
    """The long-term states of one history at many load factors, each found once."""

    problem: Problem
    start: FloatArray
    open_nodes: tuple[int, ...]
    tolerances: Tolerances
    runs: dict[float, LongTermState] = field(default_factory=dict)

    def at(self, load_factor: float) -> LongTermState:
        """The state at a load factor, which is recorded."""
        return self.runs.setdefault(load_factor, self.followed(load_factor))

    def followed(self, load_factor: float) -> LongTermState:
        """The same without a record."""
        if load_factor in self.runs:
            return self.runs[load_factor]
        return long_term_state(
            self.problem, load_factor, self.start, open_nodes=self.open_nodes, tolerances=self.tolerances
        )

    def shakes_down(self, load_factor: float) -> bool:
        """Whether it shakes down at a load factor."""
        return self.at(load_factor).outcome == Outcome.SHAKEDOWN


def history_of(limits: Any) -> History:
    """The long-term states of a joint whose limits are computed, from the slip that is asked about."""
    start = checked_initial_slip(limits.problem, limits.initial_slip)
    return History(limits.problem, start, (), limits.tolerances)


@on_one_thread
def scanned_limit(history: History, top: float, steps: int, accuracy: float) -> Bound:
    """λ_T of a history, scanned up to an end."""
    check_scan(top, steps, accuracy)
    scan = np.union1d(np.linspace(0.0, top, steps + 1), _certain(history, top)).tolist()
    good = [k for k, load_factor in enumerate(scan) if history.shakes_down(load_factor)]
    low, high = (scan[good[-1]], [*scan, inf][good[-1] + 1]) if good else (nan, scan[0])
    # of the end of the scan: limit of bisection towards an undecided outcome in space
    return _found(history, *_narrowed(history, low, high, accuracy * top, THREE_DIGITS * top))


def _certain(history: History, top: float) -> list[float]:
    """The load factors up to which shakedown is proved from the start, as far as ``top``."""
    origin = MotionStart(history.problem, 0.0, history.tolerances, history.start, history.open_nodes)
    bounds = (bound_of_start(origin), bound_of_start(origin, "accumulated"))
    ends = [nextafter(CERTAIN * bound.load_factor, 0.0) for bound in bounds if not isinstance(bound, Missing)]
    return [end for end in ends if 0.0 < end <= top]


def _narrowed(history: History, low: float, high: float, width: float, coarse: float) -> tuple[float, float]:
    """Narrow the change from shakedown to a width; towards an undecided state in space to the coarse width.

    Where such states begin depends on the cycles allowed; where a body begins to slide away does not.
    Most joints cycle right above what is proved: for large ones the distance from there is doubled first,
    beginning with the interval in which bisection would end.
    """

    def is_open(load_factor: float) -> bool:
        found, in_space = history.at(load_factor), history.problem.directions > 1
        return in_space and found.outcome == Outcome.UNDECIDED and not found.slides_away

    if takes_long(history.problem) and isfinite(high) and low in _certain(history, high):
        ends = [high]
        while ends[-1] - low > width:
            ends.append(0.5 * (low + ends[-1]))
        while len(ends) > 1 and history.shakes_down(ends[-1]):
            low = ends.pop()
        high = high if is_open(ends[-1]) else ends[-1]
    return bisected(history.shakes_down, low, high, lambda end: max(width, coarse) if is_open(end) else width)


def _found(history: History, low: float, high: float) -> Bound:
    """Everything found, with a proof near ``low``."""
    runs = history.runs
    known = [runs[at] for at in sorted(_certain(history, low), reverse=True)]
    at_proved = _proved(history, low) or next((state for state in known if state.proved), None)
    scanned = sorted(runs)
    shaken = [x for x in scanned if runs[x].outcome == Outcome.SHAKEDOWN]
    others = [x for x in scanned if x not in shaken]
    cycling = [x for x in others if x > low and runs[x].outcome != Outcome.UNDECIDED]
    evidence = ScannedHistory(
        low=low,
        high=high,
        proved=nan if at_proved is None else at_proved.load_factor,
        cycling=min(cycling, default=inf),
        initial_slip=history.start,
        scanned=np.array(scanned),
        outcomes=tuple(runs[x].outcome for x in scanned),
        monotone=max(shaken, default=-inf) < min(others, default=inf),
        at_low=runs.get(low),
        at_high=runs.get(high),
        at_proved=at_proved,
    )
    status, reason = Status.OPTIMAL, "" if evidence.monotone else "outcomes are not monotone in λ"
    if not isfinite(low):
        status, reason = Status.INFEASIBLE, "no load factor scanned shakes down"
    elif not isfinite(high):
        status, reason = Status.UNDECIDED, f"every load factor scanned shakes down, up to {down(low)}"
    return Bound("transient", status, low, evidence, reason=reason)


def _proved(history: History, low: float) -> LongTermState | None:
    """The state at the largest of some load factors up to ``low`` at which shakedown can be proved.

    Only above what is proved from the start. With two tangential directions, where every attempt solves cone
    programs, by bisection.
    """
    if not isfinite(low):
        return None
    known = max(_certain(history, low), default=-inf)

    @cache
    def below(share: float) -> LongTermState:
        return history.followed((1.0 - share) * low)

    def proved(share: float) -> bool:
        return (1.0 - share) * low <= known or below(share).proved

    if history.problem.directions == 1:
        found = next((share for share in BELOW if proved(share)), 1.0)
    else:
        first = bisect_left(BELOW, True, key=proved)
        found = BELOW[first] if first < len(BELOW) else 1.0
        if 0 < first < len(BELOW):
            # of the distance between two of these: where bisection ends, with two tangential directions
            width = 0.3 * (found - BELOW[first - 1])
            found = bisected(lambda share: not proved(share), BELOW[first - 1], found, lambda _: width)[1]
    return below(found) if found < 1.0 and (1.0 - found) * low > known else None


def check_scan(largest: float, steps: int, accuracy: float) -> None:
    """Raise ``UsageError`` where the end, the number or the accuracy of a scan is out of range."""
    if not (is_finite(largest) and largest > 0):
        raise UsageError(f"largest: expected a positive load factor, found {largest!r}")
    check_count("steps", steps, MOST_ENTRIES)
    if not (is_finite(accuracy) and 0 < accuracy < 1):
        raise UsageError(f"accuracy: expected a number between 0 and 1, found {accuracy}")


def bisected(
    holds: Callable[[float], bool], low: float, high: float, width: Callable[[float], float]
) -> tuple[float, float]:
    """Bisect a change from holding at ``low`` to not holding at ``high``; unchanged where there is none.

    The width may depend on the end at which it does not hold.
    """
    middle = 0.5 * (low + high)
    while np.isfinite(high) and high - low > width(high) and low < middle < high:  # ends as floats are finite
        low, high = (middle, high) if holds(middle) else (low, middle)
        middle = 0.5 * (low + high)
    return low, high


def scan_end(upper: Bound) -> float | None:
    """Slightly more than λ_max, so that the scan ends above it; None where that is not positive."""
    largest = 1.05 * upper.load_factor  # beyond λ_max nothing shakes down
    return largest if 0 < largest < np.inf else None


def _end(problem: Problem, open_nodes: tuple[int, ...], tolerances: Tolerances) -> float | None:
    """Where a scan ends by default; None where λ_max is not finite and positive."""
    return scan_end(upper_bound(problem, open_nodes=open_nodes, certify=False, tolerances=tolerances))


@dataclass(frozen=True, eq=False, repr=False)
class SlipLimit(Result):
    """Result of :func:`slip_limit`.

    Attributes
    ----------
    below
        The length that slip ranges are to stay below [length].
    load_factor
        The largest load factor such that they do at every simulated one up to it; NaN where
        they do not at λ = 0.
    largest, node
        The largest slip range there [length], and its node, −1 where nothing slips.
    exceeded_at
        The smallest load factor simulated at which one does not, or that is undecided; inf where there
        is none.
    monotone
        Whether none of those simulated above stays below it again.
    initial_slip : (n,)
        Slip at the start [length].
    scanned : (s,)
        Load factors simulated, in increasing order.
    slip_range : (s,)
        The largest slip range of a node at each [length]: infinite where slips grow for ever, NaN where
        undecided (:class:`~shakedown.long_term.simulation.SlipCriterion`).
    outcomes : (s,)
        Long-term state at each.
    """

    DOCUMENT: ClassVar[str] = (
        "below load_factor largest node exceeded_at monotone initial_slip scanned slip_range outcomes"
    )
    TABLE: ClassVar[str] = "scanned slip_range outcomes"

    below: float
    load_factor: float
    largest: float
    node: int
    exceeded_at: float
    monotone: bool
    initial_slip: FloatArray
    scanned: FloatArray
    slip_range: FloatArray
    outcomes: tuple[Outcome, ...]


@checked
@on_one_thread
def slip_limit(
    problem: Problem,
    slip_below: float,
    initial_slip: ArrayLike | None = None,
    *,
    largest: float | None = None,
    steps: int = SCANNED,
    accuracy: float = 1e-4,
    tolerances: Tolerances = DEFAULT,
) -> SlipLimit:
    """The load factor up to which the slip range of every node stays below a length in the long run.

    Slip ranges need not grow with λ. Therefore the range is scanned in equal steps, and the first
    change to a slip that is too large is bisected, both with exact long-term states; everything
    simulated is reported. It is about the load factors simulated, from one initial slip: nothing is
    proved of those between them. Of a load domain the corners are followed in the order given, which
    is one path of many.

    Parameters
    ----------
    problem
        The joint, its transient load steps and its loading loop.
    slip_below
        The length, > 0.
    initial_slip : (n,), optional
        Slip before the transient [length]; zero by default.
    largest
        Upper end of the scan, doubled until slips are too large there, ten times at most; by default
        a little above λ_max, 1 where that is none.
    steps
        Number of load factors scanned, beside λ = 0.
    accuracy
        Width of the final interval, relative to the upper end.
    tolerances
        What counts as zero, as reached and as periodic (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    From slip zero the two-node system shakes down up to 0.7315; slips of 0.1 allow a little more:

    >>> import shakedown
    >>> limit = slip_limit(shakedown.example("two-node"), 0.1)
    >>> round(limit.load_factor, 3), bool(limit.largest < 0.1), limit.node, limit.monotone
    (0.749, True, 1, True)
    """
    start = checked_initial_slip(problem, initial_slip)
    check_slip_below(slip_below)
    check_scan(1.0 if largest is None else largest, steps, accuracy)
    history = History(problem, start, (), tolerances)
    found = dict[float, SlipCriterion]()

    def met(load_factor: float) -> bool:
        if load_factor not in found:
            found[load_factor] = slip_criterion(history.at(load_factor), slip_below, tolerances)
        return found[load_factor].met is True

    top = largest or _end(problem, (), tolerances) or 1.0
    # at most so many doublings of the end of the scan, while slips there are small enough
    for _ in range(10):
        if met(top):
            top *= 2.0
    for load_factor in np.linspace(0.0, top, steps + 1).tolist():
        met(load_factor)
    first = min((x for x in found if not met(x)), default=inf)
    last = max((x for x in found if x < first), default=nan)
    low, high = bisected(met, last, first, lambda _: accuracy * top)
    at_low = found.get(low, SlipCriterion(slip_below, False, nan, -1))
    scanned = sorted(found)
    return SlipLimit(
        below=slip_below,
        load_factor=low,
        largest=at_low.largest,
        node=at_low.node,
        exceeded_at=high,
        monotone=not any(met(load_factor) for load_factor in scanned if load_factor > high),
        initial_slip=start,
        scanned=np.array(scanned),
        slip_range=np.array([found[load_factor].largest for load_factor in scanned]),
        outcomes=tuple(history.at(load_factor).outcome for load_factor in scanned),
    )
