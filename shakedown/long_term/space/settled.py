"""What a search for a long-term state goes by, and what it comes to."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import THREE_DIGITS
from shakedown.ground.status import Outcome
from shakedown.long_term.passage import FirstCycles
from shakedown.motion.method import CycleRecord, State, Stop
from shakedown.motion.viscous_jump import Jump

VARIES_LITTLE = "the varying part of the loads is next to round-off beside the constant part"


@dataclass(frozen=True)
class ReturnRules:
    """When a search ends, and what it neglects.

    Attributes
    ----------
    most_cycles, longest_period
        As for :func:`long_term_state`.
    noise
        How far one cycle may miss for errors of integration [length of the softest node].
    stiffness : (n,)
        Of every node, relative to the softest, ≥ 1: so much smaller a slip counts for as much.
    blurred
        Whether loads change by next to round-off: what seems at rest then may be none.
    """

    most_cycles: int
    longest_period: int
    noise: float
    stiffness: FloatArray
    blurred: bool = False


@dataclass(frozen=True, eq=False)
class Settled:
    """The result of a search.

    Attributes
    ----------
    outcome, reason
        What, and what it rests on.
    period
        In cycles; 0 where undecided.
    state, start
        At the end of the last period, and at its beginning.
    drift : (dn,)
        Growth of the slip per period [length].
    records
        The cycles of the last period.
    cycles, events
        Followed in all.
    contraction
        Factor per cycle by which the distance to the long-term state shrinks; NaN where undecided.
    return_error
        How far the last period has missed its start, drift apart [length].
    error, adrift
        Estimated distance of the state from the long-term state, and rigid slip in it that changes no cycle
        [length]; where it ratchets the distance apart from rigid slip.
    first_cycles
        What it has passed through before it first leapt.
    jumps
        Those of the cycles that it has followed, also after a leap.
    looked
        How many of the cycles were followed to see slopes.
    violation
        Of the friction law in the last period, relative; NaN where that was not looked at.
    stop
        Why the motion ended before its time; None where it did not.
    """

    outcome: Outcome
    reason: str
    period: int
    state: State
    drift: FloatArray
    records: tuple[CycleRecord, ...]
    cycles: int
    events: int
    contraction: float
    return_error: float
    error: float
    adrift: float
    start: State
    first_cycles: FirstCycles
    jumps: tuple[Jump, ...]
    looked: int
    violation: float = np.nan
    stop: Stop | None = None

    def undecided(self, reason: str) -> "Settled":
        """The same result with an undecided outcome."""
        nothing = np.full_like(self.drift, np.nan)
        return replace(
            self, outcome=Outcome.UNDECIDED, reason=reason, period=0, drift=nothing, records=(),
            contraction=np.nan, return_error=np.nan, error=np.nan, adrift=np.nan,
        )  # fmt: skip

    def held_against_law(self, violation: float, most: float) -> "Settled":
        """The same with the violation of the law in its period, undecided where that is more than so much."""
        if violation <= most:
            return replace(self, violation=violation)
        broken = f"the friction law is violated by {violation:.1e} in the period found"
        return self.undecided(f"{broken} ({self.reason})")

    @property
    def slip(self) -> float:
        """Largest slip of a node in the last period [length]."""
        return float(np.sum([record.slip for record in self.records], axis=0).max())

    @property
    def doubtful(self) -> bool:
        """Whether leaps leave more open than the slip of a period: the motion may reach another cycle."""
        return (
            self.outcome in (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING)
            and self.error - self.adrift > self.slip
        )

    def is_like(self, other: "Settled") -> bool:
        """Whether outcome and slip of a period equal those of another search, within their certainty."""
        alike = (self.outcome, self.period) == (other.outcome, other.period)
        # of the slip per period: by so little it is uncertain, and differs from the one before
        return alike and abs(self.slip - other.slip) <= THREE_DIGITS * self.slip

    def after(self, other: "Settled") -> "Settled":
        """The same, with the cycles of an earlier search."""
        return replace(self, cycles=other.cycles + self.cycles, looked=other.looked + self.looked)

    @property
    def signature(self) -> int:
        """Identifies the contact states of one period, whichever of its cycles it begins with."""
        return sum(record.signature for record in self.records) % 2**64


def opened_and_closed(records: tuple[CycleRecord, ...]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether each node was open, and whether it was closed, at some time in these cycles."""
    return (
        np.any([record.opened for record in records], axis=0),
        np.any([record.closed for record in records], axis=0),
    )
