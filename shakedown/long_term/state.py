"""The long-term state of a joint, the evidence for it, and what proves it."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from math import inf, log, nan
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.energy.energy_ball import EnergyBall, energy_ball
from shakedown.bounds.registry import BOUNDS, takes_long
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import attempt_any
from shakedown.ground.status import Outcome
from shakedown.ground.work_limit import on_one_thread
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.contact_zone import coupled_parts, of_nodes
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term import motion_start
from shakedown.long_term.creep_proofs import sliding_bodies
from shakedown.long_term.motion_start import FirstCycles, MotionStart
from shakedown.long_term.rigid_drift import RigidDrift, rigid_drift
from shakedown.motion.checked_law import path_resolution, scales
from shakedown.motion.event_history import EventHistory, path_violation
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import CycleRecord, State, Stop, Walk, walk
from shakedown.motion.viscous_jump import Jump

VARIES_LITTLE = "the varying part of the loads is next to round-off beside the constant part"
MOST_EXAMINED = 256  # largest number of cycles after which a state is examined, doubling from 1


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SettledState(Result):
    """The settled state of a joint, however it was found.

    Attributes
    ----------
    problem, load_factor, initial_slip
        What was asked for; slip (n,) [length].
    outcome, reason
        Long-term state (:class:`Outcome`), and in words what it rests on.
    period
        Cycles after which the state repeats; 0 where undecided, and where the
        body leaves (outcome "separation": contact is lost for good).
    final_slip : (n,)
        Slip at the end of a period of the long-term state [length].
    drift : (n,)
        Growth of the slip per period [length]; NaN where undecided.
    slip_per_cycle : (n,)
        Σ|Δv| in contact over one period of the long-term state [length]; of a jump
        the change of v where a node is closed before and after it. NaN where undecided.
    friction_dissipation_per_cycle
        Friction work per cycle, averaged over the period [force × length].
    jump_dissipation_per_cycle
        The work of damping in the jumps of the long-term state, per cycle
        [force × length]; 0 with fixed load steps, which cannot tell.
    jumps_per_cycle
        Number of jumps per cycle of the long-term state; NaN where undecided, and
        with fixed load steps.
    opened : (n,)
        Whether the node is open at some time of the period.
    open_nodes
        Nodes that stay open through the whole period.
    cycles_simulated
        Effort: cycles followed in all.
    slides_away
        Whether it is undecided because the body slides away for good: friction does not hold it.
    """

    DOCUMENT: ClassVar[str] = (
        "load_factor outcome reason period initial_slip final_slip drift slip_per_cycle "
        "dissipation_per_cycle friction_dissipation_per_cycle jump_dissipation_per_cycle jumps_per_cycle "
        "open_nodes cycles_simulated residual slides_away"
    )
    TABLE: ClassVar[str] = "initial_slip final_slip drift slip_per_cycle"

    problem: Problem = field(repr=False, compare=False)
    load_factor: float
    initial_slip: FloatArray
    outcome: Outcome
    reason: str
    period: int
    final_slip: FloatArray
    drift: FloatArray
    slip_per_cycle: FloatArray
    friction_dissipation_per_cycle: float
    jump_dissipation_per_cycle: float
    jumps_per_cycle: float
    opened: NDArray[np.bool_]
    open_nodes: tuple[int, ...]
    cycles_simulated: int
    slides_away: bool = False

    @property
    def separated(self) -> bool:
        """Whether every node stays open: the bodies have come apart."""
        return len(self.open_nodes) == self.problem.n

    @property
    def rigid_drift(self) -> RigidDrift | None:
        """The drift as a rigid motion of the first body, per cycle; None where none is known."""
        return rigid_drift(self.problem, self.outcome, self.period, self.drift)

    @property
    def dissipation_per_cycle(self) -> float:
        """Work of friction and of damping in jumps per cycle, averaged over the period."""
        return self.friction_dissipation_per_cycle + self.jump_dissipation_per_cycle


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SteppedState(SettledState):
    """A settled state found with fixed load steps.

    Attributes
    ----------
    residual
        Largest relative violation of the friction law (:func:`law_violation`) at all load steps.
    work_per_cycle : (n,)
        Friction work at each node per cycle, averaged over the period [force × length]; NaN
        where undecided.
    history
        The load steps of one period; none where it is undecided.
    step_slip : (s, n)
        Slip in contact during each of them, with two directions the length of the way [length].
    """

    proved: ClassVar[bool] = False
    energy_margin: ClassVar[float] = nan
    events: ClassVar[int | None] = None

    residual: float
    work_per_cycle: FloatArray
    history: EventHistory = field(repr=False)
    step_slip: FloatArray = field(repr=False)


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


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class LongTermState(SettledState):
    """Result of :func:`long_term_state`: a settled state, and how it was established.

    Attributes
    ----------
    dissipations : (period,)
        Dissipation of friction and jumps in each cycle of the period [force × length].
    events
        Events followed in all.
    contraction
        Factor per cycle by which the distance to the long-term state shrinks in
        the end; 0 where it is reached exactly, NaN where undecided. An
        estimate: it is followed over as many cycles as the approach stands out of round-off,
        and differs by a few per cent with where that ends.
    return_error
        How far one period from the long-term state misses it, drift apart,
        relative to the length scale.
    error
        Estimated distance of ``final_slip`` from where the motion really ends, largest entry [length]: from
        the rate at which the cycles close in, and from what leaps ahead leave open; where it ratchets apart
        from rigid slip, which goes on for ever. Zero in the plane, NaN where undecided.
    signature
        Identifies the contact states of one period, wherever it is cut; 0 where undecided, and where the
        body leaves.
    stop
        Why the motion ended before its time; None where it did not.
    met
        Largest violation of the friction law met elsewhere than in that period.
    most_cycles
        How many were allowed.
    origin, goal
        Where the motion began, and the state at the start of that period.
    first_cycles
        What a search in space has passed through before it first leapt ahead.
    jumps
        Those of the cycles that it has followed. Of a joint in uncoupled ``parts`` both are known of these.
    proof
        What proves it, where that is known already.
    parts
        Of a joint in uncoupled parts (:mod:`shakedown.joint.contact_zone`) the state of each, which all
        else follows from; else empty.
    """

    DOCUMENT: ClassVar[str] = (
        f"{SettledState.DOCUMENT} dissipations opened events contraction return_error proved energy_margin"
    )

    dissipations: FloatArray
    events: int
    contraction: float
    return_error: float
    error: float = 0.0
    signature: int
    stop: Stop | None = None
    met: float = field(default=np.nan, repr=False)
    most_cycles: int = field(repr=False, compare=False)
    origin: MotionStart = field(repr=False, compare=False)
    goal: State = field(repr=False, compare=False)
    first_cycles: FirstCycles | None = field(default=None, repr=False, compare=False)
    jumps: tuple[Jump, ...] = field(default=(), repr=False)
    proof: EnergyProof | None = field(default=None, repr=False, compare=False)
    parts: tuple["LongTermState", ...] = field(default=(), repr=False, compare=False)

    def _words(self) -> list[str]:
        return super()._words() + ["error"] * (self.problem.directions > 1)

    def without_period(self) -> "LongTermState":
        """The same, with nothing that is known of a period."""
        none, nothing = of_long_term_period([], self.problem.n), np.full_like(self.final_slip, np.nan)
        kept = {"opened": self.opened, "open_nodes": self.open_nodes}
        return replace(self, drift=nothing, contraction=np.nan, return_error=np.nan, **none | kept)

    def checked(self, violation: float, most: float, where: str) -> "LongTermState":
        """The same with the largest violation of the friction law, undecided where that is too large."""
        if violation <= most:
            return replace(self, met=float(np.fmax(violation, self.met)))
        return replace(
            self.without_period(),
            outcome=Outcome.UNDECIDED,
            reason=f"the friction law is violated by {violation:.1e} {where} ({self.reason})",
            open_nodes=(),
            opened=np.zeros(self.problem.n, dtype=bool),
            error=nan,
            met=violation,
        )

    def motion(self) -> Evolution:
        """The motion at the start of a period of the long-term state."""
        return self.origin.motion_from(self.goal, self.cycles_simulated - self.period)

    @cached_property
    def history(self) -> EventHistory:
        """The events of one period of the long-term state; none where it is undecided, or the body leaves."""
        path = self._walk.history if self.period else None
        return EventHistory.none(self.problem.layout) if path is None else path

    @cached_property
    def work_per_cycle(self) -> FloatArray:
        """Friction work at each node per cycle, averaged over the period, jumps included, (n,).

        [force × length]; NaN where undecided.
        """
        if not self.period:
            return np.full(self.problem.n, np.nan)
        if self.parts:
            parts = coupled_parts(self.problem, self.origin.open_nodes)
            return of_nodes(parts, (part.work_per_cycle for part in self.parts))
        return np.asarray(np.sum([record.work for record in self._walk.records], axis=0) / self.period)

    @cached_property
    def _walk(self) -> Walk:
        """Follow one period again."""
        return walk(self.motion(), self.period, record=True)

    @cached_property
    def residual(self) -> float:
        """Largest relative violation of the friction law (:func:`law_violation`), there or met before."""
        if not self.period or (self.first_cycles is not None and not np.isnan(self.met)):
            return self.met  # a search that records its path has checked the period already
        if self.parts:
            return max(part.residual for part in self.parts)
        origin = self.origin
        found = path_violation(origin.problem, origin.load_factor, origin.tolerances, self.history)
        return found if np.isnan(self.met) else max(self.met, found)

    @property
    def proved(self) -> bool:
        """Whether shakedown is proved; False says nothing.

        It is where a state that the motion passed through after the transient, admissible and
        with exactly those nodes open that stay so, lies inside an energy ball of this load
        factor (:func:`energy_ball`); or, with all nodes closed, where the slip that is still to come is
        bounded (:func:`accumulated_bound`).
        """
        return self.proof_found.proved

    @property
    def energy_margin(self) -> float:
        """How far the long-term state may be disturbed without leaving that ball; NaN without one.

        In the energy norm √(eᵀA e) [√(force × length)].
        """
        return self._margins.margin

    @property
    def single_node_margin(self) -> float:
        """The slip by which any one node may be off from the long-term state [length]; NaN without a ball."""
        return self._margins.single_node_margin

    @cached_property
    def proof_found(self) -> EnergyProof:
        """The proof, and the number of cycles; margins only where they are known: by cone programs."""
        if self.outcome != Outcome.SHAKEDOWN:
            return NO_PROOF
        if self.parts:
            return proof_of_parts([part.proof_found for part in self.parts])
        return self.proof or energy_proof(self)

    @cached_property
    def _margins(self) -> EnergyProof:
        """The proof with the margins of the best ball."""
        if self.parts and self.proof_found.proved:
            return proof_of_parts([part._margins for part in self.parts])
        return self.proof_found if self.proof_found.best else with_margins(self)

    @cached_property
    def drift_bounds(self) -> tuple[float, float]:
        """Between these lies the drift per cycle of every closed motion, in units of the rigid slip.

        By one cycle of this state (docs/creep.md, statement 2); NaN unless the joint is monotone.
        """
        bodies = sliding_bodies(self.problem)
        if len(bodies) != 1 or bodies[0] is None or bodies[0].problem is not self.problem:
            return nan, nan
        return bodies[0].drift_enclosure(self.history)

    @property
    def cycles_examined(self) -> int:
        """After how many cycles states are examined by proofs at most."""
        return self.cycles_simulated + self.most_cycles


def of_period(records: Sequence[CycleRecord], n: int) -> dict[str, Any]:
    """What the cycles of a period show of a settled state of n nodes; nothing where there is none."""

    def mean(values: list[float]) -> float:
        return float(np.mean(values)) if values else np.nan

    opened, closed = opened_and_closed(records, n)
    return {
        "period": len(records),
        "slip_per_cycle": np.sum([each.slip for each in records], axis=0) if records else np.full(n, np.nan),
        "friction_dissipation_per_cycle": mean([each.friction_dissipation for each in records]),
        "jump_dissipation_per_cycle": mean([each.jump_dissipation for each in records]),
        "jumps_per_cycle": mean([float(len(each.jumps)) for each in records]),
        "opened": opened,
        "open_nodes": tuple(np.flatnonzero(opened & ~closed).tolist()),
    }


def of_long_term_period(records: Sequence[CycleRecord], n: int) -> dict[str, Any]:
    """The same of a long-term state."""
    return of_period(records, n) | {
        "dissipations": np.array([each.dissipation for each in records]),
        "signature": sum(each.signature for each in records) % 2**64,  # whichever cycle is first
    }


def opened_and_closed(records: Sequence[CycleRecord], n: int) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether each of n nodes was open, and whether it was closed, at some time in these cycles."""
    opened, closed = np.zeros((2, n), dtype=bool)
    for record in records:
        opened, closed = opened | record.opened, closed | record.closed
    return opened, closed


