"""Evolution of a joint from a chosen initial state, and what becomes of it."""

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from shakedown.errors import UsageError
from shakedown.evolution.event_history import EventHistory
from shakedown.evolution.integrator import Evolution
from shakedown.evolution.viscous_jump import Jump
from shakedown.files.atomic_write import atomic_write
from shakedown.long_term.find_state import LongTermState, long_term_state
from shakedown.long_term.fixed_steps import CycleLog, History, Stepping
from shakedown.long_term.outcome import Cycles, Outcome
from shakedown.model.arguments import check_arguments, checked_initial_slip
from shakedown.model.problem import FloatArray, Problem
from shakedown.tolerances import DEFAULT, Tolerances

METHODS = ("event", "gauss-seidel")


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
        Slip at the end of a cycle of the long-term state [length].
    drift : (n,)
        Growth of the slip per period [length]; NaN where undecided.
    slip_per_cycle : (n,)
        Σ|Δv| in contact over one period of the long-term state [length]; NaN
        where undecided.
    dissipation_per_cycle
        Frictional dissipation per cycle, averaged over the period [force × length].
    cycles_simulated, events, method
        Effort: cycles, events followed (None at fixed load steps), and the method's name.
    residual
        Largest relative violation of the friction law (:func:`law_violation`).
    cycles
        Slip, dissipation and open nodes of the cycles from the start on. From event
        to event the first cycle includes the transient load steps; with fixed load
        steps these come before it and are not counted.
    history
        The path, where it was asked for: events or load steps.
    jumps
        Discontinuities on the way, each with the energy that it releases.
    long_term
        The evidence for the long-term state; None with fixed load steps.
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
    events: int | None
    method: str
    residual: float
    cycles: Cycles
    history: EventHistory | History | None
    jumps: tuple[Jump, ...]
    long_term: LongTermState | None


def simulate(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    *,
    cycles: int = 1000,
    method: str = "event",
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
        ``"event"``: exact, from event to event, the long-term state in closed form
        (:func:`long_term_state`). ``"gauss-seidel"``: the thesis's fixed load
        steps (§2.3.2, (2.15)), judged by how small the slip has become.
    record
        Keep the path: every event, or every load step.

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
    check_arguments(load_factor, cycles)
    start = checked_initial_slip(problem, initial_slip)
    if method == "event":
        return _from_event_to_event(problem, load_factor, start, cycles, record, tolerances)
    if method == "gauss-seidel":
        return _at_fixed_steps(problem, load_factor, start, cycles, record, tolerances)
    raise UsageError(f"method: expected one of {', '.join(METHODS)}, found '{method}'")


def _from_event_to_event(
    problem: Problem, load_factor: float, start: FloatArray, cycles: int, record: bool, tolerances: Tolerances
) -> Simulation:
    state = long_term_state(problem, load_factor, start, max_cycles=cycles, tolerances=tolerances)
    # The search leaps ahead; for the record the joint is followed from the start once more.
    evolution = Evolution(problem, load_factor, start, tolerances)
    log = CycleLog(start)
    jumps: tuple[Jump, ...] = ()
    for _ in range(min(max(state.cycles_simulated, 1), cycles)):
        done = evolution.cycle(record=record)
        if done is None:
            break
        jumps += done.jumps
        log.append(evolution.state.u[: problem.n].copy(), done.slip, done.dissipation, done.opened)
    return Simulation(
        load_factor=float(load_factor),
        initial_slip=start,
        outcome=state.outcome,
        reason=state.reason,
        period=state.period,
        final_slip=state.final_slip,
        drift=state.drift,
        slip_per_cycle=state.slip_per_cycle,
        dissipation_per_cycle=state.dissipation_per_cycle,
        cycles_simulated=state.cycles_simulated,
        events=state.events,
        method="event",
        residual=state.residual,
        cycles=log.last(len(log.slip)),
        history=evolution.history if record else None,
        jumps=jumps,
        long_term=state,
    )


def _at_fixed_steps(
    problem: Problem, load_factor: float, start: FloatArray, cycles: int, record: bool, tolerances: Tolerances
) -> Simulation:
    stepping = Stepping(problem, load_factor, tolerances, record)
    log, verdict = stepping.run(start, cycles)
    decided = verdict.outcome != Outcome.UNDECIDED
    last = slice(len(log.slip) - verdict.period, None)
    return Simulation(
        load_factor=float(load_factor),
        initial_slip=start,
        outcome=verdict.outcome,
        reason=verdict.reason,
        period=verdict.period,
        final_slip=log.end_slip[-1],
        drift=verdict.drift,
        slip_per_cycle=log.slip[last].sum(axis=0) if decided else np.full(problem.n, np.nan),
        dissipation_per_cycle=float(log.dissipation[last].mean()) if decided else np.nan,
        cycles_simulated=len(log.slip),
        events=None,
        method="gauss-seidel",
        residual=stepping.residual,
        cycles=log,
        history=stepping.history,
        jumps=(),
        long_term=None,
    )


def save_history(path: str | os.PathLike[str], run: Simulation) -> None:
    """Write the recorded path of a simulation to an NPZ file, whole or not at all.

    The file has the arrays of :class:`EventHistory` or of :class:`History`, and
    ``load_factor``, ``initial_slip``.

    Raises
    ------
    UsageError
        If the simulation was not recorded, or the file cannot be written.
    """
    if not isinstance(run, Simulation):
        raise UsageError(f"run: expected a Simulation, found {type(run).__name__}")
    if run.history is None:
        raise UsageError("nothing to write: simulate with record=True")
    arrays = {key: getattr(run.history, key) for key in type(run.history).__annotations__}
    with atomic_write(path) as file:
        np.savez(file, load_factor=run.load_factor, initial_slip=run.initial_slip, **arrays)
