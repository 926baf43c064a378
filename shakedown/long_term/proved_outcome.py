"""Verdicts of the search for a long-term state, in the plane or in space, held against proofs."""

from dataclasses import replace
from math import inf

import numpy as np

from shakedown.bounds.energy.energy_ball import no_ball_holds
from shakedown.bounds.every_state.universal_bound import universal_bound
from shakedown.ground.constants import SIX_DIGITS, THREE_DIGITS
from shakedown.ground.errors import attempt_any
from shakedown.ground.shown_values import short
from shakedown.ground.status import OPEN, Outcome
from shakedown.ground.work_limit import on_one_thread, work_again
from shakedown.joint.constraints import transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import can_drift
from shakedown.long_term import motion_start
from shakedown.long_term.motion_start import SURELY_ABOVE, SURELY_BELOW, MotionStart
from shakedown.long_term.state import VARIES_LITTLE, LongTermState, ball_about, of_long_term_period
from shakedown.motion.checked_law import scales

# Relative to the slip per period: no ball holds a cycle that misses its start by less.
RETURN_TOLERANCE = SIX_DIGITS


def overruled_by_proofs(state: LongTermState) -> LongTermState:
    """The state, or shakedown where that is proved of a motion of which a search has found another outcome.

    A cycle that returns to its start and slips is its own proof: no energy ball with margins beyond
    what it misses holds it (docs/energy.md, Theorem 9). All else is held against what is proved from where
    the motion began, from every state, and from where it has got to; the numbers are then those of the cycle
    from there. Before the first cycle is done, the transient may still be to come, and only the start counts.
    """
    stopped = state.stop is not None and not state.stop.spent
    if state.outcome == Outcome.SHAKEDOWN or stopped or _closes(state, RETURN_TOLERANCE):
        return state
    origin, goal, has_begun = state.origin, state.goal, state.cycles_simulated > 0
    problem, opened = origin.problem, tuple(np.flatnonzero(goal.contact == OPEN).tolist())
    of_start_only = not has_begun and len(transient_path(problem)) > 0
    if not of_start_only and not opened and motion_start.above_lambda_max(origin):
        return _proved_to_slip(state)
    proof, slip = proof_from_start(origin), goal.u[problem.layout.slips]
    if not proof and not opened and not of_start_only:
        proof = proof_from_every_state(origin)
    here = not proof and has_begun and not _closes(state, THREE_DIGITS)  # at the start λ_E has decided
    asked = problem, origin.load_factor, slip, opened, origin.tolerances
    if here and not attempt_any(no_ball_holds, *asked, transient=False) and ball_about(origin, slip, opened):
        proof = "an energy ball holds the state that it has come to"
    if not proof:
        return state if of_start_only else _proved_to_slip(state)
    why = f"proved, {proof}; the search has not come to rest: {state.reason}"
    return _with_last_cycle(state, Outcome.SHAKEDOWN, why)


def _proved_to_slip(state: LongTermState) -> LongTermState:
    """The state; an undecided search in space is cyclic slip without drift where λ > λ_max proves it.

    Every cycle in which all nodes are closed slips by so much at least (docs/energy.md, Theorem 10), and a
    joint without rigid slips does not drift for ever (Theorem 8).
    """
    problem, above = state.origin.problem, inf
    if state.outcome == Outcome.UNDECIDED and not (state.goal.contact == OPEN).any():
        above = motion_start.lambda_max(problem)
    if not state.load_factor > SURELY_ABOVE * above:
        return state
    known = f"above λ_max = {short(above)} it cannot come to rest while all nodes stay in contact"
    followed = problem.directions > 1 and VARIES_LITTLE not in state.reason and not state.jumps
    lifts = _every_state(problem)[1] if followed else 0.0
    if not state.load_factor < SURELY_BELOW * lifts:
        return replace(state, reason=f"{state.reason}; {known}")
    known += f", and below λ = {short(lifts)} no slip opens a node, but in a jump"
    if can_drift(problem):
        return replace(state, reason=f"{state.reason}; it slips in every cycle, and may drift: {known}")
    why = f"proved, {known}; the numbers are those of the last cycle: {state.reason}"
    return _with_last_cycle(state, Outcome.CYCLIC_SLIP, why)


def _closes(state: LongTermState, errors: float) -> bool:
    """Whether a cycle returns to its start within a given share of its slip."""
    if state.outcome != Outcome.CYCLIC_SLIP:
        return False
    slip = float(state.slip_per_cycle.max())
    missed = state.return_error * scales(state.origin.problem, state.load_factor).length
    return bool(missed <= RETURN_TOLERANCE * slip and state.error <= errors * slip)


def _with_last_cycle(state: LongTermState, outcome: Outcome, reason: str) -> LongTermState:
    """An outcome with the numbers of one cycle from the end of the search."""
    motion, length = state.motion(), scales(state.origin.problem, state.load_factor).length
    with work_again():
        record = motion.cycle()
    if record is None:
        return state
    return replace(
        state,
        outcome=outcome,
        reason=reason,
        final_slip=record.end_slip,
        drift=np.zeros_like(record.end_slip),
        return_error=float(np.abs(motion.state.u - state.goal.u).max()) / length,
        cycles_simulated=state.cycles_simulated - state.period + 1,
        met=np.nan,
        **of_long_term_period([record], state.problem.n),
    )


@on_one_thread
def proof_from_every_state(origin: MotionStart) -> str:
    """What proves it from every state in which all nodes are closed, in words; empty where nothing does."""
    every, _ = _every_state(origin.problem)
    proved = origin.load_factor < SURELY_BELOW * every
    return f"below λ_U = {short(every)}, from every state" if proved else ""


def _every_state(problem: Problem) -> tuple[float, float]:
    """λ_U, and up to which load factor no admissible slip opens a node; 0 where they come to no end."""
    found = motion_start.known_limit(problem, "universal", universal_bound)
    return (0.0, 0.0) if found is None else (found.load_factor, found.lift_off_bound)


@on_one_thread
def proof_from_start(origin: MotionStart) -> str:
    """What proves that a motion shakes down from its start, in words; empty where nothing does."""
    bound = motion_start.proving_bound(origin)
    if bound is not None:
        return f"below λ_E = {short(bound.load_factor)} of its start"
    return "below λ_S of its start" if motion_start.total_slip_from_start(origin) < inf else ""
