"""Where the friction stands against its thresholds, and what the enumeration of all subsets says."""

from __future__ import annotations

from decimal import Decimal
from typing import TYPE_CHECKING

import numpy as np

from shakedown.bounds.bound_result import Bound
from shakedown.ground.errors import Missing
from shakedown.ground.shown_values import LONGEST_WHOLE, down, up
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.report.assessment_words import IN_CONTACT

if TYPE_CHECKING:
    from shakedown.assessment.shakedown_bounds import ShakedownBounds
    from shakedown.bounds.enumeration.critical import CriticalLoadFactors
    from shakedown.bounds.uniqueness.friction_thresholds import FrictionThresholds, Threshold
    from shakedown.joint.problem import Problem

NO_THRESHOLDS = (
    "Friction thresholds (uniqueness, wedging) are computed for joints in the plane only: in space they do "
    "not follow from the signs of slips."
)


def friction_in_words(problem: Problem, limits: FrictionThresholds | Missing) -> list[str]:
    """Where the friction of a problem stands against its thresholds, and what follows, or why there are none.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("jump")
    >>> friction_in_words(joint, shakedown.friction_thresholds(joint))[0]
    'The friction lies above the threshold of uniqueness (0.3556757): a motion may have several ...'
    """
    if isinstance(limits, Missing):
        return [NO_THRESHOLDS]
    friction = 1.0 if limits.factor else float(problem.f.max())
    closed, opened = limits.uniqueness_in_contact, limits.uniqueness
    if opened is None:
        pairs = [(f" {IN_CONTACT}", closed)]
    elif (opened.low, opened.high) == (closed.low, closed.high):
        pairs = [("", closed)]
    else:
        pairs = [(f" {IN_CONTACT}", closed), (" where nodes separate", opened)]
    sentences = [_uniqueness(friction, where, threshold) for where, threshold in pairs]
    wedging = limits.wedging
    if wedging.high <= friction:
        sentences.append(
            f"It lies above the threshold of wedging ({up(wedging.high)}): locked-in slip can hold "
            "the joint without any load."
        )
    elif wedging.low <= friction:
        known = f" ({wedging.reason})" if wedging.reason else ""
        sentences.append(f"It is open whether locked-in slip can hold the joint without any load{known}.")
    return sentences


def _uniqueness(friction: float, where: str, threshold: Threshold) -> str:
    name = "the threshold of uniqueness" + where * (friction >= threshold.high or friction < threshold.low)
    if friction >= threshold.high:
        return (
            f"The friction lies above {name} ({up(threshold.high)}): a motion may have several "
            "continuations or none, and then it jumps."
        )
    if threshold.low == threshold.high == np.inf:
        return f"Friction of any size leaves every motion{where} one continuation."
    if friction < threshold.low:
        limit = down(threshold.low)
        limit = limit if threshold.low == threshold.high else f"at least {limit}"
        return f"The friction lies below {name} ({limit}): every motion there has one continuation."
    between = f"between {down(threshold.low)} and {up(threshold.high)}"
    if np.isinf(threshold.high):
        between = f"at {down(threshold.low)} or above"
    return (
        f"Whether every motion{where} has one continuation is open: {name} lies {between}. Above it a motion "
        "may have several continuations or none, and then it jumps."
    )


def critical_in_words(
    critical: CriticalLoadFactors | None, total: int | None, bounds: ShakedownBounds
) -> list[str]:
    """How many subsets there are, the smallest values, and why these differ from the bounds."""
    lower = bounds.lower
    if total is None or isinstance(lower, Missing):
        return ["Critical load factors exist for joints in the plane only."]
    if critical is None:
        return [f"The {_subsets(total)} of n + 1 constraints were not enumerated: more than the budget."]
    smallest, feasible = critical.smallest_positive, critical.smallest_feasible
    plural = "s" * (critical.regular != 1)
    counts = f"{_subsets(total)} of n + 1 constraints: {critical.regular:,} critical load factor{plural}"
    if critical.degenerate:
        counts += f", {critical.degenerate:,} degenerate (their constraints do not meet in one point)"
    if not critical.regular:
        return [f"{counts}.", *_why_degenerate(lower, bounds.upper)]
    if not smallest.rows:
        return [f"{counts}. None of them is positive."]
    sentences = [f"{counts}. The smallest positive one is {down(smallest.load_factor)}."]
    if smallest.load_factor < lower.load_factor * (1 - bounds.tolerances.feasibility):
        sentences.append(
            f"It lies below the first collapse λ_1 = {down(lower.load_factor)}, because it belongs to "
            "an intersection outside the safe region: there, other constraints are broken already, and "
            "no safe state ends. Only intersections on the safe region matter; the smallest of those is "
            f"{down(feasible.load_factor)}."
        )
    elif lower.load_factor == 0:
        sentences.append(
            "λ_1 is 0 all the same: the safe region has lost its cube shape at the mean load already, and an "
            "intersection at a positive load factor says nothing about that."
        )
    return sentences


def _why_degenerate(lower: Bound, upper: Bound) -> list[str]:
    """Why no subset meets in one point where a rigid slip changes no friction limit, and what helps."""
    if not rigid_slips(lower.problem).pinned:
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
    if total >= 10**LONGEST_WHOLE:
        return f"{Decimal(total):.2e} subsets"
    return f"{total:,} subset{'s' * (total != 1)}"
