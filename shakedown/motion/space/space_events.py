"""From event to event in space: along smooth curves, by the compiled loops of this subpackage; jumps.

Where there are no rates, a viscous system finds the next state. As in the plane
(:mod:`shakedown.motion.viscous_jump`): implicit steps of D u̇ = −(out-of-balance) are static problems with
the stiffness κ + D/Δt, and each of them is solved by following the motion of that stiffer system; where that
would be endless, by sweeps over the nodes. The end state is then put into equilibrium exactly, nodes that
still slip at the limit in their last direction.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import MINOR, NEWTON_ROUNDS, ROUND_OFF, SIX_DIGITS, THREE_DIGITS, FloatArray
from shakedown.ground.status import OPEN, SLIP, STICK
from shakedown.ground.tolerances import Tolerances
from shakedown.ground.work_limit import count_work
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.motion.checked_law import Scales, load_range
from shakedown.motion.course import CALL_OPERATIONS, Course, EventKind, LoopEnd
from shakedown.motion.event_history import CurvedHistory, EventHistory
from shakedown.motion.fixed_steps import MOST_SWEEPS, contact_nodes, load_steps, places_by_node
from shakedown.motion.method import EventMethod, State, loads_at, one_row
from shakedown.motion.space import space_run
from shakedown.motion.space.curved_loop import follow_curve
from shakedown.motion.space.space_run import DEGREE, SpaceMotion, SpaceRun
from shakedown.motion.space.speeds import MOST_EXCHANGES, arrange_afresh
from shakedown.motion.viscous_jump import Relaxation, StepEnd, ViscousJoint

STEP_OPERATIONS = 1_000_000  # operations after which the steps of integration are counted
MOST_TAKEN = 1_000  # largest number of these in an implicit step; beyond that it is solved as a whole


def end_at_once(
    kappa: FloatArray, law: Law, separable: bool, scale: Scales, u: FloatArray, load: FloatArray, most: int
) -> StepEnd | None:
    """The end of an implicit step from displacements to welded reactions, (3n,) of both.

    It is found in so many sweeps over the nodes, or not at all.
    """
    layout = law.layout
    nodes, at = contact_nodes(layout, kappa, law.f, separable, scale.force), places_by_node(layout)
    given, by_node, slip = load[at][None], u[at], np.empty((1, layout.slip_size))
    small = ROUND_OFF * scale.length
    sweeps, _, failed, _ = load_steps(nodes, given, by_node, small, most, np.empty_like(given), slip)
    count_work(sweeps * layout.size**2)
    if failed >= 0:
        return None
    end = np.empty_like(u)
    end[at] = by_node
    reaction, length, is_open = load + kappa @ end, law.size(slip[0]), end[layout.gaps] > 0.0
    work = -(layout.by_node(reaction[layout.slips]) * layout.by_node(slip[0])).sum(axis=1)
    contact = np.where(is_open, OPEN, np.where((length > 0.0) | (law.f == 0.0), SLIP, STICK))
    return StepEnd(end, contact, work, length)


def free_places(f: FloatArray, contact: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Where no reaction is transmitted, (3n,): at open nodes, and along slips without friction."""
    return np.concatenate([np.repeat((contact == OPEN) | (f == 0.0), 2), contact == OPEN])


