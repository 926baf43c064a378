"""What the limits of a joint in the plane or in space mean, and where the nominal load lies between them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from shakedown.assessment.from_state import box_proves_more
from shakedown.ground.evidence import Missing, present
from shakedown.ground.shown_values import down, up
from shakedown.ground.status import Guarantee, Status
from shakedown.joint.loading import loading
from shakedown.report.assessment_words import admissible_in_words, proved_up_to
from shakedown.report.friction_words import friction_in_words
from shakedown.report.node_words import node_in_words
from shakedown.report.zone_words import without_safe_slip_in_words, zone_in_words

if TYPE_CHECKING:
    from shakedown.assessment.every_limit import JointLimits, Limits
    from shakedown.assessment.space_limits import SpaceLimits
    from shakedown.bounds.collapse.lower import LowerBound
    from shakedown.bounds.upper import UpperBound
    from shakedown.joint.problem import Problem

NO_FIRST_COLLAPSE = (
    "With two tangential directions there is no first collapse λ_1: it needs the two opposite limits of a "
    "node, and in space the limit is a disc."
)
NO_THRESHOLDS = (
    "Of friction thresholds (uniqueness, wedging) nothing is said: with two tangential directions they do "
    "not follow from the signs of slips."
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
    The nominal load (λ = 1) lies at or above λ_max.
    """
    lower, upper = limits.lower, limits.upper
    reservations = reservations_in_words(limits)
    if upper.open_nodes:
        return [_closed(limits), *zone_in_words(upper, limits.problem), *reservations]
    if nothing_safe := without_safe_slip_in_words(upper):
        return [nothing_safe, *reservations]
    if is_constant(limits.problem):
        return [_constant(lower, upper), *reservations]
    if lower.status == Status.INFEASIBLE:
        return [*_from_least(upper, limits.problem), _as_given(limits), *reservations]
    gap = limits.bounds.have_gap or (upper.status == Status.UNBOUNDED and lower.status == Status.OPTIMAL)
    between = [_between(limits)] if gap else []
    return [_below(limits), *between, above_in_words(upper, limits.problem), _as_given(limits), *reservations]


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
    if lower.guarantee == Guarantee.PROVED:
        return (
            f"{where} the joint, closed at all nodes{_transient_over(lower)}, shakes down from every initial "
            f"state ({lower.reason})."
        )
    claim = "no node collapses, but it is not proved that the joint shakes down from every initial state"
    known = proved_up_to(universal)
    if down(known) == down(lower.load_factor):
        states = f"every initial state that is {admissible_in_words(universal)}"
        return f"{where} (= λ_U) the joint shakes down from {states}: it is proved."
    if known > 0:
        where = f"Between λ_U = {down(known)} and λ_1 = {down(lower.load_factor)}"
        if lower.status == Status.UNBOUNDED:
            where = f"Above λ_U = {down(known)}"
    return f"{where} {claim} ({lower.guarantee}): {lower.reason}."


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
    return [*sentences, exist, above_in_words(upper, problem)]


def is_constant(problem: Problem) -> bool:
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
        f"{where} {what} decides: from {safe} safe slip the joint shakes down{every}; from the critical slip "
        f"state, where {node} has lost its range of safe slips, it usually does not{usual}{lasting}."
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


def above_in_words(upper: UpperBound, problem: Problem) -> str:
    """What is excluded above λ_max, or that nothing is."""
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
        place += from_here_in_words(limits)
    return f"The nominal load (λ = 1) lies {place}."


def _below_collapse(limits: JointLimits) -> str:
    """Where the nominal load lies below λ_1: what is proved of it."""
    known = proved_up_to(limits.universal)
    if known > 1:
        return "below λ_U: proved from every initial state that is " + admissible_in_words(limits.universal)
    if limits.lower.guarantee == Guarantee.PROVED:
        return "below λ_1"
    return ("between λ_U and λ_1" if known > 0 else "below λ_1") + from_here_in_words(limits)


