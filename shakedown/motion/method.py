"""What all methods of following a joint share, and walks of cycles from a start."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import BACKWARD_SLIP, OPEN
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked_initial_slip
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.loading import first_load, loop_path, ramp_start, transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.motion.checked_law import Scales, scales, scales_of
from shakedown.motion.cycle_record import CycleRecord, State, Stop
from shakedown.motion.event_history import EventHistory
from shakedown.motion.viscous_jump import Jump


class Beginning(NamedTuple):
    """The state at the start, and the welded reactions there.

    Attributes
    ----------
    state
        Slips, gaps and contact states.
    load : (2n,)
        Welded reactions (q_w, p_w) from which the load rises to its first step [force].
    """

    state: State
    load: FloatArray


def beginning(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    open_nodes: Iterable[int] = (),
    tolerances: Tolerances = DEFAULT,
) -> Beginning:
    """The state in which a motion begins, in equilibrium with the first load step where nodes are open.

    Parameters
    ----------
    problem, load_factor
        The joint and λ.
    initial_slip : (n,), optional
        Slip [length]; zero by default. Entries of open nodes are ignored: their
        displacements follow from equilibrium, q = p = 0.
    open_nodes
        The nodes that are open; all others are closed.
    tolerances
        ``feasibility`` says how far an open node may overlap by round-off.

    Raises
    ------
    UsageError
        If an argument is out of range, or an open node would overlap.
    ProblemError
        If nodes are open and the problem has no C.

    Examples
    --------
    >>> import shakedown
    >>> block = shakedown.example("receding-block")
    >>> upper = shakedown.upper_bound(block, open_nodes="auto")
    >>> start = beginning(block, 0.5 * upper.load_factor, upper.slip, upper.open_nodes)
    >>> bool((start.state.u[33:] >= 0).all()), bool(start.state.u[33] > 0)
    (True, True)
    """
    slip, layout = checked_initial_slip(problem, initial_slip), problem.layout
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    first = first_load(problem, load_factor)
    contact = np.where(problem.f == 0.0, BACKWARD_SLIP, 0)
    nodes = np.array(zone.open_nodes, dtype=np.intp)
    if not nodes.size:
        state = State(layout.joined(slip, np.zeros(problem.n)), contact)
        return Beginning(state, ramp_start(problem, first, state.u))
    u = zone.displacements(slip[layout.slips_of(zone.closed_nodes)], *layout.split(first[None]))[0]
    gaps = u[layout.gaps_of(nodes)]
    if gaps.min() < -tolerances.feasibility * max(scales(problem, load_factor).length, np.abs(u).max()):
        raise UsageError(
            "open nodes: expected gaps >= 0 under the first load, found that "
            f"node {nodes[gaps.argmin()]} would overlap by {-gaps.min():.6g}"
        )
    u[layout.gaps_of(nodes)] = np.maximum(gaps, 0.0)
    contact[nodes] = OPEN
    load = ramp_start(problem, first, u)
    load[layout.of_nodes(nodes)] = first[layout.of_nodes(nodes)]  # in equilibrium all the way
    return Beginning(State(u, contact), load)


class Motion:
    """A joint under its loading loop, carried from cycle to cycle by some method.

    Attributes
    ----------
    problem, tolerances
        The joint; what counts as zero.
    method
        The object that holds the state and follows the load from one point to the next.
    load_factor
        λ.
    load : (m, (d + 1) n)
        Welded reactions of one period [force].
    scale
        What "small" is measured against.
    done
        Cycles followed.
    stop
        Why the last cycle could not be followed; None where it could.
    pieces
        What has been recorded, piece by piece.
    """

    problem: Problem
    tolerances: Tolerances
    method: Any
    load_factor: float
    load: FloatArray
    scale: Scales
    done: int
    stop: Stop | None
    pieces: list[Any]

    def begin(
        self, load_factor: float, initial_slip: ArrayLike | None = None, open_nodes: Iterable[int] = ()
    ) -> None:
        """Go to the start at a load factor, like a newly created motion."""
        problem = self.problem
        start = beginning(problem, load_factor, initial_slip, open_nodes, self.tolerances)
        self.load_factor, self.done, self.pieces = load_factor, 0, []
        self.load, transient = loop_path(problem, load_factor), transient_path(problem)
        self.scale = scales_of(problem, self.load, transient)
        self._begin(start, transient)

    def _begin(self, start: Beginning, transient: FloatArray) -> None:
        """Begin before given transient load steps and the first period."""
        raise NotImplementedError

    @property
    def state(self) -> State:
        """The state between two cycles; may be set to continue from another one.

        From one whose moving nodes nothing holds the next cycle cannot be followed.
        """
        return State(self.method.u.copy(), self.method.contact.copy())

    @state.setter
    def state(self, state: State) -> None:
        self.stop = None
        self._set_state(state)

    def _set_state(self, state: State) -> None:
        self.method.set_state(state)

    @property
    def history(self) -> EventHistory:
        """The path over all cycles that were recorded."""
        raise NotImplementedError

    def enter_cycle(self, done: int) -> None:
        """Enter a cycle: a number of cycles are done, and nothing has stopped the next one yet."""
        self.done, self.stop = done, None

    def cycle(self, *, record: bool = False) -> CycleRecord | None:
        """Carry the joint through its next cycle; None, and ``stop`` says why, where that cannot be done.

        ``record``: keep the path (:attr:`history`).
        """
        if self.stop is not None or not self._follow(1, record):
            return None
        return self._what_it_did()

    def _follow(self, cycles: int, record: bool) -> bool:
        """Follow at least one of a number of cycles; False, and ``stop`` says why, where it ends."""
        raise NotImplementedError

    def _what_it_did(self) -> CycleRecord:
        """The record of the last cycle."""
        raise NotImplementedError

    def advance(self, cycles: int) -> int:
        """Carry the joint through so many cycles without a record of each; how many it passes.

        Examples
        --------
        >>> import shakedown
        >>> from shakedown.motion.evolution import Evolution
        >>> evolution = Evolution(shakedown.example("two-node"), 0.9)
        >>> evolution.advance(100), evolution.stop is None
        (100, True)
        """
        before, end = self.done, self.done + cycles
        while self.done < end and self.stop is None:
            self._follow(end - self.done, False)
        return self.done - before


@dataclass(frozen=True, eq=False, repr=False)
class Walk(Result):
    """Cycles followed one by one from a start.

    Attributes
    ----------
    start : (n,)
        Slip there [length].
    records
        The record of every cycle.
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
        """Dissipation of friction and jumps in every cycle, (c,) [force × length]."""
        return np.array([record.dissipation for record in self.records])

    @cached_property
    def open_nodes(self) -> NDArray[np.bool_]:
        """Whether a node was open at some time (at some load step) of the cycle, (c, n)."""
        return self._of_nodes([record.opened for record in self.records]).astype(bool)

    def _of_nodes(self, values: list[NDArray[Any]]) -> NDArray[Any]:
        """A field of every cycle for every node, (c, n)."""
        return np.reshape(values, (len(values), len(values[0]) if values else 0))

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Discontinuities on the way, each with the energy that it releases."""
        return tuple(jump for record in self.records for jump in record.jumps)


def cycles_of(motion: Motion, most: int, *, record: bool = False) -> Iterator[CycleRecord]:
    """A number of successive cycles, or those before the motion stops."""
    for _ in range(most):
        done = motion.cycle(record=record)
        if done is None:
            return
        yield done


def walk(motion: Motion, most: int, *, record: bool = False) -> Walk:
    """At most a given number of cycles from the present state."""
    start = motion.state.u[motion.problem.layout.slips]
    records = tuple(cycles_of(motion, most, record=record))
    return Walk(start, records, motion.history if record else None)
