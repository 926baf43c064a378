"""How a program ended: the one set of words for it."""

from enum import StrEnum


class Status(StrEnum):
    """How an optimisation ended. A member equals its word: ``Status.OPTIMAL == "optimal"``.

    Attributes
    ----------
    OPTIMAL
        A solution exists and is reported.
    INFEASIBLE
        No point satisfies the constraints; where possible a certificate proves it.
    UNBOUNDED
        The objective can be made as large as one likes; where possible a direction proves it.
    UNDECIDED
        The solver stopped without an answer; what it had is not reported as a number.
    """

    OPTIMAL = "optimal"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    UNDECIDED = "undecided"
