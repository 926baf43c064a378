"""What every way to follow a joint has in common, and cycles of it one by one from a start."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.motion.cycle_record import CycleRecord, Interim, State, Stop
from shakedown.motion.event_history import EventHistory
from shakedown.motion.viscous_jump import Jump


class Motion(Protocol):
    """A joint under its loading loop, carried from cycle to cycle by some method.

    Attributes
    ----------
    problem
        The joint.
    done
        Cycles followed.
    state
        Between two cycles; may be set to continue from another one.
    stop
        Why the last cycle could not be followed; None where it could.
    history
        The path over all cycles that were recorded.
    pieces
        What has been recorded, piece by piece.
    """

    problem: Problem
    done: int
    stop: Stop | None
    pieces: list[Any]

    @property
    def state(self) -> State: ...
    @state.setter
    def state(self, state: State) -> None: ...
    @property
    def history(self) -> EventHistory: ...

    def cycle(self, *, record: bool = False) -> CycleRecord | None:
        """Carry the joint through its next cycle; None, and ``stop`` says why, where that cannot be done."""

    def interim(self) -> Interim:
        """Where it stands; another motion of the same joint and load factor can go on from there."""

    def go_on(self, interim: Interim) -> None:
        """Stand where a motion stood, as if it had been followed so far, but for what is recorded."""


@dataclass(frozen=True, eq=False, repr=False)
class Walk(Result):
    """Cycles followed one by one from a start.

    Attributes
    ----------
    start : (n,)
        Slip there [length].
    records
        What every cycle did.
    history
        The path, where it was recorded.
    """

    start: FloatArray
    records: tuple[CycleRecord, ...]
    history: EventHistory | None

    @cached_property
    def end_slip(self) -> FloatArray:
        """Slip before the first and after every cycle, (c + 1, n) [length]."""
        return np.array([self.start, *(record.end_slip for record in self.records)])

    @cached_property
    def slip(self) -> FloatArray:
        """Σ|Δv| in contact during every cycle, (c, n) [length]."""
        return self._of_nodes([record.slip for record in self.records])

    @cached_property
    def dissipation(self) -> FloatArray:
        """What friction and jumps took in every cycle, (c,) [force × length]."""
        return np.array([record.dissipation for record in self.records])

    @cached_property
    def open_nodes(self) -> NDArray[np.bool_]:
        """Whether a node was open for some time (at some load step) of the cycle, (c, n)."""
        return self._of_nodes([record.opened for record in self.records]).astype(bool)

    def _of_nodes(self, values: list[NDArray[Any]]) -> NDArray[Any]:
        """What every cycle has for every node, (c, n)."""
        return np.reshape(values, (len(values), len(values[0]) if values else 0))

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Discontinuities on the way, each with the energy that it releases."""
        return tuple(jump for record in self.records for jump in record.jumps)


def cycles_of(motion: Motion, most: int, *, record: bool = False) -> Iterator[CycleRecord]:
    """So many cycles one after the other, or as many as there are before it stops."""
    for _ in range(most):
        done = motion.cycle(record=record)
        if done is None:
            return
        yield done


def walk(motion: Motion, most: int, *, record: bool = False) -> Walk:
    """At most so many cycles from the present state."""
    start = motion.state.u[motion.problem.layout.slips]
    records = tuple(cycles_of(motion, most, record=record))
    return Walk(start, records, motion.history if record else None)
