"""A joint with two tangential directions followed at load steps, or parts of them, each solved at once."""

from collections import deque
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.argument_kinds import check_count
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem
from shakedown.motion.contact_law import Scales, reactions, scales
from shakedown.motion.cycle_record import SLIDES_AWAY, CycleRecord, Interim, State, Stop
from shakedown.motion.event_history import EventHistory, EventKind
from shakedown.motion.implicit.implicit_step import ImplicitJoint, Steps, StepStatus
from shakedown.motion.initial_state import beginning
from shakedown.motion.kernels.contact_status import OPEN, STICK

SLIPS = 1  # beside STICK and OPEN: a disc has no sides
REMEMBERED = 2  # cycles whose load steps are kept, recorded or not


class ImplicitPath:
    """A joint with two tangential directions under its loop, by implicit steps; a :class:`Motion`.

    Each load step is cut into equal parts and each part is solved at once, so that the error is of the
    first order in their size. The first load of all is put on in one step, from whatever state: an
    initial slip that the law does not allow there becomes one that it does. Transient load steps,
    where the problem has them, come first and are no cycle.

    Parameters
    ----------
    problem, load_factor, initial_slip, tolerances, open_nodes
        As for :func:`evolve`.
    parts
        Into how many a load step is cut.
    sweeps_only
        Solve each by Gauss–Seidel sweeps alone: the baseline, slow where many nodes slip or open.

    Raises
    ------
    UsageError
        If the joint has one tangential direction (:class:`FixedSteps` follows it), or an argument is out
        of range.

    Examples
    --------
    A load of constant size goes around, f p = 0.6, A = 1: the slip goes around a circle of radius 0.8.

    >>> import numpy as np
    >>> from shakedown import Problem
    >>> t = 2 * np.pi * np.arange(1, 61)[:, None] / 60
    >>> q_w = np.hstack([np.cos(t), np.sin(t)])
    >>> node = Problem(A=np.eye(2), B=np.zeros((1, 2)), f=0.3, q_w=q_w, p_w=np.full((60, 1), 2.0))
    >>> motion = ImplicitPath(node, 1.0, parts=20)
    >>> first, second = motion.cycle(), motion.cycle()
    >>> (second.slip / (2 * np.pi)).round(3), round(second.dissipation / (2 * np.pi), 3)
    (array([0.797]), 0.478)
    """

    def __init__(
        self,
        problem: Problem,
        load_factor: float,
        initial_slip: ArrayLike | None = None,
        tolerances: Tolerances = DEFAULT,
        open_nodes: Iterable[int] = (),
        parts: int = 1,
        sweeps_only: bool = False,
    ) -> None:
        check_count("parts", parts)
        start = beginning(problem, load_factor, initial_slip, open_nodes, tolerances)
        if problem.directions == 1:
            raise UsageError("implicit path: expected two tangential directions, found one")
        self.problem, self.load_factor, self.tolerances = problem, load_factor, tolerances
        self.parts, self.sweeps_only = int(parts), sweeps_only
        self.scale = scales(problem, load_factor)
        self.load = loading(problem).at(load_factor)
        self.done = 0  # cycles
        self.residual = 0.0  # largest relative violation of the friction law so far
        self.pieces: list[EventHistory] = []
        self.recent: deque[tuple[EventHistory, FloatArray]] = deque(maxlen=REMEMBERED)
        arrays = problem.A, problem.B, problem.C, problem.f
        self.joint = ImplicitJoint(*arrays, self.scale.force, tolerances)
        self.begun = False  # whether the first load has been put on
        self.state = start.state
        self.start = self.joint.v
        before = transient_path(problem)
        if len(before):
            self.pieces.append(self._advance(*problem.layout.split(before), -len(before))[0])

    @property
    def state(self) -> State:
        """The state between two cycles, at the last load step; may be set to continue from another one."""
        return State(self.problem.layout.joined(self.joint.v, self.joint.w), self.contact.copy())

    @state.setter
    def state(self, state: State) -> None:
        self.stop: Stop | None = None
        self.contact = np.array(state.contact)
        self.joint.begin(*self.problem.layout.split(state.u), *(part[-1] for part in self.load))

    @property
    def history(self) -> EventHistory:
        """The states after all recorded load steps; nothing is known of what is between them."""
        return EventHistory.joined(self.pieces or [self._nothing()])

    def last(self, cycles: int) -> tuple[EventHistory, FloatArray]:
        """The load steps of the last cycles, at most ``REMEMBERED``, and the way in contact in each."""
        chosen = list(self.recent)[max(len(self.recent) - cycles, 0) :]
        paths = [path for path, _ in chosen] or [self._nothing()]
        lengths = [length for _, length in chosen] or [np.zeros((0, self.problem.n))]
        return EventHistory.joined(paths), np.concatenate(lengths)

    def interim(self) -> Interim:
        """Where it stands, for :meth:`go_on`."""
        joint = self.joint.interim()
        return self.done, self.begun, self.contact.copy(), self.residual, tuple(self.recent), joint

    def go_on(self, interim: Interim) -> None:
        """Stand where a motion stood, but for what is recorded."""
        self.done, self.begun, self.contact, self.residual, recent, joint = interim
        self.recent.extend(recent)
        self.joint.go_on(joint)

    def cycle(self, *, record: bool = False) -> CycleRecord | None:
        """Carry the joint through its next cycle; None, and ``stop`` says why, where that cannot be done."""
        if self.stop is not None:
            return None
        path, length, work = self._advance(*self.load, 0)
        if record:
            self.pieces.append(path)
        if self.stop is not None:
            return None
        self.done += 1
        self.recent.append((path, length))
        gap = path.w > 0
        return CycleRecord(
            end_slip=self.joint.v,
            slip=length.sum(axis=0),
            work=work.sum(axis=0),
            friction_dissipation=float(work.sum()),
            jump_dissipation=0.0,
            opened=np.asarray(gap.any(axis=0)),
            closed=~np.asarray(gap.all(axis=0)),
            events=0,
            signature=0,
            jumps=(),
        )

    def _nothing(self) -> EventHistory:
        """The history of no load step."""
        q_w, p_w = (part[:0] for part in self.load)
        return self._history(Steps.none(self.problem.n), q_w, p_w, 0)

    def _advance(
        self, q_w: FloatArray, p_w: FloatArray, first: int
    ) -> tuple[EventHistory, FloatArray, FloatArray]:
        """Solve load steps and check the law on them: their path, way in contact and work in each."""
        pieces = [self._solved(q_w[:1], p_w[:1], 1)] if not self.begun else []
        if not pieces or pieces[0].status == StepStatus.SOLVED:
            begun = len(pieces)
            pieces.append(self._solved(q_w[begun:], p_w[begun:], self.parts))
        self.begun = True
        steps = Steps.joined(pieces)
        count = len(steps.v)
        path = self._history(steps, q_w[:count], p_w[:count], first)
        self.contact = path.state[-1] if count else self.contact
        self._judge(steps, path, first)
        return path, steps.length, steps.work

    def _solved(self, q_w: FloatArray, p_w: FloatArray, parts: int) -> Steps:
        return self.joint.follow(q_w, p_w, parts, sweeps_only=self.sweeps_only)

    def _history(self, steps: Steps, q_w: FloatArray, p_w: FloatArray, first: int) -> EventHistory:
        k = len(q_w)
        q, p = reactions(self.problem, q_w, p_w, steps.v, steps.w)
        state = np.where(steps.w > 0, OPEN, np.where(steps.length > 0, SLIPS, STICK))
        return EventHistory(
            cycle=self.done + (first + np.arange(k)) / self.problem.m,
            kind=np.full(k, EventKind.LOAD_STEP, dtype=np.int64),
            node=np.full(k, -1),
            v=steps.v, w=steps.w, q=q, p=p, q_w=q_w, p_w=p_w,
            state=state,
        )  # fmt: skip

    def _judge(self, steps: Steps, path: EventHistory, first: int) -> None:
        """Stop where a step was not solved, or the law is violated after the solved ones."""
        self.residual = max(self.residual, steps.residual)
        good = path.rows(np.arange(steps.solved))
        met = projection_error(self.problem, good, steps.slip[: steps.solved], self.scale)
        self.residual = max(self.residual, met)
        failure = self._failure(steps, first)
        if not failure and met > self.tolerances.friction_law:
            failure = f"the friction law is violated by {met:.1e} after converged load steps"
        if failure:
            when = self.done + (first + min(steps.solved, len(path) - 1)) / self.problem.m
            self.stop = Stop(failure, when, steps.node, steps.status == StepStatus.SLIDES_AWAY)

    def _failure(self, steps: Steps, first: int) -> str:
        """Why a load step was not solved; empty where all of them were."""
        where = f"load step {first + steps.solved}"
        if steps.status == StepStatus.SLIDES_AWAY:
            return f"{SLIDES_AWAY} at {where}"
        if steps.status == StepStatus.LIFTS_OFF:
            return f"node {steps.node} lifts off at {where}, and the problem has no C"
        if steps.status == StepStatus.UNSOLVED and steps.node >= 0:
            return f"no admissible state of node {steps.node} at {where} (friction above a threshold?)"
        if steps.status == StepStatus.UNSOLVED:
            return f"{where} not solved: the law is missed by {steps.residual:.1e}"
        return ""


def projection_error(problem: Problem, path: EventHistory, slip: FloatArray, scale: Scales) -> float:
    """By how much states (k, …) break the law of a load step with these slips in contact (k, 2n), relative.

    The departure of the reactions from their projections on what the law allows, q from the disc at
    q − slip and p from max(p − w, 0), forces and lengths relative to the scales. Where a node slips by
    ever less it loses its direction and not its meaning, other than that of q + f p slip/|slip|.
    """
    q, p = path.q / scale.force, path.p / scale.force
    pressed = np.maximum(p - path.w / scale.length, 0.0)
    apart = q - problem.law.projection(q - slip / scale.length, pressed)
    return max(float(np.abs(apart).max(initial=0.0)), float(np.abs(p - pressed).max(initial=0.0)))
