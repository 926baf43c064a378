"""Exact quasi-static evolution of a joint, cycle by cycle (event-driven)."""

import numpy as np
from numpy.typing import ArrayLike

from shakedown.errors import UsageError
from shakedown.evolution.contact_law import law_violation, scales
from shakedown.evolution.cycle_record import CycleRecord, State, Stop
from shakedown.evolution.event_history import EventHistory
from shakedown.evolution.viscous_jump import Jump, ViscousMotion, default_damping, potential_energy
from shakedown.kernels import event_loop as kernel
from shakedown.kernels.active_set import active_set, factorize
from shakedown.kernels.gauss_seidel import BACKWARD_SLIP, OPEN
from shakedown.kernels.moving_state import (
    JUMPS,
    LOAD_STEP,
    Motion,
    Precision,
    Record,
    motion_at_rest,
    room_for,
)
from shakedown.kernels.rate_problem import rates
from shakedown.model.arguments import checked_damping, checked_initial_slip
from shakedown.model.loading import loading, ramp_start, transient_path
from shakedown.model.problem import FloatArray, Problem
from shakedown.tolerances import DEFAULT, Tolerances

RECORD_ROWS = 512
NUDGE = 1e-9  # change of load, relative to the largest, that puts a state without rates out of balance
MOST_RETRIES = 20  # of one instant, each with a larger change of load
MOST_JUMPS = 20  # per node and load step of a cycle


