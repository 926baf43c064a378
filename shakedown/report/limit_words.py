"""Sentences on limits other than the bounds: coupling ratio, λ_T, the limiting node."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shakedown.bounds.bound_result import Bound
from shakedown.ground.errors import Missing
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import DIGITS, certain_digits, count, down, few, up
from shakedown.ground.status import Status
from shakedown.report.assessment_words import beside_one, start_in_words
from shakedown.report.node_words import node_in_words, open_in_words

if TYPE_CHECKING:
    from shakedown.assessment.every_limit import JointLimits
    from shakedown.assessment.sensitivities import Sensitivities
    from shakedown.assessment.verify import Verification
    from shakedown.bounds.onset import Onset
    from shakedown.joint.problem import Problem

CAUSES = {"friction": "friction there", "constant": "constant load", "amplitude": "load amplitude"}
IN_SPACE = (
    "How much λ_max and λ_E depend on each node is computed for joints in the plane only. The table above "
    "shows which nodes reach their friction limits at λ_max, and in which load steps."
)
WITHOUT_SLIP = ", if no node slipped"
SLIGHT = 5e-4  # per cent: a smaller change is called none


def coupling_in_words(ratio: float) -> str:
    """Whether a coupling ratio ρ* is below 1, where the first collapse is the limit.

    Examples
    --------
    >>> coupling_in_words(0.5), coupling_in_words(1.5)
    ('below 1: the first collapse is the limit', 'not below 1')
    """
    return "below 1: the first collapse is the limit" if ratio < 1 else "not below 1"


def onsets_in_words(limits: JointLimits) -> list[tuple[str, float, str]]:
    """(name, load factor, remark) of first slip, and of first opening if no node slipped.

    Examples
    --------
    >>> import shakedown
    >>> limits = shakedown.assess(shakedown.example("press-fit")).details
    >>> for name, load_factor, remark in onsets_in_words(limits):
    ...     print(f"{name}: {load_factor:.4f}, {remark}")
    first slip: 0.3120, node 4 (FE 40/4); below it no node slips, starting without slip
    first opening: 1.7019, node 0 (FE 36/0), if no node slipped
    """
    slip, opening, problem = limits.first_slip, limits.first_opening, limits.problem
    start = start_in_words(limits.initial_slip is not None and bool(np.any(limits.initial_slip)))
    below = f"below it no node slips, starting {start}"
    return [
        ("first slip", slip.load_factor, _onset(slip, problem, f"; {below}", "no node slips at any λ")),
        ("first opening", opening.load_factor, _onset(opening, problem, WITHOUT_SLIP, f"none{WITHOUT_SLIP}")),
    ]


def _onset(found: Onset, problem: Problem, what: str, never: str) -> str:
    """The node, and what its load factor means; or why there is none."""
    if found.status == Status.INFEASIBLE:
        return found.reason
    return f"{node_in_words(problem, found.node)}{what}" if found.node >= 0 else never


def transient_limit_as_text(limit: Bound) -> str:
    """λ_T in as many digits as are certain."""
    return down(limit.load_factor, digits_of_transient_limit(limit))


def digits_of_transient_limit(limit: Bound) -> int:
    """How many digits its bisection has made certain; all that are shown where shakedown is proved there."""
    if limit.proved >= limit.load_factor:
        return DIGITS
    least = certain_digits(limit.load_factor, limit.high)
    told = (each for each in range(least, DIGITS) if not limit.proved > float(down(limit.load_factor, each)))
    return next(told, DIGITS)  # no fewer than say that it is not below what is proved


def transient_in_words(
    limit: Bound,
    problem: Problem | None = None,
    proved_below: float = np.nan,
    impossible_above: float = np.nan,
) -> str:
    """Up to where one history shakes down, and what was scanned to say so.

    With the problem it is said where that history is one path of many through a load domain; with the load
    factor below which a bound proves shakedown from the same state, where the simulations ended before that.
    A load factor just below the one above which shakedown is impossible gets the digits that tell them apart.
    """
    path = ", with the corners of the load domain in their order," * (
        problem is not None and problem.is_domain
    )
    here = f"In the simulation from its initial state{path}"
    scan = f"{len(limit.scanned)} load factors up to {few(limit.scanned[-1])} simulated"
    if np.isnan(limit.load_factor):
        return f"{here} the joint shakes down at no load factor ({scan})."
    if not np.isfinite(limit.high):
        return f"{here} the joint shakes down at every load factor ({scan})."
    order = "" if limit.monotone else "; below it there are load factors at which it does not"
    proved = ""
    cycling = _apart(limit.cycling, impossible_above)
    if np.isfinite(limit.proved):
        there = limit.proved == limit.load_factor and not order
        where = ", where that" if there else f"; at λ = {down(limit.proved)} that"
        proved = f"{where} is proved {followed_in_words(limit)}"
        if np.isfinite(limit.cycling):
            proved += f"{';' if there else ','} at λ = {cycling} {_found_above(limit)}"
    if limit.at_high is not None and limit.at_high.outcome == "undecided":
        undecided = f"it is undecided after {limit.at_high.cycles_simulated} cycles"
        if limit.at_high.stop is not None and limit.at_high.stop.spent:
            undecided = "nothing is known, as the computation allowed is spent"
        proved += f"; just above λ_T {'the body slides away' if limit.at_high.slides_away else undecided}"
        if proved_below > limit.load_factor:
            proved += f", and yet proved to shake down below λ = {down(proved_below)}"
    return (
        f"{here} the joint shakes down up to λ_T = {transient_limit_as_text(limit)}{order}{proved} ({scan})."
    )


def _apart(load_factor: float, limit: float) -> str:
    """A load factor rounded up, in more digits where it would read like a limit that is shown beside it."""
    texts = [up(load_factor, digits) for digits in range(DIGITS, 17)]
    return next((text for text in texts if text != up(limit)), texts[0])


def transient_beside_in_words(v: Verification) -> list[str]:
    """The same of a verification, beside its other limits; nothing where there is no λ_T."""
    if v.transient is None:
        return []
    proved, impossible = v.limits.from_state.load_factor, v.assessment.impossible_above
    return [transient_in_words(v.transient, v.problem, proved, impossible)]


def followed_in_words(limit: Bound) -> str:
    """After how many cycles of this history something is proved of it.

    Examples
    --------
    >>> import shakedown
    >>> followed_in_words(shakedown.transient_limit(shakedown.example("two-node"), accuracy=1e-4))
    'after 1 cycle'
    """
    cycles = limit.followed["cycles"]
    return f"after {count(cycles, 'cycle')}" if cycles else "from its start"


def proved_by_following(limits: JointLimits) -> tuple[str, str, str]:
    """(name, value, remark) of what is proved once the cycles of this history are followed.

    Examples
    --------
    >>> import shakedown
    >>> name, value, remark = proved_by_following(shakedown.assess(shakedown.example("block-9")).details)
    >>> name, value[:8], remark
    ('proved by following', 'λ = 4.70', 'at this λ, after 4 cycles')
    """
    name, limit = "proved by following", limits.transient
    if limit is None:
        return name, "open", "there is no λ_max up to which to seek it"
    if isinstance(limit, Missing):
        return name, "open", limit.reason
    if limit.at_proved is None:
        return name, "none", "nowhere in this history"
    return name, f"λ = {beside_one(limit.proved, down)}", f"at this λ, {followed_in_words(limit)}"


def _found_above(limit: Bound) -> str:
    """Which long-term state was found at ``cycling``."""
    outcome = limit.outcomes[limit.scanned.tolist().index(limit.cycling)]
    state = limit.at_high if limit.at_high is not None and limit.high == limit.cycling else None
    if state is not None and outcome == "separation":
        if not state.period:
            return "the body was found to leave"
        nodes = tuple(j for j in np.flatnonzero(state.opened).tolist() if j not in state.open_nodes)
        verbs = "opens and closes" if len(nodes) == 1 else "open and close"
        return f"separation was found ({open_in_words(nodes)} {verbs}, no slip in contact)"
    return f"{outcome.replace('-', ' ')} was found"


def sensitivities_in_words(limits: JointLimits) -> list[str]:
    """Which node limits λ_max, and which λ_E, most, and by how much the limit moves with one per cent there.

    Examples
    --------
    >>> import shakedown
    >>> for line in sensitivities_in_words(shakedown.assess(shakedown.example("two-node")).details):
    ...     print(line)
    λ_max depends most on node 1: +0.92 % with 1 % more friction there, +0.96 % with 1 % more constant
    load, −0.97 % with 1 % more load amplitude.
    λ_E depends most on node 1: +0.95 % with 1 % more friction there, +0.95 % with 1 % more constant
    load, −0.97 % with 1 % more load amplitude.
    """
    if "sensitivities" in limits.absent:
        return [IN_SPACE]
    symbols = {"upper": "λ_max", "energy": "λ_E"}
    sentences = [
        f"Which node limits {symbols[name]} is left out: {found.reason} (docs/interpretation.md)."
        if isinstance(found, Missing)
        else limited_in_words(found, limits.problem)
        for name, found in limits.sensitivities.items()
    ]
    return [sentence for sentence in sentences if sentence]


def limited_in_words(found: Sensitivities, problem: Problem, name: str = "") -> str:
    """Which node limits one bound, called by its symbol or a name; empty where there is no derivative."""
    ranked = found.ranked()
    if not ranked.size:
        return ""
    node = int(ranked[0])
    effects = [_effect(getattr(found, kind).elasticity[node], name) for kind, name in CAUSES.items()]
    where = node_in_words(problem, node)
    return f"{name or found.symbol} depends most on {where}: {', '.join(filter(None, effects))}."


def _effect(sides: FloatArray, name: str) -> str:
    """The effect of one per cent more of a quantity, and of one per cent less if that is not the opposite."""
    fallen, grown = sides
    if np.isnan(fallen) or np.isnan(grown):
        return ""
    more = f"{_signed(grown)} with 1 % more {name}"
    alike = abs(grown - fallen) <= SLIGHT * max(1.0, abs(grown))
    return more if alike else f"{more} ({_signed(-fallen)} with 1 % less)"


def _signed(percent: float) -> str:
    return f"{percent:+.2g} %".replace("-", "−") if abs(percent) >= SLIGHT else "unchanged"