def from_here_in_words(limits: Limits) -> str:
    """Whether the nominal load is proved from this state, where every state does not do the same."""
    energy, box = limits.energy, present(limits.box)
    if energy.open_nodes:
        return ""
    start = "the given slip" if np.any(energy.initial_slip) else "slip zero"
    if box_proves_more(box, energy) and box.load_factor > 1:
        return f"; from {start} the joint is proved to shake down there"
    if energy.least_load_factor < 1 < energy.load_factor:
        return f", and below λ_E: from {start} the joint is proved to shake down"
    return f"; from {start} shakedown is not proved there"


def reservations_in_words(limits: Limits) -> list[str]:
    """What keeps a number from being certified or fully accurate, where something does."""
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
    return sentences


def _missing(limits: Limits) -> Iterator[str]:
    """Evidence that a solver failed to give, and why."""
    yield from (f"λ_max: no {missing}" for missing in limits.upper.missing)
    swing = limits.universal.swing
    if swing is not None and swing.uncertified:
        yield f"λ_U: no certificate of the swing bound: {swing.uncertified}"


def space_bounds_in_words(limits: SpaceLimits) -> list[str]:
    """What a user can rely on below, between and above the limits, and where λ = 1 lies.

    Every sentence is about the joint with all nodes in contact, or names the open ones.
    """
    upper, reservations = limits.upper, reservations_in_words(limits)
    if upper.open_nodes:
        return [*zone_in_words(upper, limits.problem), *reservations]
    if nothing_safe := without_safe_slip_in_words(upper):
        return [nothing_safe, *reservations]
    if is_constant(limits.problem):
        return [
            "The loading does not change over the period, so the load factor makes no difference: with all "
            "nodes in contact there is a slip in which no node slips.",
            *reservations,
        ]
    return [
        *_below_in_space(limits),
        above_in_words(upper, limits.problem),
        _as_given_in_space(limits),
        *reservations,
    ]


def _below_in_space(limits: SpaceLimits) -> list[str]:
    """What is open between what is proved and λ_max."""
    least, known = limits.upper.least_load_factor, proved_up_to(limits.universal)
    if least > 0:
        return [
            f"Below λ_lo = {up(least)} there is no safe slip with all nodes in contact: under the mean load "
            "alone none keeps every node within its friction limits."
        ]
    if known >= limits.upper.load_factor:
        return []
    finite = limits.upper.status == Status.OPTIMAL
    start = "λ_U" if known > 0 else "λ = 0"
    where = f"Between {start} and λ_max" if finite else f"Above {start}"
    return [
        f"{where} it is open, or depends on the initial state, whether the joint shakes down; λ_E is what "
        f"is proved of one state. {NO_FIRST_COLLAPSE}"
    ]


def _as_given_in_space(limits: SpaceLimits) -> str:
    upper, known = limits.upper, proved_up_to(limits.universal)
    if upper.least_load_factor > 1:
        place = "below λ_lo"
    elif known > 1:
        place = f"below λ_U: proved from every initial state that is {admissible_in_words(limits.universal)}"
    elif upper.load_factor <= 1:
        place = "at or above λ_max"
    else:
        begun = "between λ_U and" if known > 0 else "below"
        place = f"{begun} λ_max" if upper.status == Status.OPTIMAL else "where safe slips exist"
        place += from_here_in_words(limits)
    return f"The nominal load (λ = 1) lies {place}."


def limits_in_sentences(limits: Limits) -> list[str]:
    """What a user can rely on below, between and above the limits, and where λ = 1 lies."""
    from shakedown.assessment.every_limit import JointLimits  # loads what computes

    return bounds_in_words(limits) if isinstance(limits, JointLimits) else space_bounds_in_words(limits)


def thresholds_in_sentences(limits: Limits) -> list[str]:
    """Where the friction stands against its thresholds, or why there are none."""
    if isinstance(limits.friction, Missing):
        return [NO_THRESHOLDS]
    return friction_in_words(limits.problem, limits.friction)
