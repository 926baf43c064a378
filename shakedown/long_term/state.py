"""The long-term state of a joint, with the evidence for it."""

from dataclasses import dataclass
from math import ceil, log

import numpy as np
from numpy.typing import NDArray

from shakedown.evolution.event_history import EventHistory
from shakedown.evolution.reduced_scene import Scene
from shakedown.long_term.outcome import Outcome
from shakedown.model.problem import FloatArray


@dataclass(frozen=True)
class LongTermState:
    """Result of :func:`long_term_state`.

    Attributes
    ----------
    load_factor, initial_slip
        What was asked for; slip (n,) [length].
    outcome, reason
        Long-term state (:class:`Outcome`), and in words what it rests on.
    period
        Cycles after which the state repeats; 0 where undecided, and where the
        body leaves (outcome "separation": contact is lost for good).
    final_slip : (n,)
        Slip at the end of a period of the long-term state [length].
    drift : (n,)
        Growth of the slip per period [length]; NaN where undecided.
    slip_per_cycle : (n,)
        Σ|Δv| in contact over one period of the long-term state [length].
    dissipation_per_cycle
        Mean frictional dissipation per cycle [force × length].
    dissipations : (period,)
        Dissipation of each cycle of the period [force × length].
    open_nodes : (n,)
        Whether the node is open for some time of the period.
    cycles_simulated, events
        Effort: cycles and events followed in all.
    contraction
        Factor per cycle by which the distance to the long-term state shrinks in
        the end; 0 where it is reached exactly, NaN where undecided.
    residual
        Largest relative violation of the friction law at the events of one
        period of the long-term state.
    return_error
        How far one period from the long-term state misses it, drift apart,
        relative to the length scale.
    history
        The events of that period.
    scene
        What was left out, where that was asked for and could be done.
    """

    load_factor: float
    initial_slip: FloatArray
    outcome: Outcome
    reason: str
    period: int
    final_slip: FloatArray
    drift: FloatArray
    slip_per_cycle: FloatArray
    dissipation_per_cycle: float
    dissipations: FloatArray
    open_nodes: NDArray[np.bool_]
    cycles_simulated: int
    events: int
    contraction: float
    residual: float
    return_error: float
    history: EventHistory
    scene: Scene | None = None

    @property
    def cycles_to_one_percent(self) -> int:
        """Cycles until the distance to the long-term state has shrunk to 1 %."""
        return 1 if self.contraction <= 0.01 else ceil(log(0.01) / log(self.contraction))
