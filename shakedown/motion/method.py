"""What all methods of following a joint share.

The state between cycles, what one cycle did and why an evolution stopped; walks of many cycles from a start;
what following a joint from event to event has in common in the plane and in space.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.constants import FloatArray, Mask
from shakedown.ground.errors import UsageError
from shakedown.ground.status import BACKWARD_SLIP, OPEN
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked_initial_slip
from shakedown.joint.constraints import first_load, loop_path, ramp_start, transient_path
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.motion.checked_law import Scales, scales, scales_of
from shakedown.motion.course import RECORD_ROWS, Course, course
from shakedown.motion.event_history import EventHistory
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
    opened: Mask
    closed: Mask
    events: int = 0
    signature: int = 0
    jumps: tuple[Jump, ...] = ()
    error: float = 0.0

    @property
    def dissipation(self) -> float:
        """Work of friction and of damping in jumps [force × length]."""
        return self.friction_dissipation + self.jump_dissipation


@dataclass(frozen=True)
class State:
    """A state between two cycles, on which all that follows depends.

    Attributes
    ----------
    u, contact
        Slips and gaps (v, w), ((d + 1) n,), and contact states, (n,).
    direction : (2n,), optional
        In space the directions of slip of nodes at their apex; by default those of the motion as it is.
    """

    u: FloatArray
    contact: NDArray[np.int64]
    direction: FloatArray | None = None


def beginning(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    open_nodes: Iterable[int] = (),
    tolerances: Tolerances = DEFAULT,
) -> tuple[State, FloatArray]:
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

    Returns
    -------
    state
        Slips, gaps and contact states.
    load : (2n,)
        Welded reactions (q_w, p_w) from which the load rises to its first step [force].

    Raises
    ------
    UsageError
        If an argument is out of range, or an open node would overlap.
    ProblemError
        If nodes are open and the problem has no C.

    Examples
    --------
    A node that keeps its slip, and one that the load pulls away:

    >>> q_w, p_w = [[0.25, 0.5]], [[1.0, -3.0]]
    >>> joint = Problem(A=np.eye(2), B=np.zeros((2, 2)), C=np.diag([1.0, 2.0]), f=0.5, q_w=q_w, p_w=p_w)
    >>> state, load = beginning(joint, 1.0, [7.0, 8.0], open_nodes=[1])
    >>> state.u, state.contact, load
    (array([ 7. , -0.5,  0. ,  1.5]), array([0, 2]), array([-7. ,  0.5,  1. , -3. ]))
    >>> beginning(joint, 1.0, open_nodes=[0])
    Traceback (most recent call last):
    shakedown...UsageError: open nodes: expected gaps >= 0 under the first load, ... node 0 would overlap by 1
    """
    slip, layout = checked_initial_slip(problem, initial_slip), problem.layout
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    first = first_load(problem, load_factor)
    contact = np.where(problem.f == 0.0, BACKWARD_SLIP, 0)
    nodes = np.array(zone.open_nodes, dtype=np.intp)
    if not nodes.size:
        state = State(layout.joined(slip, np.zeros(problem.n)), contact)
        return state, ramp_start(problem, first, state.u)
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
    return State(u, contact), load


