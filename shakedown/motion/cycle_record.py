"""What one cycle of a motion did, the state between cycles, and why an evolution stopped."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.motion.viscous_jump import Jump

SLIDES_AWAY = "the body slides away"


@dataclass(frozen=True)
class Stop:
    """Why an evolution ended before its time.

    Attributes
    ----------
    reason
        In words.
    cycle
        When, in cycles.
    node
        The node concerned; −1 where it is none alone.
    slides_away
        Whether the body slides away for good: friction and stiffness do not hold it.
    spent
        Whether no more than the work allowed was in the way (:mod:`shakedown.ground.work_limit`).
    """

    reason: str
    cycle: float
    node: int
    slides_away: bool = False
    spent: bool = False


@dataclass(frozen=True)
class CycleRecord:
    """The events and sums of one cycle.

    Attributes
    ----------
    end_slip : (n,)
        Slip at its end [length].
    slip : (n,)
        Σ|Δv| in contact [length]; of a jump the change of v where a node is closed
        before and after it (:attr:`Jump.slip` has the whole way).
    work : (n,)
        Friction work at each node, including jumps [force × length].
    friction_dissipation
        The sum of that.
    jump_dissipation
        The work of damping in jumps: the rest of the energy that they release [force × length].
    opened, closed : (n,)
        Whether the node was open, and whether it was closed, at some time.
    events
        Number of events other than load steps.
    signature
        Identifies the sequence of contact states passed through; 0 with fixed load steps.
    jumps
        The jumps in this cycle.
    error
        Estimate of the error that it adds to the slips [length]; 0 where a motion is exact, or tells none.
    """

    end_slip: FloatArray
    slip: FloatArray
    work: FloatArray
    friction_dissipation: float
    jump_dissipation: float
    opened: NDArray[np.bool_]
    closed: NDArray[np.bool_]
    events: int
    signature: int
    jumps: tuple[Jump, ...]
    error: float = 0.0

    @property
    def dissipation(self) -> float:
        """Work of friction and of damping in jumps [force × length]."""
        return self.friction_dissipation + self.jump_dissipation


class Totals(NamedTuple):
    """Sums of a cycle counted by compiled loops, without jumps: as in :class:`CycleRecord`.

    ``friction`` is None where it is not counted apart from the work of each node.
    """

    slip: FloatArray
    work: FloatArray
    opened: NDArray[np.bool_]
    closed: NDArray[np.bool_]
    friction: float | None
    events: int
    signature: int
    error: float = 0.0


Checkpoint = tuple[Any, ...]
"""What all that follows depends on between two cycles, to the last bit."""


@dataclass(frozen=True)
class State:
    """A state between two cycles: slips and gaps u = (v, w), (2n,), and contact states, (n,)."""

    u: FloatArray
    contact: NDArray[np.int64]
