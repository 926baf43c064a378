"""Time integration of a joint from a chosen initial state, cycle by cycle."""

import os
import pathlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from shakedown.contact_law import law_violation, reactions, scales
from shakedown.errors import UsageError
from shakedown.gauss_seidel import Stiffness, load_steps
from shakedown.loading import loading
from shakedown.npz import atomic_write
from shakedown.outcome import WINDOW, Cycles, Outcome, Verdict, judge
from shakedown.problem import FloatArray, Problem
from shakedown.tolerances import DEFAULT, Tolerances

MAX_SWEEPS = 10_000


@dataclass(frozen=True)
class History:
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


@dataclass(frozen=True)
class Simulation:
    """Result of :func:`simulate`.

    Attributes
    ----------
    load_factor
        Load factor λ of the simulated loop.
    initial_slip : (n,)
        Slip at the start [length].
    outcome, reason
        Long-term state, and in words what it rests on.
    period
        Cycles after which the state repeats; 0 where undecided.
    final_slip : (n,)
        Slip at the end of the last cycle [length].
    drift : (n,)
        Growth of the slip per period [length]; NaN where undecided.
    slip_per_cycle : (n,)
        Σ|Δv| in contact over one period of the long-term state [length]; the
        last cycle's where undecided.
    dissipation_per_cycle
        Frictional dissipation per cycle, averaged over the period [force × length].
    cycles_simulated, method, events
        Effort: cycles, the method's name, events (None for fixed load steps).
    residual
        Largest relative violation of the friction law over all steps (:func:`law_violation`).
    cycles
        Slip, dissipation and open nodes of every cycle.
    history
        Every load step, where it was asked for.
    """

    load_factor: float
    initial_slip: FloatArray
    outcome: Outcome
    reason: str
    period: int
    final_slip: FloatArray
    drift: FloatArray
    slip_per_cycle: FloatArray
    dissipation_per_cycle: float
    cycles_simulated: int
    method: str
    events: int | None
    residual: float
    cycles: Cycles
    history: History | None


def simulate(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    *,
    cycles: int = 1000,
    method: str = "gauss-seidel",
    record: bool = False,
    tolerances: Tolerances = DEFAULT,
) -> Simulation:
    """Follow a joint through its transient and then cycle by cycle until the outcome is clear.

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0, multiplies the periodic part of the loading.
    initial_slip : (n,), optional
        Slip at the start, all nodes closed [length]; zero by default.
    cycles
        Give up after so many cycles, with the outcome "undecided".
    method
        ``"gauss-seidel"``: the thesis's fixed load steps (§2.3.2, (2.15)).
    record
        Keep the state after every load step.

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import shakedown
    >>> run = shakedown.simulate(shakedown.example("two-node"), 0.6, [0.0, 0.0])
    >>> run.outcome.value, bool(run.residual < 1e-12)
    ('shakedown', True)
    """
    start = checked_initial_slip(problem, initial_slip)
    if not (np.isfinite(load_factor) and load_factor >= 0):
        raise UsageError(f"load factor: expected a number >= 0, found {load_factor}")
    if cycles < 1:
        raise UsageError(f"cycles: expected at least 1, found {cycles}")
    if method != "gauss-seidel":
        raise UsageError(f"method: expected 'gauss-seidel', found '{method}'")
    return _Stepping(problem, load_factor, tolerances, record).run(start, cycles)


def checked_initial_slip(problem: Problem, initial_slip: ArrayLike | None) -> FloatArray:
    """An initial slip as a private array (n,), zero by default; raises ``UsageError`` if mis-shaped."""
    slip = np.zeros(problem.n) if initial_slip is None else np.array(initial_slip, dtype=float)
    if slip.shape != (problem.n,):
        raise UsageError(f"initial slip: expected shape ({problem.n},), found {slip.shape}")
    if not np.isfinite(slip).all():
        raise UsageError(f"initial slip: expected finite numbers, found {slip[~np.isfinite(slip)][0]}")
    return slip


