"""What the limits of a joint say, whatever its tangential directions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shakedown.ground.evidence import Missing
from shakedown.report.words.bound_words import bounds_in_words
from shakedown.report.words.friction_words import friction_in_words
from shakedown.report.words.space_words import space_bounds_in_words

if TYPE_CHECKING:
    from shakedown.assessment.every_limit import Limits

NO_THRESHOLDS = (
    "Of friction thresholds (uniqueness, wedging) nothing is said: with two tangential directions they do "
    "not follow from the signs of slips."
)


def limits_in_sentences(limits: Limits) -> list[str]:
    """What a user can rely on below, between and above the limits, and where λ = 1 lies."""
    from shakedown.assessment.every_limit import JointLimits  # loads what computes

    return bounds_in_words(limits) if isinstance(limits, JointLimits) else space_bounds_in_words(limits)


def thresholds_in_sentences(limits: Limits) -> list[str]:
    """Where the friction stands against its thresholds, or why there are none."""
    if isinstance(limits.friction, Missing):
        return [NO_THRESHOLDS]
    return friction_in_words(limits.problem, limits.friction)
