"""What a period of an exact evolution that returns to its start says: outcome, dissipation, friction law."""

from dataclasses import replace

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import cycles_in_words, nodes_in_words
from shakedown.ground.status import Outcome
from shakedown.long_term.state import LongTermState
from shakedown.motion.contact_law import law_violation, reactions
from shakedown.motion.cycle_record import CycleRecord
from shakedown.motion.event_history import EventHistory, EventKind
from shakedown.motion.integrator import Evolution
from shakedown.motion.kernels.contact_status import OPEN


def settled_state(
    evolution: Evolution,
    start: FloatArray,
    records: list[CycleRecord],
    drift: FloatArray,
    contraction: float,
    return_error: float,
    reason: str,
) -> LongTermState:
    """The long-term state of a period that an evolution has just gone through, and recorded.

    It is undecided where the path breaks the friction law by more than the tolerance.

    Parameters
    ----------
    evolution
        At the end of the period; its history is that of the period.
    start : (n,)
        Slip at the very start [length].
    records
        What the cycles of the period did.
    drift : (n,)
        Growth of the slip over the period [length].
    contraction, return_error, reason
        As in :class:`LongTermState`.
    """
    history = evolution.history
    residual = path_violation(evolution, history)
    if residual > evolution.tolerances.friction_law:
        broken = f"the friction law is violated by {residual:.1e} in the period found ({reason})"
        return unsettled_state(evolution, start, broken, residual)
    slip = np.sum([record.slip for record in records], axis=0)
    opened = np.any([record.opened for record in records], axis=0)
    always_open = (history.state == OPEN).all(axis=0)
    near = evolution.tolerances.periodicity * evolution.scale.length
    dissipations = np.array([record.dissipation for record in records])
    return LongTermState(
        problem=evolution.problem,
        load_factor=evolution.load_factor,
        initial_slip=start,
        outcome=_outcome(slip, drift, opened & ~always_open, near),
        reason=reason + _events_in_words(records, opened & ~always_open),
        period=len(records),
        final_slip=evolution.motion.u[evolution.problem.layout.slips].copy(),
        drift=drift,
        slip_per_cycle=slip,
        work_per_cycle=np.sum([record.work for record in records], axis=0) / len(records),
        friction_dissipation_per_cycle=sum(r.friction_dissipation for r in records) / len(records),
        jump_dissipation_per_cycle=sum(r.jump_dissipation for r in records) / len(records),
        jumps_per_cycle=sum(len(r.jumps) for r in records) / len(records),
        open_nodes=tuple(np.flatnonzero(always_open).tolist()),
        cycles_simulated=0,
        residual=residual,
        dissipations=dissipations,
        opened=opened,
        events=0,
        contraction=contraction,
        return_error=return_error / evolution.scale.length,
        history=history,
    )


def _outcome(slip: FloatArray, drift: FloatArray, breathing: np.ndarray, near: float) -> Outcome:
    if slip.max() <= 4 * near:
        return Outcome.SEPARATION if breathing.any() else Outcome.SHAKEDOWN
    return Outcome.RATCHETTING if np.abs(drift).max() > near else Outcome.CYCLIC_SLIP


def _events_in_words(records: list[CycleRecord], breathing: np.ndarray) -> str:
    """Nodes that open and close, and jumps, of a period."""
    every = cycles_in_words(len(records))
    text, jumps = "", sum(len(record.jumps) for record in records)
    if breathing.any():
        text += f"; opening and closing every {every}: {nodes_in_words(np.flatnonzero(breathing))}"
    if jumps:
        text += f"; {jumps} jump{'s' if jumps > 1 else ''} in every {every}"
    return text


def path_violation(evolution: Evolution, history: EventHistory) -> float:
    """Friction law at every event, re-computed from slips and gaps; slip counts from the event before."""
    problem, scale = evolution.problem, evolution.scale
    near = evolution.tolerances.periodicity * scale.length
    open_at_all = (history.w[1:] > near) | (history.w[:-1] > near)
    at_rest = open_at_all | (history.kind[1:] == EventKind.JUMPS)[:, None]
    slip = np.where(at_rest, 0.0, np.diff(history.v, axis=0))
    q, p = reactions(problem, history.q_w, history.p_w, history.v, history.w)
    at_end = law_violation(problem.f, q[1:], p[1:], history.w[1:], slip, scale)
    return float(at_end.max(initial=0.0))


def judged(evolution: Evolution, state: LongTermState, path: EventHistory | None) -> LongTermState:
    """A long-term state, undecided where the path recorded on the way there breaks the friction law."""
    if path is None or state.outcome == Outcome.UNDECIDED:
        return state
    residual = path_violation(evolution, path)
    if residual <= evolution.tolerances.friction_law:
        return replace(state, residual=max(residual, state.residual))
    broken = f"the friction law is violated by {residual:.1e} on the way there ({state.reason})"
    undecided = unsettled_state(evolution, state.initial_slip, broken, residual)
    return replace(undecided, cycles_simulated=state.cycles_simulated, events=state.events)


def unsettled_state(
    evolution: Evolution, start: FloatArray, reason: str, residual: float = np.nan
) -> LongTermState:
    """The answer where there is no periodic state: undecided, or the body has left."""
    n = len(start)
    nan = np.full(n, np.nan)
    return LongTermState(
        problem=evolution.problem,
        load_factor=evolution.load_factor,
        initial_slip=start,
        outcome=Outcome.SEPARATION if evolution.left else Outcome.UNDECIDED,
        reason=reason,
        period=0,
        final_slip=evolution.motion.u[evolution.problem.layout.slips].copy(),
        drift=nan,
        slip_per_cycle=nan,
        work_per_cycle=nan,
        friction_dissipation_per_cycle=np.nan,
        jump_dissipation_per_cycle=np.nan,
        jumps_per_cycle=np.nan,
        open_nodes=tuple(range(n)) if evolution.left else (),
        cycles_simulated=0,
        residual=residual,
        slides_away=evolution.stop is not None and evolution.stop.slides_away,
        dissipations=np.array([]),
        opened=np.full(n, evolution.left),
        events=0,
        contraction=np.nan,
        return_error=np.nan,
        history=evolution.history,
    )
