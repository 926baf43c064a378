"""What becomes of a joint from many initial states: how many shake down, where the others end."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from shakedown.ground.shown_values import DIGITS, count, sized
from shakedown.ground.visible_text import shortened
from shakedown.joint.units import units_of
from shakedown.report import notes
from shakedown.report.data_facts import headline
from shakedown.report.facts import Fact, Section, Sheet, Table, number
from shakedown.report.node_names import open_in_words, resolution, without_round_off

if TYPE_CHECKING:  # importing it would load the solvers
    from shakedown.joint.problem import Problem
    from shakedown.studies.basin_map import InitialStateMap, InitialStateMaps
    from shakedown.studies.limit_cycles import LimitCycle

SAMPLED = {  # after the number of states
    "grid": "on a grid about {}",
    "sobol": "in a box about {}",
    "latin": "in a box about {}",
    "ball": "in a ball about the centre of the energy ball",
    "transients": "left behind by random load steps",
}
STATES = {"zero": "zero slip", "given": "the given state", "critical": "the critical state"}
REGIONS = {
    "i": "a safe region and no complementary one, as below the first collapse",
    "ii": "a safe region and a complementary one: the initial state decides",
    "iii": "a complementary region and no safe one: nothing shakes down with both nodes closed",
    "iv": "no bounded safe region and no bounded complementary one",
}
MEANING = {
    "shakedown": "slip has ceased",
    "cyclic-slip": "nodes slip in every period and return",
    "ratchetting": "slips grow by the same amount in every period",
    "separation": "nodes open and close in every period, none slips",
    "undecided": "none of these could be established",
}
KNOWN = {True: "yes", False: "no", None: "not known"}
MOST_CYCLES = 20  # limit cycles shown
LONGEST_NODES = 16  # characters for the nodes that slip


def map_sheet(problem: Problem, found: InitialStateMap) -> Sheet:
    """All that is known of one load factor."""
    said = [*_path(problem), *_remarks(found)]
    return Sheet(
        headline(problem), [share(found)], None, map_facts(found), [_limit_cycles(found), Section(notes=said)]
    )


def _path(problem: Problem) -> list[str]:
    return [notes.ONE_PATH] * problem.is_domain


def share(found: InitialStateMap) -> str:
    """Of how many initial states, chosen how, which share shakes down."""
    begin = f"At λ = {found.load_factor:.10g}: of {states(found)}"
    if found.undecided == found.sampling.states:
        return f"{begin} none is decided."
    known = interval(found)
    return f"{begin} {per_cent(found.shakedown_fraction)} shake down{f' (95 %: {known})' if known else ''}."


def states(found: InitialStateMap) -> str:
    """How many initial states there are, and where."""
    centre = found.sampling.centre_is
    where = SAMPLED[found.sampling.sampler].format(f"{'the ' * ('safe' in centre)}{centre}")
    return f"{count(found.sampling.states, 'initial state')} {where}"


def map_facts(found: InitialStateMap) -> list[Fact]:
    """The named states, the number of states per outcome, the dissipation, whether all end alike."""
    unit, none, facts = units_of(found.problem), work_that_is_none(found), []
    for name, outcome, lost in zip(found.sampling.named, found.outcome, found.dissipation, strict=False):
        much = f"dissipation {sized(lost, unit.work)} per cycle" if lost > none else ""
        facts.append(Fact(f"from {STATES[name]}", str(outcome), note=much))
    for word, many in found.outcomes.items():
        facts.append(Fact(word, str(many), note=MEANING[word]))
    leave = np.count_nonzero(
        (found.outcome[found.sampled] == "separation") & (found.period[found.sampled] == 0)
    )
    facts += [Fact("of these leave for good", str(leave))] if leave else []
    facts += undecided(found)
    if found.undecided < found.sampling.states:
        least, first, median, third, most = without_round_off(found.dissipation_quartiles, none)
        spread = f"quartiles {number(first)}, {number(median)}, {number(third)}" if least < most else ""
        size = number(least) if least == most else f"{number(least)} … {number(most)}"
        facts.append(Fact("dissipation per cycle", f"{size} {unit.work}".rstrip(), note=spread))
        facts.append(Fact("same outcome", KNOWN[found.same_outcome], note="for all states tried"))
        facts.append(Fact("same final state", KNOWN[found.unique], note=found.evidence))
    criterion = found.slip_criterion
    if criterion is not None:
        who = "every state" if criterion.met else f"{per_cent(criterion.met_fraction)} of the states"
        largest = f"largest slip range {sized(criterion.largest, unit.length)}"
        facts.append(Fact(f"slips below {sized(criterion.below, unit.length)}", f"from {who}", note=largest))
    kind = found.region_type
    return [*facts, *([Fact("regions of slip space", f"type ({kind})", note=REGIONS[kind])] if kind else [])]


def undecided(found: InitialStateMap) -> list[Fact]:
    """Why states are undecided, and whether more cycles can help."""
    again = found.looked_at_again
    facts = []
    for one in found.undecided_reasons:
        more = "; more --cycles may decide" if one.more_cycles else ""
        facts.append(
            Fact("undecided because", one.reason, note=f"{one.count} of {again} looked at again{more}")
        )
    return facts


def _remarks(found: InitialStateMap) -> list[str]:
    """What the share is of, and what is known of states not tried."""
    said = [notes.GRID] * (found.sampling.sampler == "grid") + [notes.SHARE]
    if found.same_outcome:
        untried = notes.MAP_IMPOSSIBLE if found.impossible_everywhere else notes.UNTRIED
        said.append(notes.MAP_PROVED if found.proved_everywhere else untried)
    return [*said, *([notes.SPREAD] if found.limit_cycles else [])]


def _limit_cycles(found: InitialStateMap) -> Section:
    """How many states end on each limit cycle, or motion with separation."""
    if not found.limit_cycles:
        return Section()
    none = work_that_is_none(found)
    rows = [_cycle(cycle, none) for cycle in found.limit_cycles[:MOST_CYCLES]]
    more = len(found.limit_cycles) - MOST_CYCLES
    head = ["limit cycle", "reached", "states", "period", "dissipation", "spread", "slip at"]
    said = [f"{count(more, 'more cycle')}; --json has all."] if more > 0 else []
    return Section("", (), [Table(head, rows, (0, 1, 6))], said)


def _cycle(cycle: LimitCycle, none: float) -> list[str]:
    low, high = without_round_off(cycle.dissipation, none)
    least, most = number(low), number(high)
    return [
        str(cycle.outcome),
        f"from {' and '.join(STATES[name] for name in cycle.named)}" if cycle.named else "",
        str(cycle.count),
        str(cycle.period),
        most if least == most else f"{least} … {most}",
        number(0.0 if cycle.coincide else cycle.spread, 2) if cycle.count + len(cycle.named) > 1 else "–",
        shortened(open_in_words(cycle.slipping_nodes).partition(" ")[2], LONGEST_NODES),
    ]


def maps_sheet(problem: Problem, found: InitialStateMaps) -> Sheet:
    """Outcomes of the named states, and the shares, a row per load factor."""
    first = found.maps[0]
    named = {"λ": [number(one.load_factor, DIGITS) for one in found.maps]}
    named |= {
        f"from {STATES[name]}": [str(one.named[name]) for one in found.maps] for name in first.sampling.named
    }
    head = ["λ", "shake down", "95 %", "separate", "undecided", "cycles", "dissipation ≤"]
    head += [] if first.slip_below is None else [f"below {number(first.slip_below)}"]
    rows = [_row(one) for one in found.maps]
    for absent in found.missing:
        none = [number(absent.load_factor, DIGITS), "no energy ball"]
        rows.insert(absent.place, [*none, *[""] * (len(head) - 2)])
    facts = [Fact("at every load factor", states(first))]
    for one in found.maps:
        facts += [replace(fact, label=f"undecided at λ = {one.load_factor:.7g}") for fact in undecided(one)]
    facts += [
        Fact("no energy ball", reason) for reason in dict.fromkeys(each.reason for each in found.missing)
    ]
    shares = Section("", facts, [Table(head, rows, ())], [notes.SHARE, *_path(problem)])
    return Sheet(headline(problem), sections=[Section(tables=[Table.of(named, list(named)[1:])]), shares])


def _row(one: InitialStateMap) -> list[str]:
    """One load factor in the table of several."""
    (most,) = without_round_off(one.dissipation_quartiles[-1:], work_that_is_none(one))
    known = one.undecided < one.sampling.states
    return [
        number(one.load_factor, DIGITS),
        per_cent(one.shakedown_fraction) if known else "–",
        (interval(one) if known else "") or "–",
        str(one.outcomes.get("separation", 0)),
        str(one.undecided),
        str(sum(cycle.outcome != "separation" for cycle in one.limit_cycles)),
        number(most),
        *([] if one.slip_criterion is None else [per_cent(one.slip_criterion.met_fraction)]),
    ]


def work_that_is_none(found: InitialStateMap) -> float:
    """The work below which it counts as none."""
    return float(resolution(found.problem, found.load_factor, found.sampling.tolerances)[1].max())


def per_cent(part: float) -> str:
    """A share of the states in per cent."""
    return f"{100 * part:.1f} %"


def interval(found: InitialStateMap) -> str:
    """The 95 % confidence interval of the share; empty where it is not known."""
    low, high = found.interval
    return "" if low != low else f"{100 * low:.1f}–{100 * high:.1f} %"
