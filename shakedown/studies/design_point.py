"""One point of a design: every limit of its load factor, each with how it was found."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import inf, nan
from typing import Any, Literal, NamedTuple

import numpy as np

from shakedown.assessment.every_limit import JointLimits
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.registry import BOUNDS, Claim, kinds_of
from shakedown.ground.errors import Missing, allowed
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import SIX_DIGITS, THREE_DIGITS
from shakedown.ground.shown_values import few, nodes_in_words, up
from shakedown.ground.status import Guarantee, Outcome, Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.find_state import long_term_state

ALL = 9  # digits, so that contradictions are visible


class DesignLimit(NamedTuple):
    """One limit of the load factor.

    Attributes
    ----------
    load_factor
        NaN where there is none, inf where every load factor is on its safe side.
    status
        How it was found (:class:`Status`).
    remark
        What else should be known; empty where nothing.
    low, high
        For λ_T: shakedown is proved at ``low``, a cycle was found at ``high``; else NaN.
    """

    load_factor: float
    status: Status
    remark: str = ""
    low: float = nan
    high: float = nan


class SlipAllowed(NamedTuple):
    """The load factor up to which slips stay below a length, as ``slip_limit.SlipLimit`` has it.

    Attributes
    ----------
    below
        The length [length].
    load_factor
        The largest load factor simulated up to which every slip range does; NaN where there is none.
    largest
        The largest slip range there [length].
    """

    below: float
    load_factor: float
    largest: float


@dataclass(frozen=True, eq=False, repr=False)
class DesignPoint(Result):
    """The limits of the load factor of one joint.

    Attributes
    ----------
    values
        The values of the parameters.
    limits
        By name (``lower``, ``universal``, ``energy``, ``accumulated``, ``transient``, ``upper``);
        empty where there is no such joint.
    guarantee
        Whether λ_1 is a guarantee (as that bound says it); empty where it was not asked for.
    open_nodes
        Nodes that stay open in the state that λ_max and λ_E belong to.
    reason
        Why there is no such joint; empty where there is.
    proved_from_this_state
        As ``assess`` has it, whichever limits from this state are asked for; NaN where none is, or not known.
    outcomes
        What becomes of the joint at each load factor that was asked for (:class:`Outcome`).
    contradictions
        Limits that cannot all be right, in words: an error of this toolkit or of its theory.
    slip_criterion
        Up to which load factor slips stay below a length; None where that was not asked for.
    """

    values: tuple[float, ...]
    limits: dict[str, DesignLimit] = field(default_factory=dict)
    guarantee: str = ""
    open_nodes: tuple[int, ...] = ()
    reason: str = ""
    proved_from_this_state: float = nan
    outcomes: tuple[Outcome, ...] = ()
    contradictions: tuple[str, ...] = ()
    slip_criterion: SlipAllowed | None = None

    @property
    def exists(self) -> bool:
        """Whether the values of the parameters make a joint."""
        return not self.reason


def point_of(said: dict[str, Any]) -> DesignPoint:
    """The point whose fields JSON has said."""
    fields: dict[str, Any] = {
        name: tuple(each) if isinstance(each, list) else each for name, each in said.items()
    }
    limits = {
        name: DesignLimit(at, Status(status), *rest) for name, (at, status, *rest) in said["limits"].items()
    }
    fields |= {"limits": limits, "outcomes": tuple(map(Outcome, said["outcomes"]))}
    slips = said["slip_criterion"]
    return DesignPoint(**fields | {"slip_criterion": slips and SlipAllowed(*slips)})


class Question(NamedTuple):
    """The request for every point.

    Attributes
    ----------
    bounds
        Names of the limits.
    load_factors
        Where to simulate.
    initial_slip : (n,) or None
        The state that λ_E, λ_S, λ_T and simulations are about [length]; zero by default.
    open_nodes
        ``"auto"``: the zone with the largest λ_max; ``()``: all nodes in contact.
    quick
        λ_T to 0.1 %.
    slip_below
        A length that slip ranges are to stay below; None: nothing is asked about slips.
    tolerances
        What decides.
    """

    bounds: tuple[str, ...] = tuple(BOUNDS)
    load_factors: tuple[float, ...] = ()
    initial_slip: FloatArray | None = None
    open_nodes: tuple[()] | Literal["auto"] = "auto"
    quick: bool = False
    slip_below: float | None = None
    tolerances: Tolerances = DEFAULT


def design_point(problem: Problem, values: tuple[float, ...], question: Question) -> DesignPoint:
    """The limits of one joint, each by its fastest method.

    A limit whose program fails is undecided, with the reason as its remark.

    Examples
    --------
    >>> import shakedown
    >>> point = design_point(shakedown.example("two-node"), (0.35,), Question())
    >>> {name: round(limit.load_factor, 3) for name, limit in point.limits.items()}
    {'lower': 0.657, 'universal': 0.657, 'energy': 0.662, 'accumulated': 0.732, ...}
    """
    start, tolerances = question.initial_slip, question.tolerances
    joint = JointLimits(
        problem,
        start,
        zone=question.open_nodes,
        certify=False,
        accuracy=THREE_DIGITS if question.quick else SIX_DIGITS,
        tolerances=tolerances,
    )
    found: dict[str, Any] = {name: allowed(getattr, joint, name) for name in question.bounds}
    found |= {name: each for name, each in vars(joint).items() if name in BOUNDS}  # what these rest on
    limits = {name: _limit(name, each) for name, each in found.items()}
    guarantee = found["lower"].guarantee if found.get("lower") else ""
    open_nodes = found["upper"].open_nodes if found.get("upper") else ()
    here = allowed(getattr, joint, "proved_from_this_state") if {*question.bounds} & {*from_here()} else nan
    ends = [  # missing where loads are too large to follow
        allowed(long_term_state, problem, x, start, tolerances=tolerances) for x in question.load_factors
    ]
    slips = None if question.slip_below is None else _slips(joint, question.slip_below)
    proofs = from_here()
    if problem.q_transient is None:  # these are about closed nodes, and a transient may open some
        proofs += ["universal"] + ["lower"] * (guarantee == Guarantee.PROVED)
    proved = {name: limits[name] for name in proofs if name in limits}
    contradictions = [*out_of_order(limits, tolerances, closed=not open_nodes)]
    if found.get("transient") and not open_nodes:
        contradictions += cycles_below(proved, found["transient"], tolerances)
    return DesignPoint(
        values=values,
        limits={name: limits[name] for name in question.bounds},
        guarantee=guarantee if "lower" in question.bounds else "",
        open_nodes=open_nodes,
        proved_from_this_state=nan if isinstance(here, Missing) else here,
        outcomes=tuple(end.outcome if end else Outcome.UNDECIDED for end in ends),
        contradictions=tuple(contradictions),
        slip_criterion=slips,
    )


def _limit(name: str, result: Bound | Missing | None) -> DesignLimit:
    """A limit with how it was found."""
    if result is None or isinstance(result, Missing):
        reason = "no finite λ_max to scan up to" if result is None else result.reason
        return DesignLimit(nan, Status.UNDECIDED, reason)
    remarks, status, least = [result.reason] if result.reason else [], result.status, result.least_load_factor
    if BOUNDS[name].claim == Claim.IMPOSSIBLE:
        if result.open_nodes:
            zone = f"of the zone with {nodes_in_words(result.open_nodes)} open"
            remarks.append(f"{zone}: no upper bound of the joint")
        if least > 0:
            remarks.append(f"safe slips exist only from λ = {up(least)} on")
    elif 0 < least < inf:
        remarks, status = [f"proved only from λ = {up(least)} on"], Status.UNDECIDED
    followed = BOUNDS[name].claim == Claim.FOLLOWED
    load_factor = nan if followed and status != Status.OPTIMAL else result.load_factor
    ends = (result.proved, result.cycling) if followed else ()
    return DesignLimit(load_factor, status, "; ".join(remarks), *ends)


def from_here() -> list[str]:
    """The limits that are proved from the state asked about."""
    return [kind.name for kind in kinds_of(Claim.THIS_STATE)]


def _slips(joint: JointLimits, below: float) -> SlipAllowed:
    found = allowed(joint.slip, below)
    if isinstance(found, Missing):
        return SlipAllowed(below, nan, nan)
    return SlipAllowed(below, found.load_factor, found.largest)


def out_of_order(limits: Mapping[str, DesignLimit], tolerances: Tolerances, *, closed: bool) -> Iterator[str]:
    """Contradictions to λ_U ≤ λ_1 and, of closed nodes, to λ_1, λ_U, λ_E, λ_S ≤ λ_max."""
    pairs = [("universal", "lower")]
    if closed:  # λ_1 and λ_U are about all nodes in contact
        pairs += [(name, "upper") for name in ("lower", "universal", *from_here())]
    for small, large in pairs:
        if small in limits and large in limits:
            a, b = limits[small].load_factor, limits[large].load_factor
            if a * (1.0 - tolerances.agreement) > b:
                yield f"{BOUNDS[small].symbol} = {few(a, ALL)} exceeds {BOUNDS[large].symbol} = {few(b, ALL)}"


def cycles_below(proved: Mapping[str, DesignLimit], history: Bound, tolerances: Tolerances) -> Iterator[str]:
    """Contradictions to no cycle below what is proved of this history."""
    slips = np.isin(history.outcomes, [Outcome.CYCLIC_SLIP, Outcome.RATCHETTING])
    for first in history.scanned[slips][:1]:
        for name, limit in proved.items():
            if limit.load_factor * (1.0 - tolerances.agreement) > first:
                below = f"below {BOUNDS[name].symbol} = {few(limit.load_factor, ALL)}"
                yield f"slip goes on for ever at λ = {few(first, ALL)}, {below}"
