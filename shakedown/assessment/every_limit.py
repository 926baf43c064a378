"""Every limit of the load factor of one joint, each computed when it is first read, and once."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from shakedown.assessment.from_state import FromState, from_state
from shakedown.assessment.sensitivity.sensitivities import Sensitivities, sensitivities
from shakedown.assessment.shakedown_bounds import ShakedownBounds
from shakedown.bounds.certificate import LOWER_CERTIFIED_UP_TO
from shakedown.bounds.energy.energy_bound import EnergyBound, energy_bound
from shakedown.bounds.upper import UpperBound, upper_bound
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, require_plane
from shakedown.joint.constraints import constraints, through_transient
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.planar.collapse.box_bound import BoxBound, box_bound
from shakedown.planar.collapse.lower import LowerBound, lower_bound
from shakedown.planar.friction.thresholds import FrictionThresholds, friction_thresholds
from shakedown.planar.universal.guarantee_curve import GuaranteeCurve, guarantee_curve
from shakedown.planar.universal.universal_bound import UniversalBound, universal_bound

if TYPE_CHECKING:
    from shakedown.assessment.slip_limit import SlipLimit
    from shakedown.assessment.transient_limit import TransientLimit


ONE_SIDED_UP_TO = 20  # nodes: at a degenerate optimum their derivatives take tenths of a second


@dataclass(frozen=True, eq=False, repr=False)
class JointLimits(Result):
    """The limits of one joint: whoever needs one reads it here.

    A limit whose program comes to no end raises ``SolverError`` where it is an answer (λ_1, λ_max) and is a
    status where it is a proof; evidence beside the answers (λ_T, the guarantee curve) is ``Missing`` then.

    Attributes
    ----------
    problem
        The joint and its loading.
    initial_slip : (n,) or None
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
    def lower(self) -> LowerBound:
        """λ_1, the first collapse with all nodes closed, with its guarantee."""
        exact = self.problem.n <= LOWER_CERTIFIED_UP_TO if self.certify is None else self.certify
        return lower_bound(self.problem, certify=exact, tolerances=self.tolerances)

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
    def bounds(self) -> ShakedownBounds:
        """λ_1 and λ_max together."""
        return ShakedownBounds(self.lower, self.upper, self.tolerances, self.through_transient)

    @cached_property
    def universal(self) -> UniversalBound:
        """λ_U, proved from every state."""
        return universal_bound(
            self.problem, first_collapse=self.lower, certify=self.certify, tolerances=self.tolerances
        )

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

    @cached_property
    def box(self) -> BoxBound:
        """λ_box, proved from this state, closed at all nodes, by a box."""
        closed = None if self.open_nodes else sought(lambda: self.upper)
        upper = None if isinstance(closed, Missing) else closed
        return box_bound(self.problem, self.initial_slip, upper=upper, tolerances=self.tolerances)

    @property
    def from_state(self) -> FromState:
        """The larger of λ_E and λ_box."""
        return from_state(self.energy, self.box)

    @cached_property
    def friction(self) -> FrictionThresholds:
        """The friction at which the motion stops being unique, and at which the joint wedges."""
        return friction_thresholds(self.problem, tolerances=self.tolerances)

    @cached_property
    def sensitivities(self) -> dict[str, Sensitivities | Missing]:
        """By how much λ_max ("upper") and λ_E ("energy") move with friction and loads at every node.

        Missing for larger joints where that takes many programs (:func:`sensitivities` goes on there).
        """
        few = self.problem.n <= ONE_SIDED_UP_TO
        bounds: dict[str, UpperBound | EnergyBound] = {"upper": self.upper, "energy": self.energy}
        return {
            name: sought(sensitivities, self.problem, bound, one_sided=few, tolerances=self.tolerances)
            for name, bound in bounds.items()
        }

    @cached_property
    def transient(self) -> "TransientLimit | Missing | None":
        """λ_T: up to where this history is found to shake down; None without a finite λ_max to scan up to."""
        from shakedown.assessment.transient_limit import scan_end, transient_limit  # loads compiled code

        end = scan_end(self.upper)
        if end is None:
            return None
        return sought(
            transient_limit,
            self.problem,
            self.initial_slip,
            largest=end,
            accuracy=self.accuracy,
            tolerances=self.tolerances,
        )

    def slip(self, below: float) -> "SlipLimit | Missing":
        """Up to where every slip range of this history stays below a length."""
        from shakedown.assessment.slip_limit import slip_limit  # loads compiled code
        from shakedown.assessment.transient_limit import scan_end

        upper = sought(lambda: self.upper)
        end = None if isinstance(upper, Missing) else scan_end(upper)
        return sought(
            slip_limit, self.problem, below, self.initial_slip, largest=end or 1.0, tolerances=self.tolerances
        )

    def curve(
        self, radii: Sequence[float], centre: FloatArray | None = None
    ) -> GuaranteeCurve | Missing | None:
        """λ_1(R) around a safe slip, that of λ_max by default; None where there is no gap to close.

        Nor is there one for a load domain, where λ_1 predicts nothing.
        """
        if not self.bounds.have_gap or self.problem.is_domain:
            return None
        middle = self.upper.in_floats[:-1] if centre is None else centre
        return sought(
            guarantee_curve,
            self.problem,
            radii,
            centre=middle if np.isfinite(middle).all() else None,
            tolerances=self.tolerances,
        )


@checked
def shakedown_bounds(
    problem: Problem,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = (),
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> ShakedownBounds:
    """Lower and upper bound of the load factor.

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
    require_plane("bounds", problem)
    return JointLimits(problem, zone=open_nodes, certify=certify, tolerances=tolerances).bounds
