"""What the limits of a joint with two tangential directions mean, and where the nominal load lies."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shakedown.ground.shown_values import up
from shakedown.ground.status import Status
from shakedown.report.words.assessment_words import admissible_in_words, proved_up_to
from shakedown.report.words.bound_words import (
    above_in_words,
    from_here_in_words,
    is_constant,
    reservations_in_words,
)
from shakedown.report.words.zone_words import zone_in_words

if TYPE_CHECKING:
    from shakedown.assessment.space_limits import SpaceLimits

NO_FIRST_COLLAPSE = (
    "With two tangential directions there is no first collapse λ_1: it needs the two opposite limits of a "
    "node, and in space the limit is a disc."
)


def space_bounds_in_words(limits: SpaceLimits) -> list[str]:
    """What a user can rely on below, between and above the limits, and where λ = 1 lies.

    Every sentence is about the joint with all nodes in contact, or names the open ones.
    """
    upper, reservations = limits.upper, reservations_in_words(limits)
    if upper.open_nodes:
        return [*zone_in_words(upper, limits.problem), *reservations]
    if upper.status == Status.INFEASIBLE:
        return [f"No load factor is safe with all nodes in contact: {upper.reason}.", *reservations]
    if is_constant(limits.problem):
        return [
            "The loading does not change over the period, so the load factor makes no difference: with all "
            "nodes in contact there is a slip in which no node slips.",
            *reservations,
        ]
    return [*_below(limits), above_in_words(upper, limits.problem), _as_given(limits), *reservations]


def _below(limits: SpaceLimits) -> list[str]:
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


def _as_given(limits: SpaceLimits) -> str:
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
