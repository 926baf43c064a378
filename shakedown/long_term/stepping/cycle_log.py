"""What each cycle of a simulation did, row by row."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.joint.result import Result
from shakedown.motion.cycle_record import CycleRecord


@dataclass(frozen=True, eq=False, repr=False)
class Cycles(Result):
    """Record of a simulation, one row per cycle that was followed one by one from the start.

    Attributes
    ----------
    end_slip : (c + 1, n)
        Slip before the first and after every cycle [length].
    slip : (c, n)
        Σ|Δv| in contact during every cycle [length].
    dissipation : (c,)
        What friction and jumps took in every cycle [force × length].
    open_nodes : (c, n)
        Whether a node was open for some time (at some load step) of the cycle.
    """

    end_slip: FloatArray
    slip: FloatArray
    dissipation: FloatArray
    open_nodes: NDArray[np.bool_]


class CycleLog:
    """What each cycle did, as growing lists."""

    def __init__(self, start: FloatArray) -> None:
        self.end_slip = [start]
        self.slip: list[FloatArray] = []
        self.dissipation: list[float] = []
        self.open_nodes: list[NDArray[np.bool_]] = []

    def append(
        self,
        end_slip: FloatArray,
        slip: FloatArray,
        dissipation: float,
        open_nodes: NDArray[np.bool_],
    ) -> None:
        self.end_slip.append(end_slip)
        self.slip.append(slip)
        self.dissipation.append(dissipation)
        self.open_nodes.append(open_nodes)

    def last(self, count: int) -> Cycles:
        """The last ``count`` cycles, or as many as there are."""
        count = min(count, len(self.slip))
        shape, first = (count, len(self.end_slip[0])), len(self.slip) - count
        return Cycles(
            end_slip=np.array(self.end_slip[first:]),
            slip=np.reshape(self.slip[first:], shape),
            dissipation=np.array(self.dissipation[first:]),
            open_nodes=np.reshape(self.open_nodes[first:], shape).astype(bool),
        )


def logged(start: FloatArray, records: list[CycleRecord]) -> Cycles:
    """The log of an exact evolution from its start."""
    log = CycleLog(start)
    for record in records:
        log.append(record.end_slip, record.slip, record.dissipation, record.opened)
    return log.last(len(records))
