"""Up to which load factor do all slips stay below a length?"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf, nan
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from shakedown.assessment.transient_limit import SCANNED, History, bisected, check_scan, scan_end
from shakedown.bounds.upper import upper_bound
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, checked_initial_slip
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.slip_criterion import SlipCriterion, check_slip_below, slip_criterion

DOUBLINGS = 10  # at most so many doublings of the end of the scan, while slips there are small enough


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
        undecided (:class:`~shakedown.long_term.slip_criterion.SlipCriterion`).
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
    open_nodes: Iterable[int] = (),
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
    open_nodes
        Nodes that are open at the start, as for :func:`simulate`.
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
    start, opened = checked_initial_slip(problem, initial_slip), tuple(open_nodes)
    check_slip_below(slip_below)
    check_scan(1.0 if largest is None else largest, steps, accuracy)
    history = History(problem, start, opened, tolerances)
    found = dict[float, SlipCriterion]()

    def met(load_factor: float) -> bool:
        if load_factor not in found:
            found[load_factor] = slip_criterion(history.at(load_factor), slip_below, tolerances)
        return found[load_factor].met is True

    def first_change() -> tuple[float, float]:
        high = min((x for x in found if not met(x)), default=inf)
        return max((x for x in found if x < high), default=nan), high

    top = largest or _first_end(problem, opened, tolerances)
    for _ in range(DOUBLINGS):
        if met(top):
            top *= 2.0
    for load_factor in np.linspace(0.0, top, steps + 1).tolist():
        met(load_factor)
    bisected(met, *first_change(), lambda _: accuracy * top)
    low, high = first_change()
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


def _first_end(problem: Problem, open_nodes: tuple[int, ...], tolerances: Tolerances) -> float:
    """Slightly more than the upper bound; 1 where there is none."""
    upper = upper_bound(problem, open_nodes=open_nodes, certify=False, tolerances=tolerances)
    return scan_end(upper) or 1.0
