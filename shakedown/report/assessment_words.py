"""What is certain: the three numbers of a joint, the nominal load, and what they rest on."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from typing import TYPE_CHECKING

import numpy as np

from shakedown.bounds.bound_result import Bound
from shakedown.ground.shown_values import DIGITS, FEW_DIGITS, down, few, up
from shakedown.ground.status import Said, Status
from shakedown.joint.units import varying_loads_in_words
from shakedown.report.hint_words import LOAD_DOMAIN, last_digit_in_words
from shakedown.report.node_words import open_in_words

if TYPE_CHECKING:
    from shakedown.assessment.assess import Assessment
    from shakedown.assessment.every_limit import JointLimits
    from shakedown.ground.float_array import FloatArray
    from shakedown.joint.problem import Problem

IN_CONTACT = "while all nodes stay in contact"
HEADING = "Shakedown under λ times the varying part of the load is"  # above the three numbers
ARGUMENTS = {  # what the names of the proofs of λ_U stand for, where they are not self-explanatory
    "Melan": "slip changes no pressure",
    "differences": "no slip raises the differences between nodes",
    "swing": "a potential decreases with every slip",
    "least pressures": "friction under its least pressure holds each node, however the others slip",
    "rigid motions apart": "slip of a body as a whole is bounded separately",
}


def numbers_in_words(found: Assessment) -> list[tuple[str, str, str]]:
    """(name, value, remark) of the three numbers of a joint; each rounded so that it stays true.

    Examples
    --------
    >>> import shakedown
    >>> for line in numbers_in_words(shakedown.assess(shakedown.example("two-node"))):
    ...     print(*line, sep=" | ")
    proved from every state | λ = 0.6573734 | while all nodes stay in contact
    proved from this state | λ = 0.7315934 | starting without slip
    impossible above | λ_max = 0.7391456 | while all nodes stay in contact
    """
    limits = found.details
    numbers = _aligned(
        [
            _number(found.proved_from_every_state, down),
            _number(found.proved_from_this_state, down),
            _number(found.impossible_above, up),
        ]
    )
    symbols = ["λ", "λ", "λ_max"]
    values = [
        f"{symbol} = {number}" if number[0].isdigit() else number
        for symbol, number in zip(symbols, numbers, strict=True)
    ]
    names = ["proved from every state", "proved from this state", "impossible above"]
    remarks = [IN_CONTACT, _this_state(limits), _where_impossible(limits)]
    return list(zip(names, values, remarks, strict=True))


def _aligned(numbers: list[str]) -> list[str]:
    """Pad numbers with equal integer parts to the same number of decimals."""
    decimals: dict[str, int] = {}
    for whole, _, rest in (number.partition(".") for number in numbers):
        decimals[whole] = max(decimals.get(whole, 0), len(rest) * ("e" not in rest))
    return [
        f"{whole}.{rest.ljust(decimals[whole], '0')}" if rest and "e" not in rest else whole + point + rest
        for whole, point, rest in (number.partition(".") for number in numbers)
    ]


def _where_impossible(limits: JointLimits) -> str:
    """What is excluded above λ_max."""
    if limits.open_nodes:
        return f"not known: {_open(limits)}"
    if limits.upper.status == Status.UNDECIDED:
        return "not known: no zone with a safe slip was found"
    every = limits.upper.status == Status.UNBOUNDED
    return "a safe slip exists at every λ" if every else IN_CONTACT


def _this_state(limits: JointLimits) -> str:
    """The state that is asked about."""
    opened = limits.problem.layout.slips_of(limits.open_nodes)
    slip = np.delete(limits.energy.initial_slip, opened)
    near = "near " * (limits.distance > 0)
    return f"starting {near}{start_in_words(slip)}" + (f", {_open(limits)}" if limits.open_nodes else "")


def start_in_words(slip: FloatArray | bool) -> str:
    """The initial state, as it continues a sentence after “starting”."""
    return "from the given slip" if np.any(slip) else "without slip"


def _open(limits: JointLimits) -> str:
    return f"{len(limits.open_nodes)} node{'s' * (len(limits.open_nodes) != 1)} open"


def _number(value: float, rounded: Callable[[float, int], str]) -> str:
    """A load factor as one of the three numbers; in words where there is none, or no end to them."""
    if np.isnan(value):
        return "open"
    if np.isinf(value):
        return "any λ" if rounded is down else "no limit"
    return beside_one(value, rounded) if value > 0 or rounded is up else "nothing proved"


def beside_one(value: float, rounded: Callable[[float, int], str], digits: int = DIGITS) -> str:
    """A load factor, with more digits where rounding would hide on which side of 1 it lies.

    Examples
    --------
    >>> beside_one(1.27345678, down), beside_one(1.00000004, down), beside_one(0.99996, up)
    ('1.273456', '1.00000004', '0.99996')
    """
    texts = [rounded(value, more) for more in range(digits, 17)]
    return next((text for text in texts if np.sign(float(text) - 1) == np.sign(value - 1)), texts[-1])


def at_load_factor(
    problem: Problem, load_factor: float, rounded: Callable[[float, int], str], digits: int = DIGITS
) -> str:
    """A load factor in the user's loads; alone where the problem does not know them."""
    factor, loads = f"λ = {beside_one(load_factor, rounded, digits)}", loads_at(problem, load_factor, rounded)
    return f"{loads} ({factor})" if loads else factor


