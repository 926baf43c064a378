"""What a map of initial states says to people."""

from __future__ import annotations

from typing import TYPE_CHECKING

import shakedown
from shakedown import Problem
from shakedown.ground.shown_values import at_lambda
from shakedown.ground.visible_text import shortened
from shakedown.report.hint_words import simulated_path_in_words
from shakedown.report.map_words import (
    STATES,
    cycles_in_words,
    dissipation_in_words,
    initial_states_in_words,
    interval_in_words,
    named_in_words,
    outcomes_in_words,
    percent_of_states,
    region_in_words,
    share_of_what,
    shares_in_words,
    slips_in_words,
    undecided_in_words,
    uniqueness_in_words,
    work_that_is_none,
)
from shakedown.report.node_words import open_in_words, without_round_off
from shakedown.report.text_table import table

from .output import headline, listing, number, paragraph

if TYPE_CHECKING:  # they load what computes
    from shakedown import InitialStateMap, InitialStateMaps, LimitCycle

NODES = 16  # characters for the nodes that slip: a table has 80 columns


def map_text(problem: Problem, found: InitialStateMap | InitialStateMaps) -> str:
    """One load factor with all that is known of it, or a row for each of several."""
    lines = [headline(problem), "", *(paragraph(text) for text in simulated_path_in_words(problem))]
    if isinstance(found, shakedown.InitialStateMap):
        return "\n".join([*lines, *_one(found)])
    names = {name: STATES[name].removeprefix("the ") for name in found.maps[0].sampling.named}
    outcomes = [
        [number(one.load_factor), *(str(one.named[name]).replace("-", " ") for name in names)]
        for one in found.maps
    ]
    lines += [table(["λ", *(f"from {name}" for name in names.values())], outcomes), ""]
    about = f"{initial_states_in_words(found.maps[0])} at every load factor. {share_of_what(found.maps[0])}"
    lines.append(paragraph(about))
    heads = ["λ", "shake down", "95 % [%]", "separate", "undecided", "cycles", "dissipation ≤"]
    heads += [] if found.maps[0].slip_below is None else [f"below {number(found.maps[0].slip_below, 4)}"]
    rows = [[*_row(one)] for one in found.maps]
    for one in found.missing:
        rows.insert(one.place, [number(one.load_factor), "no energy ball", *[""] * (len(heads) - 2)])
    idle = {head for k, head in enumerate(heads) if {row[k] for row in rows} <= {"0", ""}}
    lines += ["", _without(heads, rows, idle & {"separate", "undecided"})]
    notes = [
        paragraph(undecided_in_words(one, f"{at_lambda(one.load_factor)}: "))
        for one in found.maps
        if one.undecided
    ]
    reasons = dict.fromkeys(one.reason for one in found.missing)
    notes += [paragraph(f"No energy ball: {reason}.") for reason in reasons]
    return "\n".join([*lines, *([""] if notes else []), *notes])


def _row(one: InitialStateMap) -> list[str]:
    """One load factor in the table of several."""
    (most,) = without_round_off(one.dissipation_quartiles[-1:], work_that_is_none(one))
    known = one.undecided < one.sampling.states
    return [
        number(one.load_factor),
        percent_of_states(one.shakedown_fraction) if known else "-",
        interval_in_words(one).removesuffix(" %") or "-" if known else "-",
        str(one.outcomes.get("separation", 0)),
        str(one.undecided),
        str(sum(cycle.outcome != "separation" for cycle in one.limit_cycles)),
        number(most, 5),
        *([] if one.slip_criterion is None else [percent_of_states(one.slip_criterion.met_fraction)]),
    ]


def _without(heads: list[str], rows: list[list[str]], idle: set[str]) -> str:
    """A table without some of its columns."""
    kept = [k for k, head in enumerate(heads) if head not in idle]
    return table([heads[k] for k in kept], [[row[k] for k in kept] for row in rows])


def _one(found: InitialStateMap) -> list[str]:
    """Everything about one load factor."""
    lines = [paragraph(sentence) for sentence in (named_in_words(found), *shares_in_words(found))]
    if found.undecided == found.sampling.states:
        return [*lines, "", paragraph(undecided_in_words(found))]
    lines += ["", listing(outcomes_in_words(found)), ""]
    if found.undecided:
        lines += [paragraph(undecided_in_words(found)), ""]
    said = [dissipation_in_words(found), slips_in_words(found)]
    lines += [paragraph(sentence) for sentence in said if sentence]
    for heading, separation in (("Limit cycles", False), ("Motions with separation", True)):
        cycles = [c for c in found.limit_cycles if (c.outcome == "separation") == separation]
        lines += ["", heading, _cycles(found, cycles)] if cycles else []
    if found.limit_cycles:
        lines.append(paragraph(cycles_in_words(found), "  "))
    return [*lines, "", *map(paragraph, [*uniqueness_in_words(found), *region_in_words(found)])]


def _cycles(found: InitialStateMap, cycles: list[LimitCycle]) -> str:
    none, rows = work_that_is_none(found), []
    for cycle in cycles[:20]:
        low, high = without_round_off(cycle.dissipation, none)
        least, most = number(low, 4), number(high, 4)
        spread = 0.0 if cycle.coincide else cycle.spread
        rows.append(
            [
                str(cycle.count),
                str(cycle.period),
                number(high, 5) if least == most else f"{least} … {most}",
                number(spread, 2) if cycle.count + len(cycle.named) > 1 else "-",
                shortened(open_in_words(cycle.slipping_nodes).partition(" ")[2], NODES),
            ]
        )
    heads = ["states", "period", "dissipation", "spread", "slip at"]
    idle = set() if any(cycle.slipping_nodes for cycle in cycles) else {"slip at"}
    text = _without(heads, rows, idle)
    more = len(cycles) - len(rows)
    return text + (f"\n  … {more} more; --json has all" if more > 0 else "")
