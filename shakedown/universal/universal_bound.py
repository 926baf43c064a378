"""The largest load factor up to which shakedown from every initial state is proved."""

from dataclasses import dataclass, replace
from math import inf, nan
from numbers import Integral
from typing import Any, NamedTuple

from shakedown.bounds.coupling import WEAK, coupling
from shakedown.bounds.lift_off import lift_off_bound
from shakedown.bounds.lower import LowerBound, lower_bound
from shakedown.errors import UsageError
from shakedown.evidence import Missing, sought
from shakedown.model.arguments import checked, require_problem
from shakedown.model.problem import Problem
from shakedown.model.result import Result
from shakedown.model.status import Status
from shakedown.tolerances import DEFAULT, Tolerances
from shakedown.uniqueness.in_contact import Uniqueness, unique_in_contact
from shakedown.universal.closing_box import ClosingBox, closing_box
from shakedown.universal.sharpened_swing import SharpenedSwing, sharpened_swing
from shakedown.universal.swing_bound import SwingBound, swing_bound

INTERVALS = {
    12: 12,
    20: 6,
    40: 2,
}  # by default up to so many nodes, so that it takes some ten seconds at most


@dataclass(frozen=True, eq=False, repr=False)
class UniversalBound(Result):
    """Largest load factor up to which shakedown from every initial state is proved.

    A state is one with all nodes closed that is admissible at some instant of the loop; transient
    load steps, where the problem has them, are over (``after_transient``). For every
    load factor below ``load_factor`` all nodes stay closed, the motion is unique and without
    jumps, and slip ceases. Of a load domain this is said of every path inside it: then only
    the arguments count that ask for no order, Melan's theorem and the swing bound, with the
    lift-off bound over the hull of the corners.

    Attributes
    ----------
    status
        ``"optimal"``; ``"infeasible"`` (no safe slip under the mean load); ``"unbounded"``
        (every load factor is proved); ``"undecided"`` (a linear program ended without an answer).
    load_factor
        λ_U ≤ λ_1; 0 where nothing is proved, NaN where infeasible, inf where unbounded.
    node
        The node that limits the argument; −1 where none does.
    argument
        ``"Melan"``, ``"one node"``, ``"two nodes"``, ``"weak coupling"``, ``"closing box"``, ``"swing"``,
        ``"swing with box"`` or ``"none"``.
    limited_by
        What the argument ends at: ``"first collapse"``, ``"swing"``, ``"closing box"``, ``"lift-off"``,
        ``"uniqueness"``, ``"mean load"``, or for the swing with box ``"gain"`` (a further step would add too
        little) or ``"effort"`` (as many as allowed were made); ``"solver"`` where undecided.
    reason
        The same in words.
    first_collapse
        λ_1, which is not exceeded.
    lift_off_bound
        Below this load factor no admissible slip lifts a node off; NaN where not needed.
    closing, swing, sharpened
        The arguments tried, with the evidence to check them; None where not needed.
    after_transient
        Whether the problem has transient load steps: then nothing is said of a motion
        before they are over.
    missing
        Arguments that might have reached further, had their solver come to an end, and why it did not.
    """

    status: str
    load_factor: float
    node: int
    argument: str
    limited_by: str
    reason: str
    first_collapse: float
    lift_off_bound: float
    closing: ClosingBox
    swing: SwingBound | None
    sharpened: SharpenedSwing | None
    after_transient: bool = False
    missing: tuple[str, ...] = ()

    def document(self) -> dict[str, dict[str, Any]]:
        """What is written as JSON: the number, what limits it, and the closing box beside it."""
        number = {"load_factor": self.load_factor, "node": self.node, "argument": self.argument}
        return {"universal": number, "closing_box": {"load_factor": self.closing.load_factor}}


class _Found(NamedTuple):
    load_factor: float
    node: int
    argument: str
    limited_by: str


