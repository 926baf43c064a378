"""A joint followed at fixed load steps: by the thesis's Gauss–Seidel, in space also by Newton's method."""

from collections import deque
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.argument_kinds import check_count
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import BACKWARD_SLIP, FORWARD_SLIP, OPEN, SLIP, STICK
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import require_problem
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import free_stiffness
from shakedown.motion.checked_law import Scales, law_violation, reactions
from shakedown.motion.cycle_record import SLIDES_AWAY, CycleRecord, State, Stop
from shakedown.motion.event_history import EventHistory, EventKind
from shakedown.motion.method import Beginning, Motion
from shakedown.motion.plane.gauss_seidel import PlaneStiffness, load_steps
from shakedown.motion.space.implicit_step import MOST_SWEEPS, ImplicitJoint, Steps, StepStatus

REMEMBERED = 2  # cycles whose load steps are kept, whether recorded or not


class FixedSteps(Motion):
    """A joint under its loading loop, carried from load step to load step.

    Transient load steps, where the problem has them, come first and are no cycle. In space
    the first load of all is put on in one step, from whatever state: an initial slip that the law does
    not allow there becomes one that it does.

    Parameters
    ----------
    problem, load_factor, initial_slip, tolerances, open_nodes
        As for :func:`evolve`.
    parts
        Into how many equal parts a load step is cut in space, each of them solved at once: the error is
        of the first order in their size.
    sweeps_only
        In space: solve each by Gauss–Seidel sweeps alone, the baseline, slow where many nodes slip or
        open. In the plane that is always so.

    Raises
    ------
    UsageError
        If an argument is out of range, or load steps are to be cut in the plane.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> motion = FixedSteps(shakedown.example("two-node"), 0.9)
    >>> first, second = motion.cycle(), motion.cycle()
    >>> second.slip.round(6)
    array([0.      , 1.893552])

    A load of constant size goes around, f p = 0.6, A = 1: the slip goes around a circle of radius 0.8.

    >>> t = 2 * np.pi * np.arange(1, 61)[:, None] / 60
    >>> q_w = np.hstack([np.cos(t), np.sin(t)])
    >>> node = shakedown.Problem(A=np.eye(2), B=np.zeros((1, 2)), f=0.3, q_w=q_w, p_w=np.full((60, 1), 2.0))
    >>> motion = FixedSteps(node, 1.0, parts=20)
    >>> first, second = motion.cycle(), motion.cycle()
    >>> (second.slip / (2 * np.pi)).round(3), round(second.dissipation / (2 * np.pi), 3)
    (array([0.797]), 0.478)
    """

    method: "SweptSteps | SolvedSteps"

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
        require_problem(problem)
        check_count("parts", parts)
        self.problem, self.tolerances = problem, tolerances
        self.method = _method_of(problem, int(parts), sweeps_only)
        self.begin(load_factor, initial_slip, open_nodes)

    def _begin(self, start: Beginning, transient: FloatArray) -> None:
        self.residual = 0.0  # largest relative violation of the friction law so far
        self.recent: deque[tuple[EventHistory, FloatArray]] = deque(maxlen=REMEMBERED)
        self.method.begin(self.load[-1], self.scale, self.tolerances)
        self.state = start.state
        self.start = self.state.u[self.problem.layout.slips]
        if len(transient):
            self.pieces.append(self._advance(transient, -len(transient))[0])

    @property
    def history(self) -> EventHistory:
        """The states after all recorded load steps; nothing is known of what is between them."""
        return EventHistory.joined(self.pieces or [self._nothing()])

    def last(self, cycles: int) -> tuple[EventHistory, FloatArray]:
        """The load steps of the last cycles, at most ``REMEMBERED``, and the slip in contact during each.

        In space the way in contact.
        """
        chosen = list(self.recent)[max(len(self.recent) - cycles, 0) :]
        paths = [path for path, _ in chosen] or [self._nothing()]
        ways = [way for _, way in chosen] or [np.zeros((0, self.problem.n))]
        return EventHistory.joined(paths), np.concatenate(ways)

    def _follow(self, cycles: int, record: bool) -> bool:
        path, self._steps = self._advance(self.load, 0)
        if record:
            self.pieces.append(path)
        if self.stop is not None:
            return False
        self.done += 1
        self.recent.append((path, self.method.ways(self._steps)))
        return True

    def _what_it_did(self) -> CycleRecord:
        steps = self._steps
        gap = steps.w > 0
        return CycleRecord(
            end_slip=self.state.u[self.problem.layout.slips].copy(),
            slip=steps.length.sum(axis=0),
            work=steps.work.sum(axis=0),
            friction_dissipation=float(steps.work.sum()),
            jump_dissipation=0.0,
            opened=np.asarray(gap.any(axis=0)),
            closed=~np.asarray(gap.all(axis=0)),
            events=0,
            signature=0,
            jumps=(),
        )

    def _nothing(self) -> EventHistory:
        """A history without load steps."""
        return self._path(Steps.none(self.problem.layout), self.load[:0], 0)

    def _advance(self, loads: FloatArray, first: int) -> tuple[EventHistory, Steps]:
        """Solve load steps (k, (d + 1) n) and check the law on them."""
        steps = self.method.solve(*self.problem.layout.split(loads))
        path = self._path(steps, loads[: len(steps.v)], first)
        if len(path):
            self.method.contact = path.state[-1]
        self._judge(steps, path, first)
        return path, steps

    def _path(self, steps: Steps, loads: FloatArray, first: int) -> EventHistory:
        k, (q_w, p_w) = len(loads), self.problem.layout.split(loads)
        q, p = reactions(self.problem, q_w, p_w, steps.v, steps.w)
        return EventHistory(
            cycle=self.done + (first + np.arange(k)) / self.problem.m,
            kind=np.full(k, EventKind.LOAD_STEP, dtype=np.int64),
            node=np.full(k, -1),
            v=steps.v, w=steps.w, q=q, p=p, q_w=q_w, p_w=p_w,
            state=np.where(steps.w > 0, OPEN, self.method.sides(steps)),
        )  # fmt: skip

    def _judge(self, steps: Steps, path: EventHistory, first: int) -> None:
        """Stop where a step was not solved, or the law is violated after the solved ones."""
        missed = self.method.missed(steps, path)
        self.residual = max(self.residual, steps.residual, missed)
        failure = self._failure(steps, f"load step {first + steps.solved}")
        if not failure and missed > self.tolerances.friction_law:
            failure = f"the friction law is violated by {missed:.1e} after converged load steps"
        if failure:
            when = self.done + (first + min(steps.solved, len(path) - 1)) / self.problem.m
            self.stop = Stop(failure, when, steps.node, steps.status == StepStatus.SLIDES_AWAY)

    def _failure(self, steps: Steps, where: str) -> str:
        """Why a load step was not solved; empty where all were."""
        if steps.status == StepStatus.SLIDES_AWAY:
            return f"{SLIDES_AWAY} at {where}"
        if steps.status == StepStatus.LIFTS_OFF:
            return f"node {steps.node} lifts off at {where}, and the problem has no C"
        if steps.status == StepStatus.UNSOLVED and steps.node >= 0:
            return f"no admissible state of node {steps.node} at {where} (friction above a threshold?)"
        if steps.status == StepStatus.UNSOLVED:
            return f"{where} {self.method.unsolved(steps)}"
        return ""


