"""The statuses and outcomes that results have."""

from enum import StrEnum

# What a node does at an instant, as compiled code numbers it; NO_STATE: none that satisfies the law.
STICK, BACKWARD_SLIP, OPEN, NO_STATE = range(4)
FORWARD_SLIP = -BACKWARD_SLIP
SLIP = BACKWARD_SLIP  # in space, where a disc has no sides


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


class Outcome(StrEnum):
    """Long-term state of a contact under periodic loading.

    SHAKEDOWN
        Frictional slip has ceased: every node stays as it is, closed or open, through the whole period.
    CYCLIC_SLIP
        Nodes slip in every period and return to where they were.
    RATCHETTING
        Slips grow by a constant amount per period.
    SEPARATION
        A node opens and closes within the period and none slips in contact, but
        perhaps in a jump; or the body leaves for good (period 0).
    UNDECIDED
        None of these could be established; the reason says why.
    """

    SHAKEDOWN = "shakedown"
    CYCLIC_SLIP = "cyclic-slip"
    RATCHETTING = "ratchetting"
    SEPARATION = "separation"
    UNDECIDED = "undecided"


class Guarantee(StrEnum):
    """How certain it is that below the first collapse a joint shakes down from every initial state.

    PROVED
        It is, from every state with all nodes closed.
    EVIDENCE
        Nothing is proved.
    """

    PROVED = "proved"
    EVIDENCE = "evidence"


class LimitsVerdict(StrEnum):
    """What the limits alone decide about the nominal load, without a simulation.

    SHAKEDOWN
        It is proved to shake down from the state asked about.
    IMPOSSIBLE
        With all nodes in contact it cannot shake down.
    OPEN
        They do not decide: a simulation does.
    """

    SHAKEDOWN = "shakedown"
    IMPOSSIBLE = "impossible-in-contact"
    OPEN = "open"
