"""A criterion for small slip in the long term: a limit on the slip range of every node."""

from dataclasses import dataclass
from math import inf, nan
from typing import ClassVar

from shakedown.ground.errors import UsageError
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, is_finite
from shakedown.joint.result import Result
from shakedown.long_term.node_results import Settled, slip_ranges


@dataclass(frozen=True, eq=False, repr=False)
class SlipCriterion(Result):
    """Whether the slip range of every node stays below a limit.

    Attributes
    ----------
    below
        The limit [length].
    met
        Whether ``largest`` is below it; None where the long-term state is undecided.
    largest
        The largest slip range of a node in the long-term state [length] (``NodeResults.slip_range``):
        0 where it shakes down, infinite where slips grow for ever (ratchetting, a body that slides
        away) or contact is lost for good, NaN where it is undecided.
    node
        The node that it is found at; −1 where there is none.
    """

    DOCUMENT: ClassVar[str] = "below met largest node"

    below: float
    met: bool | None
    largest: float
    node: int


def slip_criterion(settled: Settled, below: float, tolerances: Tolerances = DEFAULT) -> SlipCriterion:
    """Whether every node's slip range in a settled state is below a limit."""
    if settled.slides_away or settled.outcome == Outcome.RATCHETTING:
        return SlipCriterion(below, False, inf, -1)
    if not settled.period:
        left = settled.outcome == Outcome.SEPARATION
        return SlipCriterion(below, False if left else None, inf if left else nan, -1)
    if settled.outcome == Outcome.SHAKEDOWN:
        return SlipCriterion(below, True, 0.0, -1)
    ranges = slip_ranges(settled, tolerances)
    node, largest = int(ranges.argmax()), float(ranges.max())
    return SlipCriterion(below, largest < below, largest, node)


@checked
def check_slip_below(slip_below: float) -> float:
    """A limit on the slip range; raises ``UsageError`` unless it is finite and positive."""
    if not (is_finite(slip_below) and slip_below > 0):
        raise UsageError(f"slip_below: expected a positive length, found {slip_below!r}")
    return slip_below
