"""Proofs overrule the findings of a search: no verdict contradicts a bound."""

from dataclasses import replace
from math import inf
from typing import TypeVar

import numpy as np

from shakedown.bounds.energy.ball_watch import BallWatch
from shakedown.bounds.every_state.universal_bound import universal_bound
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.errors import Missing, allowed
from shakedown.ground.round_off import SIX_DIGITS, THREE_DIGITS
from shakedown.ground.shown_values import short
from shakedown.ground.status import OPEN, Outcome
from shakedown.joint.problem import Problem
from shakedown.long_term.energy_proof import further_from_start
from shakedown.long_term.known_bounds import (
    ABOVE,
    BELOW,
    beyond_all,
    bound_of_all,
    bound_of_start,
    bound_proves,
    known_limits,
)
from shakedown.long_term.passage import Passage
from shakedown.long_term.state import LongTermState
from shakedown.motion.checked_law import scales
from shakedown.motion.cycle_record import State

CLEAR = SIX_DIGITS  # relative to the slip per period: no ball holds a cycle that misses its start by less

S = TypeVar("S", bound=LongTermState)


def heeding_proofs(state: S) -> S:
    """The state, or shakedown where that is proved of a motion of which a search has found another outcome.

    A cycle that returns to its start and slips is its own proof: no energy ball with margins beyond
    what it misses holds it (docs/energy.md, section 9). All else is held against what is proved from where
    the motion began, from every state, and from where it has got to; the numbers are then those of the cycle
    from there.
    """
    if state.outcome == Outcome.SHAKEDOWN or state.stop is not None or _closes(state, CLEAR):
        return state
    if not (state.goal.contact == OPEN).any() and beyond_all(state.begun):
        return _slips_on(state)
    proof = proof_of_bounds(state.begun, state.goal)
    if not proof and not _closes(state, THREE_DIGITS):
        proof = proof_by_ball(state.begun, state.goal)
    return _at_rest(state, proof) if proof else _slips_on(state)


def _slips_on(state: S) -> S:
    """The same; of a search without an end it is said where λ_max tells that it cannot come to rest."""
    if state.outcome != Outcome.UNDECIDED or (state.goal.contact == OPEN).any():
        return state
    above = bound_of_all(state.begun.problem)
    if not state.load_factor > ABOVE * above:
        return state
    known = f"above λ_max = {short(above)} it cannot come to rest while all nodes stay in contact"
    return replace(state, reason=f"{state.reason}; {known}")


@on_one_thread
def proof_of_bounds(begun: Passage, reached: State) -> str:
    """What proves that a motion shakes down, by the load factor, in words; empty where nothing does.

    Parameters
    ----------
    begun
        Where it began.
    reached
        A state between two of its cycles.
    """
    load_factor, bound = begun.load_factor, bound_of_start(begun)
    if bound_proves(bound, load_factor):
        return f"below λ_E = {short(bound.load_factor)} of its start"
    if further_from_start(begun) < inf:
        return "below λ_S of its start"
    if not (reached.contact == OPEN).any():
        every = _bound_of_every_state(begun.problem)
        if load_factor < BELOW * every:
            return f"below λ_U = {short(every)}, from every state"
    return ""


@on_one_thread
def proof_by_ball(begun: Passage, reached: State) -> str:
    """What proves it by an energy ball about the state reached."""
    opened = tuple(np.flatnonzero(reached.contact == OPEN).tolist())
    watch = BallWatch(begun.problem, begun.load_factor, opened, tolerances=begun.tolerances)
    inside = allowed(watch.proves, reached.u[begun.problem.layout.slips])
    return "an energy ball holds the state that it has come to" if inside else ""


def _bound_of_every_state(problem: Problem) -> float:
    """λ_U, computed once; 0 where it does not finish."""
    known = known_limits(problem)
    if "universal" not in known:
        found = allowed(universal_bound, problem, certify=False)
        known["universal"] = 0.0 if isinstance(found, Missing) else found.load_factor
    return known["universal"]


def _closes(state: LongTermState, errors: float) -> bool:
    """Whether a cycle returns to its start within a given share of its slip."""
    if state.outcome != Outcome.CYCLIC_SLIP:
        return False
    slip = float(state.slip_per_cycle.max())
    missed = state.return_error * scales(state.begun.problem, state.load_factor).length
    return bool(missed <= CLEAR * slip and getattr(state, "error", 0.0) <= errors * slip)


def _at_rest(state: S, proof: str) -> S:
    """Shakedown with the numbers of one cycle from the end of the search."""
    motion, length = state.motion(), scales(state.begun.problem, state.load_factor).length
    record = motion.cycle()
    if record is None:
        return state
    return replace(
        state,
        outcome=Outcome.SHAKEDOWN,
        reason=f"proved, {proof}; the search has not come to rest: {state.reason}",
        period=1,
        final_slip=record.end_slip,
        drift=np.zeros_like(record.end_slip),
        slip_per_cycle=record.slip,
        friction_dissipation_per_cycle=record.friction_dissipation,
        jump_dissipation_per_cycle=record.jump_dissipation,
        jumps_per_cycle=float(len(record.jumps)),
        open_nodes=tuple(np.flatnonzero(record.opened & ~record.closed).tolist()),
        dissipations=np.array([record.dissipation]),
        opened=record.opened,
        return_error=float(np.abs(motion.state.u - state.goal.u).max()) / length,
        cycles_simulated=state.cycles_simulated - state.period + 1,
        signature=record.signature,
        met=np.nan,
    )
