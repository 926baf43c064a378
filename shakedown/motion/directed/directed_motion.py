"""Quasi-static motion with two tangential directions, cycle by cycle: smooth from event to event."""

from collections.abc import Iterable
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked_damping, require_problem
from shakedown.joint.derived import once_per_problem
from shakedown.joint.loading import loop_path, transient_path
from shakedown.joint.problem import Problem
from shakedown.motion.contact_law import Scales, law_violation, scales_of, swing
from shakedown.motion.cycle_record import SLIDES_AWAY, CycleRecord, Interim, State, Stop
from shakedown.motion.directed import curved_loop as kernel
from shakedown.motion.directed.curved_history import CurvedHistory
from shakedown.motion.directed.directed_jump import DirectedJump, end_at_once, jump_of
from shakedown.motion.directed.exchange import make_afresh
from shakedown.motion.directed.sliding import (
    DEGREE,
    CurveRecord,
    Measures,
    Reached,
    begin_sliding,
    curve_room,
    lead,
    reached,
    resume_sliding,
    sliding,
)
from shakedown.motion.event_history import EventKind
from shakedown.motion.implicit.implicit_step import ImplicitJoint
from shakedown.motion.initial_state import beginning
from shakedown.motion.kernels.contact_status import OPEN
from shakedown.motion.viscous_jump import Jump, default_damping

RECORD_ROWS = 256
NEAR = 1e-2  # of the error allowed: a node that near its limit, relative to the force scale, is there
FINEST = 1e-13  # accuracy of a path, relative to the length scale, that floats allow
NUDGE = 1e-9  # change of load, relative to the largest, that puts a state without rates out of balance
MOST_RETRIES = 20  # of one instant, each with a larger change of load
MOST_JUMPS = 20  # per node and load step of a cycle


@once_per_problem
def stiffness_of(problem: Problem) -> FloatArray:
    """κ, with zeros for C where no node may open."""
    C = np.zeros((problem.n, problem.n)) if problem.C is None else problem.C
    return problem.layout.of_blocks(problem.A, problem.B, C)


def measures(scale: Scales, locked: float, moving: float, tolerances: Tolerances) -> Measures:
    """What counts as zero where locked-in slips make up reactions of this size, and a period changes so much.

    Both [force]. What moves little must be followed so much better: by what it costs that is the same.
    """
    force = max(scale.force, locked)
    near = max(NEAR * tolerances.path * scale.force, tolerances.limit * force)
    return Measures(
        force=tolerances.limit * force,
        length=tolerances.limit * scale.length,
        rate_zero=10.0 * tolerances.rate,
        near=near,
        force_scale=scale.force,
        length_scale=scale.length,
        accuracy=max(tolerances.path * min(moving / scale.force, 1.0), FINEST) if moving else tolerances.path,
    )


class _Piece(NamedTuple):
    """Rows of a record, and the cycles done before them."""

    done: int
    time: FloatArray
    duration: FloatArray
    u: FloatArray
    curve: FloatArray
    contact: NDArray[np.int64]
    node: NDArray[np.int64]
    kind: NDArray[np.int64]


