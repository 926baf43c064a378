"""What one cycle of an exact evolution did, the state between cycles, and why an evolution stopped."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.evolution.viscous_jump import Jump
from shakedown.model.problem import FloatArray


@dataclass(frozen=True)
class Stop:
    """Why an evolution ended before its time: reason, time in cycles, node concerned (or −1)."""

    reason: str
    cycle: float
    node: int


@dataclass(frozen=True)
class CycleRecord:
    """What one cycle did.

    Attributes
    ----------
    slip : (n,)
        Σ|Δv| in contact [length].
    dissipation
        Frictional dissipation, and the energy released by jumps [force × length].
    opened : (n,)
        Whether the node was open for some time.
    events
        Number of events other than load steps.
    signature
        Identifies the sequence of contact states passed through.
    jumps
        The jumps in this cycle.
    """

    slip: FloatArray
    dissipation: float
    opened: NDArray[np.bool_]
    events: int
    signature: int
    jumps: tuple[Jump, ...]


@dataclass(frozen=True)
class State:
    """A state between two cycles: slips and gaps u = (v, w), (2n,), and contact states, (n,)."""

    u: FloatArray
    contact: NDArray[np.int64]