@checked
def universal_bound(
    problem: Problem,
    *,
    first_collapse: LowerBound | None = None,
    intervals: int | None = None,
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> UniversalBound:
    """The largest load factor λ_U up to which the joint is proved to shake down from every initial state.

    The largest that any argument gives: Melan's theorem (B = 0), one or two nodes (thesis §4.4) and weak
    coupling, which all reach λ_1; else the closing box, the swing bound, and the swing bound
    in the box of the long run. In every case the nodes must stay closed and the motion unique.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    first_collapse
        λ_1, where it has been computed already.
    intervals
        The effort: how many intervals of load factors the sharpened swing may try, 0 for none. By
        default twelve for up to 12 nodes (about a second), six for up to 20, two for up to 40 (a few
        seconds), else none; each costs several seconds for 40 nodes, a minute for 70.
    certify
        Whether to prove the swing bound in exact arithmetic; by default where that is quick.
    tolerances
        What decides (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range.
    SolverError
        If λ_1 was not given, and a linear program of it ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> bound = universal_bound(shakedown.example("three-node"))
    >>> round(bound.load_factor, 6), bound.node, bound.argument
    (0.3096, 0, 'swing')
    """
    require_problem(problem)
    intervals = _effort(problem, intervals)
    if not isinstance(first_collapse, LowerBound | None):
        raise UsageError(f"first_collapse: expected a LowerBound, found {type(first_collapse).__name__}")
    lower = lower_bound(problem, tolerances=tolerances) if first_collapse is None else first_collapse
    closing = closing_box(problem)
    if lower.status == Status.INFEASIBLE:
        return _without(lower, closing, nan, "mean load", "no slip is safe under the mean load")
    if lower.load_factor == 0.0:
        reason = f"node {lower.node} collapses under the mean load alone: locked-in slip can lift it off"
        return _without(lower, closing, 0.0, "first collapse", reason)
    known = sought(unique_in_contact, problem, tolerances=tolerances)
    uniqueness = Uniqueness(None, known.reason) if isinstance(known, Missing) else known
    complete = complete_argument(problem, uniqueness)
    if not (uniqueness or complete):
        reason = f"the motion is not proved to be unique: {uniqueness.argument}"
        return _without(lower, closing, 0.0, "uniqueness", reason)
    lift = _lift_off(problem, lower, complete, tolerances)
    if isinstance(lift, Missing):
        return _undecided(lower, closing, f"the lift-off bound is missing: {lift.reason}")
    if complete:
        found = _Found(lower.load_factor, lower.node, complete, "first collapse")
        return _result(lower, closing, found, lift)
    swing = sought(swing_bound, problem, certify=certify, tolerances=tolerances)
    if isinstance(swing, Missing):
        return _undecided(lower, closing, f"the swing bound is missing: {swing.reason}")
    found = _Found(swing.load_factor, swing.node, "swing", "swing")
    if closing.load_factor > swing.load_factor:
        found = _Found(closing.load_factor, closing.node, "closing box", "closing box")
    climb = sought(_sharpened, problem, found, min(lower.load_factor, lift), intervals, tolerances)
    missing = (f"swing with box: {climb.reason}",) if isinstance(climb, Missing) else ()
    sharpened = None if isinstance(climb, Missing) else climb
    if sharpened is not None and sharpened.load_factor > found.load_factor:
        found = _Found(sharpened.load_factor, -1, "swing with box", sharpened.limited_by)
    return replace(_result(lower, closing, found, lift, swing, sharpened), missing=missing)


def _lift_off(problem: Problem, lower: LowerBound, complete: str, tolerances: Tolerances) -> float | Missing:
    """The lift-off bound; inf where the argument does not need it."""
    if complete == "Melan":
        return inf
    return sought(lift_off_bound, problem, lower.load_factor, tolerances=tolerances)


def _effort(problem: Problem, intervals: int | None) -> int:
    """How many intervals may be tried."""
    if intervals is None:
        return next((effort for most, effort in INTERVALS.items() if problem.n <= most), 0)
    if not isinstance(intervals, Integral) or intervals < 0:
        raise UsageError(f"intervals: expected a whole number >= 0, found {intervals!r}")
    return int(intervals)


def _sharpened(
    problem: Problem, found: _Found, cap: float, intervals: int, tolerances: Tolerances
) -> SharpenedSwing | None:
    """The climb from what is found towards what cannot be exceeded; None where there is nothing to gain."""
    start = found.load_factor
    if problem.is_domain or not (0.0 < start < cap < inf and intervals > 0):
        return None
    return sharpened_swing(problem, start, cap, intervals=intervals, tolerances=tolerances)


def complete_argument(problem: Problem, uniqueness: Uniqueness) -> str:
    """The argument that proves shakedown all the way to λ_1 while all nodes stay closed; empty for none.

    Without coupling it holds for every path inside a load domain; the others follow a loop.
    """
    if not problem.B.any():
        return "Melan"
    if problem.is_domain:
        return ""
    if problem.n <= 2 and uniqueness:
        return "one node" if problem.n == 1 else "two nodes"
    return "weak coupling" if coupling(problem).bound <= WEAK else ""


def _without(
    lower: LowerBound, closing: ClosingBox, load_factor: float, limited_by: str, reason: str
) -> UniversalBound:
    """The answer where nothing is proved."""
    return UniversalBound(
        status=Status.INFEASIBLE if lower.status == Status.INFEASIBLE else Status.OPTIMAL,
        load_factor=load_factor,
        node=lower.node if limited_by == "first collapse" else -1,
        argument="none",
        limited_by=limited_by,
        reason=reason,
        first_collapse=lower.load_factor,
        lift_off_bound=nan,
        closing=closing,
        swing=None,
        sharpened=None,
        after_transient=lower.problem.q_transient is not None,
    )


def _undecided(lower: LowerBound, closing: ClosingBox, reason: str) -> UniversalBound:
    """The answer where a program on which it rests came to no end."""
    return replace(_without(lower, closing, nan, "solver", reason), status=Status.UNDECIDED)


def _result(
    lower: LowerBound,
    closing: ClosingBox,
    found: _Found,
    lift: float,
    swing: SwingBound | None = None,
    sharpened: SharpenedSwing | None = None,
) -> UniversalBound:
    if min(lower.load_factor, lift) < found.load_factor:
        limit, node = ("lift-off", -1) if lift < lower.load_factor else ("first collapse", lower.node)
        found = _Found(min(lower.load_factor, lift), node, found.argument, limit)
    return UniversalBound(
        status=Status.OPTIMAL if found.load_factor < inf else Status.UNBOUNDED,
        load_factor=found.load_factor,
        node=found.node,
        argument=found.argument,
        limited_by=found.limited_by,
        reason=_reason(found, lift),
        first_collapse=lower.load_factor,
        lift_off_bound=lift,
        closing=closing,
        swing=swing,
        sharpened=sharpened,
        after_transient=lower.problem.q_transient is not None,
    )


def _reason(found: _Found, lift: float) -> str:
    ends = {
        "first collapse": f"node {found.node} collapses there",
        "lift-off": f"from {lift:.6g} on locked-in slip can lift a node off",
        "swing": f"from there on node {found.node} may slip forward and backward at the same reaction A v",
        "closing box": f"from there on node {found.node} may slip both ways in the box of the long run",
        "gain": "a further step would add too little",
        "effort": "as many steps as allowed were made",
    }
    return f"{found.argument}: {ends[found.limited_by]}"
