"""Every limit of the load factor of one joint, each computed when it is first read, and once."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from shakedown.assessment.common_limits import CommonLimits
from shakedown.assessment.from_state import FromState, from_state
from shakedown.assessment.sensitivities import Sensitivities, sensitivities
from shakedown.assessment.shakedown_bounds import ShakedownBounds, SpaceBounds
from shakedown.assessment.space_limits import SpaceLimits
from shakedown.bounds.certificate import LOWER_CERTIFIED_UP_TO
from shakedown.bounds.collapse.box_bound import BoxBound, box_bound
from shakedown.bounds.collapse.lower import LowerBound, lower_bound
from shakedown.bounds.energy.energy_bound import EnergyBound
from shakedown.bounds.every_state.guarantee_curve import GuaranteeCurve, guarantee_curve
from shakedown.bounds.every_state.universal_bound import UniversalBound, universal_bound
from shakedown.bounds.uniqueness.friction_thresholds import FrictionThresholds, friction_thresholds
from shakedown.bounds.upper import UpperBound
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, require_problem
from shakedown.joint.problem import Problem

ONE_SIDED_UP_TO = 20  # nodes: at a degenerate optimum their derivatives take tenths of a second


@dataclass(frozen=True, eq=False, repr=False)
class JointLimits(CommonLimits):
    """The limits of one joint in the plane."""

    @cached_property
    def lower(self) -> LowerBound:
        """λ_1, the first collapse with all nodes closed, with its guarantee."""
        exact = self.problem.n <= LOWER_CERTIFIED_UP_TO if self.certify is None else self.certify
        return lower_bound(self.problem, certify=exact, tolerances=self.tolerances)

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
    def box(self) -> BoxBound:
        """λ_box, proved from this state, closed at all nodes, by a box."""
        closed = None if self.open_nodes else sought(lambda: self.upper)
        upper = None if isinstance(closed, Missing) else closed
        return box_bound(self.problem, self.initial_slip, upper=upper, tolerances=self.tolerances)

    def _note_what_is_known(self) -> None:
        """Keep λ_box besides."""
        from shakedown.long_term.energy_proof import note_box  # loads compiled code
        from shakedown.long_term.passage import Passage

        super()._note_what_is_known()
        note_box(Passage(self.problem, 0.0, self.tolerances, self.box.initial_slip, ()), self.box)

    @property
    def from_state(self) -> FromState:
        """The larger of λ_E and λ_box."""
        return from_state(self.energy, self.box)

    @property
    def is_open_from_state(self) -> bool:
        """Whether a program for λ_E or λ_box came to no end."""
        return Status.UNDECIDED in (self.energy.status, self.box.status)

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


Limits = JointLimits | SpaceLimits


def kind_of_limits(problem: Problem) -> type[JointLimits] | type[SpaceLimits]:
    """The class of the limits of a joint: what it has follows from its tangential directions.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> kind_of_limits(joint)(joint).lower.node
    1
    """
    require_problem(problem)
    return SpaceLimits if problem.directions > 1 else JointLimits


@checked
def shakedown_bounds(
    problem: Problem,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = (),
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> ShakedownBounds | SpaceBounds:
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
    kind = kind_of_limits(problem)
    return kind(problem, zone=open_nodes, certify=certify, tolerances=tolerances).bounds