@on_one_thread
def energy_proof(state: LongTermState) -> EnergyProof:
    """What an energy ball, or else a bound on the slip to come, proves of a motion found to shake down.

    Within a ball the distance from its centre never grows. So a motion that comes to
    rest outside has never been inside, and one that comes to rest inside is there
    after finitely many cycles: the ball that holds the state at rest best is found, and
    the states that the motion really passes through are looked at until one is inside.
    Where none is, the slip that is still to come is bounded, if it can be. All that is for motions of whose
    start it is not known already that λ_E proves it.
    """
    if motion_start.is_known(state.origin) and motion_start.proving_bound(state.origin) is not None:
        return EnergyProof(True, best=False, cycles=0, by=ENERGY)
    ball = ball_about(state.origin, state.final_slip, state.open_nodes)
    found = None if ball is None else proof_in(ball, state)
    # A ball that holds the start also holds the state at rest, so where none does λ_E is not computed.
    if ball is not None and found is None and motion_start.proving_bound(state.origin) is not None:
        return EnergyProof(True, cycles=0, by=ENERGY)
    return found or slip_proof(state)


def slip_proof(state: LongTermState) -> EnergyProof:
    """The proof by accumulated slip (docs/accumulated.md), of all nodes closed.

    The start is asked about, then the state at rest. Where that one proves nothing, states near it hardly
    do; where it does, the states after 1, 2, 4, … cycles are asked about, with the error of their path. No
    state is known better than a path is resolved.
    """
    origin = state.origin
    further = motion_start.total_slip_from_start(origin)
    if further < inf:
        return EnergyProof(True, cycles=0, by=SLIP, further=further)
    loop = _after_transient(origin.problem)
    known = path_resolution(loop, origin.tolerances) * scales(loop, origin.load_factor).length
    at_rest = motion_start.total_slip_from(loop, origin.load_factor, state.final_slip, known)
    if state.open_nodes or not at_rest < inf:
        return NO_PROOF
    passed = islice(origin.passed(state.first_cycles, state.cycles_examined), MOST_EXAMINED)
    for cycles, slip, open_nodes, error in passed:
        if open_nodes or cycles & (cycles - 1):
            continue
        further = motion_start.total_slip_from(loop, origin.load_factor, slip, known + error)
        if further < inf:
            return EnergyProof(True, cycles=cycles, by=SLIP, further=further)
    return NO_PROOF