def loads_at(problem: Problem, load_factor: float, rounded: Callable[[float, int], str]) -> str:
    """The varying loads at a load factor; a single one without its name, empty where none are known.

    Examples
    --------
    >>> import dataclasses, shakedown
    >>> loads = {"load_names": ["shear"], "load_mean": [20], "load_amplitude": [20], "load_units": ["N"]}
    >>> loads_at(dataclasses.replace(shakedown.example("two-node"), **loads), 1.2734, down)
    '20 ± 25.46 N'
    """
    loads = varying_loads_in_words(problem, load_factor, "down" if rounded is down else "up")
    varying = [load for load in problem.loads if load.amplitude != 0]
    return loads.removeprefix(f"{varying[0].name} ") if len(varying) == 1 else loads


def percent(load_factor: float, rounded: Callable[[float, int], str]) -> str:
    """How far a load factor is from 1.

    Examples
    --------
    >>> percent(1.679993, down), percent(0.73159, up)
    ('67.99 %', '26.85 %')
    """
    if np.isinf(load_factor):
        return "arbitrarily"
    return f"{rounded(float(abs(Decimal(repr(float(load_factor))) - 1) * 100), FEW_DIGITS)} %"


def loads_of_numbers(found: Assessment) -> list[str]:
    """The three numbers of a joint in the user's loads; empty where these are not known."""
    limits = (
        (found.proved_from_every_state, down),
        (found.proved_from_this_state, down),
        (found.impossible_above, up),
    )
    known = ((value if np.isfinite(value) and value > 0 else np.nan, rounded) for value, rounded in limits)
    return [loads_at(found.problem, value, rounded) for value, rounded in known]


def said_as_given_in_words(found: Assessment) -> str:
    """What becomes of the nominal load (λ = 1), where the bounds decide it.

    Examples
    --------
    >>> import shakedown
    >>> said_as_given_in_words(shakedown.assess(shakedown.example("block-9")))
    'At the nominal load (λ = 1) the joint shakes down, proved from this state.'
    """
    given = "At the nominal load (λ = 1)"
    if found.said_as_given == Said.SHAKEDOWN and found.proved_from_every_state > 1:
        return f"{given} the joint shakes down, proved from every state."
    if found.said_as_given == Said.SHAKEDOWN:
        return f"{given} the joint shakes down, proved from this state."
    if found.said_as_given == Said.IMPOSSIBLE:
        return f"{given} the joint cannot shake down {IN_CONTACT}."
    if found.details.open_nodes:
        these = "this node opens" if len(found.details.open_nodes) == 1 else "these nodes open"
        return f"{given} the bounds do not decide whether {these}."
    energy = found.details.energy
    why = f": {energy.reason}" if energy.status == Status.INFEASIBLE else ""
    return f"{given} the bounds do not decide{why}."


def certain_in_words(limits: JointLimits) -> list[str]:
    """What is certain, first of all: proved from this state, proved from every state, excluded.

    For a load domain it adds that this holds for every path; it also says where it is not clear whether
    the joint can move as a whole.

    Examples
    --------
    >>> import shakedown
    >>> for line in certain_in_words(shakedown.assess(shakedown.example("two-node")).details):
    ...     print(line)
    Starting without slip, the joint is proved to shake down up to λ = 0.7315934 (by the total slip of its
    nodes; by energy up to λ_E = 0.6619611); from every initial state with all nodes in contact and within
    their friction limits up to λ_U = 0.6573734 (first collapse); above λ_max = 0.7391456 it cannot shake
    down while all nodes stay in contact; all for these 50 load steps, joined by straight lines.
    """
    here = _proved_from_here(limits.energy, limits.from_state, limits.problem)
    return _certain([here, _proved_from_everywhere(limits.universal)], limits.upper, limits.problem)


