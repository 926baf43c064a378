"""The limits that joints have in the plane and in space, each computed when it is first read, and once."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, ClassVar, Literal

from numpy.typing import ArrayLike

from shakedown.assessment.from_state import FromState
from shakedown.bounds.energy.energy_ball import EnergyBall, energy_ball
from shakedown.bounds.energy.energy_bound import EnergyBound, energy_bound
from shakedown.bounds.energy.reasons import NO_SAFE_SLIP
from shakedown.bounds.every_state.universal_bound import UniversalBound, universal_bound
from shakedown.bounds.upper import UpperBound, upper_bound
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import constraints, through_transient
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

if TYPE_CHECKING:
    from shakedown.assessment.slip_limit import SlipLimit
    from shakedown.assessment.transient_limit import TransientLimit

MANY_PAIRS = 200  # node pairs, from where on a program or a run in space takes seconds


@dataclass(frozen=True, eq=False, repr=False)
class CommonLimits(Result):
    """The limits of one joint: whoever needs one reads it here.

    A limit whose program comes to no end raises ``SolverError`` where it is an answer (λ_1, λ_max) and is a
    status where it is a proof; evidence beside the answers (λ_T, the guarantee curve) is ``Missing`` then.

    Attributes
    ----------
    problem
        The joint and its loading.
    initial_slip : (dn,) or None
        The state that is asked about [length]; None for slip zero.
    distance
        How far the state may be from it, in the energy norm [√(force · length)]; for λ_E.
    zone
        The nodes that stay open, for λ_max and λ_E, or ``"auto"`` (:func:`upper_bound`).
    certify
        Whether to check in exact arithmetic; None: each limit where that is quick.
    accuracy
        Of λ_T, relative to where its scan ends.
    tolerances
        The tolerances that decide.
    """

    DOCUMENT: ClassVar[str] = "lower upper energy box universal friction"

    problem: Problem
    initial_slip: ArrayLike | None = None
    distance: float = 0.0
    zone: Iterable[int] | Literal["auto"] = "auto"
    certify: bool | None = None
    accuracy: float = 1e-6
    tolerances: Tolerances = DEFAULT

    @cached_property
    def upper(self) -> UpperBound:
        """λ_max, with its safe slip and its zone."""
        return upper_bound(
            self.problem, open_nodes=self.zone, certify=self.certify, tolerances=self.tolerances
        )

    @cached_property
    def open_nodes(self) -> tuple[int, ...]:
        """The nodes that are open in the zone of λ_max; none where that is not found."""
        upper = sought(lambda: self.upper)
        return () if isinstance(upper, Missing) else upper.open_nodes

    @cached_property
    def through_transient(self) -> UpperBound | None:
        """λ_max of slips that the transient load steps do not move either; None without such steps."""
        problem = self.problem
        if self.open_nodes or through_transient(problem) is constraints(problem):
            return None
        return upper_bound(problem, transient=True, tolerances=self.tolerances)

    @cached_property
    def universal(self) -> UniversalBound:
        """λ_U, proved from every state."""
        return universal_bound(self.problem, certify=self.certify, tolerances=self.tolerances)

    @cached_property
    def energy(self) -> EnergyBound:
        """λ_E, proved from this state by an energy; that of the zone where nodes are open."""
        return energy_bound(
            self.problem,
            self.initial_slip,
            self.distance,
            open_nodes=self.open_nodes,
            certify=self.certify,
            tolerances=self.tolerances,
        )

    def ball_at(self, load_factor: float) -> EnergyBall | Missing:
        """An energy ball of this load factor, sought once; Missing above λ_max, where there is none.

        In the plane the largest. In space, where one that holds a slip is found sooner, the one that holds
        this state best where λ_E proves it, above λ_E a slip that is safe there.
        """
        if load_factor not in self._balls:
            above = not self.open_nodes and load_factor > self.upper.load_factor
            self._balls[load_factor] = Missing(NO_SAFE_SLIP) if above else sought(self._ball_at, load_factor)
        return self._balls[load_factor]

    @cached_property
    def _balls(self) -> dict[float, EnergyBall | Missing]:
        return {}

    def _ball_at(self, load_factor: float) -> EnergyBall:
        problem, around, split = self.problem, None, True
        if problem.directions > 1 and not self.open_nodes:
            proved, upper = self.energy, self.upper
            split = False
            if proved.least_load_factor <= load_factor < proved.load_factor:
                around, split = proved.initial_slip, problem.n <= MANY_PAIRS
            elif proved.load_factor <= load_factor < upper.load_factor < inf:
                # from a slip that is safe at λ_E to one that is at λ_max: between them all are
                share = (load_factor - proved.load_factor) / (upper.load_factor - proved.load_factor)
                around = (1.0 - share) * proved.slip + share * upper.slip
        return energy_ball(problem, load_factor, around=around, split=split, tolerances=self.tolerances)

    @cached_property
    def transient(self) -> "TransientLimit | Missing | None":
        """λ_T: up to where this history is found to shake down; None without a finite λ_max to scan up to."""
        from shakedown.assessment.transient_limit import scan_end, transient_limit  # loads compiled code

        end = scan_end(self.upper)
        if end is None:
            return None
        if not self.open_nodes:
            self._note_what_is_known()
        return sought(
            transient_limit,
            self.problem,
            self.initial_slip,
            largest=end,
            accuracy=self.accuracy,
            tolerances=self.tolerances,
        )

    def _note_what_is_known(self) -> None:
        """Keep λ_max and λ_E for the states that are followed."""
        from shakedown.long_term.energy_proof import note_bound, note_largest  # loads compiled code
        from shakedown.long_term.passage import Passage

        problem, bound = self.problem, self.energy
        note_largest(problem, self.upper.load_factor)
        if self.distance == 0.0 and bound.status != Status.UNDECIDED:
            note_bound(Passage(problem, 0.0, self.tolerances, bound.initial_slip, ()), bound)

    def slip(self, below: float) -> "SlipLimit | Missing":
        """Up to where every slip range of this history stays below a length."""
        from shakedown.assessment.slip_limit import slip_limit  # loads compiled code
        from shakedown.assessment.transient_limit import scan_end

        upper = sought(lambda: self.upper)
        end = None if isinstance(upper, Missing) else scan_end(upper)
        return sought(
            slip_limit, self.problem, below, self.initial_slip, largest=end or 1.0, tolerances=self.tolerances
        )

    @property
    def pinned(self) -> tuple[int, ...]:
        """The slips, by number, that are set to zero where the joint can move as a whole.

        Of closed nodes: with one tangential direction they are the nodes that slips are given relative to.
        """
        return self.upper.pinned if self.open_nodes else constraints(self.problem).pinned

    @property
    def why_missing(self) -> dict[str, str]:
        """Why a limit does not exist for joints of this kind, by its word in documents."""
        return {}

    @property
    def from_state(self) -> FromState:
        """What is proved from this state: the largest of the bounds there are."""
        return FromState.of_energy(self.energy)

    @property
    def is_open_from_state(self) -> bool:
        """Whether a program for what is proved from this state came to no end."""
        return self.energy.status == Status.UNDECIDED
