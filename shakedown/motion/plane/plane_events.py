"""From event to event in the plane: exact, by the compiled loops of this subpackage."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.motion.checked_law import Scales
from shakedown.motion.course import CALL_OPERATIONS, Course, EventKind, LoopEnd
from shakedown.motion.event_history import EventHistory
from shakedown.motion.method import EventMethod, State, loads_at, one_row
from shakedown.motion.plane import moving_state
from shakedown.motion.plane.active_set import active_set, factorize, rates
from shakedown.motion.plane.event_loop import enumerate_states, follow_straight
from shakedown.motion.plane.moving_state import PlaneMotion, PlaneRun
from shakedown.motion.viscous_jump import ViscousJoint, ViscousMotion

ROUNDING = 16 * np.finfo(float).eps  # residual of moving nodes, relative to the largest force


class PlaneEvents(EventMethod):
    """The moving state of a joint in the plane, and the loops that follow it: straight from event to event.

    Attributes
    ----------
    active, rates
        The equations of the moving nodes, and their rates, as compiled loops take them.
    passable
        Ends of the loop after which there may be a way on (:meth:`finds_way_on`).
    error
        None: the path is exact.
    """

    run: PlaneRun
    motion: PlaneMotion
    new_record = staticmethod(moving_state.empty_record)
    passable = (LoopEnd.NO_RATES,)
    error = 0.0

    def __init__(self, problem: Problem, kappa: FloatArray, tolerances: Tolerances) -> None:
        self.active, self.rates = active_set(kappa, problem.f), rates(problem.n)
        parts = {
            "motion": moving_state.motion_at_rest(problem.n),
            "record": moving_state.empty_record(0, problem.n),
            "course": Course({}),
        }
        run = PlaneRun({}, active=self.active, rates=self.rates, **parts)
        super().__init__(problem, kappa, tolerances, run, self.active.state)

    def begin(self, start: FloatArray, first: FloatArray, later: FloatArray, scale: Scales) -> None:
        """Follow courses through the first and any other cycle, from given displacements (2n,).

        Forces and lengths count as zero up to round-off of the terms that make up the reactions.
        """
        locked, t = np.abs(self.kappa) @ np.abs(start), self.tolerances
        force = max(scale.force, float(locked.max()))
        self.lead(first, later, force=force, length=scale.length, rate=t.rate, residual=ROUNDING * force)

    def set_state(self, state: State) -> bool:
        """Go to a state; False where nothing holds its moving nodes."""
        super().set_state(state)
        return bool(factorize(self.active) != 0)

    def enter(self, first: bool, record: bool) -> None:
        """Go to the beginning of a cycle."""
        self.run = self.run_of(first, record)
        moving_state.begin(self.motion)

    def follow(self, cycles: int) -> int:
        """Follow the course a number of times; returns the status with which the loop ends."""
        status: int = follow_straight(self.run, cycles, CALL_OPERATIONS)
        return status

    def finds_rates(self) -> bool:
        """Whether enumeration finds states and rates where pivoting failed; the loop then finds them, too."""
        return enumerate_states(self.active, self.rates, self.courses[False].rate)

    def finds_way_on(self) -> bool:
        """Whether there are rates after all; the instant is then recorded when they are used."""
        record = self.run.record
        if not self.finds_rates():
            return False
        record.set(rows=max(record.rows - 1, 0))
        return True

    def present(self, done: int, reaction: FloatArray) -> EventHistory:
        """The present state, between two cycles."""
        columns = one_row(time=-1.0, kind=EventKind.LOAD_STEP, u=self.u, r=reaction, state=self.contact)
        return self.path(self.courses[False], done, **columns)

    def path(self, course: Course, done: int, **columns: NDArray[Any]) -> EventHistory:
        """The path along a course after so many cycles, from the columns (s, …) of a record."""
        time, split = columns["time"], self.problem.layout.split
        welded, _ = loads_at(course, time)
        (v, w), (q, p), (q_w, p_w) = split(columns["u"]), split(columns["r"]), split(welded)
        what = done + time / self.problem.m, columns["kind"], columns["node"]
        return EventHistory(*what, v, w, q, p, q_w, p_w, columns["state"])

    def reaction(self, load: FloatArray) -> FloatArray:
        """Reactions at the present instant, under these welded ones, (2n,) [force]."""
        return self.motion.r

    def relaxation(self, joint: ViscousJoint, state: State, reaction: FloatArray) -> ViscousMotion:
        """The viscous motion from a state with given reactions that the joint's load puts out of balance."""
        return ViscousMotion(joint, state.u, state.contact, reaction, self.courses[False])

    def resume(self, time: float) -> None:
        """Continue after a jump, from a given share of the load step."""
        moving_state.resume(self.motion, time)