def load_steps_in_words(problem: Problem) -> str:
    """For which path of the loads every limit holds; empty for a load domain, which is about every path."""
    if problem.is_domain or problem.m < 2:
        return ""
    return f"for these {problem.m} load steps, joined by straight lines"


def quickly_in_words(energy: Bound, upper: Bound, problem: Problem) -> list[str]:
    """What is certain by λ_E and λ_max alone."""
    return _certain([_proved_from_here(energy, energy, problem)], upper, problem)


def _certain(parts: list[str], upper: Bound, problem: Problem) -> list[str]:
    if upper.status == Status.OPTIMAL and not upper.open_nodes:
        often = " on a path that returns to all corners" * problem.is_domain
        parts.append(f"above λ_max = {up(upper.load_factor)} it cannot shake down{often} {IN_CONTACT}")
    steps = load_steps_in_words(problem)
    sentence = "; ".join([*filter(None, parts), *([f"all {steps}"] if steps else [])])
    return [sentence + ".", *last_digit_in_words(problem), *([LOAD_DOMAIN] if problem.is_domain else [])]


def _proved_from_here(energy: Bound, here: Bound, problem: Problem) -> str:
    closed = np.delete(energy.initial_slip, problem.layout.slips_of(energy.open_nodes))
    start = f"Starting {start_in_words(closed)}"
    if energy.distance > 0:
        near = "the given slip" if np.any(closed) else "zero slip"
        start = f"Starting from any slip within the energy distance {few(energy.distance)} of {near}"
    if energy.open_nodes:
        start += f", with {open_in_words(energy.open_nodes, problem)} open and in equilibrium"
    if here.kind != "energy":
        how = "by the total slip of its nodes"
        if np.isinf(here.load_factor):
            return f"{start}, the joint is proved to shake down at every load factor ({how})"
        also = "" if np.isnan(energy.load_factor) else f"; by energy up to λ_E = {down(energy.load_factor)}"
        up_to = f"λ = {down(here.load_factor)} ({how}{also})"
        return f"{start}, the joint is proved to shake down up to {up_to}"
    if energy.status == Status.UNDECIDED:
        return f"{start}, it is open what is proved ({energy.reason})"
    if energy.status == Status.INFEASIBLE:
        hint = (
            "a smaller distance may do" if energy.distance > 0 else "following its first cycles may prove one"
        )
        return f"{start}, no load factor is proved at once ({energy.reason}; {hint})"
    least = energy.least_load_factor
    begins = f" from λ = {up(least)} on" if least > 0 else ""
    if energy.status == Status.UNBOUNDED:
        return f"{start}, the joint is proved to shake down at every load factor{begins}"
    return f"{start}, the joint is proved to shake down{begins} up to λ_E = {down(energy.load_factor)}"


def _proved_from_everywhere(universal: Bound) -> str:
    if universal.status == Status.UNDECIDED:
        return f"from every initial state it is open what is proved ({universal.reason})"
    if np.isnan(universal.load_factor):
        return ""
    how = argument_in_words(universal)
    if universal.load_factor == 0:
        return f"from every initial state no load factor is proved ({universal.reason})"
    if np.isinf(universal.load_factor):
        return f"from every initial state {admissible_in_words(universal)} at every load factor ({how})"
    number = f"λ_U = {down(universal.load_factor)}"
    return f"from every initial state {admissible_in_words(universal)} up to {number} ({how})"


def argument_in_words(universal: Bound) -> str:
    """What proves λ_U, and what that means.

    Examples
    --------
    >>> import shakedown
    >>> argument_in_words(shakedown.universal_bound(shakedown.example("uncoupled")))
    'Melan: slip changes no pressure'
    """
    parts = universal.argument.split(", ")
    return "; ".join(": ".join(filter(None, [part, ARGUMENTS.get(part)])) for part in parts)


def admissible_in_words(universal: Bound | None) -> str:
    """Which initial states λ_U is about."""
    over = universal is not None and universal.after_transient
    return "with all nodes in contact and within their friction limits" + " after the transient" * over


def proved_up_to(universal: Bound | None) -> float:
    """λ_U; 0 where there is none."""
    return 0.0 if universal is None or np.isnan(universal.load_factor) else universal.load_factor
