"""Every limit of the load factor of one joint, each computed when it is first read, and once."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from math import inf, isnan, nan
from typing import TYPE_CHECKING, ClassVar, Literal, TypeVar

from numpy.typing import ArrayLike

from shakedown.assessment.mesh_check import MeshCheck, mesh_check
from shakedown.assessment.sensitivities import Sensitivities, sensitivities
from shakedown.assessment.shakedown_bounds import ShakedownBounds
from shakedown.assessment.three_numbers import REFUTED, FromState, from_state, not_refuted
from shakedown.bounds.accumulated.accumulated_bound import (
    AccumulatedBound,
    accumulated_bound,
    total_slip_bound,
)
from shakedown.bounds.certificate import LOWER_CERTIFIED_UP_TO
from shakedown.bounds.collapse.lower import LowerBound, lower_bound
from shakedown.bounds.energy.energy_ball import EnergyBall, energy_ball
from shakedown.bounds.energy.energy_bound import EnergyBound, energy_bound
from shakedown.bounds.energy.energy_results import NO_SAFE_SLIP
from shakedown.bounds.enumeration.critical import subset_count
from shakedown.bounds.every_state.universal_bound import UniversalBound, universal_bound
from shakedown.bounds.onset import Onset, first_opening, first_slip
from shakedown.bounds.plane_or_space import methods_of, takes_long
from shakedown.bounds.results import UpperBound
from shakedown.bounds.uniqueness.friction_thresholds import FrictionThresholds, friction_thresholds
from shakedown.bounds.upper import upper_bound
from shakedown.ground.errors import Missing, present, sought
from shakedown.ground.round_off import FOUR_DIGITS, SIX_DIGITS
from shakedown.ground.shown_values import short
from shakedown.ground.size_limits import EXTRAS_UP_TO
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked
from shakedown.joint.constraints import constraints, through_transient
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

if TYPE_CHECKING:
    from shakedown.assessment.slip_limit import SlipLimit
    from shakedown.assessment.transient_limit import TransientLimit

LIMITS = ("universal", "energy", "accumulated", "transient", "lower", "upper")  # shown


REFUTED_BY_ALL = "round-off decides: it is {:.7g} in floats, although shakedown is proved up to {:.7g}"

T = TypeVar("T")
P = TypeVar("P", EnergyBound, AccumulatedBound)


def _where_it_exists(compute: "Callable[[JointLimits], T]") -> "cached_property[T | Missing]":
    """A limit that some kinds of joints do not have: for these it is the reason why."""

    def found(limits: "JointLimits") -> T | Missing:
        absent = limits.absent.get(compute.__name__)
        return compute(limits) if absent is None else absent

    found.__doc__ = compute.__doc__
    return cached_property(found)


@dataclass(frozen=True, eq=False, repr=False)
class JointLimits(Result):
    """The limits of one joint, the only place where they are computed.

    With two tangential directions there are λ_max, λ_E, λ_U and λ_T. A disc has no sides, so that there is no
    first collapse λ_1 and nothing that rests on it, and no friction threshold by signs: these are
    ``Missing``, with the reason (``absent``), and null in documents.

    A limit whose program does not finish raises ``SolverError`` where it is an answer (λ_1, λ_max) and is a
    status where it is a proof; evidence beside the answers (λ_T) is ``Missing`` then.

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
        Of λ_T, relative to where its scan ends; None: six digits, four of a joint whose runs take long.
    tolerances
        The tolerances that decide.
    """

    DOCUMENT: ClassVar[str] = "lower upper energy accumulated universal friction"

    problem: Problem
    initial_slip: ArrayLike | None = None
    distance: float = 0.0
    zone: Iterable[int] | Literal["auto"] = "auto"
    certify: bool | None = None
    accuracy: float | None = None
    tolerances: Tolerances = DEFAULT

    def _shown(self) -> Iterator[tuple[str, str]]:
        """Settings that differ from the defaults, and every limit that has been read so far."""
        usual = {field.name: field.default for field in fields(self)}
        for name, value in super()._shown():
            if name == "problem" or value != short(usual[name]):
                yield name, value
        known = self.absent | vars(self)
        for name in LIMITS:
            value = known.get(name, Missing("not read yet"))
            yield name, value.reason if isinstance(value, Missing) else short(value)

    def keep(self, name: str, found: object) -> None:
        """Store a limit that was computed beside others."""
        vars(self)[name] = found

    @cached_property
    def absent(self) -> dict[str, Missing]:
        """The limits that joints of this kind do not have, by their words in documents, and why."""
        return {word: Missing(reason) for word, reason in methods_of(self.problem).ABSENT.items()}

    @_where_it_exists
    def lower(self) -> LowerBound:
        """λ_1, the first collapse with all nodes closed, with its guarantee."""
        exact = self.problem.n <= LOWER_CERTIFIED_UP_TO if self.certify is None else self.certify
        return lower_bound(self.problem, certify=exact, tolerances=self.tolerances)

    @cached_property
    def upper(self) -> UpperBound:
        """λ_max, with its safe slip and its zone; undecided where it is not certified and λ_U refutes it."""
        found = upper_bound(
            self.problem, open_nodes=self.zone, certify=self.certify, tolerances=self.tolerances
        )
        if not found.uncertified or found.open_nodes:
            return found
        every = sought(lambda: self.universal)
        proved = 0.0 if isinstance(every, Missing) else every.load_factor
        if not isnan(not_refuted(proved, found, self.tolerances)) or isnan(proved):
            return found
        why = REFUTED_BY_ALL.format(found.load_factor, proved)
        return replace(found, status=Status.UNDECIDED, load_factor=nan, reason=why)

    def _not_refuted(self, found: P) -> P:
        """A proof from this state with all nodes closed; undecided where λ_max refutes it."""
        upper = present(sought(lambda: self.upper))
        if upper is None or not found.load_factor > 0.0:
            return found
        at = not_refuted(found.load_factor, upper, self.tolerances)
        if not isnan(at):
            return found if at == found.load_factor else replace(found, load_factor=at)
        why = REFUTED.format(found.load_factor, upper.load_factor)
        return replace(found, status=Status.UNDECIDED, load_factor=nan, reason=why)

    @cached_property
    def open_nodes(self) -> tuple[int, ...]:
        """The nodes that are open in the zone of λ_max; none where that is not found."""
        upper = sought(lambda: self.upper)
        return () if isinstance(upper, Missing) else upper.open_nodes

    @cached_property
    def through_transient(self) -> UpperBound | None:
        """λ_max for slips that the transient load steps do not move either; None without such steps."""
        problem = self.problem
        if self.open_nodes or through_transient(problem) is constraints(problem):
            return None
        return upper_bound(problem, transient=True, tolerances=self.tolerances)

    @cached_property
    def bounds(self) -> ShakedownBounds:
        """λ_1, where there is one, and λ_max together."""
        return ShakedownBounds(self.lower, self.upper, self.tolerances, self.through_transient)

    @cached_property
    def universal(self) -> UniversalBound:
        """λ_U, proved from every state."""
        return universal_bound(
            self.problem,
            first_collapse=present(self.lower),
            certify=self.certify,
            tolerances=self.tolerances,
        )

    @cached_property
    def energy(self) -> EnergyBound:
        """λ_E, proved from this state by an energy; for the zone where nodes are open."""
        return self._not_refuted(
            energy_bound(
                self.problem,
                self.initial_slip,
                self.distance,
                open_nodes=self.open_nodes,
                certify=self.certify,
                tolerances=self.tolerances,
            )
        )

    @cached_property
    def accumulated(self) -> AccumulatedBound:
        """λ_S, proved from this state, closed at all nodes, by a bound on their total slip."""
        return self._not_refuted(accumulated_bound(self.problem, self.initial_slip))

    @cached_property
    def first_slip(self) -> Onset:
        """Up to where no node slips, from this state with all nodes closed."""
        return first_slip(self.problem, self.initial_slip, tolerances=self.tolerances)

    @cached_property
    def first_opening(self) -> Onset:
        """Up to where no node would open if none slipped, from the same state."""
        return first_opening(self.problem, self.initial_slip, tolerances=self.tolerances)

    def ball_at(self, load_factor: float) -> EnergyBall | Missing:
        """An energy ball at this load factor, sought once; Missing above λ_max, where there is none.

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
        if methods_of(problem).HOLDING_BALL_SOONER and not self.open_nodes:
            proved, upper = self.energy, self.upper
            split = False
            if proved.least_load_factor <= load_factor < proved.load_factor:
                around, split = proved.initial_slip, not takes_long(problem)
            elif proved.load_factor <= load_factor < upper.load_factor < inf:
                # between a slip safe at λ_E and one safe at λ_max all slips are safe in between
                share = (load_factor - proved.load_factor) / (upper.load_factor - proved.load_factor)
                around = (1.0 - share) * proved.slip + share * upper.slip
        return energy_ball(problem, load_factor, around=around, split=split, tolerances=self.tolerances)

    @cached_property
    def transient(self) -> "TransientLimit | Missing | None":
        """λ_T, up to which this history is found to shake down; None without a finite λ_max to scan up to."""
        from shakedown.assessment.transient_limit import scan_end, transient_limit  # loads compiled code

        end = scan_end(self.upper)
        if end is None:
            return None
        self.note_what_is_known()
        return sought(
            transient_limit,
            self.problem,
            self.initial_slip,
            largest=end,
            accuracy=self._usual_accuracy if self.accuracy is None else self.accuracy,
            tolerances=self.tolerances,
        )

    @property
    def _usual_accuracy(self) -> float:
        # where following a joint takes seconds, and longer near λ_T
        return FOUR_DIGITS if takes_long(self.problem) else SIX_DIGITS

    def note_what_is_known(self) -> None:
        """Pass λ_max and the proved limits on to simulations; nothing where nodes stay open."""
        from shakedown.long_term.known_bounds import known_limits, note_bound, note_slip
        from shakedown.long_term.passage import Passage

        if self.open_nodes:
            return
        bound = self.energy
        known = known_limits(self.problem)
        known["upper"] = self.upper.load_factor
        if "universal" in vars(self):
            known["universal"] = self.universal.load_factor
        begun = partial(Passage, self.problem, 0.0, self.tolerances, open_nodes=())
        if self.distance == 0.0 and bound.status != Status.UNDECIDED:
            note_bound(begun(start=bound.initial_slip), bound)
        if "accumulated" in vars(self):
            note_slip(begun(start=self.accumulated.initial_slip), self.accumulated)

    @cached_property
    def mesh(self) -> MeshCheck:
        """Whether the edge of the mesh determines λ_max, and the limits on every second node."""
        return mesh_check(self)

    def slip(self, below: float) -> "SlipLimit | Missing":
        """The load factor up to which every slip range of this history stays below a length."""
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
    def from_state(self) -> FromState:
        """What is proved from this state: the larger of λ_E and λ_S, which is computed where it may be."""
        slip = self.accumulated if self._slip_may_prove_more else None
        return from_state(self.energy, slip)

    @cached_property
    def _slip_may_prove_more(self) -> bool:
        """Whether λ_S may be larger than λ_E, by checking its conditions at that load factor."""
        if self.open_nodes or self.distance > 0.0:
            return False
        energy = self.energy
        if "accumulated" in vars(self) or energy.least_load_factor > 0.0 or not energy.load_factor > 0.0:
            return True
        if energy.load_factor >= (1.0 - self.tolerances.agreement) * self.upper.load_factor:
            return False
        return total_slip_bound(self.problem, energy.load_factor, self.initial_slip).status == Status.OPTIMAL

    @_where_it_exists
    def friction(self) -> FrictionThresholds:
        """The friction at which the motion stops being unique, and at which the joint wedges."""
        return friction_thresholds(self.problem, tolerances=self.tolerances)

    @cached_property
    def sensitivities(self) -> dict[str, Sensitivities | Missing]:
        """How λ_max ("upper") and λ_E ("energy") depend on friction and loads at every node.

        Missing for larger joints where that takes many programs (:func:`sensitivities` goes on there).
        """
        if "sensitivities" in self.absent:
            return dict.fromkeys(("upper", "energy"), self.absent["sensitivities"])
        few = self.problem.n <= EXTRAS_UP_TO  # one-sided derivatives at a degenerate optimum take longer
        bounds: dict[str, UpperBound | EnergyBound] = {"upper": self.upper, "energy": self.energy}
        return {
            name: sought(sensitivities, self.problem, bound, one_sided=few, tolerances=self.tolerances)
            for name, bound in bounds.items()
        }

    @property
    def subsets(self) -> int | None:
        """How many (n+1)-subsets of rows there are to enumerate; None where there is no first collapse."""
        problem = self.problem
        return None if "lower" in self.absent else subset_count(problem.n, len(problem.law.smooth))


@checked
def shakedown_bounds(
    problem: Problem,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = (),
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> ShakedownBounds:
    """Lower and upper bound of the load factor; with two tangential directions the upper one alone.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    open_nodes
        The nodes that stay open, for the upper bound (:func:`upper_bound`).
    certify
        Whether to check both in exact arithmetic; by default each where that is quick.
    tolerances
        The tolerances that decide.

    Raises
    ------
    SolverError
        If a linear program ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> bounds = shakedown.shakedown_bounds(shakedown.example("two-node"))
    >>> round(bounds.lower.load_factor, 6), round(bounds.upper.load_factor, 6)
    (0.657373, 0.739146)
    """
    return JointLimits(problem, zone=open_nodes, certify=certify, tolerances=tolerances).bounds
