"""What the bounds mean for the joint, in sentences that the command line and the report share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from decimal import Decimal
from typing import TYPE_CHECKING

import numpy as np

from shakedown.assessment.from_state import box_proves_more
from shakedown.ground.shown_values import down as down
from shakedown.ground.shown_values import up as up
from shakedown.ground.status import Outcome, Said, Status
from shakedown.joint.loading import loading
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.joint.units import loads_in_words as loads_in_words
from shakedown.joint.units import units_of, work_unit
from shakedown.report.node_words import node_in_words as node_in_words
from shakedown.report.node_words import pinned_in_words, slipping_nodes
from shakedown.report.zone_words import open_in_words, zone_in_words

if TYPE_CHECKING:
    from shakedown.assessment.assess import Assessment
    from shakedown.assessment.every_limit import JointLimits
    from shakedown.assessment.shakedown_bounds import LowerBound, ShakedownBounds, UpperBound
    from shakedown.assessment.transient_limit import TransientLimit
    from shakedown.bounds.energy.energy_bound import EnergyBound
    from shakedown.joint.problem import Problem
    from shakedown.long_term.simulation import Simulation
    from shakedown.planar.collapse.box_bound import BoxBound
    from shakedown.planar.enumeration.critical import CriticalLoadFactors
    from shakedown.planar.friction.thresholds import FrictionThresholds, Threshold
    from shakedown.planar.universal.guarantee_curve import GuaranteeCurve
    from shakedown.planar.universal.universal_bound import UniversalBound
    from shakedown.verification.runs import Run


LARGEST_USUAL_FRICTION = 5.0
MANY = 10**15  # subsets, from here on only their order of magnitude is said
SEPARATION = (
    "Separation: within the period nodes open and close, and none slips while it is closed, except "
    "perhaps in a jump."
)
BOX = "by the box of slips that it cannot leave"
ARGUMENTS = {  # what the names of the arguments for λ_U stand for, where they do not speak for themselves
    "Melan": "slip changes no pressure",
    "differences": "no slip raises the differences between nodes",
    "swing": "a potential falls with every slip",
}
LOAD_DOMAIN = (
    "The load steps are the corners of a load domain. What is proved, and λ_max, is about every path of the "
    "loads inside it, in whatever order; what is simulated, λ_T too, follows the corners in the order "
    "given: one path of many."
)
ONE_PATH = (
    "The load steps are the corners of a load domain, followed here in the order given: one path of many."
)


def bounds_in_words(limits: JointLimits) -> list[str]:
    """What a user can rely on below, between and above the bounds, and where λ = 1 lies.

    Every sentence is about the joint with all nodes in contact, or names the open ones.

    Examples
    --------
    >>> import shakedown
    >>> for line in bounds_in_words(shakedown.assess(shakedown.example("uncoupled")).details):
    ...     print(line)
    Below λ_1 = 0.646554 the joint, closed at all nodes, shakes down from every initial state (no ...).
    Above λ_max = 0.6465541 it cannot shake down with all nodes in contact.
    The loading as given (λ = 1) lies at or above λ_max.
    """
    lower, upper = limits.lower, limits.upper
    reservations = _reservations(limits)
    if upper.open_nodes:
        return [_closed(limits), *zone_in_words(upper, limits.problem), *reservations]
    if upper.status == Status.INFEASIBLE:
        return [f"No load factor is safe with all nodes in contact: {upper.reason}.", *reservations]
    if _is_constant(limits.problem):
        return [_constant(lower, upper), *reservations]
    if lower.status == Status.INFEASIBLE:
        return [*_from_least(upper, limits.problem), _as_given(limits), *reservations]
    gap = limits.bounds.have_gap or (upper.status == Status.UNBOUNDED and lower.status == Status.OPTIMAL)
    between = [_between(limits)] if gap else []
    return [_below(limits), *between, _above(upper, limits.problem), _as_given(limits), *reservations]


def numbers_in_words(found: Assessment) -> list[tuple[str, str, str]]:
    """(name, value, remark) of the three numbers of a joint; each rounded so that it stays true.

    Examples
    --------
    >>> import shakedown
    >>> for line in numbers_in_words(shakedown.assess(shakedown.example("two-node"))):
    ...     print(*line, sep=" | ")
    proved from every state | λ = 0.6573734 | all nodes closed
    proved from this state | λ = 0.7315934 | slip zero
    impossible above | λ = 0.7391456 | with all nodes in contact
    """
    limits = found.details
    over = ", transient over" * limits.universal.after_transient
    return [
        ("proved from every state", _number(found.proved_from_every_state, down), f"all nodes closed{over}"),
        ("proved from this state", _number(found.proved_from_this_state, down), _this_state(limits)),
        ("impossible above", _number(found.impossible_above, up), _where_impossible(limits)),
    ]


def _where_impossible(limits: JointLimits) -> str:
    """What is excluded above λ_max."""
    if limits.open_nodes:
        return f"not known: {_open(limits)}"
    every = limits.upper.status == Status.UNBOUNDED
    return "some slip is safe at every λ" if every else "with all nodes in contact"


def _this_state(limits: JointLimits) -> str:
    """The state that is asked about."""
    slip = np.delete(limits.energy.initial_slip, limits.open_nodes)
    start = "the given slip" if slip.any() else "slip zero"
    return "near " * (limits.distance > 0) + start + (f", {_open(limits)}" if limits.open_nodes else "")


def _open(limits: JointLimits) -> str:
    return f"{len(limits.open_nodes)} node{'s' * (len(limits.open_nodes) != 1)} open"


def _number(value: float, rounded: Callable[[float], str]) -> str:
    """A load factor as one of the three numbers: what there is none of, and what has no end, in words."""
    if np.isnan(value):
        return "open"
    if np.isinf(value):
        return "any λ" if rounded is down else "none"
    return f"λ = {rounded(value)}" if value > 0 or rounded is up else "none"


def said_as_given_in_words(found: Assessment) -> str:
    """What becomes of the loading as given (λ = 1), where the bounds decide it.

    Examples
    --------
    >>> import shakedown
    >>> said_as_given_in_words(shakedown.assess(shakedown.example("block-9")))
    'The loading as given (λ = 1): shakes down, proved from this state.'
    """
    given = "The loading as given (λ = 1)"
    if found.said_as_given == Said.SHAKEDOWN:
        return f"{given}: shakes down, proved from this state."
    if found.said_as_given == Said.IMPOSSIBLE:
        return f"{given}: cannot shake down with all nodes in contact."
    return f"{given}: the bounds do not decide; run simulate."


def certain_in_words(limits: JointLimits) -> list[str]:
    """What is certain, first of all: proved from this state, proved from every state, excluded.

    Of a load domain it is said that this holds for every path, and where it is not clear whether the
    joint can move as a whole, that is said.

    Examples
    --------
    >>> import shakedown
    >>> for line in certain_in_words(shakedown.assess(shakedown.example("two-node")).details):
    ...     print(line)
    From slip zero the joint is proved to shake down up to λ = 0.7315934 (by the box of slips that it
    cannot leave; by energy up to λ_E = 0.6619611); from every initial state, closed and admissible,
    up to λ_U = 0.6573734 (first collapse); with all nodes in contact it cannot above λ_max = 0.7391456.
    """
    here = _proved_from_here(limits.energy, limits.box, limits.problem)
    return _certain([here, _proved_from_everywhere(limits.universal)], limits.upper, limits.problem)


def quickly_in_words(energy: EnergyBound, upper: UpperBound, problem: Problem) -> list[str]:
    """What is certain by λ_E and λ_max alone."""
    return _certain([_proved_from_here(energy, None, problem)], upper, problem)


def _certain(parts: list[str], upper: UpperBound, problem: Problem) -> list[str]:
    if upper.status == Status.OPTIMAL and not upper.open_nodes:
        parts.append(f"with all nodes in contact it cannot above λ_max = {up(upper.load_factor)}")
    sentence = "; ".join(part for part in parts if part)
    doubt = rigid_slips(problem).doubt
    about = [f"All of this is about the stiffness to its last stored digit: {doubt}."] if doubt else []
    return [sentence + ".", *about, *([LOAD_DOMAIN] if problem.is_domain else [])]


def simulated_path_in_words(problem: Problem) -> list[str]:
    """Along which of many paths a load domain was simulated; nothing for a loop, which has one."""
    return [ONE_PATH] if problem.is_domain else []


def hints_in_words(problem: Problem) -> list[str]:
    """What a user should know of the data, in words: what slips are relative to, likely slips of the pen.

    Examples
    --------
    >>> import shakedown
    >>> hints_in_words(shakedown.example("two-node"))
    []
    """
    relative = pinned_in_words(rigid_slips(problem).pinned, problem)
    hints = [relative] if relative else []
    p_mean = problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean
    if np.all(p_mean < 0):
        hints.append(
            "The mean pressure is negative at every node: compression is positive in p_w. Is its sign right?"
        )
    if np.any(problem.f > LARGEST_USUAL_FRICTION):
        hints.append(f"The friction coefficient {problem.f.max():g} is unusually large: is it in percent?")
    return hints


def as_given_in_words(
    run: Run, unit: str = "", problem: Problem | None = None, universal: UniversalBound | None = None
) -> str:
    """The answer for the loading as given: what becomes of the joint at λ = 1, with the unit of slips.

    With the problem its nodes are called by their labels; with the universal bound it is
    said where shakedown is proved from every state.

    Examples
    --------
    >>> import shakedown
    >>> result = shakedown.verify(shakedown.example("two-node"), load_factors=[1.0], random_states=0)
    >>> print(as_given_in_words(result.as_given))
    At the loading as given (λ = 1), from slip zero, the joint slips in every cycle (node 1): cyclic
    slip, simulated.
    """
    state = run.simulation
    start = "slip zero" if run.initial == "zero" else "the given slip"
    order = ", with the corners of the load domain in their order" * (
        problem is not None and problem.is_domain
    )
    here = f"At the loading as given (λ = 1){order}, from {start}, the joint"
    slipping = open_in_words(slipping_nodes(state.slip_per_cycle), problem)
    if state.outcome == Outcome.SHAKEDOWN:
        kept = f" with {open_in_words(state.open_nodes, problem)} open" if len(state.open_nodes) else ""
        return f"{here} shakes down{kept}: {_certainty(state, unit, problem, universal)}."
    if state.slides_away:
        return f"{here} does not hold: {sliding_in_words(state)}."
    words = {
        Outcome.CYCLIC_SLIP: f"slips in every cycle ({slipping}): cyclic slip, simulated.",
        Outcome.RATCHETTING: f"slips on and on in every cycle ({slipping}): ratchetting, simulated.",
        Outcome.SEPARATION: f"is in separation, simulated: {state.reason}.",
        Outcome.UNDECIDED: f"is undecided: {state.reason}.",
    }
    return f"{here} {words[state.outcome]}"


def start_in_words(run: Run) -> str:
    """Beside the name of an initial state: whether nodes are open in it, or it is one after the transient."""
    if run.open_nodes:
        return " (zone)"
    return " (after)" * run.case.after_transient


def sliding_in_words(run: Simulation) -> str:
    """That the body slides away, and when, in the words of its stop."""
    from shakedown.motion.cycle_record import SLIDES_AWAY  # compiled code stands behind it

    return run.reason.replace(SLIDES_AWAY, f"{SLIDES_AWAY} (gross slip)", 1)


def _certainty(
    state: Simulation, unit: str, problem: Problem | None, universal: UniversalBound | None
) -> str:
    """How far the shakedown at λ = 1 is proved, and what the state at rest may be off by."""
    everywhere = _proved_up_to(universal) > 1
    from_all = f"from every initial state that is {_admissible(universal)}"
    if not state.proved or state.long_term is None:
        return f"simulated; it is proved {from_all}" if everywhere else "simulated, not proved"
    proved = f"proved, and so it is {from_all} (λ = 1 < λ_U)" if everywhere else "proved"
    return f"{proved}. {margin_at_rest(state, unit, problem)}"


def margin_at_rest(state: Simulation, unit: str, problem: Problem | None = None) -> str:
    """How far slips may be off from those at rest, one node at a time or all of them; without full stop."""
    if state.long_term is not None and np.isnan(state.long_term.single_node_margin):
        return "It keeps to a box of slips in which the limits of no node meet"
    if state.long_term is None or np.isinf(state.long_term.single_node_margin):
        return "From its state at rest it may be disturbed by any amount"
    force, length = ("", unit) if problem is None else units_of(problem)
    energy_unit = f"√({work_unit(force, length)})" if work_unit(force, length) else ""
    one, all_nodes = (
        f"{down(margin, 3)} {name}".rstrip()
        for margin, name in (
            (state.long_term.single_node_margin, unit),
            (state.long_term.energy_margin, energy_unit),
        )
    )
    return (
        f"This stays so if the slip of any one node is off from its slip at rest by {one}, the others in "
        f"place, or slips of several nodes by {all_nodes} in the energy norm"
    )


def _admissible(universal: UniversalBound | None) -> str:
    """Which initial states λ_U is about."""
    over = universal is not None and universal.after_transient
    return "closed and admissible" + " after the transient" * over


def _proved_from_here(energy: EnergyBound, box: BoxBound | None, problem: Problem) -> str:
    closed = np.delete(energy.initial_slip, energy.open_nodes)
    start = "the given slip" if np.any(closed) else "slip zero"
    if energy.distance > 0:
        start = f"every state within the energy distance {energy.distance:.4g} of {start}"
    if energy.open_nodes:
        start += f", with {open_in_words(energy.open_nodes, problem)} open and in equilibrium,"
    if box_proves_more(box, energy):
        if box.status == Status.UNBOUNDED:
            return f"From {start} the joint is proved to shake down at every load factor ({BOX})"
        also = "" if np.isnan(energy.load_factor) else f"; by energy up to λ_E = {down(energy.load_factor)}"
        up_to = f"λ = {down(box.load_factor)} ({BOX}{also})"
        return f"From {start} the joint is proved to shake down up to {up_to}"
    if energy.status == Status.UNDECIDED:
        return f"From {start} it is open what is proved ({energy.reason})"
    if energy.status == Status.INFEASIBLE:
        hint = "; a smaller distance may do" if energy.distance > 0 else "; a state after some cycles may do"
        return f"From {start} no load factor is proved ({energy.reason}{hint})"
    least = energy.least_load_factor
    begins = f" from λ = {up(least)} on" if least > 0 else ""
    if energy.status == Status.UNBOUNDED:
        return f"From {start} the joint is proved to shake down at every load factor{begins}"
    return f"From {start} the joint is proved to shake down{begins} up to λ_E = {down(energy.load_factor)}"


def _proved_from_everywhere(universal: UniversalBound) -> str:
    if universal.status == Status.UNDECIDED:
        return f"from every initial state it is open what is proved ({universal.reason})"
    if np.isnan(universal.load_factor):
        return ""
    more = ARGUMENTS.get(universal.argument)
    how = f"{universal.argument}: {more}" if more else universal.argument
    if universal.load_factor == 0:
        return f"from every initial state no load factor is proved ({universal.reason})"
    if np.isinf(universal.load_factor):
        return f"from every initial state, {_admissible(universal)}, at every load factor ({how})"
    number = f"λ_U = {down(universal.load_factor)}"
    return f"from every initial state, {_admissible(universal)}, up to {number} ({how})"


def _closed(limits: JointLimits) -> str:
    """What holds with all nodes closed, where the upper bound is that of a zone."""
    if limits.lower.status == Status.INFEASIBLE:
        return "With all nodes in contact no slip is safe under the mean load alone."
    return _below(limits)


def _below(limits: JointLimits) -> str:
    lower, universal = limits.lower, limits.universal
    if lower.load_factor == 0:
        return f"λ_1 = 0, so no load factor is safe from every initial state: {lower.reason}."
    where = f"Below λ_1 = {down(lower.load_factor)}"
    if lower.status == Status.UNBOUNDED:
        where = "At every load factor"
    if lower.guarantee == "proved":
        return (
            f"{where} the joint, closed at all nodes{_transient_over(lower)}, shakes down from every initial "
            f"state ({lower.reason})."
        )
    claim = "no node collapses, but it is not proved that the joint shakes down from every initial state"
    known = _proved_up_to(universal)
    if down(known) == down(lower.load_factor):
        claim = (
            f"the joint shakes down from every initial state that is {_admissible(universal)}: it is proved"
        )
        return f"{where} (= λ_U) {claim}."
    if known > 0:
        where = f"Between λ_U = {down(known)} and λ_1 = {down(lower.load_factor)}"
        if lower.status == Status.UNBOUNDED:
            where = f"Above λ_U = {down(known)}"
    return f"{where} {claim} ({lower.guarantee}): {lower.reason}."


def _proved_up_to(universal: UniversalBound | None) -> float:
    """λ_U; 0 where there is none."""
    return 0.0 if universal is None or np.isnan(universal.load_factor) else universal.load_factor


def _transient_over(lower: LowerBound) -> str:
    """λ_1 is about the loop: of transient load steps before it nothing is said."""
    return "" if lower.problem.q_transient is None else " when the transient is over"


def _from_least(upper: UpperBound, problem: Problem) -> list[str]:
    """The bounds where the mean load alone has no safe slip, but load factors from λ_lo on have."""
    start = f"λ_lo = {down(upper.least_load_factor)}"
    sentences = [
        f"Below {start} there is no safe slip with all nodes in contact: under the mean load alone none "
        "keeps every node within its friction limits. So λ_1, which is counted from there, does not exist."
    ]
    if upper.status == Status.UNBOUNDED:
        return [*sentences, f"From λ_lo on a safe slip exists at every load factor: {upper.reason}."]
    exist = f"Safe slips exist from λ_lo up to λ_max = {down(upper.load_factor)}."
    return [*sentences, exist, _above(upper, problem)]


def _is_constant(problem: Problem) -> bool:
    """Whether the loading does not change over the period, so that the load factor multiplies nothing."""
    loop = loading(problem)
    return not (loop.q1.any() or loop.p1.any())


def _constant(lower: LowerBound, upper: UpperBound) -> str:
    """What the bounds mean where the load factor makes no difference."""
    said = "The loading does not change over the period, so the load factor makes no difference: with all "
    said += "nodes in contact there is a slip in which no node slips"
    if upper.status == Status.UNBOUNDED and lower.load_factor == 0:
        return f"{said}, but not every initial slip leads to one ({lower.reason})."
    return f"{said}."


def _between(limits: JointLimits) -> str:
    lower, upper, before = limits.lower, limits.upper, limits.through_transient
    finite, domain = upper.status == Status.OPTIMAL, lower.problem.is_domain
    where, safe = ("Between λ_1 and λ_max", "the") if finite else ("Above λ_1", "a")
    node = node_in_words(lower.problem, lower.node)
    what = "the initial state" if before is None else "the slip that is locked in when the transient is over"
    every, usual = (", on every path", ", with the corners in their order") if domain else ("", "")
    lasting = "" if before is None else f"; {_through_transient(before, limits)}"
    return (
        f"{where} {what} decides: from {safe} safe slip the joint shakes down{every}; from the witness, "
        f"where {node} has lost its range of safe slips, it usually does not{usual}{lasting}."
    )


def _through_transient(before: UpperBound, limits: JointLimits) -> str:
    """What transient load steps leave of the safe slips that are locked in before them."""
    near = 1 - limits.tolerances.feasibility
    first, last = limits.lower.load_factor, limits.upper.load_factor
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


def _above(upper: UpperBound, problem: Problem) -> str:
    if upper.status == Status.UNBOUNDED:
        return f"With all nodes in contact a safe slip exists at every load factor: {upper.reason}."
    often = " on a path that returns to all corners" * problem.is_domain
    return f"Above λ_max = {up(upper.load_factor)} it cannot shake down{often} with all nodes in contact."


def _as_given(limits: JointLimits) -> str:
    lower, upper = limits.lower, limits.upper
    if upper.least_load_factor > 1:
        place = "below λ_lo"
    elif lower.load_factor > 1:
        place = _below_collapse(limits)
    elif upper.load_factor <= 1:
        place = "at or above λ_max"
    else:
        beyond = "λ_max" if upper.status == Status.OPTIMAL else "any load factor"
        place = f"between λ_1 and {beyond}"
        if lower.status == Status.INFEASIBLE:
            place = "where safe slips exist"
        place += _against_energy(limits)
    return f"The loading as given (λ = 1) lies {place}."


def _below_collapse(limits: JointLimits) -> str:
    """Where the loading as given lies below λ_1: what is proved of it."""
    known = _proved_up_to(limits.universal)
    if known > 1:
        return "below λ_U: proved from every initial state that is " + _admissible(limits.universal)
    if limits.lower.guarantee == "proved":
        return "below λ_1"
    return ("between λ_U and λ_1" if known > 0 else "below λ_1") + _against_energy(limits)


def _against_energy(limits: JointLimits) -> str:
    """Whether the loading as given is proved from this state, where every state does not do the same."""
    energy, box = limits.energy, limits.box
    if energy.open_nodes:
        return ""
    start = "the given slip" if np.any(energy.initial_slip) else "slip zero"
    if box_proves_more(box, energy) and box.load_factor > 1:
        return f"; from {start} the joint is proved to shake down there"
    if energy.least_load_factor < 1 < energy.load_factor:
        return f", and below λ_E: from {start} the joint is proved to shake down"
    return f"; from {start} shakedown is not proved there"


def _reservations(limits: JointLimits) -> list[str]:
    """What keeps a number from being certified or fully accurate, where something does."""
    sentences = [f"{missing} (no number is touched by it)." for missing in _missing(limits)]
    if limits.energy.uncertified:
        sentences.append(f"λ_E is not certified: {limits.energy.uncertified}.")
    for name, bound in (("λ_1", limits.lower), ("λ_max", limits.upper)):
        if bound.uncertified:
            sentences.append(f"{name} is not certified: {bound.uncertified}.")
        if bound.reduced_accuracy:
            sentences.append(
                f"{name} has reduced accuracy (1e-7): the data are at the end of double precision."
            )
    return sentences


def _missing(limits: JointLimits) -> Iterator[str]:
    """Evidence that a solver failed to give, and why."""
    yield from (f"λ_max: no {missing}" for missing in limits.upper.missing)
    swing = limits.universal.swing
    if swing is not None and swing.uncertified:
        yield f"λ_U: no certificate of the swing bound: {swing.uncertified}"


def coupling_in_words(ratio: float) -> str:
    """Which side of 1 a coupling ratio ρ* is on: below it the first collapse is the limit.

    Examples
    --------
    >>> coupling_in_words(0.5), coupling_in_words(1.5)
    ('moderate coupling: the first collapse is the limit', 'strong coupling')
    """
    return "moderate coupling: the first collapse is the limit" if ratio < 1 else "strong coupling"


def curve_in_words(curve: GuaranteeCurve, problem: Problem | None = None) -> str:
    """How far the lower bound improves for initial states near the safe slip.

    With the problem it is said that these are states after a transient.
    """
    points = ", ".join(
        f"{down(load_factor, 5)} (R = {radius:g})"
        for radius, load_factor in zip(curve.radii, curve.load_factors, strict=True)
    )
    over = " when the transient is over" * (problem is not None and problem.q_transient is not None)
    return (
        f"For initial states within R of the safe slip{over} the first collapse lies at λ_1(R) = {points}; "
        f"R is in multiples of {curve.unit:.4g}, the largest safe slip."
    )


def critical_in_words(critical: CriticalLoadFactors | None, total: int, bounds: ShakedownBounds) -> list[str]:
    """How many subsets there are, the smallest values, and why these differ from the bounds."""
    if critical is None:
        return [f"The {_subsets(total)} of n + 1 constraints were not enumerated: more than the budget."]
    smallest, feasible = critical.smallest_positive, critical.smallest_feasible
    plural = "s" * (critical.regular != 1)
    counts = f"{_subsets(total)} of n + 1 constraints: {critical.regular:,} critical load factor{plural}"
    if critical.degenerate:
        counts += f", {critical.degenerate:,} degenerate (their constraints do not meet in one point)"
    if not critical.regular:
        return [f"{counts}.", *_why_degenerate(bounds)]
    if not smallest.rows:
        return [f"{counts}. None of them is positive."]
    sentences = [f"{counts}. The smallest positive one is {down(smallest.load_factor)}."]
    if smallest.load_factor < bounds.lower.load_factor * (1 - bounds.tolerances.feasibility):
        sentences.append(
            f"It lies below the first collapse λ_1 = {down(bounds.lower.load_factor)}, because it belongs to "
            "an intersection outside the safe region: there, other constraints are broken already, and "
            "no safe state ends. Only intersections on the safe region matter; the smallest of those is "
            f"{down(feasible.load_factor)}."
        )
    elif bounds.lower.load_factor == 0:
        sentences.append(
            "λ_1 is 0 all the same: the safe region has lost its cube shape at the mean load already, and an "
            "intersection at a positive load factor says nothing about that."
        )
    return sentences


def _why_degenerate(bounds: ShakedownBounds) -> list[str]:
    """Why no subset meets in one point where a rigid slip changes no friction limit, and what helps."""
    problem, lower, upper = bounds.lower.problem, bounds.lower, bounds.upper
    if not rigid_slips(problem).pinned:
        return []
    known = [
        f"{name} = {rounded(value)}"
        for name, value, rounded in (("λ_1", lower.load_factor, down), ("λ_max", upper.load_factor, up))
        if np.isfinite(value)
    ]
    there = f" They exist: {', '.join(known)} (see solve)." if known else ""
    return [
        "Only friction holds this body: a slip of all nodes together, as of a rigid body, changes no "
        "reaction, so that the constraints of a subset meet along a line, or nowhere. The enumeration says "
        f"nothing here. The bounds do not need such points.{there}"
    ]


def _subsets(total: int) -> str:
    if total >= MANY:
        return f"{Decimal(total):.2e} subsets"
    return f"{total:,} subset{'s' * (total != 1)}"


def transient_in_words(limit: TransientLimit, problem: Problem | None = None) -> str:
    """Up to where one history shakes down, and what was scanned to say so.

    With the problem it is said where that history is one path of many through a load domain.
    """
    path = ", with the corners of the load domain in their order," * (
        problem is not None and problem.is_domain
    )
    here = f"From its initial state{path}"
    scan = f"{len(limit.scanned)} load factors up to {limit.scanned[-1]:.5g} simulated"
    if np.isnan(limit.load_factor):
        return f"{here} the joint shakes down at no load factor ({scan})."
    if not np.isfinite(limit.high):
        return f"{here} the joint shakes down at every load factor scanned ({scan})."
    order = "" if limit.monotone else "; below it there are load factors at which it does not"
    proved = ""
    if np.isfinite(limit.proved):
        proved = f"; shakedown is proved at λ = {down(limit.proved)}"
        if np.isfinite(limit.cycling):
            proved += f", {_found_above(limit)} at λ = {up(limit.cycling)}"
    return f"{here} the joint shakes down up to λ_T = {down(limit.load_factor)}{order}{proved} ({scan})."


def _found_above(limit: TransientLimit) -> str:
    """Which long-term state was found at ``cycling``."""
    outcome = limit.outcomes[limit.scanned.tolist().index(limit.cycling)]
    state = limit.at_high if limit.at_high is not None and limit.high == limit.cycling else None
    if state is not None and outcome == "separation":
        if not state.period:
            return "the body was found to leave"
        nodes = tuple(j for j in np.flatnonzero(state.opened).tolist() if j not in state.open_nodes)
        verbs = "opens and closes" if len(nodes) == 1 else "open and close"
        return f"separation was found ({open_in_words(nodes)} {verbs}, no slip in contact)"
    return f"{outcome.replace('-', ' ')} was found"


def friction_in_words(problem: Problem, limits: FrictionThresholds) -> list[str]:
    """Where the friction of a problem stands against its thresholds, and what follows.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("jump")
    >>> friction_in_words(joint, shakedown.friction_thresholds(joint))[0]
    'The friction lies above the threshold of uniqueness (0.35568): the evolution may have ...'
    """
    friction = 1.0 if limits.factor else float(problem.f.max())
    closed, opened = limits.uniqueness_in_contact, limits.uniqueness
    if opened is None:
        pairs = [(" with all nodes in contact", closed)]
    elif (opened.low, opened.high) == (closed.low, closed.high):
        pairs = [("", closed)]
    else:
        pairs = [(" with all nodes in contact", closed), (" where nodes separate", opened)]
    sentences = [_uniqueness(friction, where, threshold) for where, threshold in pairs]
    if any(sentence.startswith("It is open") for sentence in sentences):
        sentences.append(
            "Below it a motion has one continuation; above it may have several or none, and then it jumps."
        )
    wedging = limits.wedging
    if wedging.high <= friction:
        sentences.append(
            f"It lies above the threshold of wedging ({up(wedging.high, 5)}): locked-in slip can hold "
            "the joint without any load."
        )
    elif wedging.low <= friction:
        known = f" ({wedging.reason})" if wedging.reason else ""
        sentences.append(f"It is open whether locked-in slip can hold the joint without any load{known}.")
    return sentences


def _uniqueness(friction: float, where: str, threshold: Threshold) -> str:
    name = f"the threshold of uniqueness{where}"
    if friction >= threshold.high:
        return (
            f"The friction lies above {name} ({up(threshold.high, 5)}): the evolution may have several "
            "continuations or none, and then it jumps."
        )
    if threshold.low == threshold.high == np.inf:
        return f"Friction of any size leaves the evolution unique{where}."
    if friction < threshold.low:
        limit = down(threshold.low, 5)
        limit = limit if threshold.low == threshold.high else f"at least {limit}"
        return f"The friction lies below {name} ({limit})."
    between = f"between {down(threshold.low, 5)} and {up(threshold.high, 5)}"
    if np.isinf(threshold.high):
        between = f"at {down(threshold.low, 5)} or above"
    return f"It is open whether the friction lies below {name}, which is only known to lie {between}."
