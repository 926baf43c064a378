"""Quasi-static evolution of a joint from event to event, cycle by cycle, and its path over some cycles."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.constants import NEGLIGIBLE, SIX_DIGITS, FloatArray
from shakedown.ground.status import OPEN
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import work_is_left
from shakedown.joint.arguments import check_arguments, checked, checked_damping, require_problem
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import free_stiffness
from shakedown.motion.checked_law import law_resolution, law_violation
from shakedown.motion.course import LoopEnd
from shakedown.motion.event_history import EventHistory
from shakedown.motion.method import SLIDES_AWAY, CycleRecord, Motion, State, Stop, cycles_of
from shakedown.motion.plane.plane_events import PlaneEvents
from shakedown.motion.space.space_events import SpaceEvents
from shakedown.motion.viscous_jump import Jump, ViscousJoint, default_damping


class Evolution(Motion):
    """A joint under its loading loop at one load factor, carried from cycle to cycle, event by event.

    In the plane without error (:class:`~shakedown.motion.plane.plane_events.PlaneEvents`), in space to the
    accuracy ``Tolerances.path`` (:class:`~shakedown.motion.space.space_events.SpaceEvents`).

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

    A node in space that a force across drags along:

    >>> from shakedown import Problem
    >>> joint = Problem(A=[[2, 0], [0, 2]], B=[[0, 0]], f=0.4, q_w=[[0.4, 0], [0.4, 1]], p_w=[[1], [1]])
    >>> Evolution(joint, 1.0).cycle().end_slip.round(6)
    array([-0.167386, -0.302677])
    """

    method: PlaneEvents | SpaceEvents

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
        self.problem, self.tolerances = problem, tolerances
        self.kappa, given = free_stiffness(problem), checked_damping(problem, damping)
        self.damping = default_damping(self.kappa) if given is None else given  # diagonal of D, ((d + 1) n,)
        method = PlaneEvents if problem.directions == 1 else SpaceEvents
        self.method = method(problem, self.kappa, tolerances)
        self.u, self.contact, self.direction = self.method.u, self.method.contact, self.method.direction
        self.left: bool  # contact is lost for good
        self.slides: bool  # a jump has no end although nodes are in contact
        self.held: bool  # the moving nodes of the last state set are held; otherwise nothing can continue
        self.may_jump = True  # False: stop before a jump, for callers that examine a state without jumps
        self.begin(load_factor, initial_slip, open_nodes)

    def _begin(self, state: State, load: FloatArray, transient: FloatArray) -> None:
        first, later = np.vstack([load, transient, self.load]), np.vstack([self.load[-1:], self.load])
        self.method.begin(state.u, first, later, self.scale)
        self.enter_cycle(0)
        self.state = state

    @property
    def path(self) -> FloatArray:
        """Welded reactions at the ends of the load steps of the present cycle, (s + 1, (d + 1) n) [force]."""
        path: FloatArray = self.method.courses[self.done == 0].path
        return path

    def _set_state(self, state: State) -> None:
        self.held = self.method.set_state(state)

    def enter_cycle(self, done: int) -> None:
        """Enter a cycle: a number of cycles are done, with no stop and no jump in the next one yet."""
        self.done, self.stop = done, None
        self.left, self.slides = False, False
        self.jumps: list[Jump] = []  # of the present cycle
        self._nudged = -1, 0.0, 0  # load step of the last jump, time in it, retries there

    def violation(self, state: State, load: FloatArray | None = None) -> float:
        """The relative violation of the contact and friction law by a state, by default between cycles."""
        layout = self.problem.layout
        q, p = layout.split((self.load[-1] if load is None else load) + self.kappa @ state.u)
        gap, still = state.u[layout.gaps], np.zeros_like(q)
        return float(law_violation(self.problem.f, q, p, gap, still, self.scale).max())

    def _follow(self, cycles: int, record: bool) -> bool:
        """Run the compiled loop through cycles of one course."""
        method, before = self.method, self.done
        self.enter_cycle(before)
        method.enter(before == 0, record)
        if not (self.held and work_is_left()):
            self.say_why(LoopEnd.OUT_OF_WORK if self.held else LoopEnd.NOT_HELD)
            return False
        goes_on = True
        while goes_on:  # ends, as events per load step, jumps per cycle and cycles are limited
            status = method.follow(1 if before == 0 else cycles)
            found = status in method.passable and method.finds_way_on()
            self.pieces += method.recorded(before)
            self.done = before + method.motion.passes
            goes_on = status != LoopEnd.DONE and work_is_left()
            if goes_on and not found and status not in (LoopEnd.RECORD_FULL, LoopEnd.PAUSED):
                goes_on = status == LoopEnd.NO_RATES and self.jump()
        if status != LoopEnd.DONE:
            self.say_why(status if work_is_left() else LoopEnd.OUT_OF_WORK)
        return status == LoopEnd.DONE

    def _what_it_did(self) -> CycleRecord:
        did, counted, jumps = self.method.motion, self.method.motion.content, tuple(self.jumps)
        work = sum((jump.work for jump in jumps), did.work.copy())
        return CycleRecord(
            end_slip=self.u[self.problem.layout.slips].copy(),
            slip=did.slip.copy(),
            work=work,
            friction_dissipation=float(work.sum()),
            jump_dissipation=float(sum(jump.damping_work for jump in jumps)),
            opened=did.opened.astype(np.bool_),
            closed=did.closed.astype(np.bool_),
            events=counted.events,
            signature=counted.signature,
            jumps=jumps,
            error=self.method.error,
        )

    def jump(self) -> bool:
        """Carry the state across an instant without rates; False where the motion does not come to rest."""
        method, path, step, now = self.method, self.path, self.method.motion.step, self.method.motion.time
        # so many jumps at most per node and load step of a cycle
        if not self.may_jump or len(self.jumps) == 20 * self.problem.n * (len(path) - 1):
            return False
        again = self._nudged[:2] == (step, now)  # the load has not changed since the last jump
        retries, rate = (self._nudged[2] + 1 if again else 0), path[step + 1] - path[step]
        # retries at one instant, each with a larger change of load
        if retries == 20 or not rate.any():
            return False
        time = min(now + NEGLIGIBLE * self.scale.force * 4.0**retries / float(np.abs(rate).max()), 1.0)
        self._nudged = (step, time, retries)
        load, before = path[step] + time * rate, self.state
        joint = ViscousJoint(self.kappa, self.problem.law, load, self.damping, self.scale)
        moving = method.relaxation(joint, before, method.reaction(path[step] + now * rate))
        rest = moving.to_rest()
        if rest is None:
            goes = moving.endless or moving.moved > SIX_DIGITS * self.scale.length
            self.left = goes and bool((moving.contact == OPEN).all())
            self.slides = moving.endless and not self.left
            if goes:
                return False
            if time == 1.0 and self.violation(before, load) <= law_resolution(self.problem, self.tolerances):
                method.resume(time)  # unloaded, where reactions have no direction, it keeps its place
                return True
            self._nudged = (step, now, retries)
            return self.jump()  # it stands still next to where it was: a larger change of load leads away
        cycle = self.done + (self.problem.m - len(path) + step + time) / self.problem.m
        jump = moving.jump_to(rest, cycle)
        self.state = State(rest.u, rest.contact)
        if not self.held:
            return False
        method.resume(time)
        closed = (before.contact != OPEN) & (rest.contact != OPEN)
        method.slip[:] += np.where(closed, self.problem.law.size(jump.v_after - jump.v_before), 0.0)
        self.jumps.append(jump)
        return True

    @property
    def history(self) -> EventHistory:
        """The recorded path, closed by the present state where nothing has stopped it."""
        present = self.method.present(self.done, self.load[-1] + self.kappa @ self.u)
        return present.joined([*self.pieces, present.rows(np.arange(self.stop is None))])

    def say_not_held(self) -> None:
        """Set ``stop`` where a cycle cannot begin as nothing holds the moving nodes of its first state."""
        self.method.enter(self.done == 0, False)
        self.say_why(LoopEnd.NOT_HELD)

    def say_why(self, status: int) -> None:
        """Set ``stop`` to the reason for this status of the loop."""
        now = self.method.motion
        steps = self.problem.m - len(self.path) + now.step + now.time
        time = float(self.done + steps / self.problem.m)
        reasons: dict[int, str] = {
            LoopEnd.NO_RATES: "the state jumps and does not come to rest",
            LoopEnd.LIFTS_OFF: f"node {now.concerned} lifts off, and the problem has no C",
            LoopEnd.TOO_MANY_EVENTS: "events accumulate within one load step",
            LoopEnd.NOT_HELD: "the moving nodes are not held: their stiffness is singular to round-off",
            LoopEnd.OUT_OF_WORK: "the computation allowed for a run is spent",
        }
        if self.left and status != LoopEnd.OUT_OF_WORK:
            reasons[status] = "the body leaves: every node is open and nothing else holds it"
        if self.slides:
            reasons[status] = SLIDES_AWAY
        if not self.held:
            reasons[status] = reasons[LoopEnd.NOT_HELD]
        when = f"at time {time:.6g} cycles" if time >= 0 else "on the way to the first period"
        why = ": friction and stiffness do not hold it" * self.slides
        self.stop = Stop(
            f"{reasons[status]} {when}{why}", time, now.concerned, self.slides, status == LoopEnd.OUT_OF_WORK
        )


@dataclass(frozen=True, eq=False, repr=False)
class EvolutionResult(Result):
    """Result of :func:`evolve`.

    Attributes
    ----------
    load_factor, initial_slip
        What was simulated; the slip of a node that was open at the start is its displacement.
    cycles
        What every cycle did.
    history
        Every event.
    stop
        Why it ended before its time; None where it did not.
    """

    DOCUMENT: ClassVar[str] = "load_factor initial_slip cycles history stop"

    load_factor: float
    initial_slip: FloatArray
    cycles: tuple[CycleRecord, ...]
    history: EventHistory
    stop: Stop | None

    def columns(self) -> dict[str, Any]:
        """One row per event."""
        return self.history.columns()


@checked
def evolve(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    *,
    open_nodes: Iterable[int] = (),
    cycles: int = 1,
    damping: ArrayLike | None = None,
    tolerances: Tolerances = DEFAULT,
) -> EvolutionResult:
    """The exact path of a joint through its transient and a number of cycles (thesis (2.10), (2.3)–(2.9)).

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0, multiplies the periodic part of the loading.
    initial_slip : (n,), optional
        Slip at the start [length]; zero by default.
    open_nodes
        Nodes that are open at the start, all others closed: they are in equilibrium with
        the first load step (:func:`beginning`), and their initial slips are ignored.
    cycles
        How many.
    damping : (2n,), optional
        Diagonal of the matrix D that carries the state across jumps, only ratios
        matter; by default in proportion to the diagonal of κ.
    tolerances
        What counts as zero, as reached and as periodic (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range, or an open node would overlap.

    Examples
    --------
    >>> import shakedown
    >>> run = evolve(shakedown.example("three-node"), 2.6, [2.60902, -0.60226, -0.36541], cycles=2)
    >>> run.stop is None, run.cycles[1].events
    (True, 3)
    """
    check_arguments(load_factor, cycles, problem)
    evolution = Evolution(problem, load_factor, initial_slip, tolerances, damping, open_nodes)
    start = evolution.state.u[problem.layout.slips]
    records = tuple(cycles_of(evolution, cycles, record=True))
    return EvolutionResult(float(load_factor), start, records, evolution.history, evolution.stop)
