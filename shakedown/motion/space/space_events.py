"""From event to event in space: along smooth curves, by the compiled loops of this subpackage."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import PER_CENT, ROUND_OFF, THREE_DIGITS
from shakedown.ground.status import OPEN
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.motion.checked_law import Scales, swing
from shakedown.motion.course import (
    EFFORT,
    NO_RATES,
    RECORD_ROWS,
    TOO_MANY_EVENTS,
    Precision,
    Progress,
    course,
    progress,
)
from shakedown.motion.cycle_record import Checkpoint, State, Totals
from shakedown.motion.event_history import EventKind
from shakedown.motion.space.curved_history import CurvedHistory
from shakedown.motion.space.curved_loop import follow_curve
from shakedown.motion.space.directed_jump import FEW_TURNS, DirectedJump, end_at_once
from shakedown.motion.space.exchange import MOST_EXCHANGES
from shakedown.motion.space.implicit_step import TURNS, ImplicitJoint
from shakedown.motion.space.moving_state import DEGREE, empty_curve_record
from shakedown.motion.space.space_run import Measures, SpaceRun, begin, resume, run_in_space
from shakedown.motion.viscous_jump import StepEnd

MOST_PASSED = 10  # instants of a cycle passed by implicit steps
MOST_SHORTENED = 8  # lengths of such steps that are tried


def measures(scale: Scales, locked: float, moving: float, tolerances: Tolerances) -> Measures:
    """What counts as zero, given the size of reactions due to locked-in slip and their change over a period.

    Both [force]. A small motion must be followed more accurately in proportion; the cost is the same.
    """
    force = max(scale.force, locked)
    near = max(PER_CENT * tolerances.path * scale.force, tolerances.limit * force)
    accuracy = max(tolerances.path * min(moving / scale.force, 1.0), ROUND_OFF) if moving else tolerances.path
    zero = tolerances.limit * force, tolerances.limit * scale.length, 10.0 * tolerances.rate
    return Measures(Precision(*zero, settled=near), scale, accuracy)


class PathSteps(NamedTuple):
    """Steps of a record, and the cycles done before them."""

    done: int
    time: FloatArray
    duration: FloatArray
    u: FloatArray
    curve: FloatArray
    contact: NDArray[np.int64]
    node: NDArray[np.int64]
    kind: NDArray[np.int64]


class SpaceEvents:
    """The moving state of a joint in space, and the loops that follow it smoothly from event to event.

    The direction in which a node slips is that of its tangential reaction, and only the speeds are
    unknown: between events the slips follow a smooth differential equation (docs/space.md), which is
    integrated to the accuracy ``Tolerances.path``.

    Attributes
    ----------
    u, contact, slip
        Slips and gaps (3n,), contact states (n,), and way in contact in the present cycle (n,), in place.
    run
        The same as compiled loops take it, along a course.
    measures
        What counts as zero, and how accurate the path is.
    passable
        Ends of the loop after which there may be a way on (:meth:`finds_way_on`).
    """

    passable = NO_RATES, TOO_MANY_EVENTS

    def __init__(self, problem: Problem, kappa: FloatArray, tolerances: Tolerances) -> None:
        self.problem, self.kappa, self.tolerances = problem, kappa, tolerances
        self._runs: dict[tuple[bool, bool], SpaceRun] = {}  # by: through the first cycle, recorded
        self._passed = 0  # instants without rates in the present cycle

    def begin(self, start: FloatArray, first: FloatArray, later: FloatArray, scale: Scales) -> None:
        """Follow courses through the first and any other cycle, from given displacements (3n,)."""
        problem, locked = self.problem, float((np.abs(self.kappa) @ np.abs(start)).max())
        self.scale = scale
        self.measures = measures(scale, locked, swing(problem, later[1:]), self.tolerances)
        precision, separable = self.measures.precision, problem.C is not None
        self._courses = {
            is_first: course(path, problem.m - len(path), separable, precision)
            for is_first, path in ((True, first), (False, later))
        }
        if self._runs:
            self._lead()
            return
        record = empty_curve_record(0, problem.n)
        self.run = run_in_space(self.kappa, problem.f, self.measures, self._courses[False], record)
        self._runs[False, False] = self.run
        self.u, self.contact, self.slip = self.run.motion.u, self.run.motion.contact, self.run.motion.slip

    def _lead(self) -> None:
        """Lead the runs that there are along the present courses, from a state at rest at the origin."""
        for (is_first, _), run in self._runs.items():
            run.hold(course=self._courses[is_first])
        self.run.control.set(**self.measures.of_steps)  # of all of them
        at_rest = (np.zeros_like(part) for part in self.checkpoint())
        self.restore(*at_rest)

    def set_state(self, state: State) -> bool:
        """Go to a state: whether its moving nodes are held shows on the way."""
        self.u[:], self.contact[:] = state.u, state.contact
        return True

    def checkpoint(self) -> Checkpoint:
        """Everything the continuation depends on: besides u and contact, directions of slip at an apex."""
        return self.u.copy(), self.contact.copy(), self.run.motion.direction.copy()

    def restore(self, u: FloatArray, contact: NDArray[np.int64], direction: FloatArray) -> None:
        """Go on from a checkpoint."""
        self.u[:], self.contact[:], self.run.motion.direction[:] = u, contact, direction
        self.run.joint.set(exchanges=MOST_EXCHANGES + 1)  # recomputed at the beginning of every cycle

    def enter(self, first: bool, record: bool) -> None:
        """Go to the beginning of a cycle."""
        if (first, record) not in self._runs:
            path = empty_curve_record(RECORD_ROWS if record else 0, self.problem.n)
            self._runs[first, record] = self.run.with_parts(course=self._courses[first], record=path)
        self._passed = 0
        self.run, self._risen = self._runs[first, record], list[PathSteps]()
        begin(self.run)

    def follow(self, cycles: int) -> int:
        """Follow one cycle, however many are requested; returns the status with which the loop ends."""
        status: int = follow_curve(self.run, EFFORT)
        return status

    @property
    def effort(self) -> int:
        """What the loop has taken since it was last entered [multiplications and additions]."""
        return int(self.run.control.effort)

    def progress(self) -> Progress:
        """Where the present cycle has got to."""
        return progress(self.run.motion)

    def finds_way_on(self, now: Progress, path: FloatArray) -> bool:
        """Pass an instant without rates by one implicit step; False where the joint jumps or stops there.

        A load step that begins without reactions and gaps is passed as a whole: as the law is a cone, the
        end is reached along a straight path. Where the pressure of a node is so small that round-off decides
        in which direction it slips, a piece is passed in two steps whose displacements are the same but for
        the error of a path: then nothing jumps on the way.
        """
        mo, rest = self.run.motion, 1.0 - now.time
        before, after = path[now.step], path[now.step + 1]
        load = before + now.time * (after - before)
        if not rest:
            return False
        reaction = self.reaction(load)
        if (
            np.abs(reaction).max() <= self.measures.precision.force
            and not mo.u[self.problem.layout.gaps].any()
        ):
            steps = self._implicit_steps(np.stack([load, after]))
            if steps:
                self._pass(rest, steps[0], 0.5, EventKind.LOAD_STEP)  # the reaction rises linearly
            return bool(steps)
        if self._passed == MOST_PASSED or not self._is_next_to_apex(reaction):
            return False
        allowed, share = self.measures.accuracy * self.scale.length, PER_CENT * rest
        for _ in range(MOST_SHORTENED):
            steps = self._implicit_steps(
                load + np.outer([0.0, 0.5 * share, share], after - before), FEW_TURNS
            )
            ends = [mo.u, *(step.u for step in steps)]
            uneven = float(np.abs(np.diff(ends, 2, axis=0)).max()) if len(steps) == 2 else np.inf
            if uneven <= allowed:
                self._passed += 1
                mo.set(error=mo.error + uneven, crowd=0)
                for step in steps:
                    self._pass(0.5 * share, step, 1.0, EventKind.CURVES)
                return True
            share *= max(PER_CENT, min(0.5, 0.5 * np.sqrt(allowed / uneven)))
        return False

    def _is_next_to_apex(self, reaction: FloatArray) -> bool:
        """Whether a closed node has too little pressure for a direction of slip."""
        pressure = reaction[self.problem.layout.gaps]
        little = (self.problem.f > 0.0) & (pressure <= self.measures.near / THREE_DIGITS)
        return bool((little & (self.contact != OPEN)).any())

    def _implicit_steps(self, loads: FloatArray, turns: int = TURNS) -> list[StepEnd]:
        """The ends of implicit steps from the present state between welded reactions, as far as there are.

        Each is found in so many turns, or not at all.
        """
        layout, u, ends = self.problem.layout, self.u, list[StepEnd]()
        A, B, C = layout.blocks(self.kappa)
        body = A, B, C if self.problem.C is not None else None
        joint = ImplicitJoint(*body, self.problem.f, self.scale.force, self.tolerances)
        joint.turns = turns
        for path in pairwise(loads):
            end = end_at_once(joint, layout, u, np.stack(path))
            if end is None:
                break
            ends.append(end)
            u = end.u
        return ends

    def _pass(self, share: float, end: StepEnd, work: float, kind: EventKind) -> None:
        """Go on from the end of an implicit step over a share of the load step."""
        mo, problem = self.run.motion, self.problem
        if self.run.record.capacity:
            at = self.run.course.first + mo.step + mo.time
            curve = np.zeros((1, DEGREE, problem.layout.size))
            curve[0, 0] = end.u - mo.u
            numbers = np.array([at]), np.array([share]), mo.u[None].copy(), curve
            self._risen.append(
                PathSteps(0, *numbers, end.contact[None].copy(), np.array([-1]), np.array([int(kind)]))
            )
        mo.slip[:] += end.slip
        mo.work[:] += work * end.work
        time = min(mo.time + share, 1.0)
        self.set_state(State(end.u, end.contact))
        resume(self.run, time, kind)

    def recorded(self, done: int) -> list[PathSteps]:
        """What a record has been filled with, so many cycles being done, and a rise after it."""
        record, risen = self.run.record, self._risen
        rows, self._risen = record.content.rows, []
        risen = [rise._replace(done=done) for rise in risen]
        if not rows:
            return risen
        return [
            PathSteps(done, *(getattr(record, name)[:rows].copy() for name in PathSteps._fields[1:])),
            *risen,
        ]

    def present(self, done: int, reaction: FloatArray) -> PathSteps:
        """The present state, between two cycles, as a step of no duration."""
        curve = np.zeros((1, DEGREE, self.problem.layout.size))
        kinds = np.array([-1]), np.array([EventKind.LOAD_STEP])
        times = np.array([-1.0]), np.zeros(1)
        return PathSteps(done, *times, self.u[None].copy(), curve, self.contact[None].copy(), *kinds)

    def histories(
        self, cycle: FloatArray, steps: PathSteps, welded: FloatArray, change: FloatArray
    ) -> CurvedHistory:
        """The path of steps at times in cycles: welded reactions, and their change in the load step."""
        split = self.problem.layout.split
        pressed = steps.u[:1] @ self.kappa + self._of_moved(steps.u - steps.u[:1])
        (v, w), (q, p), (q_w, p_w) = split(steps.u), split(welded + pressed), split(welded)
        bend, what = self._of_moved(steps.curve), (cycle, steps.kind, steps.node)
        bend[:, 0] += steps.duration[:, None] * change
        curves = steps.duration / self.problem.m, steps.curve, bend
        return CurvedHistory(*what, v, w, q, p, q_w, p_w, steps.contact, *curves)

    def _of_moved(self, changes: FloatArray) -> FloatArray:
        """Reactions to changes of displacements (…, N): of those alone that change in any, mostly few."""
        moved = np.flatnonzero(changes.any(axis=tuple(range(changes.ndim - 1))))
        return np.asarray(changes[..., moved] @ self.kappa[moved])

    def totals(self) -> Totals:
        """The sums of the present cycle, without jumps."""
        mo, counted = self.run.motion, self.run.motion.content
        opened, closed = mo.opened.astype(np.bool_), mo.closed.astype(np.bool_)
        numbers = None, counted.events, counted.signature, counted.error
        return Totals(mo.slip.copy(), mo.work, opened, closed, *numbers)

    def reaction(self, load: FloatArray) -> FloatArray:
        """Reactions at the present instant, under these welded ones, (3n,) [force]."""
        return load + self.kappa @ self.u

    def relaxation(
        self, state: State, reaction: FloatArray, load: FloatArray, damping: FloatArray
    ) -> DirectedJump:
        """The viscous motion from a state with given reactions that the load puts out of balance."""
        before = state.u, state.contact, reaction
        return DirectedJump(self.kappa, self.problem.f, *before, load, damping, self.measures)

    def resume(self, time: float) -> None:
        """Continue after a jump, from a given share of the load step."""
        resume(self.run, time)
