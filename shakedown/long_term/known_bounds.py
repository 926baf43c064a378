"""Limits already known for a joint and the start of a motion; no verdict may contradict them."""

from math import inf
from typing import TypeGuard

from shakedown.bounds.accumulated.accumulated_bound import ACCURACY, accumulated_bound
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.energy.energy_ball import no_ball_holds
from shakedown.bounds.energy.energy_bound import energy_bound
from shakedown.bounds.upper import upper_bound
from shakedown.ground.errors import Missing, allowed
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.derived import once_per_problem
from shakedown.joint.problem import Problem
from shakedown.long_term.passage import Passage

ABOVE = 1.0 + DEFAULT.agreement  # times λ_max: beyond its uncertainty
BELOW = 1.0 - NEGLIGIBLE  # times a proved load factor: below its round-off


def bound_proves(bound: Bound | Missing, load_factor: float) -> TypeGuard[Bound]:
    """Whether a bound proves shakedown at a load factor, beyond its round-off."""
    if isinstance(bound, Missing):
        return False
    return bool(bound.least_load_factor <= load_factor < BELOW * bound.load_factor)


def bound_of_start(begun: Passage) -> Bound | Missing:
    """λ_E of the start, computed once."""
    known, asked = _known_bounds(begun.problem), _key(begun, "energy")
    if asked not in known:
        known[asked] = allowed(
            energy_bound, begun.problem, begun.start, open_nodes=begun.open_nodes, certify=False,
            tolerances=begun.tolerances,
        )  # fmt: skip
    return known[asked]


def is_known(begun: Passage) -> bool:
    """Whether λ_E of the start is known already."""
    return _key(begun, "energy") in _known_bounds(begun.problem)


def proving_bound(begun: Passage) -> Bound | None:
    """λ_E of the start where it proves shakedown; not worked out where no ball is seen to hold the start."""
    asked = begun.problem, begun.load_factor, begun.start, begun.open_nodes, begun.tolerances
    if not is_known(begun) and allowed(no_ball_holds, *asked):
        return None
    bound = bound_of_start(begun)
    return bound if bound_proves(bound, begun.load_factor) else None


def note(begun: Passage, bound: Bound) -> None:
    """Store a limit that is proved from a start: λ_E or λ_S."""
    _known_bounds(begun.problem).setdefault(_key(begun, bound.kind), bound)


def slip_of_start(begun: Passage) -> Bound | Missing:
    """λ_S of the start, computed once; Missing where nodes are open there."""
    if begun.open_nodes:
        return Missing("λ_S is about all nodes closed")
    known, asked = _known_bounds(begun.problem), _key(begun, "accumulated")
    if asked not in known:
        known[asked] = accumulated_bound(begun.problem, begun.start)
    return known[asked]


def slip_unbounded_from(begun: Passage) -> float:
    """The least load factor known at which nothing bounds the total slip from the start; inf unknown.

    Nothing does at larger ones either, as the conditions of a bound cover all smaller load factors.
    """
    known = _known_bounds(begun.problem).get(_key(begun, "accumulated"))
    asked = _asked_slips(begun.problem).get(_key(begun), inf)
    if not known or known.status not in (Status.OPTIMAL, Status.INFEASIBLE):
        return asked
    found_to = (1.0 + 2.0 * ACCURACY[begun.problem.directions]) * known.load_factor
    return min(asked, found_to if known.status == Status.OPTIMAL else 0.0)


def note_slip_unbounded(begun: Passage, load_factor: float) -> None:
    """Store a load factor, less than those known, at which nothing bounds the total slip from a start."""
    _asked_slips(begun.problem)[_key(begun)] = load_factor


@once_per_problem
def _asked_slips(problem: Problem) -> dict[object, float]:
    """The least load factor asked about at which total slip has no bound, by the start."""
    return {}


def _key(begun: Passage, kind: str = "") -> object:
    return kind, begun.start.tobytes(), begun.open_nodes, begun.tolerances


@once_per_problem
def _known_bounds(problem: Problem) -> dict[object, Bound | Missing]:
    """Known proofs from a start of one problem, by kind, start, open nodes and tolerances."""
    return {}


@once_per_problem
def known_limits(problem: Problem) -> dict[str, float]:
    """λ_max and λ_U of a problem with all nodes closed, by their words, where they are known."""
    return {}


def bound_of_all(problem: Problem) -> float:
    """λ_max with all nodes closed, computed once; inf where unbounded, NaN where no slip is safe."""
    known = known_limits(problem)
    if "upper" not in known:
        found = allowed(upper_bound, problem)
        known["upper"] = inf if isinstance(found, Missing) else found.load_factor
    return known["upper"]


def beyond_all(begun: Passage) -> bool:
    """Whether a load factor is known to exceed λ_max, beyond its round-off."""
    return begun.load_factor > ABOVE * known_limits(begun.problem).get("upper", inf)
