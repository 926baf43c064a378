"""The long-term state of a joint, with the evidence for it."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil, log
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Outcome
from shakedown.joint.coupled_parts import coupled_parts, of_nodes
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.energy_proof import (
    NO_PROOF,
    EnergyProof,
    energy_proof,
    proof_of_parts,
    with_margins,
)
from shakedown.long_term.passage import Approach, FirstCycles, Passage
from shakedown.motion.event_history import EventHistory, path_violation
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import State, Stop, Walk, walk


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
    open_nodes: tuple[int, ...]
    cycles_simulated: int
    slides_away: bool = False

    @property
    def separated(self) -> bool:
        """Whether every node stays open: the bodies have come apart."""
        return len(self.open_nodes) == self.problem.n

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

    residual: float
    work_per_cycle: FloatArray
    history: EventHistory = field(repr=False)
    step_slip: FloatArray = field(repr=False)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class LongTermState(SettledState):
    """Result of :func:`long_term_state`: a settled state, and the evidence for it.

    Attributes
    ----------
    dissipations : (period,)
        Dissipation of friction and jumps in each cycle of the period [force × length].
    opened : (n,)
        Whether the node is open at some time of the period.
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
    signature
        Identifies the contact states of one period, wherever it is cut
        (:attr:`EventHistory.signature`); 0 where undecided, and where the body leaves.
    stop
        Why the motion ended before its time; None where it did not.
    met
        Largest violation of the friction law met elsewhere than in that period.
    most_cycles
        How many were allowed.
    begun, goal
        Where the motion began, and the state at the start of that period.
    first_cycles
        What was passed through on the way, where that is kept.
    proof
        What proves it, where that is known already.
    parts
        Of a joint in uncoupled parts (:mod:`shakedown.joint.coupled_parts`) the state of each, which all
        else follows from; else empty.
    """

    DOCUMENT: ClassVar[str] = (
        "load_factor outcome reason period initial_slip final_slip drift slip_per_cycle "
        "dissipation_per_cycle friction_dissipation_per_cycle jump_dissipation_per_cycle jumps_per_cycle "
        "open_nodes cycles_simulated residual slides_away dissipations opened events contraction "
        "return_error proved energy_margin"
    )

    dissipations: FloatArray
    opened: NDArray[np.bool_]
    events: int
    contraction: float
    return_error: float
    signature: int
    stop: Stop | None = None
    met: float = field(default=np.nan, repr=False)
    most_cycles: int = field(repr=False, compare=False)
    begun: Passage = field(repr=False, compare=False)
    goal: State = field(repr=False, compare=False)
    first_cycles: FirstCycles | None = field(default=None, repr=False, compare=False)
    proof: EnergyProof | None = field(default=None, repr=False, compare=False)
    parts: tuple["LongTermState", ...] = field(default=(), repr=False, compare=False)

    def without_period(self) -> Self:
        """The same, with nothing that is known of a period."""
        nothing = np.full_like(self.final_slip, np.nan)
        return replace(
            self,
            period=0,
            drift=nothing,
            slip_per_cycle=np.full(self.problem.n, np.nan),
            friction_dissipation_per_cycle=np.nan,
            jump_dissipation_per_cycle=np.nan,
            jumps_per_cycle=np.nan,
            dissipations=np.array([]),
            contraction=np.nan,
            return_error=np.nan,
            signature=0,
        )

    def motion(self) -> Evolution:
        """The motion at the start of a period of the long-term state."""
        return self.begun.motion_from(self.goal, self.cycles_simulated - self.period)

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
            parts = coupled_parts(self.problem, self.begun.open_nodes)
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
        begun = self.begun
        found = path_violation(begun.problem, begun.load_factor, begun.tolerances, self.history)
        return found if np.isnan(self.met) else max(self.met, found)

    @property
    def proved(self) -> bool:
        """Whether shakedown is proved; False says nothing.

        It is where a state that the motion passed through after the transient, admissible and
        with exactly those nodes open that stay so, lies inside an energy ball of this load
        factor (:func:`energy_ball`); or, with all nodes closed, where the slip that is still to come is
        bounded (:func:`accumulated_bound`).
        """
        return self._proof.proved

    @property
    def proof_found(self) -> EnergyProof:
        """The proof, and the number of cycles; margins only where they are known."""
        return self._proof

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
    def _proof(self) -> EnergyProof:
        """The proof, computed on first use by cone programs."""
        if self.outcome != Outcome.SHAKEDOWN:
            return NO_PROOF
        if self.parts:
            return proof_of_parts([part._proof for part in self.parts])
        return self.proof or energy_proof(self.begun, self.approach)

    @cached_property
    def _margins(self) -> EnergyProof:
        """The proof with the margins of the best ball."""
        if self.parts and self._proof.proved:
            return proof_of_parts([part._margins for part in self.parts])
        return self._proof if self._proof.best else with_margins(self.begun, self.approach)

    @property
    def approach(self) -> Approach:
        """The approach to rest, as the proofs need it."""
        most = self.cycles_simulated + self.most_cycles
        return Approach(self.final_slip, self.open_nodes, most, self.contraction, self.first_cycles)

    @property
    def cycles_to_one_percent(self) -> int:
        """Cycles until the distance to the long-term state has shrunk to 1 %."""
        return 1 if self.contraction <= 0.01 else ceil(log(0.01) / log(self.contraction))
