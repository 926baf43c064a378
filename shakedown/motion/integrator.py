"""Exact quasi-static evolution of a joint, cycle by cycle (event-driven)."""

from collections.abc import Iterable
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked_damping, require_plane
from shakedown.joint.derived import once_per_problem
from shakedown.joint.loading import loop_path, transient_path
from shakedown.joint.problem import Problem
from shakedown.motion.contact_law import law_violation, scales_of
from shakedown.motion.cycle_record import SLIDES_AWAY, CycleRecord, Interim, State, Stop
from shakedown.motion.event_history import EventHistory
from shakedown.motion.initial_state import beginning
from shakedown.motion.kernels import event_loop as kernel
from shakedown.motion.kernels.active_set import active_set, factorize
from shakedown.motion.kernels.contact_status import OPEN
from shakedown.motion.kernels.moving_state import (
    LOAD_STEP,
    Course,
    Precision,
    begin,
    course,
    follow_derivative,
    motion_at_rest,
    resume,
    room_for,
    without_tangent,
)
from shakedown.motion.kernels.rate_problem import rates
from shakedown.motion.kernels.rate_search import enumerate_states
from shakedown.motion.kernels.run import Progress, Run, progress, run_along
from shakedown.motion.viscous_jump import Jump, ViscousMotion, default_damping, potential_energy

RECORD_ROWS = 512
ROUNDING = 16 * np.finfo(float).eps  # of the largest force: equations with such a residual are settled
NUDGE = 1e-9  # change of load, relative to the largest, that puts a state without rates out of balance
MOST_RETRIES = 20  # of one instant, each with a larger change of load
MOST_JUMPS = 20  # per node and load step of a cycle


@once_per_problem
def closed_stiffness(problem: Problem) -> FloatArray:
    """κ, with zeros for C where no node may open."""
    C = np.zeros_like(problem.A) if problem.C is None else problem.C
    return np.block([[problem.A, problem.B.T], [problem.B, C]])


class _Piece(NamedTuple):
    """Rows of a record, and the cycles done before them."""

    done: int
    time: FloatArray
    kind: NDArray[np.int64]
    node: NDArray[np.int64]
    u: FloatArray
    r: FloatArray
    state: NDArray[np.int64]