class _Stepping:
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

    def run(self, start: FloatArray, cycles: int) -> Simulation:
        self.v[:] = start
        threshold = self.tolerances.steadiness * self.scale.length
        q_transient, p_transient = self.problem.q_transient, self.problem.p_transient
        failure, verdict = "", None
        if q_transient is not None and p_transient is not None and len(q_transient):
            _, failure = self._advance(q_transient, p_transient, None)
        log = _CycleLog(self.v.copy())
        while not failure and verdict is None and len(log.slip) < cycles:
            piece, failure = self._advance(*self.loop, len(log.slip))
            log.append(piece)
            verdict = judge(log.last(WINDOW), threshold)
        if failure or verdict is None:
            reason = failure or f"no steady state within {cycles} cycles"
            verdict = Verdict(Outcome.UNDECIDED, 0, np.full(self.problem.n, np.nan), reason)
        return self._result(start, log.last(len(log.slip)), verdict)

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

    def _result(self, start: FloatArray, record: Cycles, verdict: Verdict) -> Simulation:
        last = slice(len(record.slip) - max(verdict.period, 1), None) if len(record.slip) else slice(0)
        slip = record.slip[last]
        return Simulation(
            load_factor=self.load_factor,
            initial_slip=start,
            outcome=verdict.outcome,
            reason=verdict.reason,
            period=verdict.period,
            final_slip=record.end_slip[-1],
            drift=verdict.drift,
            slip_per_cycle=slip.sum(axis=0) if len(slip) else np.full(self.problem.n, np.nan),
            dissipation_per_cycle=float(record.dissipation[last].mean()) if len(slip) else np.nan,
            cycles_simulated=len(record.slip),
            method="gauss-seidel",
            events=None,
            residual=self.residual,
            cycles=record,
            history=None if self.pieces is None else _joined(self.pieces),
        )


class _CycleLog:
    """What each cycle did, as growing lists."""

    def __init__(self, start: FloatArray) -> None:
        self.end_slip = [start]
        self.slip: list[FloatArray] = []
        self.dissipation: list[float] = []
        self.open_nodes: list[Any] = []

    def append(self, piece: History) -> None:
        self.end_slip.append(piece.v[-1].copy())
        self.slip.append(np.abs(piece.slip).sum(axis=0))
        self.dissipation.append(float(-(piece.q * piece.slip).sum()))
        self.open_nodes.append((piece.w > 0).any(axis=0))

    def last(self, count: int) -> Cycles:
        """The last ``count`` cycles, or as many as there are."""
        count = min(count, len(self.slip))
        shape, first = (count, len(self.end_slip[0])), len(self.slip) - count
        return Cycles(
            end_slip=np.array(self.end_slip[first:]),
            slip=np.reshape(self.slip[first:], shape),
            dissipation=np.array(self.dissipation[first:]),
            open_nodes=np.reshape(self.open_nodes[first:], shape).astype(bool),
        )


def _joined(pieces: list[History]) -> History:
    return History(
        *(np.concatenate([getattr(piece, key) for piece in pieces]) for key in History.__annotations__)
    )


def save_history(path: str | os.PathLike[str], run: Simulation) -> None:
    """Write every recorded load step of a simulation to an NPZ file, whole or not at all.

    The file has the arrays of :class:`History` and ``load_factor``, ``initial_slip``.

    Raises
    ------
    UsageError
        If the simulation was not recorded, or the file cannot be written.
    """
    if run.history is None:
        raise UsageError("nothing to write: simulate with record=True")
    arrays = {key: getattr(run.history, key) for key in History.__annotations__}
    try:
        with atomic_write(pathlib.Path(path)) as file:
            np.savez(file, load_factor=run.load_factor, initial_slip=run.initial_slip, **arrays)
    except OSError as error:
        raise UsageError(f"{os.fspath(path)}: cannot be written ({error.strerror})") from None
