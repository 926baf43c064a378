"""What is proved of a joint, and from the start of a motion; no verdict may contradict it."""

from math import inf
from typing import Any, TypeGuard

from shakedown.bounds.accumulated.accumulated_bound import ACCURACY, accumulated_bound, total_slip_bound
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.energy.energy_ball import no_ball_holds
from shakedown.bounds.energy.energy_bound import energy_bound
from shakedown.bounds.upper import upper_bound
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.errors import Missing, allowed
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.shown_values import short
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


def bound_of_start(begun: Passage, kind: str = "energy") -> Bound | Missing:
    """λ_E, or λ_S (``"accumulated"``), of the start, computed once; λ_S is Missing where nodes are open."""
    known, key = _bounds_of_starts(begun.problem), _key(begun, kind)
    if key not in known:
        if kind == "energy":
            zone: dict[str, Any] = {"open_nodes": begun.open_nodes, "tolerances": begun.tolerances}
            known[key] = allowed(energy_bound, begun.problem, begun.start, certify=False, **zone)
        elif begun.open_nodes:
            known[key] = Missing("λ_S is about all nodes closed")
        else:
            known[key] = accumulated_bound(begun.problem, begun.start)
    found: Bound | Missing = known[key]
    return found


def is_known(begun: Passage) -> bool:
    """Whether λ_E of the start is known already."""
    return _key(begun, "energy") in _bounds_of_starts(begun.problem)


def note(begun: Passage, bound: Bound) -> None:
    """Store a limit that is proved from a start: λ_E or λ_S."""
    _bounds_of_starts(begun.problem).setdefault(_key(begun, bound.kind), bound)


def proving_bound(begun: Passage) -> Bound | None:
    """λ_E of the start where it proves shakedown; not worked out where no ball is seen to hold the start."""
    asked = begun.problem, begun.load_factor, begun.start, begun.open_nodes, begun.tolerances
    if not is_known(begun) and allowed(no_ball_holds, *asked):
        return None
    bound = bound_of_start(begun)
    return bound if bound_proves(bound, begun.load_factor) else None


def further_from(problem: Problem, load_factor: float, slip: FloatArray, error: float = 0.0) -> float:
    """The bound on the total slip of any node from a closed state known to an error; inf where unknown."""
    found = total_slip_bound(problem, load_factor, slip, start_error=error)
    return float(found.total_slip.max()) if found.status == Status.OPTIMAL else inf


def further_from_start(begun: Passage) -> float:
    """The bound on the total slip of any node from the start; inf where it is not known.

    At λ = 0 it is asked for first, as where there is none there it is told soonest. Nothing bounds it at load
    factors larger than one at which nothing does, as the conditions of a bound cover all smaller ones.
    """
    of_starts, key = _bounds_of_starts(begun.problem), _key(begun, "unbounded slip")
    least, known = of_starts.get(key, inf), of_starts.get(_key(begun, "accumulated"))
    if known and known.status == Status.INFEASIBLE:
        least = 0.0
    elif known and known.status == Status.OPTIMAL:
        least = min(least, (1.0 + 2.0 * ACCURACY[begun.problem.directions]) * known.load_factor)
    further = inf
    if begun.open_nodes or begun.load_factor >= least:
        return further
    for load_factor in (0.0, begun.load_factor):
        further = further_from(begun.problem, load_factor, begun.start)
        if further == inf:
            of_starts[key] = load_factor
            break
    return further


@on_one_thread
def proof_from_start(begun: Passage) -> str:
    """What proves that a motion shakes down from its start, in words; empty where nothing does."""
    bound = proving_bound(begun)
    if bound is not None:
        return f"below λ_E = {short(bound.load_factor)} of its start"
    return "below λ_S of its start" if further_from_start(begun) < inf else ""


def _key(begun: Passage, kind: str) -> object:
    return kind, begun.start.tobytes(), begun.open_nodes, begun.tolerances


@once_per_problem
def _bounds_of_starts(problem: Problem) -> dict[object, Any]:
    """Known proofs from a start of one problem, by kind, start, open nodes and tolerances.

    Also the least load factor asked about at which total slip has no bound ("unbounded slip").
    """
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
