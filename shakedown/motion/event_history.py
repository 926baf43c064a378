"""The path of a motion: its events, and the states at these."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Self

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.argument_kinds import check_count
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.status import OPEN
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.layout import Layout
from shakedown.joint.result import Result
from shakedown.motion.course import (
    CLOSES,
    JUMPS,
    LOAD_STEP,
    OPENS,
    REACHES_BACKWARD_LIMIT,
    REACHES_FORWARD_LIMIT,
)
from shakedown.motion.space.moving_state import CURVES, REACHES_LIMIT, STOPS

HASH_START, HASH_PRIME = np.uint64(14695981039346656037), np.uint64(1099511628211)


class EventKind(IntEnum):
    """What happens: a load step begins, a node reaches a limit, opens or closes, the state jumps.

    With two tangential directions a node reaches its one limit, and stops there; between events the path
    goes on in curves.
    """

    LOAD_STEP = LOAD_STEP
    REACHES_BACKWARD_LIMIT = REACHES_BACKWARD_LIMIT
    REACHES_FORWARD_LIMIT = REACHES_FORWARD_LIMIT
    OPENS = OPENS
    CLOSES = CLOSES
    JUMPS = JUMPS
    REACHES_LIMIT = REACHES_LIMIT
    STOPS = STOPS
    CURVES = CURVES


@dataclass(frozen=True, eq=False, repr=False)
class EventHistory(Result):
    """The path of a motion, one row per event; between rows everything is linear in time.

    With fixed load steps there is a row for each, the state at its end; what lies between is not known.

    Attributes
    ----------
    cycle : (s,)
        Time in cycles; what precedes the first period has negative times.
    kind : (s,)
        What happened at that time (:class:`EventKind`).
    node : (s,)
        The node that it happened to; −1 where it concerns none.
    v, w : (s, n)
        Slips and gaps [length].
    q, p : (s, n)
        Reactions [force].
    q_w, p_w : (s, n)
        Welded reactions [force].
    state : (s, n)
        State from this time on: 0 stick, +1 backward slip, −1 forward slip, 2 open. With fixed
        load steps that during the step.
    """

    cycle: FloatArray
    kind: NDArray[np.int64]
    node: NDArray[np.int64]
    v: FloatArray
    w: FloatArray
    q: FloatArray
    p: FloatArray
    q_w: FloatArray
    p_w: FloatArray
    state: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.cycle)

    @classmethod
    def none(cls, layout: Layout) -> "EventHistory":
        """A path on which nothing is recorded."""
        slips, empty = np.empty((0, layout.slip_size)), np.empty((0, layout.n))
        numbers = np.empty(0, dtype=np.int64)
        state = empty.astype(np.int64)
        return cls(np.empty(0), numbers, numbers, slips, empty, slips, empty, slips, empty, state)

    @classmethod
    def joined(cls, pieces: "Sequence[EventHistory]") -> Self:
        """One path after the other."""
        columns = ([getattr(part, key) for part in pieces] for key in cls.__dataclass_fields__)
        return cls(*(np.concatenate(column) for column in columns))

    def rows(self, index: NDArray[np.intp] | NDArray[np.bool_]) -> Self:
        """The history at chosen rows only."""
        return type(self)(*(getattr(self, key)[index] for key in self.__dataclass_fields__))

    def refined(self) -> "EventHistory":
        """The path with enough rows for linear interpolation; without curves the path itself."""
        return self

    def thinned(self, keep: int = 1) -> "EventHistory":
        """Only the load steps, every ``keep``-th of them, and the last state.

        Examples
        --------
        >>> import shakedown
        >>> from shakedown.motion.evolve import evolve
        >>> history = evolve(shakedown.example("two-node"), 0.9, cycles=3).history
        >>> len(history) > len(history.thinned()) > len(history.thinned(10))
        True
        """
        check_count("keep", keep)
        steps = np.flatnonzero(self.kind == EventKind.LOAD_STEP)[::keep]
        return self.rows(np.union1d(steps, np.arange(len(self))[-1:]))

    def slips(self, tolerances: Tolerances = DEFAULT) -> NDArray[np.bool_]:
        """Whether slips in contact exceed round-off over the path, one per column of ``v``.

        A node that comes to its limit and no further is there in the state of a slip: whether it is
        depends on the last bit. What it slips then, up to ``periodicity`` of the largest slip, is none.

        Examples
        --------
        >>> import shakedown
        >>> joint = shakedown.example("two-node")
        >>> shakedown.long_term_state(joint, 0.9, [2.0, 1.0]).history.slips()
        array([False,  True])
        """
        ways = np.where(self.state[:-1] != OPEN, np.abs(np.diff(self.v, axis=0)), 0.0).sum(axis=0)
        return np.asarray(ways > tolerances.periodicity * np.abs(self.v).max(initial=0.0))

    @property
    def signature(self) -> int:
        """64 bits for the contact states of a period and the changes between them, wherever it is cut.

        Neither the instants nor the load steps of the changes count.

        Examples
        --------
        >>> import shakedown
        >>> joint, slips = shakedown.example("two-node"), ([0.0, 0.0], [2.0, 1.0])
        >>> one, other = (shakedown.long_term_state(joint, 0.9, slip).history for slip in slips)
        >>> one.signature == other.signature
        True
        """
        lasting = np.flatnonzero(np.diff(self.cycle) > NEGLIGIBLE)
        codes = np.full(len(lasting), HASH_START, dtype=np.uint64)
        for states in self.state[lasting].T:
            codes = (codes ^ (states + 2).astype(np.uint64)) * HASH_PRIME
        changes = codes != np.roll(codes, 1)
        if not changes.any():
            return int(codes[0]) if len(codes) else 0
        mixed = (np.roll(codes, 1)[changes] * HASH_PRIME) ^ codes[changes]
        return int(((mixed ^ (mixed >> np.uint64(32))) * HASH_PRIME).sum())

    def at(self, cycle: FloatArray) -> "EventHistory":
        """The exact states at given times in cycles, by linear interpolation between events.

        At a jump the state after it counts. The last load step of m begins at 1 − 1/m of a
        cycle: the end of a cycle is the beginning of the next one.

        Raises
        ------
        UsageError
            If a time lies before the first event or after the last.

        Examples
        --------
        >>> import shakedown
        >>> from shakedown.motion.evolve import evolve
        >>> evolve(shakedown.example("two-node"), 0.9, cycles=2).history.at([0.0, 1.0]).v.round(4)
        array([[0.    , 0.    ],
               [0.    , 0.7132]])
        """
        cycle = np.asarray(cycle, dtype=float)
        first, last = self.cycle[[0, -1]]
        outside = cycle[~((cycle >= first - NEGLIGIBLE) & (cycle <= last + NEGLIGIBLE))]
        if outside.size:
            raise UsageError(f"cycle: expected times from {first:g} to {last:g}, found {outside[0]:g}")
        right = np.clip(np.searchsorted(self.cycle, cycle, side="right"), 1, len(self) - 1)
        left = right - 1
        span = self.cycle[right] - self.cycle[left]
        share = np.where(span > 0, (cycle - self.cycle[left]) / np.where(span > 0, span, 1.0), 1.0)[:, None]

        def between(values: FloatArray) -> FloatArray:
            return values[left] + share * (values[right] - values[left])

        return EventHistory(
            cycle=cycle,
            kind=np.full(len(cycle), EventKind.LOAD_STEP, dtype=np.int64),
            node=np.full(len(cycle), -1, dtype=np.int64),
            v=between(self.v),
            w=between(self.w),
            q=between(self.q),
            p=between(self.p),
            q_w=between(self.q_w),
            p_w=between(self.p_w),
            state=self.state[left],
        )
