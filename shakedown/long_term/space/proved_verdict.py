"""The verdict as proofs leave it, in the plane and in space: proofs overrule what a search has found."""

from dataclasses import replace

import numpy as np

from shakedown.bounds.energy.energy_ball import holding_ball
from shakedown.bounds.every_state.universal_bound import universal_bound
from shakedown.ground.constants import SIX_DIGITS, THREE_DIGITS
from shakedown.ground.errors import Missing, allowed
from shakedown.ground.shown_values import short
from shakedown.ground.status import OPEN, Outcome
from shakedown.ground.work_limit import on_one_thread, work_again
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.loading import transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import can_drift
from shakedown.long_term.passage import (
    ABOVE,
    BELOW,
    Passage,
    beyond_all,
    bound_of_all,
    known_limits,
    proof_from_start,
)
from shakedown.long_term.state import VARIES_LITTLE, LongTermState, of_long_term_period
from shakedown.motion.checked_law import scales
from shakedown.motion.method import State

CLEAR = SIX_DIGITS  # relative to the slip per period: no ball holds a cycle that misses its start by less


def overruled_by_proofs(state: LongTermState) -> LongTermState:
    """The state, or shakedown where that is proved of a motion of which a search has found another outcome.

    A cycle that returns to its start and slips is its own proof: no energy ball with margins beyond
    what it misses holds it (docs/energy.md, section 9). All else is held against what is proved from where
    the motion began, from every state, and from where it has got to; the numbers are then those of the cycle
    from there. Before the first cycle is done, the transient may still be to come, and only the start counts.
    """
    stopped = state.stop is not None and not state.stop.spent
    if state.outcome == Outcome.SHAKEDOWN or stopped or _closes(state, CLEAR):
        return state
    begun, has_begun = state.begun, state.cycles_simulated > 0
    if not has_begun and len(transient_path(begun.problem)):
        proof = proof_from_start(begun)
        return _proved_at_rest(state, proof) if proof else state
    if not (state.goal.contact == OPEN).any() and beyond_all(begun):
        return _proved_to_slip(state)
    proof = proof_from_start(begun)
    if not proof and not (state.goal.contact == OPEN).any():
        proof = proof_from_every_state(begun)
    if not proof and has_begun and not _closes(state, THREE_DIGITS):  # of the start, λ_E has told
        proof = proof_by_ball(begun, state.goal)
    return _proved_at_rest(state, proof) if proof else _proved_to_slip(state)


def _proved_to_slip(state: LongTermState) -> LongTermState:
    """The state; an undecided search in space is cyclic slip without drift where λ > λ_max proves it.

    Every cycle in which all nodes are closed slips by so much at least (docs/energy.md, theorem 10), and a
    joint without rigid slips does not drift for ever (theorem 8).
    """
    problem, above = state.begun.problem, np.inf
    if state.outcome == Outcome.UNDECIDED and not (state.goal.contact == OPEN).any():
        above = bound_of_all(problem)
    if not state.load_factor > ABOVE * above:
        return state
    known = f"above λ_max = {short(above)} it cannot come to rest while all nodes stay in contact"
    followed = problem.directions > 1 and VARIES_LITTLE not in state.reason and not state.jumps
    lifts = _every_state(problem)[1] if followed else 0.0
    if not state.load_factor < BELOW * lifts:
        return replace(state, reason=f"{state.reason}; {known}")
    known += f", and below λ = {short(lifts)} no slip opens a node, but in a jump"
    if can_drift(problem):
        return replace(state, reason=f"{state.reason}; it slips in every cycle, and may drift: {known}")
    return _with_last_cycle(
        state,
        Outcome.CYCLIC_SLIP,
        f"proved, {known}; the numbers are those of the last cycle: {state.reason}",
    )


@on_one_thread
def proof_by_ball(begun: Passage, reached: State) -> str:
    """What proves it by an energy ball about the state reached."""
    opened = tuple(np.flatnonzero(reached.contact == OPEN).tolist())
    slip = reached.u[begun.problem.layout.slips]
    ball = allowed(holding_ball, begun.problem, begun.load_factor, slip, opened, begun.tolerances)
    inside = not isinstance(ball, Missing) and bool(ball.contains(slip))
    return "an energy ball holds the state that it has come to" if inside else ""


def _closes(state: LongTermState, errors: float) -> bool:
    """Whether a cycle returns to its start within a given share of its slip."""
    if state.outcome != Outcome.CYCLIC_SLIP:
        return False
    slip = float(state.slip_per_cycle.max())
    missed = state.return_error * scales(state.begun.problem, state.load_factor).length
    return bool(missed <= CLEAR * slip and state.error <= errors * slip)


def _proved_at_rest(state: LongTermState, proof: str) -> LongTermState:
    """Shakedown with the numbers of one cycle from the end of the search."""
    why = f"proved, {proof}; the search has not come to rest: {state.reason}"
    return _with_last_cycle(state, Outcome.SHAKEDOWN, why)


def _with_last_cycle(state: LongTermState, outcome: Outcome, reason: str) -> LongTermState:
    """An outcome with the numbers of one cycle from the end of the search."""
    motion, length = state.motion(), scales(state.begun.problem, state.load_factor).length
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
def proof_from_every_state(begun: Passage) -> str:
    """What proves it from every state in which all nodes are closed, in words; empty where nothing does."""
    known = known_limits(begun.problem)
    every = known["universal"] if "universal" in known else _every_state(begun.problem)[0]
    return f"below λ_U = {short(every)}, from every state" if begun.load_factor < BELOW * every else ""


@once_per_problem
def _every_state(problem: Problem) -> tuple[float, float]:
    """λ_U, and up to which load factor no admissible slip opens a node; 0 where they come to no end."""
    found = allowed(universal_bound, problem)
    return (0.0, 0.0) if isinstance(found, Missing) else (found.load_factor, found.lift_off_bound)