class Evolution:
    """A joint under its loading loop at one load factor, carried from cycle to cycle without error.

    The first cycle begins with the transient load steps, where the problem has
    them. What comes first of all is a ramp: with the initial slip v₀ given, the
    tangential reactions grow from zero to what v₀ and the first load step
    prescribe, under the normal load of that step. It moves nothing where v₀ is
    admissible at the first load step, and it brings the state to equilibrium
    where it is not. Nodes that are open at the start are in equilibrium all the while.

    Parameters
    ----------
    problem, load_factor, initial_slip, tolerances, damping, open_nodes
        As for :func:`evolve`.

    Examples
    --------
    >>> import shakedown
    >>> evolution = Evolution(shakedown.example("two-node"), 0.9)
    >>> first, second = evolution.cycle(), evolution.cycle()
    >>> second.slip.round(6)
    array([0.      , 1.893552])
    """

    def __init__(
        self,
        problem: Problem,
        load_factor: float,
        initial_slip: ArrayLike | None = None,
        tolerances: Tolerances = DEFAULT,
        damping: ArrayLike | None = None,
        open_nodes: Iterable[int] = (),
    ) -> None:
        require_plane("evolution", problem)
        self.problem, self.tolerances = problem, tolerances
        self.kappa, self._damping = closed_stiffness(problem), checked_damping(problem, damping)
        self.active, self.rates = active_set(self.kappa, problem.f), rates(problem.n)
        self.motion = motion_at_rest(problem.n)
        self._runs: dict[tuple[bool, bool], Run] = {}  # by: through the first cycle, recorded
        self._courses: dict[bool, Course] = {}  # by: through the first cycle
        self.stop: Stop | None
        self.left: bool  # whether contact is lost for good
        self.slides: bool  # whether a jump has no end although nodes are in contact
        self.held: bool  # whether the moving nodes of the state set last are: nothing goes on from it if not
        self.begin(load_factor, initial_slip, open_nodes)

    def begin(
        self, load_factor: float, initial_slip: ArrayLike | None = None, open_nodes: Iterable[int] = ()
    ) -> None:
        """Go to the very start at a load factor, as an evolution that is made anew would."""
        problem = self.problem
        start = beginning(problem, load_factor, initial_slip, open_nodes, self.tolerances)
        self.load_factor = load_factor
        self.load, transient = loop_path(problem, load_factor), transient_path(problem)
        self.scale = scales_of(problem, self.load, transient)
        self.precision = self._precision(start.state.u)
        self.pieces: list[_Piece] = []
        self.jumps: list[Jump] = []  # of the present cycle
        self._nudged: tuple[int, float, int] | None = None  # load step, time in it, retries of the last jump
        self._before = np.vstack([start.load, transient])
        for first, way in self._courses.items():
            way.path[: -problem.m] = self._before if first else self.load[-1:]
            way.path[-problem.m :] = self.load
            way.set(**self.precision._asdict())
        self.done = 0  # cycles
        self.state = start.state

    @property
    def damping(self) -> FloatArray:
        """Diagonal of D, (2n,)."""
        return default_damping(self.kappa) if self._damping is None else self._damping

    def _precision(self, start: FloatArray) -> Precision:
        """Forces and lengths that count as zero: round-off of the terms that make up the reactions."""
        locked = np.abs(self.kappa) @ np.abs(start)
        force = max(self.scale.force, float(locked.max()))
        t = self.tolerances
        return Precision(t.limit * force, t.limit * self.scale.length, t.rate, ROUNDING * force)

    def course_after(self, before: FloatArray) -> Course:
        """One period after these welded reactions (s, 2n)."""
        path = np.vstack([before, self.load])
        separable = self.problem.C is not None
        return course(path, self.problem.m - len(path), separable, self.precision)

    @property
    def state(self) -> State:
        """The state between two cycles; may be set to continue from another one.

        From one whose moving nodes nothing holds the next cycle cannot be followed.
        """
        return State(self.motion.u.copy(), self.active.state.copy())

    @state.setter
    def state(self, state: State) -> None:
        self.stop, self.left, self.slides = None, False, False
        self.motion.u[:] = state.u
        self.active.state[:] = state.contact
        self.held = factorize(self.active) != 0

    def interim(self) -> Interim:
        """Where it stands, for :meth:`go_on`: the equations of the moving nodes depend on the way there."""
        act = self.active
        size, sign, updates = act.size, act.sign, act.updates
        places = act.state.copy(), act.place.copy(), act.col[:size].copy(), act.coef[:size].copy()
        return self.done, self.motion.u.copy(), *places, act.inverse[:size, :size].copy(), sign, updates

    def go_on(self, interim: Interim) -> None:
        """Stand where a motion stood, but for what is recorded."""
        act, size = self.active, len(interim[-3])
        done, self.motion.u[:], act.state[:], act.place[:], act.col[:size], act.coef[:size] = interim[:6]
        act.inverse[:size, :size], sign, updates = interim[6:]
        act.set(size=size, sign=sign, updates=updates)
        self.held = True
        self.enter_cycle(done)

    def violation(self, state: State) -> float:
        """By how much a state between two cycles breaks the contact and friction law (relative)."""
        layout = self.problem.layout
        q, p = layout.split(self.load[-1] + self.kappa @ state.u)
        gap, still = state.u[layout.gaps], np.zeros_like(q)
        return float(law_violation(self.problem.f, q, p, gap, still, self.scale).max())

    def cycle(self, *, record: bool = False, tangent: FloatArray | None = None) -> CycleRecord | None:
        """Carry the joint through its next cycle; None, and ``stop`` says why, where that cannot be done.

        Parameters
        ----------
        record
            Keep the events (:attr:`history`).
        tangent : (2n, t), optional
            Derivative of u = (v, w) with respect to t parameters; carried along in place.
        """
        done = self._follow(1, record, tangent)
        if done is None:
            return None
        return CycleRecord(
            end_slip=self.motion.u[self.problem.layout.slips].copy(),
            slip=self.motion.slip.copy(),
            work=self.motion.work + sum(jump.work for jump in self.jumps),
            friction_dissipation=done.dissipation + sum(jump.friction_work for jump in self.jumps),
            jump_dissipation=float(sum(jump.damping_work for jump in self.jumps)),
            opened=self.motion.opened.astype(np.bool_),
            closed=self.motion.closed.astype(np.bool_),
            events=done.events,
            signature=int(done.signature),
            jumps=tuple(self.jumps),
        )

    def advance(self, cycles: int) -> int:
        """Carry the joint through so many cycles without a record of each; how many it passes.

        Examples
        --------
        >>> import shakedown
        >>> evolution = Evolution(shakedown.example("two-node"), 0.9)
        >>> evolution.advance(100), evolution.stop is None
        (100, True)
        """
        before = self.done
        while self.done < before + cycles:
            left = before + cycles - self.done
            if self._follow(1 if self.done == 0 else left, False, None) is None:
                break
        return self.done - before

    def run(self, first: bool, record: bool) -> Run:
        """The run through the first cycle or another one; made when it is first needed."""
        if (first, record) not in self._runs:
            if first not in self._courses:
                self._courses[first] = self.course_after(self._before if first else self.load[-1:])
            room = room_for(RECORD_ROWS if record else 0, self.problem.n)
            run = run_along(self.active, self.rates, self.motion, room, self._courses[first])
            self._runs[first, record] = run
        return self._runs[first, record]

    def _follow(self, cycles: int, record: bool, tangent: FloatArray | None) -> Progress | None:
        """Run the compiled loop through cycles of one course; None, and ``stop`` says why, where it ends."""
        run, before = self.run(self.done == 0, record), self.done
        begin(self.motion)
        if tangent is not None:
            delay = np.zeros(tangent.shape[1])
            follow_derivative(self.motion, tangent, delay)
        self.enter_cycle(before)
        if not self.held:
            self.say_not_held(run)
            return None
        while True:  # ends: events per load step and jumps per cycle are limited, and so are cycles
            status = kernel.follow(run, cycles, kernel.EFFORT)
            now = progress(run)
            found = status == kernel.NO_RATES and self.finds_rates()
            if now.rows > found:  # an instant whose rates have been found is recorded when they are taken
                self.pieces.append(self._piece(run, now.rows - found))
            self.done = before + now.passes
            if found or status in (kernel.RECORD_FULL, kernel.PAUSED):
                continue
            if status != kernel.NO_RATES or not self.jump(now, run):
                break
        if tangent is not None:
            follow_derivative(self.motion, *without_tangent(self.problem.n))
        if status == kernel.DONE:
            return now
        self.say_why(status, now, run)
        return None

    def enter_cycle(self, done: int) -> None:
        """So many cycles are done, and nothing has stopped the motion or made it jump in the next."""
        self.done, self.jumps, self._nudged = done, [], None
        self.stop, self.left, self.slides = None, False, False

    def finds_rates(self) -> bool:
        """Whether enumeration finds states and rates where pivoting has not; the loop then finds them too."""
        return enumerate_states(self.active, self.rates, self.precision.rate)

    def jump(self, now: Progress, run: Run) -> bool:
        """Carry the state across an instant without rates; False where the motion does not come to rest."""
        motion, path, step = self.motion, run.course.path, now.step
        if len(self.jumps) == MOST_JUMPS * self.problem.n * (len(path) - 1):
            return False
        retries = self._retries(step, now.time)
        if retries == MOST_RETRIES:
            return False
        rate = path[step + 1] - path[step]
        if not rate.any():
            return False
        nudge = NUDGE * self.scale.force * 4.0**retries / float(np.abs(rate).max())
        time = min(now.time + nudge, 1.0)
        self._nudged = (step, time, retries)
        load, before = path[step] + time * rate, motion.u.copy()
        moving = ViscousMotion(
            self.kappa, self.problem.f, before, self.active.state, motion.r, load, self.damping,
            self.precision, self.scale,
        )  # fmt: skip
        rest = moving.to_rest()
        if rest is None:
            self.left = bool((moving.contact == OPEN).all())
            self.slides = moving.endless and not self.left
            return False
        released = potential_energy(self.kappa, load, before) - potential_energy(self.kappa, load, rest.u)
        contact_before = self.active.state.copy()
        self.state = State(rest.u, rest.contact)
        if not self.held:
            return False
        resume(motion, time)
        closed = (contact_before != OPEN) & (rest.contact != OPEN)
        split = self.problem.layout.split
        (v, w), (v_rest, w_rest) = split(before), split(rest.u)
        motion.slip[:] += np.where(closed, np.abs(v_rest - v), 0.0)
        cycle = self.done + (self.problem.m - len(path) + step + time) / self.problem.m
        self.jumps.append(
            Jump(cycle, v, w, v_rest, w_rest, rest.contact, released,
                 rest.friction_work, rest.work, rest.slip, rest.steps)
        )  # fmt: skip
        return True

    def _retries(self, step: int, time: float) -> int:
        """How often this instant has been jumped from already: the load has not moved since the last jump."""
        if self._nudged is None or self._nudged[:2] != (step, time):
            return 0
        return self._nudged[2] + 1

    def _piece(self, run: Run, rows: int) -> _Piece:
        """What a record has been filled with."""
        room = run.record
        u, r, states = room.u[:rows].copy(), room.r[:rows].copy(), room.state[:rows].copy()
        times, kinds, nodes = room.time[:rows].copy(), room.kind[:rows].copy(), room.node[:rows].copy()
        return _Piece(self.done, times, kinds, nodes, u, r, states)

    def _joined(self, pieces: list[_Piece]) -> EventHistory:
        """The history of pieces of one course."""
        split, path = self.problem.layout.split, self.run(pieces[0].done == 0, True).course.path
        done = np.repeat([piece.done for piece in pieces], [len(piece.time) for piece in pieces])
        steps, kind, node, u, r, state = (
            np.concatenate(parts) for parts in list(zip(*pieces, strict=True))[1:]
        )
        first = self.problem.m - len(path)
        index = np.minimum((steps - first).astype(int), len(path) - 2)
        welded = np.diff(path, axis=0)[index]  # in place from here on: a path may be long
        welded *= (steps - first - index)[:, None]
        welded += path[index]
        q_w, p_w = split(welded)
        (v, w), (q, p) = split(u), split(r)
        cycle = done + steps / self.problem.m
        return EventHistory(cycle, kind, node, v, w, q, p, q_w, p_w, state)

    @property
    def history(self) -> EventHistory:
        """All recorded events, closed by the present state."""
        split = self.problem.layout.split
        q_w, p_w = split(self.load[-1:])
        v, w = split(self.motion.u[None])
        q, p = split((self.load[-1] + self.kappa @ self.motion.u)[None])
        last = EventHistory(
            cycle=np.array([self.done - 1 / self.problem.m]),
            kind=np.array([LOAD_STEP]),
            node=np.array([-1]),
            v=v.copy(),
            w=w.copy(),
            q=q,
            p=p,
            q_w=q_w,
            p_w=p_w,
            state=self.active.state[None, :].copy(),
        )
        end = last if self.stop is None else EventHistory.none(self.problem.n)
        by_course = groupby(self.pieces, key=lambda piece: piece.done == 0)
        return EventHistory.joined([*(self._joined(list(pieces)) for _, pieces in by_course), end])

    def say_not_held(self, run: Run) -> None:
        """Set ``stop`` where a cycle cannot begin: nothing holds the moving nodes of its first state."""
        begin(self.motion)
        self.say_why(kernel.NOT_SETTLED, progress(run), run)

    def say_why(self, status: int, now: Progress, run: Run) -> None:
        """Set ``stop``: why the loop has ended with this status."""
        node, steps = now.concerned, self.problem.m - len(run.course.path) + now.step + now.time
        time = float(self.done + steps / self.problem.m)
        reasons = {
            kernel.NO_RATES: "the state jumps and does not come to rest",
            kernel.LIFTS_OFF: f"node {node} lifts off, and the problem has no C",
            kernel.TOO_MANY_EVENTS: "events accumulate within one load step",
            kernel.NOT_SETTLED: "the moving nodes are not held: their stiffness is singular to round-off",
        }
        if self.left:
            reasons[status] = "the body leaves: every node is open and nothing else holds it"
        if self.slides:
            reasons[status] = SLIDES_AWAY
        if not self.held:
            reasons[status] = reasons[kernel.NOT_SETTLED]
        when = f"at time {time:.6g} cycles" if time >= 0 else "on the way to the first period"
        why = ": friction and stiffness do not hold it" * self.slides
        self.stop = Stop(f"{reasons[status]} {when}{why}", time, node, self.slides)