class Evolution:
    """A joint under its loading loop at one load factor, carried from cycle to cycle without error.

    The first cycle begins with the transient load steps, where the problem has
    them. What comes first of all is a ramp: with the initial slip v₀ given, the
    tangential reactions grow from zero to what v₀ and the first load step
    prescribe, under the normal load of that step. It moves nothing where v₀ is
    admissible at the first load step, and it brings the state to equilibrium
    where it is not.

    Parameters
    ----------
    problem, load_factor, initial_slip, tolerances, damping
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
    ) -> None:
        self.problem, self.load_factor, self.tolerances = problem, load_factor, tolerances
        start = checked_initial_slip(problem, initial_slip)
        n = problem.n
        C = np.zeros((n, n)) if problem.C is None else problem.C
        self.kappa = np.block([[problem.A, problem.B.T], [problem.B, C]])
        given = checked_damping(problem, damping)
        self.damping = default_damping(self.kappa) if given is None else given
        self.scale = scales(problem, load_factor)
        self.load = np.hstack(loading(problem).at(load_factor))
        self.active, self.rates = active_set(self.kappa, problem.f), rates(n)
        self.motion = motion_at_rest(n)
        self.precision = self._precision(start)
        self.done = 0  # cycles
        self.pieces: list[EventHistory] = []
        self.jumps: list[Jump] = []  # of the present cycle
        self._nudged: tuple[int, float, int] | None = None  # load step, time in it, retries of the last jump
        self._approach = self._path_to_first_period(start)
        self.stop: Stop | None
        self.left: bool  # whether contact is lost for good
        self.slides: bool  # whether a jump has no end although nodes are in contact
        self.state = State(np.concatenate([start, np.zeros(n)]), np.where(problem.f == 0.0, BACKWARD_SLIP, 0))

    def _precision(self, start: FloatArray) -> Precision:
        """Forces and lengths that count as zero: round-off of the terms that make up the reactions."""
        locked = np.abs(self.kappa[:, : self.problem.n]) @ np.abs(start)
        force = max(self.scale.force, float(locked.max()))
        t = self.tolerances
        return Precision(
            t.limit * force, t.limit * self.scale.length, t.rate, 16 * np.finfo(float).eps * force
        )

    def _path_to_first_period(self, start: FloatArray) -> FloatArray:
        """Welded reactions from the beginning of the ramp to the load step before the first period."""
        before = transient_path(self.problem)
        first = np.vstack([before, self.load])[0]
        return np.vstack([ramp_start(self.problem, first, start), before])

    @property
    def state(self) -> State:
        """The state between two cycles; may be set to continue from another one."""
        return State(self.motion.u.copy(), self.active.state.copy())

    @state.setter
    def state(self, state: State) -> None:
        self.stop, self.left, self.slides = None, False, False
        self.motion.u[:] = state.u
        self.active.state[:] = state.contact
        if not factorize(self.active):
            raise UsageError("state: expected one in which the moving nodes are held, found a singular one")

    def violation(self, state: State) -> float:
        """By how much a state between two cycles breaks the contact and friction law (relative)."""
        n = self.problem.n
        r = self.load[-1] + self.kappa @ state.u
        still = np.zeros(n)
        return float(law_violation(self.problem.f, r[:n], r[n:], state.u[n:], still, self.scale).max())

    def cycle(self, *, record: bool = False, tangent: FloatArray | None = None) -> CycleRecord | None:
        """Carry the joint through its next cycle; None, and ``stop`` says why, where that cannot be done.

        Parameters
        ----------
        record
            Keep the events (:attr:`history`).
        tangent : (2n, t), optional
            Derivative of u = (v, w) with respect to t parameters; carried along in place.
        """
        motion = self.motion
        if tangent is not None:
            motion = motion._replace(tangent=tangent, delay=np.zeros(tangent.shape[1]))
        path = np.vstack([self._approach if self.done == 0 else self.load[-1:], self.load])
        for counter in (motion.slip, motion.work, motion.opened, motion.signature, motion.time):
            counter[:] = 0
        motion.counts[:] = 0, -1, -1, LOAD_STEP, 0
        self.jumps, self._nudged = [], None
        status = self._follow(motion, path, record)
        if status != kernel.DONE:
            self._say_why(status, path)
            return None
        self.done += 1
        return CycleRecord(
            end_slip=motion.u[: self.problem.n].copy(),
            slip=motion.slip.copy(),
            friction_dissipation=float(motion.work[0]) + sum(jump.friction_work for jump in self.jumps),
            jump_dissipation=float(sum(jump.damping_work for jump in self.jumps)),
            opened=motion.opened.copy(),
            events=int(motion.counts[0]),
            signature=int(motion.signature[0]),
            jumps=tuple(self.jumps),
        )

    def _follow(self, motion: Motion, path: FloatArray, record: bool) -> int:
        """Run the compiled loop along a path, emptying the record whenever it is full."""
        n, first = self.problem.n, self.problem.m - len(path)
        separable = self.problem.C is not None
        room = room_for(RECORD_ROWS if record else 0, n)
        while True:
            status = kernel.load_steps(
                self.active, self.rates, motion, room, path, first, separable, self.precision
            )
            jumped = status == kernel.NO_RATES and self._jump(motion, room, path, first)
            if record:
                self.pieces.append(self._history(room, path, first))
                room.rows[0] = 0
            if status != kernel.RECORD_FULL and not jumped:
                return int(status)

    def _jump(self, motion: Motion, room: Record, path: FloatArray, first: int) -> bool:
        """Carry the state across an instant without rates; False where the motion does not come to rest."""
        n, step = self.problem.n, int(motion.counts[4])
        if len(self.jumps) == MOST_JUMPS * n * (len(path) - 1):
            return False
        retries = self._retries(step, float(motion.time[0]))
        if retries == MOST_RETRIES:
            return False
        if len(room.time):
            kernel.note(self.active, motion, room, first + step, *motion.counts[2:4])
        rate = path[step + 1] - path[step]
        if not rate.any():
            return False
        nudge = NUDGE * self.scale.force * 4.0**retries / float(np.abs(rate).max())
        time = min(float(motion.time[0]) + nudge, 1.0)
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
        motion.time[0], motion.time[1] = time, 0.0
        motion.counts[2:4] = -1, JUMPS
        motion.counts[0] += 1
        closed = (contact_before != OPEN) & (rest.contact != OPEN)
        motion.slip[:] += np.where(closed, np.abs(rest.u[:n] - before[:n]), 0.0)
        cycle = self.done + (first + step + time) / self.problem.m
        self.jumps.append(
            Jump(cycle, before[:n], before[n:], rest.u[:n], rest.u[n:], rest.contact, released,
                 rest.friction_work, rest.slip, rest.steps)
        )  # fmt: skip
        return True

    def _retries(self, step: int, time: float) -> int:
        """How often this instant has been jumped from already: the load has not moved since the last jump."""
        if self._nudged is None or self._nudged[:2] != (step, time):
            return 0
        return self._nudged[2] + 1

    def _history(self, room: Record, path: FloatArray, first: int) -> EventHistory:
        rows, n = int(room.rows[0]), self.problem.n
        steps = room.time[:rows]
        index = np.minimum((steps - first).astype(int), len(path) - 2)
        share = (steps - first - index)[:, None]
        welded = path[index] + share * (path[index + 1] - path[index])
        return EventHistory(
            cycle=self.done + steps / self.problem.m,
            kind=room.kind[:rows].copy(),
            node=room.node[:rows].copy(),
            v=room.u[:rows, :n].copy(),
            w=room.u[:rows, n:].copy(),
            q=room.r[:rows, :n].copy(),
            p=room.r[:rows, n:].copy(),
            q_w=welded[:, :n],
            p_w=welded[:, n:],
            state=room.state[:rows].copy(),
        )

    @property
    def history(self) -> EventHistory:
        """All recorded events, closed by the present state."""
        n = self.problem.n
        welded = self.load[-1]
        reaction = welded + self.kappa @ self.motion.u
        last = EventHistory(
            cycle=np.array([self.done - 1 / self.problem.m]),
            kind=np.array([LOAD_STEP]),
            node=np.array([-1]),
            v=self.motion.u[None, :n].copy(),
            w=self.motion.u[None, n:].copy(),
            q=reaction[None, :n],
            p=reaction[None, n:],
            q_w=welded[None, :n],
            p_w=welded[None, n:],
            state=self.active.state[None, :].copy(),
        )
        parts = [*self.pieces, last if self.stop is None else last.rows(np.array([], dtype=int))]
        return EventHistory(
            *(np.concatenate([getattr(part, key) for part in parts]) for key in last.__dataclass_fields__)
        )

    def _say_why(self, status: int, path: FloatArray) -> None:
        node = int(self.motion.counts[1])
        steps = self.problem.m - len(path) + self.motion.counts[4] + self.motion.time[0]
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
            reasons[status] = "the body slides away: friction and stiffness do not hold it"
        when = f"at time {time:.6g} cycles" if time >= 0 else "on the way to the first period"
        self.stop = Stop(f"{reasons[status]} {when}", time, node)
