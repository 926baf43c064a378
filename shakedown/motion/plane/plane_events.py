"""From event to event in the plane: exact, by the compiled loops of this subpackage."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.motion.checked_law import Scales
from shakedown.motion.course import (
    EFFORT,
    LOAD_STEP,
    NO_RATES,
    RECORD_ROWS,
    Course,
    Precision,
    Progress,
    course,
    progress,
)
from shakedown.motion.cycle_record import State, Totals
from shakedown.motion.event_history import EventHistory
from shakedown.motion.plane.active_set import active_set, factorize
from shakedown.motion.plane.event_loop import follow_straight
from shakedown.motion.plane.moving_state import (
    begin,
    empty_record,
    motion_at_rest,
    resume,
)
from shakedown.motion.plane.rate_problem import rates
from shakedown.motion.plane.rate_search import enumerate_states
from shakedown.motion.plane.run import PlaneRun, run_along
from shakedown.motion.viscous_jump import ViscousMotion

ROUNDING = 16 * np.finfo(float).eps  # relative to the largest force: residual of settled equations


class Rows(NamedTuple):
    """Rows of a record, and the cycles done before them."""

    done: int
    time: FloatArray
    kind: NDArray[np.int64]
    node: NDArray[np.int64]
    u: FloatArray
    r: FloatArray
    state: NDArray[np.int64]


class PlaneEvents:
    """The moving state of a joint in the plane, and the loops that follow it: straight from event to event.

    Attributes
    ----------
    u, contact, slip
        Slips and gaps (2n,), contact states (n,), and Σ|Δv| in contact in the present cycle (n,), in place.
    motion, active, rates
        The same as compiled loops take it, with the equations of the moving nodes.
    precision
        What counts as zero.
    passable
        Ends of the loop after which there may be a way on (:meth:`finds_way_on`).
    """

    passable = (NO_RATES,)
    effort = 0  # not counted: a cycle takes milliseconds

    def __init__(self, problem: Problem, kappa: FloatArray, tolerances: Tolerances) -> None:
        self.problem, self.kappa, self.tolerances = problem, kappa, tolerances
        self.active, self.rates = active_set(kappa, problem.f), rates(problem.n)
        self.motion = motion_at_rest(problem.n)
        self.u, self.contact, self.slip = self.motion.u, self.active.state, self.motion.slip
        self._runs: dict[tuple[bool, bool], PlaneRun] = {}  # by: through the first cycle, recorded
        self._courses: dict[bool, Course] = {}  # by: through the first cycle

    def begin(self, start: FloatArray, first: FloatArray, later: FloatArray, scale: Scales) -> None:
        """Follow courses through the first and any other cycle, from given displacements (2n,).

        Forces and lengths count as zero up to round-off of the terms that make up the reactions.
        """
        locked, t = np.abs(self.kappa) @ np.abs(start), self.tolerances
        force = max(scale.force, float(locked.max()))
        self.precision = Precision(t.limit * force, t.limit * scale.length, t.rate, ROUNDING * force)
        self.scale = scale
        self._paths = {True: np.ascontiguousarray(first), False: np.ascontiguousarray(later)}
        for which, way in self._courses.items():
            way.hold(path=self._paths[which])
            way.set(**self.precision._asdict())

    def set_state(self, state: State) -> bool:
        """Go to a state; False where nothing holds its moving nodes."""
        self.u[:], self.contact[:] = state.u, state.contact
        return bool(factorize(self.active) != 0)

    def run(self, first: bool, record: bool) -> PlaneRun:
        """The run through the first cycle or another one, created when first needed."""
        if (first, record) not in self._runs:
            if first not in self._courses:
                path, separable = self._paths[first], self.problem.C is not None
                self._courses[first] = course(path, self.problem.m - len(path), separable, self.precision)
            events = empty_record(RECORD_ROWS if record else 0, self.problem.n)
            run = run_along(self.active, self.rates, self.motion, events, self._courses[first])
            self._runs[first, record] = run
        return self._runs[first, record]

    def enter(self, first: bool, record: bool) -> None:
        """Go to the beginning of a cycle."""
        self._present = self.run(first, record)
        begin(self.motion)

    def follow(self, cycles: int) -> int:
        """Follow the course a number of times; returns the status with which the loop ends."""
        status: int = follow_straight(self._present, cycles, EFFORT)
        return status

    def progress(self) -> Progress:
        """Where the present cycle has got to."""
        return progress(self.motion)

    def finds_rates(self) -> bool:
        """Whether enumeration finds states and rates where pivoting failed; the loop then finds them, too."""
        return enumerate_states(self.active, self.rates, self.precision.rate)

    def finds_way_on(self, now: Progress, path: FloatArray) -> bool:
        """Whether there are rates after all; the instant is then recorded when they are used."""
        record = self._present.record
        if not self.finds_rates():
            return False
        record.set(rows=max(record.rows - 1, 0))
        return True

    def recorded(self, done: int) -> list[Rows]:
        """What a record has been filled with, so many cycles being done."""
        record = self._present.record
        rows = record.content.rows
        if not rows:
            return []
        times, kinds, nodes = record.time[:rows].copy(), record.kind[:rows].copy(), record.node[:rows].copy()
        u, r, states = record.u[:rows].copy(), record.r[:rows].copy(), record.state[:rows].copy()
        return [Rows(done, times, kinds, nodes, u, r, states)]

    def present(self, done: int, reaction: FloatArray) -> Rows:
        """The present state, between two cycles, as a row."""
        kinds = np.array([LOAD_STEP]), np.array([-1])
        return Rows(done, np.array([-1.0]), *kinds, self.u[None], reaction[None], self.contact[None])

    def histories(
        self, cycle: FloatArray, rows: Rows, welded: FloatArray, change: FloatArray
    ) -> EventHistory:
        """The path of rows at times in cycles, with these welded reactions."""
        split = self.problem.layout.split
        (v, w), (q, p), (q_w, p_w) = split(rows.u), split(rows.r), split(welded)
        return EventHistory(cycle, rows.kind, rows.node, v, w, q, p, q_w, p_w, rows.state)

    def totals(self) -> Totals:
        """The sums of the present cycle, without jumps."""
        mo, counted = self.motion, self.motion.content
        opened, closed = mo.opened.astype(np.bool_), mo.closed.astype(np.bool_)
        numbers = counted.dissipation, counted.events, counted.signature
        return Totals(mo.slip.copy(), mo.work, opened, closed, *numbers)

    def reaction(self, load: FloatArray) -> FloatArray:
        """Reactions at the present instant, under these welded ones, (2n,) [force]."""
        return self.motion.r

    def relaxation(
        self, state: State, reaction: FloatArray, load: FloatArray, damping: FloatArray
    ) -> ViscousMotion:
        """The viscous motion from a state with given reactions that the load puts out of balance."""
        before = state.u, state.contact, reaction
        return ViscousMotion(self.kappa, self.problem.f, *before, load, damping, self.precision, self.scale)

    def resume(self, time: float) -> None:
        """Continue after a jump, from a given share of the load step."""
        resume(self.motion, time)
