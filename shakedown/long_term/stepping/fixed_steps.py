"""Time integration at fixed load steps, cycle by cycle, by the thesis's Gauss–Seidel."""

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.stepping.cycle_log import CycleLog, Cycles
from shakedown.long_term.stepping.verdict import LONGEST_PERIOD, WINDOW, Verdict, judge
from shakedown.motion.contact_law import law_violation, reactions, scales
from shakedown.motion.kernels.gauss_seidel import Stiffness, load_steps

MAX_SWEEPS = 10_000


@dataclass(frozen=True, eq=False, repr=False)
class History(Result):
    """States after every load step, s of them in all.

    Attributes
    ----------
    cycle : (s,)
        Time in cycles; the transient, where there is one, has negative times.
    v, w : (s, n)
        Slips and gaps [length].
    q, p : (s, n)
        Reactions [force].
    slip : (s, n)
        Slip in contact during the step [length].
    """

    cycle: FloatArray
    v: FloatArray
    w: FloatArray
    q: FloatArray
    p: FloatArray
    slip: FloatArray


class Stepping:
    """One simulation with fixed load steps: the state, and the record of what has happened."""

    def __init__(self, problem: Problem, load_factor: float, tolerances: Tolerances, record: bool) -> None:
        self.problem, self.load_factor, self.tolerances = problem, load_factor, tolerances
        self.scale = scales(problem, load_factor)
        self.loop = loading(problem).at(load_factor)
        n = problem.n
        C = np.zeros((n, n)) if problem.C is None else problem.C
        tension = 16 * np.finfo(float).eps * self.scale.force
        self.stiffness = Stiffness(problem.A, problem.B, C, problem.f, problem.C is not None, tension)
        self.v, self.w = np.zeros(n), np.zeros(n)
        self.residual = 0.0
        self.pieces: list[History] | None = [] if record else None
        self.recent: deque[History] = deque(maxlen=LONGEST_PERIOD)  # the last cycles

    def run(self, start: FloatArray, cycles: int) -> tuple[Cycles, Verdict]:
        """Cycle from slips and gaps (2n,) until the outcome is clear, at most ``cycles`` times."""
        self.v[:], self.w[:] = np.split(start, 2)
        threshold = self.tolerances.steadiness * self.scale.length
        before, failure, verdict = transient_path(self.problem), "", None
        if len(before):
            q_before, p_before = (np.ascontiguousarray(part) for part in np.hsplit(before, 2))
            _, failure = self._advance(q_before, p_before, None)
        log = CycleLog(self.v.copy())
        always_open: list[NDArray[np.bool_]] = []
        while not failure and verdict is None and len(log.slip) < cycles:
            piece, failure = self._advance(*self.loop, len(log.slip))
            self.recent.append(piece)
            slip, work = np.abs(piece.slip).sum(axis=0), float(-(piece.q * piece.slip).sum())
            gap = piece.w > 0
            log.append(self.v.copy(), slip, work, np.asarray(gap.any(axis=0)))
            always_open = [*always_open[1 - WINDOW :], np.asarray(gap.all(axis=0))]
            verdict = judge(log.last(WINDOW), np.array(always_open), threshold)
        if failure or verdict is None:
            reason = failure or f"no steady state within {cycles} cycles"
            verdict = Verdict(Outcome.UNDECIDED, 0, np.full(self.problem.n, np.nan), reason)
        return log.last(len(log.slip)), verdict

    def _advance(self, q_w: FloatArray, p_w: FloatArray, cycle: int | None) -> tuple[History, str]:
        """Solve load steps, re-check the law on them; says what failed, if anything did."""
        v, w, slip = (np.zeros_like(q_w) for _ in range(3))
        tolerance = self.tolerances.convergence * self.scale.length
        _, change, step, node = load_steps(
            self.stiffness, q_w, p_w, self.v, self.w, tolerance, MAX_SWEEPS, v, w, slip
        )
        q, p = reactions(self.problem, q_w, p_w, v, w)
        m = len(q_w)
        time = (np.arange(m) - m) / self.problem.m if cycle is None else cycle + np.arange(m) / m
        piece = History(time, v, w, q, p, slip)
        if self.pieces is not None:
            self.pieces.append(piece)
        if step < 0:
            violation = float(law_violation(self.problem.f, q, p, w, slip, self.scale).max())
            self.residual = max(self.residual, violation)
            if violation <= self.tolerances.friction_law:
                return piece, ""
            return piece, f"the friction law is violated by {violation:.1e} after converged load steps"
        self.residual = max(self.residual, float(change / self.scale.length))
        if node >= 0 and not self.stiffness.separable:
            return piece, f"node {node} lifts off at load step {step}, and the problem has no C"
        if node >= 0:
            cause = "friction above a threshold?"
            return piece, f"no admissible state of node {node} at load step {step} ({cause})"
        return piece, (
            f"load step {step} not converged in {MAX_SWEEPS} sweeps "
            f"(last relative change {change / self.scale.length:.1e})"
        )

    def last(self, cycles: int) -> History:
        """Every load step of the last cycles, at most the longest period."""
        n = self.problem.n
        none = History(np.zeros(0), *(np.zeros((0, n)) for _ in range(5)))
        return _joined([none, *list(self.recent)[len(self.recent) - cycles :]])

    @property
    def history(self) -> History | None:
        """Every load step so far, where they were recorded."""
        return None if self.pieces is None else _joined(self.pieces)


def _joined(pieces: list[History]) -> History:
    return History(
        *(np.concatenate([getattr(piece, key) for piece in pieces]) for key in History.__annotations__)
    )
