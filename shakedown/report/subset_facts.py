"""What the enumeration of all (n+1)-subsets of constraints says, and why it differs from the limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shakedown.ground.errors import Missing
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.report import notes
from shakedown.report.facts import Fact

if TYPE_CHECKING:
    from shakedown.assessment.every_limit import ShakedownBounds
    from shakedown.bounds.enumeration.critical import CriticalLoadFactors


def critical_facts(critical: CriticalLoadFactors, bounds: ShakedownBounds) -> tuple[list[Fact], list[str]]:
    """How many subsets there are, the smallest values, and notes on why these differ from the limits.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> found = shakedown.critical_load_factors(joint)
    >>> for fact in critical_facts(found, shakedown.shakedown_bounds(joint))[0]:
    ...     print(fact.label, fact.shown, fact.note, sep=" | ")
    subsets | 4 | 4 with a critical load factor, 0 degenerate
    smallest positive | 0.6573 |
    """
    lower = bounds.lower
    assert not isinstance(lower, Missing)  # critical load factors, too, exist only in the plane
    counted = f"{critical.regular:,} with a critical load factor, {critical.degenerate:,} degenerate"
    facts, smallest = [Fact("subsets", f"{critical.total:,}", note=counted)], critical.smallest_positive
    if not critical.regular:
        return facts, [notes.DEGENERATE] if rigid_slips(lower.problem).pinned else []
    if not smallest.rows:
        return [*facts, Fact("smallest positive", "none")], []
    facts.append(Fact("smallest positive", smallest.load_factor, rounding="down"))
    feasible = critical.smallest_feasible.load_factor
    if smallest.load_factor < lower.load_factor * (1 - bounds.tolerances.feasibility):
        facts.append(
            Fact("smallest feasible", feasible, rounding="down", note="= λ_1" * bool(np.isfinite(feasible)))
        )
        return facts, [notes.INFEASIBLE_CORNER]
    return facts, [notes.COLLAPSED_AT_MEAN] if lower.load_factor == 0 else []
