"""A joint followed at fixed load steps, by the thesis's Gauss–Seidel."""

from collections import deque
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem
from shakedown.motion.contact_law import law_violation, reactions, scales
from shakedown.motion.cycle_record import CycleRecord, Interim, State, Stop
from shakedown.motion.event_history import EventHistory, EventKind
from shakedown.motion.initial_state import beginning
from shakedown.motion.kernels.contact_status import BACKWARD_SLIP, FORWARD_SLIP, OPEN
from shakedown.motion.kernels.gauss_seidel import Stiffness, load_steps

MAX_SWEEPS = 10_000
REMEMBERED = 2  # cycles whose load steps are kept, recorded or not


class FixedSteps:
    """A joint under its loading loop, carried from load step to load step; a :class:`Motion`.

    Transient load steps, where the problem has them, come first and are no cycle.

    Parameters
    ----------
    problem, load_factor, initial_slip, tolerances, open_nodes
        As for :func:`evolve`.

    Examples
    --------
    >>> import shakedown
    >>> motion = FixedSteps(shakedown.example("two-node"), 0.9)
    >>> first, second = motion.cycle(), motion.cycle()
    >>> second.slip.round(6)
    array([0.      , 1.893552])
    """

    def __init__(
        self,
        problem: Problem,
        load_factor: float,
        initial_slip: ArrayLike | None = None,
        tolerances: Tolerances = DEFAULT,
        open_nodes: Iterable[int] = (),
    ) -> None:
        self.problem, self.load_factor, self.tolerances = problem, load_factor, tolerances
        self.scale = scales(problem, load_factor)
        self.load = loading(problem).at(load_factor)
        n = problem.n
        C = np.zeros((n, n)) if problem.C is None else problem.C
        tension = 16 * np.finfo(float).eps * self.scale.force
        separable = problem.C is not None
        self.stiffness = Stiffness(problem.A, problem.B, C, problem.f, separable, tension).compact()
        self.v, self.w = np.zeros(n), np.zeros(n)
        self.contact = np.zeros(n, dtype=np.int64)
        self.done = 0  # cycles
        self.residual = 0.0  # largest relative violation of the friction law so far
        self.pieces: list[EventHistory] = []
        self.recent: deque[tuple[EventHistory, FloatArray]] = deque(maxlen=REMEMBERED)
        self.state = beginning(problem, load_factor, initial_slip, open_nodes, tolerances).state
        self.start = self.v.copy()
        before = transient_path(problem)
        if len(before):
            q_w, p_w = (np.ascontiguousarray(part) for part in problem.layout.split(before))
            self.pieces.append(self._advance(q_w, p_w, -len(before))[0])

    @property
    def state(self) -> State:
        """The state between two cycles; may be set to continue from another one."""
        return State(self.problem.layout.joined(self.v, self.w), self.contact.copy())

    @state.setter
    def state(self, state: State) -> None:
        self.stop: Stop | None = None
        self.v[:], self.w[:] = self.problem.layout.split(state.u)
        self.contact[:] = state.contact

    @property
    def history(self) -> EventHistory:
        """The states after all recorded load steps; nothing is known of what is between them."""
        return EventHistory.joined(self.pieces or [EventHistory.none(self.problem.n)])

    def last(self, cycles: int) -> tuple[EventHistory, FloatArray]:
        """The load steps of the last cycles, at most ``REMEMBERED``, and the slip in contact during each."""
        n = self.problem.n
        paths, slips = [EventHistory.none(n)], [np.zeros((0, n))]
        for path, slip in list(self.recent)[len(self.recent) - cycles :]:
            paths.append(path)
            slips.append(slip)
        return EventHistory.joined(paths), np.concatenate(slips)

    def interim(self) -> Interim:
        """Where it stands, for :meth:`go_on`."""
        return self.done, self.v.copy(), self.w.copy(), self.contact.copy(), self.residual, tuple(self.recent)

    def go_on(self, interim: Interim) -> None:
        """Stand where a motion stood, but for what is recorded."""
        self.done, self.v[:], self.w[:], self.contact[:], self.residual, recent = interim
        self.recent.extend(recent)

    def cycle(self, *, record: bool = False) -> CycleRecord | None:
        """Carry the joint through its next cycle; None, and ``stop`` says why, where that cannot be done."""
        if self.stop is not None:
            return None
        path, slip = self._advance(*self.load, 0)
        if record:
            self.pieces.append(path)
        if self.stop is not None:
            return None
        self.done += 1
        self.recent.append((path, slip))
        gap, work = path.w > 0, -(path.q * slip)
        return CycleRecord(
            end_slip=self.v.copy(),
            slip=np.abs(slip).sum(axis=0),
            work=work.sum(axis=0),
            friction_dissipation=float(work.sum()),
            jump_dissipation=0.0,
            opened=np.asarray(gap.any(axis=0)),
            closed=~np.asarray(gap.all(axis=0)),
            events=0,
            signature=0,
            jumps=(),
        )

    def _advance(self, q_w: FloatArray, p_w: FloatArray, first: int) -> tuple[EventHistory, FloatArray]:
        """Solve load steps and check the law on them: their path, and the slip in contact during each."""
        v, w, slip = (np.zeros_like(q_w) for _ in range(3))
        tolerance = self.tolerances.convergence * self.scale.length
        _, change, step, node = load_steps(
            self.stiffness, q_w, p_w, self.v, self.w, tolerance, MAX_SWEEPS, v, w, slip
        )
        q, p = reactions(self.problem, q_w, p_w, v, w)
        contact = np.where(
            w > 0, OPEN, np.where(slip < 0, BACKWARD_SLIP, np.where(slip > 0, FORWARD_SLIP, 0))
        )
        self.contact[:] = contact[-1]
        path = EventHistory(
            cycle=self.done + (first + np.arange(len(q_w))) / self.problem.m,
            kind=np.full(len(q_w), EventKind.LOAD_STEP, dtype=np.int64),
            node=np.full(len(q_w), -1),
            v=v, w=w, q=q, p=p, q_w=q_w, p_w=p_w,
            state=contact,
        )  # fmt: skip
        failure = self._failure(change, step, node)
        if step < 0:
            violation = float(law_violation(self.problem.f, q, p, w, slip, self.scale).max())
            self.residual = max(self.residual, violation)
            if violation > self.tolerances.friction_law:
                failure = f"the friction law is violated by {violation:.1e} after converged load steps"
        if failure:
            self.stop = Stop(failure, self.done + (first + max(step, 0)) / self.problem.m, node)
        return path, slip

    def _failure(self, change: float, step: int, node: int) -> str:
        """Why a load step was not solved; empty where all of them were."""
        if step < 0:
            return ""
        self.residual = max(self.residual, float(change / self.scale.length))
        if node >= 0 and not self.stiffness.separable:
            return f"node {node} lifts off at load step {step}, and the problem has no C"
        if node >= 0:
            cause = "friction above a threshold?"
            return f"no admissible state of node {node} at load step {step} ({cause})"
        return (
            f"load step {step} not converged in {MAX_SWEEPS} sweeps "
            f"(last relative change {change / self.scale.length:.1e})"
        )