class DirectedJump(Relaxation):
    """The viscous system of a joint in space: implicit steps are followed, or solved at once.

    Parameters
    ----------
    joint, u, contact, reaction, precise
        As for :class:`Relaxation`.
    accuracy
        The error of a path in the scene.
    """

    def __init__(
        self,
        joint: ViscousJoint,
        u: FloatArray,
        contact: NDArray[np.int64],
        reaction: FloatArray,
        precise: Course,
        accuracy: float,
    ) -> None:
        super().__init__(joint, u, contact, reaction, precise)
        self.at_once = False  # whether a path was too long to follow
        record = space_run.empty_curve_record(0, self.layout.n)
        self.run = space_run.run_in_space(self.kappa, self.law.f, self.course, record)
        of_steps = {"force_scale": self.scale.force, "length_scale": self.scale.length}
        self.run.step.set(**of_steps, accuracy=max(accuracy, SIX_DIGITS))  # the end is exact

    def _step_end(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        end = None if self.at_once else self._followed(stiffer, path)
        if self.at_once:
            # so many sweeps over the nodes: the step can also be tried shorter
            end = end_at_once(stiffer, self.law, True, self.scale, self.u, path[1], 1_000)
            self.at_once = end is not None  # the path of a shorter step may not be too long
        return end

    def _followed(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        """The end of an implicit step along the path of its static problem; None where there is none."""
        run = self.run
        run.course.path[:] = path
        run.joint.kappa[:] = stiffer
        space_run.begin(run)
        mo = run.motion
        mo.u[:], mo.contact[:], mo.direction[:] = self.u, self.contact, 0.0
        arrange_afresh(run.joint, mo)
        status = LoopEnd.PAUSED
        while status == LoopEnd.PAUSED and not self.at_once:
            status = follow_curve(run, STEP_OPERATIONS)
            count_work(run.step.effort)
            self.at_once = status == LoopEnd.PAUSED and run.step.taken > MOST_TAKEN
        if status != LoopEnd.DONE or not np.isfinite(mo.u).all():
            return None
        return StepEnd(mo.u.copy(), mo.contact.copy(), mo.work.copy(), mo.slip.copy())

    def _equilibrium(self) -> FloatArray | None:
        """Displacements with slipping nodes at their limits and nothing on open ones, by Newton's method.

        None where there are none near, as where the motion does not slow down, or what moves is not held.
        """
        if not self.slows_down:
            return None
        u, layout, f = self.u.copy(), self.layout, self.law.f
        nodes = np.flatnonzero((self.contact == SLIP) & (f > 0.0))
        free, gaps = np.flatnonzero(free_places(f, self.contact)), layout.gaps_of(nodes)
        slips, k = layout.slips_of(nodes).reshape(-1, 2), len(nodes)

        def missing(reaction: FloatArray) -> FloatArray:
            """What departs from the limits, and from zero where places are free, (k + free, …)."""
            along = np.einsum("kc,kc...->k...", unit, reaction[slips])
            return np.concatenate([along + (f[nodes] * reaction[gaps].T).T, reaction[free]])

        for _ in range(NEWTON_ROUNDS):
            reaction = self.load + self.kappa @ u
            unit = layout.by_node(self.law.direction(reaction[layout.slips]))[nodes]
            residual = missing(reaction)
            if np.abs(residual).max(initial=0.0) <= 1e-15 * self.scale.force:
                break
            columns = np.hstack([np.einsum("ikc,kc->ik", self.kappa[:, slips], unit), self.kappa[:, free]])
            equations = missing(columns)
            if np.linalg.slogdet(equations).sign <= 0.0:
                return None
            change = np.linalg.solve(equations, residual)
            u[slips] -= change[:k, None] * unit
            u[free] -= change[k:]
            if not self._is_near(u):
                return None
        u[layout.gaps][self.contact != OPEN] = 0.0
        return u


class SpaceEvents(EventMethod):
    """The moving state of a joint in space, and the loops that follow it smoothly from event to event.

    The direction in which a node slips is that of its tangential reaction, and only the speeds are
    unknown: between events the slips follow a smooth differential equation (docs/space.md), which is
    integrated to the accuracy ``Tolerances.path``.

    Attributes
    ----------
    scale, accuracy
        Of the scene; error allowed for one passage of the course, relative to the length scale.
    passable
        Ends of the loop after which there may be a way on (:meth:`finds_way_on`).

    Examples
    --------
    Loads that change by twice the largest of them, by a hundredth of it, and not at all:

    >>> from shakedown.motion.evolution import Evolution
    >>> joint = {"A": np.eye(2), "B": np.zeros((1, 2)), "f": 0.5, "p_w": [[2.0], [2.0]]}
    >>> loads = [[-2.0, 0.0], [2.0, 0.0]], [[0.0, 0.0], [0.02, 0.0]], [[2.0, 0.0], [2.0, 0.0]]
    >>> [round(Evolution(Problem(**joint, q_w=q_w), 1.0).method.accuracy, 15) for q_w in loads]
    [1e-08, 1e-10, 1e-08]
    """

    run: SpaceRun
    motion: SpaceMotion
    new_record = staticmethod(space_run.empty_curve_record)
    passable = LoopEnd.NO_RATES, LoopEnd.TOO_MANY_EVENTS

    def __init__(self, problem: Problem, kappa: FloatArray, tolerances: Tolerances) -> None:
        run = space_run.run_in_space(kappa, problem.f, Course({}), space_run.empty_curve_record(0, problem.n))
        super().__init__(problem, kappa, tolerances, run, run.motion.contact)
        self.direction: FloatArray = run.motion.direction
        self._passed = 0  # instants without rates in the present cycle

    def begin(self, start: FloatArray, first: FloatArray, later: FloatArray, scale: Scales) -> None:
        """Follow courses through the first and any other cycle, from given displacements (3n,).

        What counts as zero follows from the forces of the scene and those of locked-in slip; a motion that
        is small beside them is followed more accurately in proportion.
        """
        t, moving = self.tolerances, load_range(self.problem, later[1:])
        force = max(scale.force, float((np.abs(self.kappa) @ np.abs(start)).max()))
        near = max(MINOR * t.path * scale.force, t.limit * force)
        small = min(moving / scale.force, 1.0) if moving else 1.0  # small motions cost no more
        self.scale, self.accuracy = scale, max(t.path * small, ROUND_OFF)
        self.lead(first, later, force=force, length=scale.length, rate=10.0 * t.rate, residual=near)
        self.run.step.set(force_scale=scale.force, length_scale=scale.length, accuracy=self.accuracy)
        self.direction[:] = 0.0

    def set_state(self, state: State) -> bool:
        """Go to a state; False where nothing holds its moving nodes."""
        if state.direction is not None:
            self.direction[:] = state.direction
        return super().set_state(state)

    def enter(self, first: bool, record: bool) -> None:
        """Go to the beginning of a cycle."""
        self.run = self.run_of(first, record)
        self._passed, self._risen = 0, list[dict[str, NDArray[Any]]]()
        space_run.begin(self.run)

    def follow(self, cycles: int) -> int:
        """Follow one cycle, however many are requested; returns the status with which the loop ends.

        The stiffness is made afresh where a cycle begins, and after many exchanges of open nodes' places.
        """
        joint, motion = self.run.joint, self.motion
        if motion.time == 0.0:
            worn = joint.exchanges > (MOST_EXCHANGES if motion.step else 0)
            if worn or (joint.free != free_places(self.problem.f, self.contact)).any():
                arrange_afresh(joint, motion)
        status: int = follow_curve(self.run, CALL_OPERATIONS)
        count_work(self.run.step.effort)
        return status

    @property
    def error(self) -> float:
        """Estimated error of the slips in the present cycle [length]."""
        return float(self.motion.error)

    def finds_way_on(self) -> bool:
        """Pass an instant without rates by one implicit step; False where the joint jumps or stops there.

        A load step that begins without reactions and gaps is passed as a whole: as the law is a cone, the
        end is reached along a straight path. Where the pressure of a node is so small that round-off decides
        in which direction it slips, a piece is passed in two steps whose displacements are the same but for
        the error of a path: then nothing jumps on the way.
        """
        mo, rest, path = self.motion, 1.0 - self.motion.time, self.run.course.path
        before, after = path[mo.step], path[mo.step + 1]
        load = before + mo.time * (after - before)
        if not rest:
            return False
        reaction = self.reaction(load)
        if np.abs(reaction).max() <= self.courses[False].force and not mo.u[self.problem.layout.gaps].any():
            steps = self._implicit_steps(after[None], MOST_SWEEPS)
            if steps:
                self._pass(rest, steps[0], 0.5, EventKind.LOAD_STEP)  # the reaction rises linearly
            return bool(steps)
        little = self.courses[False].residual / THREE_DIGITS  # too little pressure for a direction of slip
        at_apex = (reaction[self.problem.layout.gaps] <= little) & (self.problem.f > 0.0)
        # instants of a cycle passed by implicit steps
        if self._passed == 10 or not (at_apex & (self.contact != OPEN)).any():
            return False
        allowed, share = self.accuracy * self.scale.length, MINOR * rest
        # lengths of such steps that are tried
        for _ in range(8):
            # so many sweeps over the nodes: a step that takes more is too long
            steps = self._implicit_steps(load + np.outer([0.5 * share, share], after - before), 100)
            ends = [mo.u, *(step.u for step in steps)]
            uneven = float(np.abs(np.diff(ends, 2, axis=0)).max()) if len(steps) == 2 else np.inf
            if uneven <= allowed:
                self._passed += 1
                mo.set(error=mo.error + uneven, events_in_step=0)
                for step in steps:
                    self._pass(0.5 * share, step, 1.0, EventKind.CURVES)
                return True
            share *= max(MINOR, min(0.5, 0.5 * np.sqrt(allowed / uneven)))
        return False

    def _implicit_steps(self, loads: FloatArray, most: int) -> list[StepEnd]:
        """The ends of implicit steps from the present state to welded reactions (k, 3n), as far as there are.

        Each is found in so many sweeps over the nodes, or not at all.
        """
        problem, u, ends = self.problem, self.u, list[StepEnd]()
        for load in loads:
            end = end_at_once(self.kappa, problem.law, problem.C is not None, self.scale, u, load, most)
            if end is None:
                break
            ends.append(end)
            u = end.u
        return ends

    def _pass(self, share: float, end: StepEnd, work: float, kind: EventKind) -> None:
        """Go on from the end of an implicit step over a share of the load step."""
        mo, problem = self.motion, self.problem
        if self.run.record.capacity:
            curve = np.zeros((DEGREE, problem.layout.size))
            curve[0] = end.u - mo.u
            time = self.run.course.first + mo.step + mo.time
            place = {"u": mo.u, "curve": curve, "contact": end.contact}
            self._risen.append(one_row(time=time, duration=share, kind=kind, **place))
        mo.slip[:] += end.slip
        mo.work[:] += work * end.work
        time = min(mo.time + share, 1.0)
        self.set_state(State(end.u, end.contact))
        space_run.resume(self.run, time, kind)

    def recorded(self, done: int) -> list[EventHistory]:
        """The path recorded since the loop was entered, and what was passed after it."""
        risen, self._risen = self._risen, []
        return [*super().recorded(done), *(self.path(self.run.course, done, **step) for step in risen)]

    def present(self, done: int, reaction: FloatArray) -> CurvedHistory:
        """The present state, between two cycles, as a step of no duration."""
        curve = np.zeros((DEGREE, self.problem.layout.size))
        place = {"u": self.u, "curve": curve, "contact": self.contact}
        step = one_row(time=-1.0, duration=0.0, kind=EventKind.LOAD_STEP, **place)
        return self.path(self.courses[False], done, **step)

    def path(self, course: Course, done: int, **columns: NDArray[Any]) -> CurvedHistory:
        """The path along a course after so many cycles, from the columns (s, …) of a record."""
        split, u, time = self.problem.layout.split, columns["u"], columns["time"]
        welded, change = loads_at(course, time)
        pressed = u[:1] @ self.kappa + self._of_moved(u - u[:1])
        (v, w), (q, p), (q_w, p_w) = split(u), split(welded + pressed), split(welded)
        bend, duration, m = self._of_moved(columns["curve"]), columns["duration"], self.problem.m
        bend[:, 0] += duration[:, None] * change
        what, curves = (done + time / m, columns["kind"], columns["node"]), (columns["curve"], bend)
        return CurvedHistory(*what, v, w, q, p, q_w, p_w, columns["contact"], duration / m, *curves)

    def _of_moved(self, changes: FloatArray) -> FloatArray:
        """Reactions to changes of displacements (…, N): of those alone that change in any, mostly few."""
        moved = np.flatnonzero(changes.any(axis=tuple(range(changes.ndim - 1))))
        return np.asarray(changes[..., moved] @ self.kappa[moved])

    def reaction(self, load: FloatArray) -> FloatArray:
        """Reactions at the present instant, under these welded ones, (3n,) [force]."""
        return load + self.kappa @ self.u

    def relaxation(self, joint: ViscousJoint, state: State, reaction: FloatArray) -> DirectedJump:
        """The viscous motion from a state with given reactions that the joint's load puts out of balance."""
        return DirectedJump(joint, state.u, state.contact, reaction, self.courses[False], self.accuracy)

    def resume(self, time: float) -> None:
        """Continue after a jump, from a given share of the load step."""
        space_run.resume(self.run, time)
