"""What the limits of a joint in the plane or in space mean, and where the nominal load lies between them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from shakedown.bounds.bound_result import Bound
from shakedown.ground.errors import Missing, present
from shakedown.ground.round_off import MUCH
from shakedown.ground.shown_values import down, up
from shakedown.ground.status import Guarantee, Status
from shakedown.joint.loading import loading
from shakedown.report.assessment_words import IN_CONTACT, admissible_in_words, proved_up_to, start_in_words
from shakedown.report.node_words import node_in_words
from shakedown.report.zone_words import without_safe_slip_in_words, zone_in_words

if TYPE_CHECKING:
    from shakedown.assessment.every_limit import JointLimits
    from shakedown.joint.problem import Problem

NO_FIRST_COLLAPSE = (
    "There is no first collapse λ_1 in space: it is defined by the two opposite friction limits of a node, "
    "and in space the limit is a disc."
)


def bounds_in_words(limits: JointLimits) -> list[str]:
    """What a user can rely on below, between and above the limits, and where λ = 1 lies.

    Every sentence is about the joint with all nodes in contact, or names the open ones.

    Examples
    --------
    >>> import shakedown
    >>> for line in bounds_in_words(shakedown.assess(shakedown.example("uncoupled")).details):
    ...     print(line)
    Below λ_1 = 0.646554 the joint, closed at all nodes, shakes down from every initial state (no ...).
    The nominal load (λ = 1) lies at or above λ_max.
    """
    upper, lower = limits.upper, present(limits.lower)
    if upper.open_nodes:
        closed = [] if lower is None else [_closed(limits, lower)]
        said = [*closed, *zone_in_words(upper, limits.problem)]
    elif nothing_safe := without_safe_slip_in_words(upper):
        said = [nothing_safe]
    elif is_constant(limits.problem):
        said = [_constant(lower, upper)]
    else:
        nominal = f"The nominal load (λ = 1) lies {_nominal_load(limits, lower)}."
        said = [*_below_and_above(limits, lower), nominal]
    return [*said, *reservations_in_words(limits)]


def _below_and_above(limits: JointLimits, lower: Bound | None) -> list[str]:
    """What holds below, between and above the limits of a joint with all nodes in contact."""
    upper = limits.upper
    begins = upper.least_load_factor > 0 if lower is None else lower.status == Status.INFEASIBLE
    if begins:
        return _from_least(upper, limits.problem)
    endless = upper.status == Status.UNBOUNDED
    above = [above_in_words(upper, limits.problem)] if endless else []  # otherwise certain_in_words says it
    if lower is None:
        return [*_open_in_space(limits), *above]
    gap = endless and lower.status == Status.OPTIMAL
    between = [_between(limits, lower)] if limits.bounds.have_gap or gap else []
    return [_below(limits, lower), *between, *above]


def _closed(limits: JointLimits, lower: Bound) -> str:
    """What holds with all nodes closed, where the upper bound is that of a zone."""
    if lower.status == Status.INFEASIBLE:
        return f"No slip is safe {IN_CONTACT}, under the mean load alone."
    return _below(limits, lower)


def _below(limits: JointLimits, lower: Bound) -> str:
    """What holds below λ_1."""
    universal = limits.universal
    if lower.load_factor == 0:
        return f"λ_1 = 0, so no load factor is safe from every initial state: {_why(lower)}."
    where = f"Below λ_1 = {down(lower.load_factor)}"
    if lower.status == Status.UNBOUNDED:
        where = "At every load factor"
    if lower.guarantee == Guarantee.PROVED:
        return (
            f"{where} the joint, closed at all nodes{_transient_over(lower)}, shakes down from every initial "
            f"state ({_why(lower)})."
        )
    claim = "every node keeps a range of slips, but shakedown is not proved from every initial state"
    known = proved_up_to(universal)
    if down(known) == down(lower.load_factor):
        states = f"every initial state {admissible_in_words(universal)}"
        return f"{where} (= λ_U) the joint shakes down from {states}: it is proved."
    if known > 0:
        where = f"Between λ_U = {down(known)} and λ_1 = {down(lower.load_factor)}"
        if lower.status == Status.UNBOUNDED:
            where = f"Above λ_U = {down(known)}"
    return f"{where} {claim} (guarantee of λ_1: {lower.guarantee}): {_why(lower)}."


def _why(lower: Bound) -> str:
    return str(lower.to_dict()["reason"])


def _transient_over(lower: Bound) -> str:
    """λ_1 is about the periodic loop; it says nothing about transient load steps before it."""
    return "" if lower.problem.q_transient is None else " when the transient is over"


def _from_least(upper: Bound, problem: Problem) -> list[str]:
    """The bounds where the mean load alone has no safe slip, but load factors from λ_lo on do."""
    elsewhere = problem.directions == 1
    none = " So λ_1, which is counted from there, does not exist." * elsewhere
    sentences = [
        f"Below λ_lo = {down(upper.least_load_factor)} there is no safe slip {IN_CONTACT}: "
        f"under the mean load alone none keeps every node within its friction limits.{none}"
    ]
    if upper.status == Status.UNBOUNDED:
        return [*sentences, f"From λ_lo on a safe slip exists at every load factor: {upper.reason}."]
    exist = f"Safe slips exist from λ_lo up to λ_max = {down(upper.load_factor)}."
    return [*sentences, exist, above_in_words(upper, problem)]


def is_constant(problem: Problem) -> bool:
    """Whether the loading does not change over the period, so that the load factor multiplies nothing."""
    loop = loading(problem)
    return not (loop.q1.any() or loop.p1.any())


def _constant(lower: Bound | None, upper: Bound) -> str:
    """What the bounds mean where the load factor makes no difference."""
    said = "The loading does not change over the period, so the load factor makes no difference: with all "
    said += "nodes in contact there is a slip in which no node slips"
    if upper.status == Status.UNBOUNDED and lower is not None and lower.load_factor == 0:
        return f"{said}, but not every initial slip leads to one ({_why(lower)})."
    return f"{said}."


def _between(limits: JointLimits, lower: Bound) -> str:
    """What decides between λ_1 and λ_max."""
    upper, before = limits.upper, limits.through_transient
    finite, domain = upper.status == Status.OPTIMAL, lower.problem.is_domain
    where, safe = ("Between λ_1 and λ_max", "the") if finite else ("Above λ_1", "a")
    node = node_in_words(lower.problem, lower.node)
    what = "the initial state" if before is None else "the slip that is locked in when the transient is over"
    every, usual = (", on every path", ", with the corners in their order") if domain else ("", "")
    lasting = "" if before is None else f"; {_through_transient(before, limits, lower.load_factor)}"
    return (
        f"{where} {what} decides: from {safe} safe slip the joint shakes down{every}; from the critical slip "
        f"state, where {node} has lost its range of safe slips, it usually does not{usual}{lasting}."
    )


def _through_transient(before: Bound, limits: JointLimits, first: float) -> str:
    """What transient load steps leave of the safe slips that are locked in before them."""
    near, last = 1 - limits.tolerances.feasibility, limits.upper.load_factor
    low, high = before.least_load_factor, before.load_factor
    if before.status == Status.INFEASIBLE or high * near <= first:
        return "the transient load steps move every safe slip that is locked in before them"
    begins = f"from λ = {up(low)} " if low * near > first else ""
    if high >= last * near and not begins:
        return "there are safe slips that the transient load steps do not move either"
    until = f"up to λ = {down(high)} " if high < last * near else ""
    return (
        f"{begins}{until}there are safe slips that the transient load steps do not move either, "
        f"{'elsewhere' if begins else 'above'} they move every one"
    )


def above_in_words(upper: Bound, problem: Problem) -> str:
    """What is excluded above λ_max, or that nothing is."""
    if upper.status == Status.UNBOUNDED:
        return f"A safe slip exists at every load factor {IN_CONTACT}: {upper.reason}."
    often = " on a path that returns to all corners" * problem.is_domain
    return f"Above λ_max = {up(upper.load_factor)} it cannot shake down{often} {IN_CONTACT}."


def _nominal_load(limits: JointLimits, lower: Bound | None) -> str:
    """Where λ = 1 lies between the limits; where that leaves it open, whether this state is proved."""
    upper, known = limits.upper, proved_up_to(limits.universal)
    finite = upper.status == Status.OPTIMAL
    if upper.least_load_factor > 1:
        return "below λ_lo"
    if known > 1:
        return f"below λ_U: proved from every initial state {admissible_in_words(limits.universal)}"
    if upper.load_factor <= 1:
        return "at or above λ_max"
    if lower is not None and lower.load_factor > 1:
        if lower.guarantee == Guarantee.PROVED:
            return "below λ_1"
        place = "between λ_U and λ_1" if known > 0 else "below λ_1"
    elif lower is not None and lower.status != Status.INFEASIBLE:
        place = "between λ_1 and λ_max" if finite else "above λ_1"
    elif lower is None and finite:
        place = "between λ_U and λ_max" if known > 0 else "below λ_max"
    else:
        place = "where safe slips exist"
    return place + from_here_in_words(limits)


def from_here_in_words(limits: JointLimits) -> str:
    """Whether shakedown at λ = 1 is proved from this state, where it is not from every state."""
    energy, here = limits.energy, limits.from_state
    if energy.open_nodes:
        return ""
    start = f"starting {start_in_words(energy.initial_slip)}"
    if here.kind != "energy" and here.load_factor > 1:
        return f"; {start} the joint is proved to shake down there"
    if energy.least_load_factor < 1 < energy.load_factor:
        return f", and below λ_E: {start} the joint is proved to shake down"
    return f"; {start} no bound proves shakedown there"


def reservations_in_words(limits: JointLimits) -> list[str]:
    """Why a number is not certified or not fully accurate, where that is so."""
    sentences = [f"{missing} (no number is touched by it)." for missing in _missing(limits)]
    if limits.energy.uncertified:
        sentences.append(f"λ_E is not certified: {limits.energy.uncertified}.")
    for name, bound in (("λ_1", limits.lower), ("λ_max", limits.upper)):
        if isinstance(bound, Missing):
            continue
        if bound.uncertified:
            sentences.append(f"{name} is not certified: {bound.uncertified}.")
        if bound.reduced_accuracy:
            sentences.append(f"{name} has reduced accuracy (1e-7): limited by floating-point precision.")
    return sentences if limits.open_nodes else [*sentences, *_slip_bound_ends(limits)]


def _slip_bound_ends(limits: JointLimits) -> Iterator[str]:
    """Why λ_S proves nothing, or much less than λ_E."""
    slip = limits.accumulated
    where = f", at {node_in_words(limits.problem, slip.node)}" if slip.node >= 0 else ""
    if slip.status in (Status.INFEASIBLE, Status.UNDECIDED):
        yield f"There is no bound on total slip (λ_S) from this state: {slip.reason}{where}."
    elif slip.load_factor < (1.0 - MUCH) * limits.energy.load_factor:
        start, until = start_in_words(slip.initial_slip), f"λ_S = {down(slip.load_factor)}"
        yield (
            f"Starting {start}, a bound on the total slip of each node is proved up to {until}, for any "
            f"order of the loads; not above that, because {slip.limited_because}{where}."
        )


def _missing(limits: JointLimits) -> Iterator[str]:
    """Evidence that a solver failed to give, and why."""
    yield from (f"λ_max: no {missing}" for missing in limits.upper.missing)
    swing = limits.universal.swing
    if swing is not None and swing.uncertified:
        yield f"λ_U: no certificate of the swing bound: {swing.uncertified}"


def _open_in_space(limits: JointLimits) -> list[str]:
    """What remains open between the proved limit and λ_max, where there is no first collapse."""
    known = proved_up_to(limits.universal)
    if known >= limits.upper.load_factor:
        return []
    finite = limits.upper.status == Status.OPTIMAL
    start = "λ_U" if known > 0 else "λ = 0"
    where = f"Between {start} and λ_max" if finite else f"Above {start}"
    return [
        f"{where} shakedown depends on the initial state, or is open; λ_E is what is proved of one state. "
        f"{NO_FIRST_COLLAPSE}"
    ]