@once_per_problem
def _after_transient(problem: Problem) -> Problem:
    """The joint in its loop."""
    if problem.q_transient is None:
        return problem
    return replace(problem, q_transient=None, p_transient=None)


@on_one_thread
def with_margins(state: LongTermState) -> EnergyProof:
    """The proof by an energy ball, with the margins of the ball that holds the state at rest best."""
    ball = ball_about(state.origin, state.final_slip, state.open_nodes)
    return EnergyProof(True) if ball is None else _proof_of(ball, state)


def proof_in(ball: EnergyBall, state: LongTermState) -> EnergyProof | None:
    """The proof by a given ball of the load factor; None where it proves nothing."""
    holds = ball.open_nodes == state.open_nodes and bool(ball.contains(state.final_slip))
    cycles = cycles_until_inside(ball, state) if holds else None
    return None if cycles is None else replace(_proof_of(ball, state), cycles=cycles)


def _proof_of(ball: EnergyBall, state: LongTermState) -> EnergyProof:
    slip = state.final_slip
    return EnergyProof(True, float(ball.margin(slip)), float(ball.single_node_margin(slip)), True, by=ENERGY)


def cycles_until_inside(ball: EnergyBall, state: LongTermState) -> int | None:
    """The number of cycles until a motion that comes to rest in a ball is in it; None if not found."""
    kept = 0 if state.first_cycles is None else len(state.first_cycles)
    passed = state.origin.passed(state.first_cycles, state.cycles_examined)
    for cycles, slip, open_nodes, error in passed:
        if open_nodes == state.open_nodes and ball.contains(slip, off=error):
            return cycles
        if cycles == kept:
            away = float(ball.distance(slip)) - float(ball.distance(state.final_slip))
            left = _cycles_left(away, float(ball.margin(state.final_slip)), state.contraction)
            if left > state.cycles_examined:
                return None
    return None


def _cycles_left(away: float, margin: float, contraction: float) -> float:
    """About how many cycles it takes until a shrinking distance is less than a margin."""
    if not away > margin or not contraction > 0.0:
        return 0.0
    return log(margin / away) / log(contraction) if contraction < 1.0 else inf


@on_one_thread
def ball_about(origin: MotionStart, slip: FloatArray, open_nodes: tuple[int, ...]) -> EnergyBall | None:
    """The ball that holds a state best, with these nodes open; None where there is none, or no such zone.

    Where that takes long, without shares where such a ball holds it: one program instead of three.
    """
    more: dict[str, Any] = {"open_nodes": open_nodes, "transient": False, "tolerances": origin.tolerances}
    for split in (False, True) if takes_long(origin.problem) else (True,):
        found = attempt_any(energy_ball, origin.problem, origin.load_factor, around=slip, split=split, **more)
        if isinstance(found, EnergyBall) and found.contains(slip):
            return found
    return None
