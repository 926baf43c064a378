"""What an engineer asks about a joint: three numbers, the nominal load, and both bounds by another solver."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from shakedown.assessment.every_limit import THREE_NUMBERS, JointLimits, ShakedownBounds, on_mesh
from shakedown.bounds.independent_solver import ConicBound, conic_lower_bound, conic_upper_bound
from shakedown.ground.errors import Missing
from shakedown.ground.shown_values import plain, short
from shakedown.ground.status import LimitsVerdict, Outcome, Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, checked_initial_slip
from shakedown.joint.hat_functions import averaged
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

AS_GIVEN = 1.0  # the load factor of the nominal load


@dataclass(frozen=True, eq=False, repr=False)
class Assessment(Result):
    """Shakedown limits of a joint, each computed when it is first read.

    The load factor λ multiplies the periodic part of the loading; λ = 1 is the nominal load.

    Attributes
    ----------
    details
        Every limit, with its evidence; each is computed when it is first read. With two tangential
        directions some do not exist, and are ``Missing``.
    """

    details: JointLimits

    @property
    def problem(self) -> Problem:
        """The joint."""
        return self.details.problem

    @property
    def proved_from_every_state(self) -> float:
        """λ_U: below it shakedown is proved whatever slip is locked in, all nodes closed, transient over.

        Every state is one that the load admits at some instant of the loop. 0 where nothing is proved,
        inf where every load factor is, NaN where a program of the proof came to no end.
        """
        return self.details.proved_from_every_state

    @property
    def proved_from_this_state(self) -> float:
        """Below it shakedown is proved from the state asked about: the largest of what is proved of it.

        λ_E (a ball in the energy norm), λ_S (how far nodes slip in all) and, as far as the first load step
        admits the state, λ_U. Where ``details.open_nodes`` are open it is λ_E, of the state with these open.
        0 where nothing is proved, or not from λ = 0 on (``details.from_state``); NaN where a program came to
        no end.
        """
        return self.details.proved_from_this_state

    @property
    def impossible_above(self) -> float:
        """λ_max: above it the joint cannot shake down with all nodes in contact.

        Where λ_max is certified that is the upper end of what encloses it. inf where a safe slip exists at
        every load factor, and where the nodes of ``details.open_nodes`` are open, as other zones are not
        covered. 0 where no slip is safe at any load factor, NaN where a search found none and left out zones.
        """
        return self.details.impossible_above

    @property
    def verdict(self) -> LimitsVerdict:
        """What the limits alone decide about the nominal load (λ = 1), without a simulation."""
        limits, here = self.details, self.details.from_state
        if limits.open_nodes:  # the bounds are about a state with these nodes open
            return LimitsVerdict.OPEN
        if self.proved_from_this_state > AS_GIVEN or here.least_load_factor < AS_GIVEN < here.load_factor:
            return LimitsVerdict.SHAKEDOWN
        if self.impossible_above < AS_GIVEN or limits.upper.least_load_factor > AS_GIVEN:
            return LimitsVerdict.IMPOSSIBLE
        return LimitsVerdict.OPEN

    def averaged(self, radius: float) -> "Assessment":
        """The assessment with slips and reactions averaged over a length: no proof for this joint itself."""
        limits, problem = self.details, self.problem
        start = checked_initial_slip(problem, limits.initial_slip)
        return Assessment(on_mesh(limits, averaged(replace(problem, initial_slip=start), radius)))

    @cached_property
    def as_given(self) -> Outcome:
        """What becomes of the joint under the nominal load, from the initial slip with all nodes closed.

        Where the bounds prove shakedown that is the answer; else it is simulated when first read.
        """
        if self.verdict == LimitsVerdict.SHAKEDOWN:
            return Outcome.SHAKEDOWN
        from shakedown.long_term.find_state import long_term_state  # loads compiled code

        start, tolerances = self.details.initial_slip, self.details.tolerances
        return long_term_state(self.problem, AS_GIVEN, start, tolerances=tolerances).outcome

    def to_dict(self) -> dict[str, Any]:
        """The three numbers, and what they decide about the nominal load; nothing is simulated."""
        return {word: plain(value) for word, value in self._numbers().items()}

    def columns(self) -> dict[str, Any]:
        """One row: the words of :meth:`to_dict`."""
        return {word: [value] for word, value in self._numbers().items()}

    def _numbers(self) -> dict[str, Any]:
        verdict = self.verdict
        return {word: getattr(self, word) for word in reversed(THREE_NUMBERS)} | {
            "said_as_given": None if verdict == LimitsVerdict.OPEN else str(verdict)
        }

    def _shown(self) -> Any:
        for word, value in self._numbers().items():
            yield word, short(value)


@checked
def assess(
    problem: Problem,
    initial_slip: ArrayLike | None = None,
    *,
    distance: float = 0.0,
    open_nodes: Iterable[int] | Literal["auto"] = "auto",
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Assessment:
    """Shakedown limits of a joint: proved from every state, proved from this state, impossible above.

    Parameters
    ----------
    problem
        The joint and its loading.
    initial_slip : (dn,), optional
        The state that is asked about [length]; zero by default, a joint assembled without locked-in slip.
    distance
        Largest distance of the true initial state from ``initial_slip``, in the energy norm
        [√(force · length)].
    open_nodes
        The nodes that stay open (:func:`upper_bound`); ``"auto"`` searches for them if the mean
        load opens some, or if no slip is safe with all nodes closed.
    certify
        Whether to check in exact arithmetic; by default each limit where that is quick.
    tolerances
        The tolerances that decide.

    Raises
    ------
    UsageError
        If an argument has the wrong shape or is out of range.
    SolverError
        If a linear program ends without an answer, when the limit is read.

    Examples
    --------
    >>> import shakedown
    >>> found = shakedown.assess(shakedown.example("two-node"))
    >>> round(found.proved_from_every_state, 4), round(found.proved_from_this_state, 4)
    (0.6574, 0.7316)
    >>> round(found.impossible_above, 4), found.as_given.value
    (0.7391, 'cyclic-slip')
    >>> found.details.energy.load_factor < found.details.accumulated.load_factor
    True
    """
    start = None if initial_slip is None else checked_initial_slip(problem, initial_slip)
    zone = open_nodes if isinstance(open_nodes, str) else tuple(open_nodes)
    return Assessment(JointLimits(problem, start, distance, zone, certify, tolerances=tolerances))


class SecondBounds(NamedTuple):
    """λ_1, where there is one, and λ_max by another solver, and the number of nodes checked for λ_1."""

    lower: ConicBound | None
    upper: ConicBound
    nodes: int


def second_bounds(problem: Problem, bounds: ShakedownBounds, tolerances: Tolerances) -> SecondBounds:
    """The bounds by Clarabel; for a large joint λ_1 only at the nodes that collapse first by HiGHS."""
    upper = conic_upper_bound(problem, open_nodes=bounds.upper.open_nodes, tolerances=tolerances)
    if isinstance(bounds.lower, Missing):
        return SecondBounds(None, upper, 0)
    limits = bounds.lower.collapse_limits
    nodes = np.lexsort((limits, np.arange(len(limits)) != bounds.lower.node)).tolist()
    # all up to a size, as the cost grows as n³; of larger joints those that collapse first
    nodes = nodes if len(nodes) <= 60 else nodes[:8]
    return SecondBounds(conic_lower_bound(problem, nodes=nodes, tolerances=tolerances), upper, len(nodes))


def independent_findings(
    bounds: ShakedownBounds, second: SecondBounds, tolerances: Tolerances
) -> Iterator[tuple[bool | None, str]]:
    """(False, what differs) or (None, what the independent solver leaves open) for each bound."""
    # As a bound may be zero, differences are relative to λ_max, or to the nominal load.
    size = bounds.upper.load_factor if 0 < bounds.upper.load_factor < np.inf else 1.0
    lower, method = bounds.lower, "the cone program" if second.lower is None else "linear programming"
    for first, other in ((lower, second.lower), (bounds.upper, second.upper)):
        if isinstance(first, Missing) or other is None:
            continue
        name, one, two = first.symbol, first.load_factor, other.load_factor
        closest = tolerances.cross_check if first.reduced_accuracy else tolerances.agreement
        if other.status == Status.UNDECIDED:
            left = f"the value rests on {method} alone"
            yield None, f"{name}: the independent solver ({other.solver}) stopped without an answer; {left}"
        elif first.undecided:  # no zone found; the other bound is for all closed
            continue
        elif first.status != other.status:
            yield False, f"{name}: {first.status} by {method}, {other.status} by the independent solver"
        elif np.isfinite(one) and abs(one - two) > closest * max(abs(one), size):
            seen = abs(one - two) > tolerances.agreement * other.unit
            end = "" if seen else ", which tells no smaller ones apart"
            text = f"{name}: {one:.10g} by {method}, {two:.10g} by the independent solver{end}"
            yield False if seen else None, text
        elif first.reduced_accuracy:
            yield None, f"{name}: by {method} only to reduced accuracy (1e-7)"
    if isinstance(lower, Missing) or second.nodes == lower.problem.n:
        return
    if lower.load_factor > tolerances.feasibility:
        asked = f"{second.nodes} of {lower.problem.n} nodes, those that collapse first"
        yield None, f"λ_1: the independent solver has sought it at {asked}"
