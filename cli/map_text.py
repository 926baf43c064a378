"""What a map of initial states says to people."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

import shakedown
from shakedown import Problem
from shakedown.ground.shown_values import at_lambda, sized
from shakedown.ground.visible_text import shortened, with_unit
from shakedown.joint.units import units_of
from shakedown.report.hint_words import simulated_path_in_words
from shakedown.report.node_words import open_in_words, resolution, without_round_off

from .output import headline, listing, number, paragraph, table

if TYPE_CHECKING:  # they load what computes
    from shakedown import InitialStateMap, InitialStateMaps, LimitCycle
SAMPLED = {  # after "of N states"
    "grid": "on a grid about {centre}",
    "sobol": "in a box about {centre}",
    "latin": "in a box about {centre}",
    "ball": "in a ball about the centre of the energy ball",
    "transients": "left behind by random load steps",
}
MEANING = {
    "shakedown": "slip has ceased",
    "cyclic-slip": "nodes slip in every period and return",
    "ratchetting": "slips grow by the same amount in every period",
    "separation": "nodes open and close in every period, none slips",
    "undecided": "none of these could be established",
}

NODES = 16  # characters for the nodes that slip: a table has 80 columns


def map_text(problem: Problem, found: InitialStateMap | InitialStateMaps) -> str:
    """One load factor with all that is known of it, or a row for each of several."""
    lines = [headline(problem), "", *(paragraph(text) for text in simulated_path_in_words(problem))]
    if isinstance(found, shakedown.InitialStateMap):
        return "\n".join([*lines, *_one(found)])
    lines.append(paragraph(f"{_initial_states(found.maps[0])} at every load factor."))
    heads = ["λ", "shake down", "95 % [%]", "separate", "undecided", "cycles", "dissipation ≤"]
    heads += [] if found.maps[0].slip_below is None else [f"below {number(found.maps[0].slip_below, 4)}"]
    rows = [[*_row(one)] for one in found.maps]
    for one in found.missing:
        rows.insert(one.place, [number(one.load_factor), "no energy ball", *[""] * (len(heads) - 2)])
    lines += ["", table(*_without_idle(heads, rows, idle=("separate", "undecided")))]
    notes = [_why_undecided(one, f"{at_lambda(one.load_factor)}: ") for one in found.maps if one.undecided]
    reasons = dict.fromkeys(one.reason for one in found.missing)
    notes += [paragraph(f"No energy ball: {reason}.") for reason in reasons]
    return "\n".join([*lines, *([""] if notes else []), *notes])


def _row(one: InitialStateMap) -> list[str]:
    """One load factor in the table of several."""
    (most,) = without_round_off(one.dissipation_quartiles[-1:], _none(one))
    known = one.undecided < len(one)
    return [
        number(one.load_factor),
        _percent(one.shakedown_fraction) if known else "-",
        _interval(one).removesuffix(" %") if known else "-",
        str(one.outcomes.get("separation", 0)),
        str(one.undecided),
        str(sum(cycle.outcome != "separation" for cycle in one.limit_cycles)),
        number(most, 5),
        *([] if one.slip_criterion is None else [_percent(one.slip_criterion.met_fraction)]),
    ]


def _without_idle(
    heads: list[str], rows: list[list[str]], idle: tuple[str, ...]
) -> tuple[list[str], list[list[str]]]:
    """A table without those of some columns in which nothing but zeros stands."""
    kept = [k for k, head in enumerate(heads) if head not in idle or {row[k] for row in rows} - {"0", ""}]
    return [heads[k] for k in kept], [[row[k] for k in kept] for row in rows]


def _one(found: InitialStateMap) -> list[str]:
    """Everything about one load factor."""
    states, unit, none = len(found), units_of(found.problem).work, _none(found)
    begin = f"Load factor {found.load_factor:.10g}: of {_initial_states(found)}"
    if found.undecided == states:
        return [paragraph(f"{begin}, none is decided."), "", _why_undecided(found)]
    interval = f" (95 %: {_interval(found)})" if _interval(found) != "-" else ""
    lines = [paragraph(f"{begin}, {_percent(found.shakedown_fraction)} shake down{interval}.")]
    if found.sampling.sampler == "grid":
        lines.append(paragraph("A grid is no random sample: it has no confidence interval."))
    lines += ["", _outcomes(found), ""]
    if found.undecided:
        lines += [_why_undecided(found), ""]
    quartiles = without_round_off(found.dissipation_quartiles, none)
    least, first, median, third, most = (number(value, 5) for value in quartiles)
    heading = with_unit("Dissipation per cycle", unit)
    over = "the decided states" if found.undecided else "all states"
    spread = f"from {least} to {most}; quartiles {first}, {median}, {third}"
    lines.append(paragraph(f"{heading} over {over}: {least if least == most else spread}."))
    lines += [paragraph(text) for text in [_slips(found)] if text]
    for heading, separation in (("Limit cycles", False), ("Motions with separation", True)):
        cycles = [c for c in found.limit_cycles if (c.outcome == "separation") == separation]
        lines += ["", heading, _cycles(found, cycles)] if cycles else []
    if found.limit_cycles:
        lines.append(_legend(found))
    lines += ["", *(paragraph(sentence) for sentence in _uniqueness(found))]
    if found.plane.region_type:
        kind = found.plane.region_type
        lines.append(paragraph(f"Regions of slip space: type ({kind}), {found.plane.region}."))
    return lines


def _slips(found: InitialStateMap) -> str:
    """From which share of the states slip ranges stay below the length asked for."""
    length, criterion = units_of(found.problem).length, found.slip_criterion
    if criterion is None:
        return ""
    below, largest = (sized(x, length) for x in (criterion.below, criterion.largest))
    who = "from every state" if criterion.met else f"from {_percent(criterion.met_fraction)} of the states"
    return f"Every slip range stays below {below} {who} (largest: {largest})."


def _outcomes(found: InitialStateMap) -> str:
    """How many states have which outcome, and what the words mean."""
    leave = int(np.count_nonzero((found.outcome == "separation") & (found.period == 0)))
    rows = []
    for word, count in found.outcomes.items():
        name = word.replace("-", " ")
        if word == "separation" and leave:
            rows += [(name, str(count - leave), MEANING[word])] * (count > leave)
            rows.append((name, str(leave), "the body leaves for good"))
        else:
            rows.append((name, str(count), MEANING[word]))
    return listing(rows)


def _why_undecided(found: InitialStateMap, begin: str = "") -> str:
    """Why states are undecided, and whether more cycles can help."""
    count, looked_at, reasons = found.undecided, found.looked_at_again, found.undecided_reasons
    who = "1 state is" if count == 1 else f"{count} states are"
    why = [
        one.reason
        + ("" if looked_at == one.count == count else f" ({_of(one.count, looked_at)} looked at again)")
        for one in reasons
    ]
    advice = "More --cycles may decide them." if any(one.more_cycles for one in reasons) else ""
    return paragraph(f"{begin}{who} undecided: {'; '.join(why)}. {advice}".rstrip())


def _of(count: int, states: int) -> str:
    return f"all {states}" if count == states else f"{count} of {states}"


def _uniqueness(found: InitialStateMap) -> list[str]:
    """Whether the outcome, and whether the state itself, is one and the same for all."""
    outcome = {
        True: "The outcome is the same for all states tried",
        False: "The outcome is not the same for all states",
        None: "The outcome is not known to be the same for all states",
    }[found.same_outcome]
    word = f": {next(iter(found.outcomes)).replace('-', ' ')}" if found.same_outcome else ""
    state = {
        True: "The final state is the same for all states tried",
        False: "The final state is not unique",
        None: "The final state is not known to be unique",
    }[found.unique]
    untried = " Of states not tried only λ_U says something (solve)." if found.same_outcome else ""
    return [f"{outcome}{word}.{untried}", f"{state}: {found.evidence}."]


def _cycles(found: InitialStateMap, cycles: list[LimitCycle]) -> str:
    none, rows = _none(found), []
    for cycle in cycles[:20]:
        low, high = without_round_off(cycle.dissipation, none)
        least, most = number(low, 4), number(high, 4)
        spread = 0.0 if cycle.coincide else cycle.spread
        largest = max((abs(value) for value in cycle.multipliers), default=0.0)
        rows.append(
            [
                str(cycle.count),
                str(cycle.period),
                number(high, 5) if least == most else f"{least} … {most}",
                "jumps" if cycle.stability == "unknown" else f"{largest:.4f}",
                number(spread, 2) if cycle.count > 1 else "-",
                shortened(open_in_words(cycle.slipping_nodes).partition(" ")[2], NODES),
            ]
        )
    heads = ["states", "period", "dissipation", "multiplier", "spread", "slip at"]
    idle = {"multiplier"} if found.problem.directions > 1 else set()
    idle |= set() if any(cycle.slipping_nodes for cycle in cycles) else {"slip at"}
    kept = [k for k, head in enumerate(heads) if head not in idle]
    text = table([heads[k] for k in kept], [[row[k] for k in kept] for row in rows])
    more = len(cycles) - len(rows)
    return text + (f"\n  … {more} more; --json has all" if more > 0 else "")


def _legend(found: InitialStateMap) -> str:
    length = units_of(found.problem).length
    spread = with_unit("spread", length)
    apart = (
        f"{spread}: how far apart the slips lie that these states end on; 0: one and the same motion, more: "
        "several of a continuum."
    )
    if found.problem.directions > 1:
        return paragraph(
            f"{apart} With two tangential directions it is not worked out whether they are stable.", "  "
        )
    jumps = any(cycle.stability == "unknown" for cycle in found.limit_cycles)
    return paragraph(
        "multiplier: factor per period by which a small disturbance of the motion shrinks; below 1 stable, "
        f"above unstable, at 1 a continuum of neighbouring motions is possible. {apart}"
        + " jumps: the motion jumps and has no multiplier."
        * jumps,
        "  ",
    )


def _none(found: InitialStateMap) -> float:
    """The work that counts as none."""
    return resolution(found.problem, found.load_factor, found.search.tolerances)[1]


def _initial_states(found: InitialStateMap) -> str:
    """How many there are, and where."""
    centre = found.sampling.centre_is
    where = SAMPLED[found.sampling.sampler].format(centre=("the " if "safe" in centre else "") + centre)
    return f"{len(found)} initial state{'s' * (len(found) != 1)} {where}"


def _percent(share: float) -> str:
    return f"{100 * share:.1f}\u00a0%"  # no line ends between them


def _interval(found: InitialStateMap) -> str:
    low, high = found.interval
    return "-" if low != low else f"{100 * low:.1f}–{100 * high:.1f} %"