def _method_of(problem: Problem, parts: int, sweeps_only: bool) -> "SweptSteps | SolvedSteps":
    """The solver for the load steps of a joint."""
    if problem.directions > 1:
        return SolvedSteps(problem, parts, sweeps_only)
    if parts > 1:
        raise UsageError(f"parts: expected 1 with one tangential direction, found {parts}")
    return SweptSteps(problem)


class SweptSteps:
    """Load steps in the plane, by Gauss–Seidel over the nodes."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.v, self.w = np.zeros(problem.n), np.zeros(problem.n)
        self.contact = np.zeros(problem.n, dtype=np.int64)

    @property
    def u(self) -> FloatArray:
        """Slips and gaps, (2n,)."""
        return self.problem.layout.joined(self.v, self.w)

    def begin(self, load: FloatArray, scale: Scales, tolerances: Tolerances) -> None:
        """What "small" is measured against."""
        problem, self.scale = self.problem, scale
        self.tolerance = tolerances.convergence * scale.length
        tension, separable = 16 * np.finfo(float).eps * scale.force, problem.C is not None
        blocks = problem.layout.blocks(free_stiffness(problem))
        self.stiffness = PlaneStiffness(*blocks, problem.f, separable, tension).compact()

    def set_state(self, state: State) -> None:
        """Go to a state."""
        self.v[:], self.w[:] = self.problem.layout.split(state.u)
        self.contact = state.contact.copy()

    def solve(self, q_w: FloatArray, p_w: FloatArray) -> Steps:
        """Carry the state through load steps (k, n), (k, n)."""
        loads = np.ascontiguousarray(q_w), np.ascontiguousarray(p_w)
        v, w, slip = (np.zeros_like(loads[0]) for _ in range(3))
        _, change, failed, node = load_steps(
            self.stiffness, *loads, self.v, self.w, self.tolerance, MOST_SWEEPS, v, w, slip
        )
        if failed < 0:
            status, solved, residual = StepStatus.SOLVED, len(v), 0.0
        else:
            lifts = node >= 0 and not self.stiffness.separable
            status, solved = StepStatus.LIFTS_OFF if lifts else StepStatus.UNSOLVED, failed
            residual = float(change / self.scale.length)
            v, w, slip = v[: failed + 1], w[: failed + 1], slip[: failed + 1]
        q, _ = reactions(self.problem, q_w[: len(v)], p_w[: len(v)], v, w)
        return Steps(status, solved, node, residual, v, w, slip, np.abs(slip), -(q * slip), 0, 0)

    def sides(self, steps: Steps) -> NDArray[np.int64]:
        """States of closed nodes."""
        return np.where(steps.slip < 0, BACKWARD_SLIP, np.where(steps.slip > 0, FORWARD_SLIP, STICK))

    def ways(self, steps: Steps) -> FloatArray:
        """The slip in contact in every load step, (k, n) [length]."""
        return steps.slip

    def missed(self, steps: Steps, path: EventHistory) -> float:
        """The relative violation of the law by load steps that were all solved."""
        if steps.status != StepStatus.SOLVED:
            return 0.0
        return float(law_violation(self.problem.f, path.q, path.p, path.w, steps.slip, self.scale).max())

    def unsolved(self, steps: Steps) -> str:
        """What is said of a load step that no node alone was in the way of."""
        return f"not converged in {MOST_SWEEPS} sweeps (last relative change {steps.residual:.1e})"


class SolvedSteps:
    """Load steps in space, or parts of them, each solved at once."""

    def __init__(self, problem: Problem, parts: int, sweeps_only: bool) -> None:
        self.problem, self.parts, self.sweeps_only = problem, parts, sweeps_only

    @property
    def u(self) -> FloatArray:
        """Slips and gaps, (3n,)."""
        return self.problem.layout.joined(self.joint.v, self.joint.w)

    def begin(self, load: FloatArray, scale: Scales, tolerances: Tolerances) -> None:
        """Begin before the first load; states set here are those under the last load of the period."""
        problem, self.scale, self._last = self.problem, scale, load
        A, B, C = problem.layout.blocks(free_stiffness(problem))
        normal = None if problem.C is None else C
        self.joint = ImplicitJoint(A, B, normal, problem.f, scale.force, tolerances)
        self.begun = False  # whether the first load has been applied

    def set_state(self, state: State) -> None:
        """Go to a state."""
        split = self.problem.layout.split
        self.contact = np.array(state.contact)
        self.joint.begin(*split(state.u), *split(self._last))

    def solve(self, q_w: FloatArray, p_w: FloatArray) -> Steps:
        """Carry the state through load steps (k, 2n), (k, n), the very first of all in one."""
        pieces = [self._solved(q_w[:1], p_w[:1], 1)] if not self.begun else []
        if not pieces or pieces[0].status == StepStatus.SOLVED:
            pieces.append(self._solved(q_w[len(pieces) :], p_w[len(pieces) :], self.parts))
        self.begun = True
        return Steps.joined(pieces)

    def _solved(self, q_w: FloatArray, p_w: FloatArray, parts: int) -> Steps:
        return self.joint.follow(q_w, p_w, parts, sweeps_only=self.sweeps_only)

    def sides(self, steps: Steps) -> NDArray[np.int64]:
        """States of closed nodes."""
        return np.where(steps.length > 0, SLIP, STICK)

    def ways(self, steps: Steps) -> FloatArray:
        """The length of the way in contact in every load step, (k, n) [length]."""
        return steps.length

    def missed(self, steps: Steps, path: EventHistory) -> float:
        """The relative violation of the law by solved load steps (:func:`projection_error`)."""
        good = path.rows(np.arange(steps.solved))
        return projection_error(self.problem, good, steps.slip[: steps.solved], self.scale)

    def unsolved(self, steps: Steps) -> str:
        """What is said of a load step that no node alone was in the way of."""
        return f"not solved: the law is missed by {steps.residual:.1e}"


def projection_error(problem: Problem, path: EventHistory, slip: FloatArray, scale: Scales) -> float:
    """The relative violation by states (k, …) of the law of a load step with slips in contact (k, 2n).

    The departure of the reactions from their projections on what the law allows, q from the disc at
    q − slip and p from max(p − w, 0), forces and lengths relative to the scales. Where a node slips by
    ever less it loses its direction and not its meaning, other than that of q + f p slip/|slip|.
    """
    q, p = path.q / scale.force, path.p / scale.force
    pressed = np.maximum(p - path.w / scale.length, 0.0)
    apart = q - problem.law.projection(q - slip / scale.length, pressed)
    return max(float(np.abs(apart).max(initial=0.0)), float(np.abs(p - pressed).max(initial=0.0)))
