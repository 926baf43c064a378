"""A joint followed at fixed load steps, by the thesis's Gauss–Seidel, in the plane and in space."""

from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import OPEN, SLIP
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import require_problem
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import free_stiffness
from shakedown.motion.checked_law import Scales, reactions
from shakedown.motion.event_history import EventHistory, EventKind
from shakedown.motion.gauss_seidel import MOST_SWEEPS, contact_nodes, load_steps, places_by_node
from shakedown.motion.method import SLIDES_AWAY, Beginning, CycleRecord, Motion, State, Stop

REMEMBERED = 2  # cycles whose load steps are kept, whether recorded or not
WANDERING = 50  # sweeps that show whether a body that found no rest keeps moving


class LoadSteps(NamedTuple):
    """The states after load steps, slip in contact (k, dn), and its length (k, n) [length], during each."""

    path: EventHistory
    slip: FloatArray
    length: FloatArray


class FixedSteps(Motion):
    """A joint under its loading loop, carried from load step to load step.

    Transient load steps, where the problem has them, come first and are no cycle. An initial slip that the
    law does not allow under the first load of all becomes one that it does.

    Parameters
    ----------
    problem, load_factor, initial_slip, tolerances, open_nodes
        As for :func:`evolve`.

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> motion = FixedSteps(shakedown.example("two-node"), 0.9)
    >>> first, second = motion.cycle(), motion.cycle()
    >>> second.slip.round(6)
    array([0.      , 1.893552])

    A load of constant size goes around, f p = 0.6, A = 1: the slip goes around a circle of radius 0.8.

    >>> t = 2 * np.pi * np.arange(1, 1201)[:, None] / 1200
    >>> q_w = np.hstack([np.cos(t), np.sin(t)])
    >>> node = shakedown.Problem(A=np.eye(2), B=np.zeros((1, 2)), f=0.3, q_w=q_w, p_w=np.full((1200, 1), 2.0))
    >>> motion = FixedSteps(node, 1.0)
    >>> first, second = motion.cycle(), motion.cycle()
    >>> (second.slip / (2 * np.pi)).round(3), round(second.dissipation / (2 * np.pi), 3)
    (array([0.798]), 0.479)
    """

    def __init__(
        self,
        problem: Problem,
        load_factor: float,
        initial_slip: ArrayLike | None = None,
        tolerances: Tolerances = DEFAULT,
        open_nodes: Iterable[int] = (),
    ) -> None:
        require_problem(problem)
        self.problem, self.tolerances = problem, tolerances
        self.u, self.contact = problem.layout.zeros(), np.zeros(problem.n, dtype=np.int64)
        self.begin(load_factor, initial_slip, open_nodes)

    def _begin(self, start: Beginning, transient: FloatArray) -> None:
        problem, layout = self.problem, self.problem.layout
        self.residual = 0.0  # largest relative violation of the friction law so far
        self.recent: deque[LoadSteps] = deque(maxlen=REMEMBERED)
        kappa, separable = free_stiffness(problem), problem.C is not None
        self._at = places_by_node(layout)
        self._nodes = contact_nodes(layout, kappa, problem.f, separable, self.scale.force)
        self.state = start.state
        self.start = self.u[layout.slips].copy()
        if len(transient):
            self.pieces.append(self._advance(transient, -len(transient)).path)

    def _set_state(self, state: State) -> None:
        self.u[:], self.contact[:] = state.u, state.contact

    @property
    def history(self) -> EventHistory:
        """The states after all recorded load steps; nothing is known of what is between them."""
        return EventHistory.joined(self.pieces or [EventHistory.none(self.problem.layout)])

    def last(self, cycles: int) -> tuple[EventHistory, FloatArray]:
        """The load steps of the last cycles, at most ``REMEMBERED``, and the slip in contact during each.

        In space its length.
        """
        chosen = list(self.recent)[max(len(self.recent) - cycles, 0) :]
        slips = [steps.slip if self.problem.directions == 1 else steps.length for steps in chosen]
        if not chosen:
            return EventHistory.none(self.problem.layout), np.zeros((0, self.problem.n))
        return EventHistory.joined([steps.path for steps in chosen]), np.concatenate(slips)

    def _follow(self, cycles: int, record: bool) -> bool:
        self._steps = self._advance(self.load, 0)
        if record:
            self.pieces.append(self._steps.path)
        if self.stop is not None:
            return False
        self.done += 1
        self.recent.append(self._steps)
        return True

    def _what_it_did(self) -> CycleRecord:
        (path, slip, length), layout = self._steps, self.problem.layout
        work, gap = -(layout.by_node(path.q) * layout.by_node(slip)).sum(axis=(0, 2)), path.w > 0
        return CycleRecord(
            end_slip=self.u[layout.slips].copy(),
            slip=length.sum(axis=0),
            work=work,
            friction_dissipation=float(work.sum()),
            jump_dissipation=0.0,
            opened=np.asarray(gap.any(axis=0)),
            closed=~np.asarray(gap.all(axis=0)),
            events=0,
            signature=0,
            jumps=(),
        )

    def _advance(self, loads: FloatArray, first: int) -> LoadSteps:
        """Solve load steps (k, (d + 1) n), the last perhaps in vain, and check the law on those before."""
        layout, at, u = self.problem.layout, self._at, self.u[self._at]
        slips, found = np.empty((len(loads), layout.slip_size)), np.empty_like(loads)
        tolerance, given = self.tolerances.convergence * self.scale.length, loads[:, at].copy()
        _, change, failed, node = load_steps(self._nodes, given, u, tolerance, MOST_SWEEPS, found, slips)
        k = len(loads) if failed < 0 else failed + 1
        states, slip = np.empty_like(found[:k]), slips[:k]
        self.u[at], states[:, at] = u, found[:k]
        steps = self._steps_of(states, slip, loads[:k], first)
        self.contact[:] = steps.path.state[-1]
        good = steps.path.rows(np.arange(k if failed < 0 else failed))
        missed = projection_error(self.problem, good, slip[: len(good)], self.scale)
        self.residual = max(self.residual, missed)
        reason, slides_away = "", False
        if failed >= 0:
            self.residual = max(self.residual, change / self.scale.length)
            slides_away = node < 0 and self._slides_away(given[failed:k], u)
            lifts = node >= 0 and not self._nodes.separable and steps.path.p[-1, node] < 0.0
            reason = self._failure(f"load step {first + failed}", node, change, lifts, slides_away)
        elif missed > self.tolerances.friction_law:
            reason = f"the friction law is violated by {missed:.1e} after converged load steps"
        if reason:
            when = self.done + (first + k - 1) / self.problem.m
            self.stop = Stop(reason, when, node, slides_away)
        return steps

    def _steps_of(self, u: FloatArray, slip: FloatArray, loads: FloatArray, first: int) -> LoadSteps:
        """The load steps with these states and slips in contact, the first of them with this number."""
        k, problem, split = len(loads), self.problem, self.problem.layout.split
        (v, w), (q_w, p_w), length = split(u), split(loads), problem.law.size(slip)
        q, p = reactions(problem, q_w, p_w, v, w)
        moving = -np.sign(slip) if problem.directions == 1 else SLIP * (length > 0)
        path = EventHistory(
            cycle=self.done + (first + np.arange(k)) / problem.m,
            kind=np.full(k, EventKind.LOAD_STEP, dtype=np.int64),
            node=np.full(k, -1),
            v=v, w=w, q=q, p=p, q_w=q_w, p_w=p_w,
            state=np.where(w > 0, OPEN, moving.astype(np.int64)),
        )  # fmt: skip
        return LoadSteps(path, slip, length)

    def _failure(self, where: str, node: int, change: float, lifts: bool, slides_away: bool) -> str:
        """Why a load step was not solved."""
        if lifts:
            return f"node {node} lifts off at {where}, and the problem has no C"
        if node >= 0:
            return f"no admissible state of node {node} at {where} (friction above a threshold?)"
        if slides_away:
            return f"{SLIDES_AWAY} at {where}"
        last = change / self.scale.length
        return f"{where} not converged in {MOST_SWEEPS} sweeps (last relative change {last:.1e})"

    def _slides_away(self, load: FloatArray, u: FloatArray) -> bool:
        """Whether the displacement of some more sweeps goes on, and nothing holds it."""
        before, kappa, stiffest = u.copy(), self._nodes.kappa, np.abs(np.diag(self._nodes.kappa)).max()
        load_steps(self._nodes, load, u, 0.0, WANDERING, np.empty_like(load), np.empty((1, len(u))))
        way = u - before
        held = way @ kappa @ way > self.tolerances.zero_mode * stiffest * (way @ way)
        return bool(stiffest * np.abs(way).max() > self.scale.force and not held)


def projection_error(problem: Problem, path: EventHistory, slip: FloatArray, scale: Scales) -> float:
    """The relative violation by states (k, …) of the law of a load step with slips in contact (k, dn).

    The departure of the reactions from their projections on what the law allows, q from the limits at
    q − slip and p from max(p − w, 0), forces and lengths relative to the scales. Where a node slips by
    ever less it loses its direction and not its meaning, other than that of q + f p slip/|slip|.
    """
    q, p = path.q / scale.force, path.p / scale.force
    pressed = np.maximum(p - path.w / scale.length, 0.0)
    apart = q - problem.law.projection(q - slip / scale.length, pressed)
    return max(float(np.abs(apart).max(initial=0.0)), float(np.abs(p - pressed).max(initial=0.0)))
