"""How far the first collapse is a guarantee of shakedown from every initial state.

The proofs are statements 1 to 6 of docs/guarantee.md. In short: below λ_1 no slip has all
nodes between their limits and one of them collapsed (statement 1), and every cycle would need
one where coupling is weak (3), where one node moves alone (4), or where there are two nodes (5).
That no node lifts off is checked apart (6, ``lift_off``). All of it follows one loop in its
order: of a load domain nothing is proved here.
"""

from dataclasses import dataclass, replace
from math import isnan, nan

from shakedown.bounds.coupling import WEAK, Coupling, coupling
from shakedown.bounds.lift_off import lift_off_bound
from shakedown.bounds.single_node_cycle import single_node_cycle
from shakedown.evidence import Missing, sought
from shakedown.model.problem import Problem
from shakedown.shown_values import down, up
from shakedown.tolerances import DEFAULT, Tolerances
from shakedown.uniqueness.in_contact import unique_in_contact

ANY_ORDER = (
    "the load steps are the corners of a load domain, and λ_1 is about a loop that returns to each of them "
    "in every period: what is proved of every path is λ_U"
)


@dataclass(frozen=True)
class GuaranteeStatus:
    """Status of the guarantee below the first collapse, with the evidence.

    Attributes
    ----------
    guarantee
        ``"proved"``: below λ_1 the system shakes down from every initial state with
        all nodes closed. ``"single-node-excluded"``: no node alone can slip
        cyclically. ``"evidence"``: nothing is proved.
    reason
        Why, in words.
    coupling_ratio
        ρ; NaN where a node is at or above its own critical friction.
    single_node_bound
        Load factor below which no node alone can slip cyclically; NaN where not computed, and
        for a load domain.
    lift_off_bound
        Load factor below which no admissible slip lifts a node off; NaN where not computed.
    """

    guarantee: str
    reason: str
    coupling_ratio: float
    single_node_bound: float
    lift_off_bound: float


def guarantee_status(
    problem: Problem, load_factor: float, *, tolerances: Tolerances = DEFAULT
) -> GuaranteeStatus:
    """What is proved about shakedown from every initial state below the first collapse.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    load_factor
        Its first collapse λ_1.
    tolerances
        A bound that misses λ_1 by no more than ``feasibility`` reaches it: the claim is
        about load factors below λ_1.

    Examples
    --------
    >>> import shakedown
    >>> status = guarantee_status(shakedown.example("three-node"), 3.096)
    >>> status.guarantee, round(status.coupling_ratio, 3), round(status.single_node_bound, 4)
    ('evidence', 1.342, 2.4442)
    """
    influence, cycle = coupling(problem), sought(single_node_cycle, problem, tolerances=tolerances)
    if isinstance(cycle, Missing):
        rest = _status(problem, load_factor, influence, nan, tolerances)
        return replace(rest, reason=f"{rest.reason}; the single-node bound is missing: {cycle.reason}")
    return _status(problem, load_factor, influence, cycle.load_factor, tolerances)


def _status(
    problem: Problem, load_factor: float, influence: Coupling, alone: float, tolerances: Tolerances
) -> GuaranteeStatus:
    """The status, with the load factor below which no node cycles alone (NaN where that is not known)."""
    if problem.is_domain and load_factor > 0.0:
        return GuaranteeStatus("evidence", ANY_ORDER, influence.ratio, alone, nan)
    if not problem.B.any():
        reason = "no coupling (B = 0): Melan's theorem holds, both bounds coincide"
        return GuaranteeStatus("proved", reason, influence.ratio, alone, nan)
    if load_factor == 0.0:
        return GuaranteeStatus("evidence", "there is nothing to guarantee", influence.ratio, alone, nan)
    reached = load_factor * (1 - tolerances.feasibility)
    argument = _argument(problem, influence, tolerances)
    if argument:
        stays_closed = sought(lift_off_bound, problem, enough=load_factor, tolerances=tolerances)
        if isinstance(stays_closed, Missing):
            caveat = f"{argument}, but the lift-off bound is missing: {stays_closed.reason}"
            return GuaranteeStatus("single-node-excluded", caveat, influence.ratio, alone, nan)
        if stays_closed >= reached:
            return GuaranteeStatus("proved", argument, influence.ratio, alone, stays_closed)
        caveat = (
            f"{argument}, but from the load factor {up(stays_closed)} on locked-in slip can lift a node off"
        )
        return GuaranteeStatus("single-node-excluded", caveat, influence.ratio, alone, stays_closed)
    return _without_proof(reached, influence, alone)


def _argument(problem: Problem, influence: Coupling, tolerances: Tolerances) -> str:
    """The proof that holds while all nodes are closed, in words; empty where there is none."""
    unique = sought(unique_in_contact, problem, tolerances=tolerances) if problem.n <= 2 else None
    if unique:
        return f"{'one node' if problem.n == 1 else 'two nodes'} below the friction thresholds (thesis §4.4)"
    if influence.bound <= WEAK:
        return f"weak coupling, ratio {influence.ratio:.3g} <= 1/3"
    return ""


def _without_proof(reached: float, influence: Coupling, alone: float) -> GuaranteeStatus:
    """No proof: at most, cycles of one node alone are excluded."""
    status, ratio = "evidence", influence.ratio
    if influence.bound < 1.0:
        status, reason = (
            "single-node-excluded",
            f"coupling ratio {ratio:.3g} < 1: no node can cycle alone",
        )
    elif alone >= reached:
        status, reason = "single-node-excluded", f"no node can cycle alone below {down(alone)}"
    elif isnan(ratio):
        reason = "a node is at or above its own critical friction: there is no proof, only simulation"
    elif isnan(alone):
        reason = f"strong coupling, ratio {ratio:.3g}: there is no proof, only simulation"
    else:
        reason = f"strong coupling, ratio {ratio:.3g}: a node may cycle alone from {up(alone)} on"
    return GuaranteeStatus(status, reason, ratio, alone, nan)