class DirectedMotion:
    """A joint with two tangential directions under its loading loop; a :class:`Motion`.

    The direction in which a node slips is that of its tangential reaction, and only the speeds are
    unknown: between events the slips follow a smooth differential equation (docs/space.md), which is
    integrated to the accuracy ``Tolerances.path``. The first cycle begins as in the plane, with a ramp and
    the transient load steps (:class:`~shakedown.motion.integrator.Evolution`), and jumps are carried
    across as there.

    Parameters
    ----------
    problem, load_factor, initial_slip, tolerances, damping, open_nodes
        As for :func:`evolve`.

    Raises
    ------
    UsageError
        If the joint has one tangential direction, or an argument is out of range.

    Examples
    --------
    A node that a force across drags along:

    >>> from shakedown import Problem
    >>> joint = Problem(A=[[2, 0], [0, 2]], B=[[0, 0]], f=0.4, q_w=[[0.4, 0], [0.4, 1]], p_w=[[1], [1]])
    >>> motion = DirectedMotion(joint, 1.0)
    >>> motion.cycle().end_slip.round(6)
    array([-0.167386, -0.302677])
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
        require_problem(problem)
        if problem.directions == 1:
            raise UsageError("directed motion: expected two tangential directions, found one")
        self.problem, self.tolerances = problem, tolerances
        self.kappa, self._damping = stiffness_of(problem), checked_damping(problem, damping)
        self._rooms: dict[bool, CurveRecord] = {}
        self.stop: Stop | None
        self.left: bool  # whether contact is lost for good
        self.slides: bool  # whether a jump has no end although nodes are in contact
        self.begin(load_factor, initial_slip, open_nodes)

    def begin(
        self, load_factor: float, initial_slip: ArrayLike | None = None, open_nodes: Iterable[int] = ()
    ) -> None:
        """Go to the very start at a load factor, as a motion that is made anew would."""
        problem = self.problem
        start = beginning(problem, load_factor, initial_slip, open_nodes, self.tolerances)
        self.load_factor = load_factor
        self.load, transient = loop_path(problem, load_factor), transient_path(problem)
        self.scale = scales_of(problem, self.load, transient)
        locked = float((np.abs(self.kappa) @ np.abs(start.state.u)).max())
        self.measures = measures(self.scale, locked, swing(problem, self.load), self.tolerances)
        self._first = np.vstack([start.load, transient, self.load])
        self._later = np.vstack([self.load[-1:], self.load])
        self.sliding = sliding(self.kappa, problem.f, self._later, -1, problem.C is not None)
        self.sliding.set(**self.measures._asdict())
        self.pieces: list[_Piece] = []
        self.jumps: list[Jump] = []  # of the present cycle
        self._nudged: tuple[int, float, int] | None = None  # load step, time in it, retries of the last jump
        self.done = 0  # cycles
        self.state = start.state

    @property
    def damping(self) -> FloatArray:
        """Diagonal of D, (3n,)."""
        return default_damping(self.kappa) if self._damping is None else self._damping

    @property
    def state(self) -> State:
        """The state between two cycles; may be set to continue from another one."""
        return State(self.sliding.u.copy(), self.sliding.contact.copy())

    @state.setter
    def state(self, state: State) -> None:
        self.stop, self.left, self.slides = None, False, False
        self.sliding.u[:] = state.u
        self.sliding.contact[:] = state.contact

    def interim(self) -> Interim:
        """Where it stands, for :meth:`go_on`: apart from u and contact, directions of slip at an apex."""
        mo = self.sliding
        return self.done, mo.u.copy(), mo.contact.copy(), mo.direction.copy()

    def go_on(self, interim: Interim) -> None:
        """Stand where a motion stood, but for what is recorded."""
        done, self.sliding.u[:], self.sliding.contact[:], self.sliding.direction[:] = interim
        make_afresh(self.sliding)  # as every cycle begins
        self.enter_cycle(done)

    def enter_cycle(self, done: int) -> None:
        """So many cycles are done, and nothing has stopped the motion or made it jump in the next."""
        self.done, self.jumps, self._nudged = done, [], None
        self.stop, self.left, self.slides = None, False, False

    def forget(self) -> None:
        """Keep nothing of what has been recorded."""
        self.pieces = []

    def violation(self, state: State) -> float:
        """By how much a state between two cycles breaks the contact and friction law (relative)."""
        layout = self.problem.layout
        q, p = layout.split(self.load[-1] + self.kappa @ state.u)
        gap, still = state.u[layout.gaps], np.zeros_like(q)
        return float(law_violation(self.problem.f, q, p, gap, still, self.scale).max())

    def cycle(self, *, record: bool = False) -> CycleRecord | None:
        """Carry the joint through its next cycle; None, and ``stop`` says why, where that cannot be done."""
        done = self._follow(record)
        if done is None:
            return None
        mo = self.sliding
        work = mo.work + sum(jump.work for jump in self.jumps)
        return CycleRecord(
            end_slip=mo.u[self.problem.layout.slips].copy(),
            slip=mo.slipped.copy(),
            work=work,
            friction_dissipation=float(work.sum()),
            jump_dissipation=float(sum(jump.damping_work for jump in self.jumps)),
            opened=mo.opened.astype(np.bool_),
            closed=mo.closed.astype(np.bool_),
            events=done.events,
            signature=int(done.signature),
            jumps=tuple(self.jumps),
            error=done.error,
        )

    def advance(self, cycles: int) -> int:
        """Carry the joint through so many cycles without a record of each; how many it passes."""
        passed = 0
        while passed < cycles and self._follow(record=False) is not None:
            passed += 1
        return passed

    def _follow(self, record: bool) -> Reached | None:
        """Run the compiled loop through one cycle; None, and ``stop`` says why, where it ends."""
        if self.stop is not None:
            return None
        mo, path = self.sliding, self._first if self.done == 0 else self._later
        if record not in self._rooms:
            self._rooms[record] = curve_room(RECORD_ROWS if record else 0, self.problem.n)
        room = self._rooms[record]
        lead(mo, path, self.problem.m - len(path))
        begin_sliding(mo)
        self.jumps, self._nudged = [], None
        while True:  # ends: events per load step and jumps per cycle are limited
            status = kernel.follow_curve(mo, room, 1, kernel.EFFORT)
            now = reached(mo, room)
            if now.rows:
                self.pieces.append(self._piece(room, now.rows))
            if status in (kernel.RECORD_FULL, kernel.PAUSED):
                continue
            if status != kernel.NO_RATES or not (self._rise(now, path, record) or self._jump(now, path)):
                break
        if status == kernel.DONE:
            self.done += 1
            return now
        self._say_why(status, now, path)
        return None

    def _rise(self, now: Reached, path: FloatArray, record: bool) -> bool:
        """Pass the rest of a load step that begins without reactions and gaps; False where it does not.

        The law is a cone: what one implicit step says of its end is reached along a straight way.
        """
        mo, layout, rest = self.sliding, self.problem.layout, 1.0 - now.time
        load = path[now.step] + now.time * (path[now.step + 1] - path[now.step])
        if (
            np.abs(load + self.kappa @ mo.u).max() > self.measures.force
            or mo.u[layout.gaps].any()
            or not rest
        ):
            return False
        A, B, C = layout.blocks(self.kappa)
        body = A, B, C if self.problem.C is not None else None
        joint = ImplicitJoint(*body, self.problem.f, self.scale.force, self.tolerances)
        end = end_at_once(joint, layout, mo.u, np.stack([load, path[now.step + 1]]))
        if end is None:
            return False
        if record:
            at = self.problem.m - len(path) + now.step + now.time
            curve = np.zeros((1, DEGREE, layout.size))
            curve[0, 0] = end.u - mo.u
            numbers = np.array([at]), np.array([rest]), mo.u[None].copy(), curve
            none, kind = np.array([-1]), np.array([int(EventKind.LOAD_STEP)])
            self.pieces.append(_Piece(self.done, *numbers, end.contact[None].copy(), none, kind))
        mo.slipped[:] += end.slip
        mo.work[:] += 0.5 * end.work  # the reaction rises, too
        self.state = State(end.u, end.contact)
        resume_sliding(mo, 1.0, EventKind.LOAD_STEP)
        return True

    def _jump(self, now: Reached, path: FloatArray) -> bool:
        """Carry the state across an instant without rates; False where the motion does not come to rest."""
        mo, step = self.sliding, now.step
        if len(self.jumps) == MOST_JUMPS * self.problem.n * (len(path) - 1):
            return False
        retries = self._retries(step, now.time)
        rate = path[step + 1] - path[step]
        if retries == MOST_RETRIES or not rate.any():
            return False
        nudge = NUDGE * self.scale.force * 4.0**retries / float(np.abs(rate).max())
        time = min(now.time + nudge, 1.0)
        self._nudged = (step, time, retries)
        load, before = path[step] + time * rate, State(mo.u.copy(), mo.contact.copy())
        reaction = path[step] + now.time * rate + self.kappa @ before.u
        moving = DirectedJump(
            self.kappa, self.problem.f, before, reaction, load, self.damping, self.measures, self.scale
        )
        rest = moving.to_rest()
        if rest is None:
            self.left = bool((moving.contact == OPEN).all())
            self.slides = moving.endless and not self.left
            return False
        cycle = self.done + (self.problem.m - len(path) + step + time) / self.problem.m
        jump = jump_of(cycle, self.kappa, load, before, rest)
        self.state = State(rest.u, rest.contact)
        resume_sliding(mo, time)
        closed = (before.contact != OPEN) & (rest.contact != OPEN)
        way = self.problem.law.size(jump.v_after - jump.v_before)
        mo.slipped[:] += np.where(closed, way, 0.0)
        self.jumps.append(jump)
        return True

    def _retries(self, step: int, time: float) -> int:
        """How often this instant has been jumped from already: the load has not moved since the last jump."""
        if self._nudged is None or self._nudged[:2] != (step, time):
            return 0
        return self._nudged[2] + 1

    def _piece(self, room: CurveRecord, rows: int) -> _Piece:
        """What a record has been filled with."""
        kept = (getattr(room, key)[:rows].copy() for key in _Piece._fields[1:])
        return _Piece(self.done, *kept)

    @property
    def history(self) -> CurvedHistory:
        """All recorded steps, closed by the present state."""
        parts = [
            self._joined(list(pieces))
            for _, pieces in groupby(self.pieces, key=lambda piece: piece.done == 0)
        ]
        if self.stop is None:
            parts.append(self._end())
        return CurvedHistory.joined(parts or [CurvedHistory.none(self.problem.n)])

    def _joined(self, pieces: list[_Piece]) -> CurvedHistory:
        """The history of pieces of one course."""
        path = self._first if pieces[0].done == 0 else self._later
        first = self.problem.m - len(path)
        done = np.repeat([piece.done for piece in pieces], [len(piece.time) for piece in pieces])
        steps, duration, u, curve, contact, node, kind = (
            np.concatenate(parts) for parts in list(zip(*pieces, strict=True))[1:]
        )
        index = np.minimum((steps - first).astype(int), len(path) - 2)
        change = np.diff(path, axis=0)[index]
        welded = path[index] + change * (steps - first - index)[:, None]
        bend = curve @ self.kappa
        bend[:, 0] += duration[:, None] * change
        return self._history(
            (done + steps / self.problem.m, kind, node), u, welded, contact, (duration, curve, bend)
        )

    def _end(self) -> CurvedHistory:
        """The present state."""
        nothing = np.zeros((1, DEGREE, self.problem.layout.size))
        what = np.array([self.done - 1 / self.problem.m]), np.array([EventKind.LOAD_STEP]), np.array([-1])
        contact = self.sliding.contact[None].copy()
        curves = np.zeros(1), nothing, nothing
        return self._history(what, self.sliding.u[None].copy(), self.load[-1:], contact, curves)

    def _history(
        self,
        what: tuple[FloatArray, NDArray[np.int64], NDArray[np.int64]],
        u: FloatArray,
        welded: FloatArray,
        contact: NDArray[np.int64],
        curves: tuple[FloatArray, FloatArray, FloatArray],
    ) -> CurvedHistory:
        split = self.problem.layout.split
        (v, w), (q, p), (q_w, p_w) = split(u), split(welded + u @ self.kappa), split(welded)
        duration, curve, bend = curves
        return CurvedHistory(*what, v, w, q, p, q_w, p_w, contact, duration / self.problem.m, curve, bend)

    def _say_why(self, status: int, now: Reached, path: FloatArray) -> None:
        """Set ``stop``: why the loop has ended with this status."""
        steps = self.problem.m - len(path) + now.step + now.time
        time = float(self.done + steps / self.problem.m)
        reasons = {
            kernel.NO_RATES: "the state jumps and does not come to rest",
            kernel.LIFTS_OFF: f"node {now.concerned} lifts off, and the problem has no C",
            kernel.TOO_MANY_EVENTS: "events accumulate within one load step",
            kernel.NOT_SETTLED: "the moving nodes are not held: their stiffness is singular to round-off",
        }
        if self.left:
            reasons[status] = "the body leaves: every node is open and nothing else holds it"
        if self.slides:
            reasons[status] = SLIDES_AWAY
        when = f"at time {time:.6g} cycles" if time >= 0 else "on the way to the first period"
        why = ": friction and stiffness do not hold it" * self.slides
        self.stop = Stop(f"{reasons[status]} {when}{why}", time, now.concerned, self.slides)