class Motion(ABC):
    """A joint under its loading loop, carried from cycle to cycle by some method.

    Attributes
    ----------
    problem, tolerances
        The joint; what counts as zero.
    u, contact, direction
        Slips and gaps ((d + 1) n,), contact states (n,), directions of slip (:class:`State`), in place.
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
    u: FloatArray
    contact: NDArray[np.int64]
    direction: FloatArray | None = None
    load_factor: float
    load: FloatArray
    scale: Scales
    done: int
    stop: Stop | None
    pieces: list[EventHistory]

    def begin(
        self, load_factor: float, initial_slip: ArrayLike | None = None, open_nodes: Iterable[int] = ()
    ) -> None:
        """Go to the start at a load factor, like a newly created motion."""
        problem = self.problem
        state, load = beginning(problem, load_factor, initial_slip, open_nodes, self.tolerances)
        self.load_factor, self.done, self.pieces = load_factor, 0, []
        self.load, transient = loop_path(problem, load_factor), transient_path(problem)
        self.scale = scales_of(problem, self.load, transient)
        self._begin(state, load, transient)

    @abstractmethod
    def _begin(self, state: State, load: FloatArray, transient: FloatArray) -> None:
        """Begin in a state and under a load before given transient load steps and the first period."""

    @property
    def state(self) -> State:
        """The state between two cycles; may be set to continue from another one.

        From one whose moving nodes nothing holds the next cycle cannot be followed.
        """
        direction = None if self.direction is None else self.direction.copy()
        return State(self.u.copy(), self.contact.copy(), direction)

    @state.setter
    def state(self, state: State) -> None:
        self.stop = None
        self._set_state(state)

    @abstractmethod
    def _set_state(self, state: State) -> None:
        """Go to a state between two cycles."""

    @property
    @abstractmethod
    def history(self) -> EventHistory:
        """The path over all cycles that were recorded."""

    def cycle(self, *, record: bool = False) -> CycleRecord | None:
        """Carry the joint through its next cycle; None, and ``stop`` says why, where that cannot be done.

        ``record``: keep the path (:attr:`history`).
        """
        if self.stop is not None or not self._follow(1, record):
            return None
        return self._what_it_did()

    @abstractmethod
    def _follow(self, cycles: int, record: bool) -> bool:
        """Follow at least one of a number of cycles; False, and ``stop`` says why, where it ends."""

    @abstractmethod
    def _what_it_did(self) -> CycleRecord:
        """The record of the last cycle."""

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
    def open_nodes(self) -> Mask:
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
    return islice(iter(lambda: motion.cycle(record=record), None), most)


def walk(motion: Motion, most: int, *, record: bool = False) -> Walk:
    """At most a given number of cycles from the present state."""
    start = motion.state.u[motion.problem.layout.slips]
    records = tuple(cycles_of(motion, most, record=record))
    return Walk(start, records, motion.history if record else None)


def one_row(**columns: Any) -> dict[str, NDArray[Any]]:
    """The columns of a record of one row, which concerns no node."""
    return {name: np.array(value)[None] for name, value in {"node": -1, **columns}.items()}


class EventMethod(ABC):
    """The moving state of a joint, and the runs of compiled loops that carry it along courses.

    Attributes
    ----------
    problem, kappa, tolerances
        The joint, its stiffness, and what counts as zero.
    run
        The present run: the state along a course, recorded or not.
    u, contact, slip
        Slips and gaps ((d + 1) n,), contact states (n,), way in contact in the present cycle (n,), in place.
    direction : (2n,)
        In space the directions of slip of nodes at their apex, in place.
    motion
        All of these and what has been counted, as compiled loops take them.
    courses
        Those through the first cycle (True) and any other one, which say what counts as zero.
    """

    new_record: ClassVar[Any]  # an empty record, of so many rows and nodes
    direction: FloatArray | None = None

    def __init__(
        self,
        problem: Problem,
        kappa: FloatArray,
        tolerances: Tolerances,
        run: Any,
        contact: NDArray[np.int64],
    ) -> None:
        self.problem, self.kappa, self.tolerances = problem, kappa, tolerances
        self.run, self.motion = run, run.motion
        self.u, self.contact, self.slip = self.motion.u, contact, self.motion.slip
        self._runs: dict[tuple[bool, bool], Any] = {}  # by: through the first cycle, recorded
        self.courses = {True: Course({}), False: Course({})}

    def lead(
        self,
        first: FloatArray,
        later: FloatArray,
        *,
        force: float,
        length: float,
        rate: float,
        residual: float,
    ) -> None:
        """Follow courses through the first and any other cycle.

        What counts as zero are small shares of a force and a length, and so large rates and residuals.
        """
        separable, m, limit = self.problem.C is not None, self.problem.m, self.tolerances.limit
        for is_first, path in ((True, first), (False, later)):
            new = course(path, m - len(path), separable, self.courses[is_first])
            new.set(force=limit * force, length=limit * length, rate=rate, residual=residual)

    def run_of(self, first: bool, record: bool) -> Any:
        """The run through the first cycle or another one, created when first needed."""
        if (first, record) not in self._runs:
            rows = self.new_record(RECORD_ROWS if record else 0, self.problem.n)
            self._runs[first, record] = self.run.with_parts(course=self.courses[first], record=rows)
        return self._runs[first, record]

    def set_state(self, state: State) -> bool:
        """Go to a state; False where nothing holds its moving nodes."""
        self.u[:], self.contact[:] = state.u, state.contact
        return True

    def recorded(self, done: int) -> list[EventHistory]:
        """The path recorded since the loop was entered, so many cycles being done."""
        record = self.run.record
        columns = {key: part[: record.rows].copy() for key, part in vars(record).items() if key != "content"}
        return [self.path(self.run.course, done, **columns)] if record.rows else []

    @abstractmethod
    def path(self, course: Course, done: int, **columns: NDArray[Any]) -> EventHistory:
        """The path along a course after so many cycles, from the columns (s, …) of a record."""


def loads_at(course: Course, time: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Welded reactions at times (s,) [load steps], and their change in the load step, (s, (d + 1) n).

    Examples
    --------
    >>> along = course(np.array([[0.0], [2.0], [3.0]]), 1, True, Course({}))
    >>> loads, changes = loads_at(along, np.array([1.5, 2.0, 3.0]))
    >>> loads.ravel(), changes.ravel()
    (array([1., 2., 3.]), array([2., 1., 1.]))
    """
    index = np.minimum((time - course.first).astype(int), course.steps - 1)
    before = course.path[index]
    change = course.path[index + 1] - before
    return before + change * (time - course.first - index)[:, None], change
