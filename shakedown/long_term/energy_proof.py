"""A verdict with proof: has the motion entered an energy ball, or is the slip to come bounded?"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, log, nan
from typing import NamedTuple

import numpy as np

from shakedown.bounds.accumulated.accumulated_bound import total_slip_bound
from shakedown.bounds.energy.energy_ball import EnergyBall, energy_ball, holding_ball
from shakedown.bounds.plane_or_space import holding_ball_sooner, takes_long
from shakedown.bounds.registry import BOUNDS
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.errors import Missing, UsageError, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.joint.derived import once_per_problem
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.known_bounds import (
    is_known,
    note_slip_unbounded,
    proving_bound,
    slip_unbounded_from,
)
from shakedown.long_term.passage import Approach, Passage
from shakedown.motion.checked_law import path_resolution, scales

MOST = 256  # largest number of cycles after which a state is examined, doubling from 1


class SlipProof(NamedTuple):
    """The state of a motion from which on the total slip is bounded.

    Attributes
    ----------
    cycles
        After how many cycles the motion is in that state; 0 at its start.
    further
        The bound on the total slip of any node from then on [length].
    """

    cycles: int
    further: float


def slip_proof(passage: Passage, approach: Approach) -> SlipProof | None:
    """The proof by accumulated slip (docs/accumulated.md), of all nodes closed; None where none is found.

    The start is asked about, then the state at rest. Where that one proves nothing, states near it hardly
    do; where it does, the states after 1, 2, 4, … cycles are asked about, with the error of their path.
    """
    further = further_from_start(passage)
    if further < inf:
        return SlipProof(0, further)
    loop = _after_transient(passage.problem)
    if approach.open_nodes or not _further(loop, passage.load_factor, approach.final_slip, 0.0) < inf:
        return None
    known = path_resolution(loop, passage.tolerances) * scales(loop, passage.load_factor).length
    for state in passage.passed(approach.first_cycles, min(approach.most, MOST)):
        if state.cycles > MOST:
            break
        if state.open_nodes or state.cycles & (state.cycles - 1):
            continue
        further = _further(loop, passage.load_factor, state.slip, known + state.error)
        if further < inf:
            return SlipProof(state.cycles, further)
    return None


def further_from_start(passage: Passage) -> float:
    """The bound on the total slip of any node from the start; inf where it is not known.

    At λ = 0 it is asked for first, as where there is none there it is told soonest.
    """
    further = inf
    if passage.open_nodes or passage.load_factor >= slip_unbounded_from(passage):
        return further
    for load_factor in (0.0, passage.load_factor):
        further = _further(passage.problem, load_factor, passage.start, 0.0)
        if further == inf:
            note_slip_unbounded(passage, load_factor)
            break
    return further


def _further(problem: Problem, load_factor: float, slip: FloatArray, error: float) -> float:
    """The bound on the total slip of any node from a closed state known to an error; inf where unknown."""
    found = total_slip_bound(problem, load_factor, slip, start_error=error)
    return float(found.total_slip.max()) if found.status == Status.OPTIMAL else inf


@once_per_problem
def _after_transient(problem: Problem) -> Problem:
    """The joint in its loop."""
    if problem.q_transient is None:
        return problem
    return replace(problem, q_transient=None, p_transient=None)


@dataclass(frozen=True, eq=False, repr=False)
class EnergyProof(Result):
    """Whether shakedown is proved, and how far the final state may be off, as in :class:`LongTermState`.

    Attributes
    ----------
    proved
        Whether it is.
    margin, single_node_margin
        NaN where no ball proves it; the other proofs have no margin.
    best
        Whether these are the margins of the best ball found.
    cycles
        After how many cycles the motion is in the state that proves it; None where nothing does.
    by
        What proves it: ``"λ_E"`` (a ball, or the bound of its start) or ``"λ_S"``; empty where
        that differs from one uncoupled part to another.
    further
        With ``"λ_S"`` the bound on the total slip of any node from then on [length].
    """

    proved: bool
    margin: float = nan
    single_node_margin: float = nan
    best: bool = True
    cycles: int | None = None
    by: str = ""
    further: float = nan


NO_PROOF = EnergyProof(False)
ENERGY, SLIP = BOUNDS["energy"].symbol, BOUNDS["accumulated"].symbol


def proof_of_parts(proofs: Sequence[EnergyProof]) -> EnergyProof:
    """The proof of a joint in uncoupled parts from that of each: a product of balls, …"""
    if not all(proof.proved for proof in proofs):
        return NO_PROOF
    by = {proof.by for proof in proofs}
    return EnergyProof(
        proved=True,
        margin=float(np.min([proof.margin for proof in proofs])),
        single_node_margin=float(np.min([proof.single_node_margin for proof in proofs])),
        best=all(proof.best for proof in proofs),
        cycles=max(proof.cycles or 0 for proof in proofs),
        by=by.pop() if len(by) == 1 else "",
        further=float(np.max([proof.further for proof in proofs])),
    )


@on_one_thread
def energy_proof(passage: Passage, approach: Approach) -> EnergyProof:
    """What an energy ball, or else a bound on the slip to come, proves of a motion found to shake down.

    Within a ball the distance from its centre never grows. So a motion that comes to
    rest outside has never been inside, and one that comes to rest inside is there
    after finitely many cycles: the ball that holds the state at rest best is found, and
    the states that the motion really passes through are looked at until one is inside.
    Where none is, the slip that is still to come is bounded, if it can be. In space any ball that holds the
    state comes first.

    Parameters
    ----------
    passage
        The joint, and where its motion began.
    approach
        Where it comes to rest, and what is known of how it gets there.
    """
    for best in (False, True) if holding_ball_sooner(passage.problem) else (True,):
        ball = _ball(passage, approach, best=best)
        if not isinstance(ball, EnergyBall):
            break
        cycles = comes_into(ball, passage, approach)
        if cycles is not None:
            return replace(_proof_of(ball, approach, best=best), cycles=cycles)
    # A ball that holds the start also holds the state at rest, so where none does λ_E is not computed.
    known = is_known(passage)
    asked = best or ball is not None or known
    if asked and proving_bound(passage) is not None:
        return EnergyProof(True, cycles=0, by=ENERGY)
    slip = slip_proof(passage, approach)
    if slip is not None:
        return EnergyProof(True, cycles=slip.cycles, by=SLIP, further=slip.further)
    return NO_PROOF


@on_one_thread
def with_margins(passage: Passage, approach: Approach) -> EnergyProof:
    """The proof by an energy ball, with the margins of the ball best suited to the state at rest.

    Where that takes long, without shares where such a ball holds it: one program instead of three.
    """
    for split in (False, True) if takes_long(passage.problem) else (True,):
        ball = _ball(passage, approach, best=True, split=split)
        if isinstance(ball, EnergyBall):
            return _proof_of(ball, approach, best=True)
    return EnergyProof(True)


def proof_in(ball: EnergyBall, passage: Passage, approach: Approach) -> EnergyProof | None:
    """The proof by a given ball of the load factor; None where it proves nothing."""
    holds = ball.open_nodes == approach.open_nodes and bool(ball.contains(approach.final_slip))
    cycles = comes_into(ball, passage, approach) if holds else None
    return None if cycles is None else replace(_proof_of(ball, approach, best=True), cycles=cycles)


def held_by_friction(problem: Problem, load_factor: float, slip: FloatArray) -> float:
    """How far friction can hold any one node from its slip at some load step, the others fixed [length].

    With node i displaced by e, all nodes closed, its reactions change by A_ii e and B_ii e: from one within
    f p to another, |A_ii e| ≤ 2 f p + f |B_ii e|. inf where that is no bound.

    Examples
    --------
    >>> import shakedown
    >>> round(held_by_friction(shakedown.example("one-node"), 0.0, np.zeros(1)), 3)
    2.667
    """
    n, d, law = problem.n, problem.directions, problem.law
    own = np.arange(n)
    least = np.linalg.svd(problem.A.reshape(n, d, n, d)[own, :, own], compute_uv=False)[:, -1]
    coupled = np.linalg.norm(problem.B.reshape(n, n, d)[own, own], axis=1)
    most = (loading(problem).at(load_factor)[1] + problem.B @ slip).max(axis=0)
    resisted = least - law.limit(coupled)
    if not resisted.min() > 0:
        return inf
    return float(np.max(2.0 * law.limit(np.maximum(most, 0.0)) / resisted))


def _proof_of(ball: EnergyBall, approach: Approach, *, best: bool) -> EnergyProof:
    slip = approach.final_slip
    return EnergyProof(True, float(ball.margin(slip)), float(ball.single_node_margin(slip)), best, by=ENERGY)


def comes_into(ball: EnergyBall, passage: Passage, approach: Approach) -> int | None:
    """The number of cycles until a motion that comes to rest in a ball is in it; None if not found."""
    kept = 0 if approach.first_cycles is None else len(approach.first_cycles.records)
    for state in passage.passed(approach.first_cycles, approach.most):
        if state.open_nodes == approach.open_nodes and ball.contains(state.slip, off=state.error):
            return state.cycles
        if state.cycles == kept:
            away = float(ball.distance(state.slip)) - float(ball.distance(approach.final_slip))
            left = _cycles_left(away, float(ball.margin(approach.final_slip)), approach.contraction)
            if left > approach.most:
                return None
    return None


def _cycles_left(away: float, margin: float, contraction: float) -> float:
    """About how many cycles it takes until a shrinking distance is less than a margin."""
    if not away > margin or not contraction > 0.0:
        return 0.0
    return log(margin / away) / log(contraction) if contraction < 1.0 else inf


def _ball(
    passage: Passage, approach: Approach, *, best: bool, split: bool = True
) -> EnergyBall | Missing | None:
    """A ball that holds the state at rest, or the best one; None where there is none, or no such zone."""
    about, state = (passage.problem, passage.load_factor), approach.final_slip
    opened, tolerances = approach.open_nodes, passage.tolerances
    try:
        if best:
            found = sought(
                energy_ball,
                *about,
                around=state,
                transient=False,
                open_nodes=opened,
                split=split,
                tolerances=tolerances,
            )
        else:
            found = sought(holding_ball, *about, state, opened, tolerances)
    except UsageError:  # there is no such zone
        return None
    return found if isinstance(found, Missing) or found.contains(approach.final_slip) else None
