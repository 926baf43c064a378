"""A map of initial states in words: how many shake down, why some are undecided, whether all end alike."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shakedown.ground.shown_values import FEW_DIGITS, few, sized
from shakedown.ground.visible_text import with_unit
from shakedown.joint.units import units_of
from shakedown.report.node_words import resolution, without_round_off

if TYPE_CHECKING:  # importing it would load the solvers
    from shakedown.studies.basin_map import InitialStateMap

SAMPLED = {  # after "of N states"
    "grid": "on a grid about {centre}",
    "sobol": "in a box about {centre}",
    "latin": "in a box about {centre}",
    "ball": "in a ball about the centre of the energy ball",
    "transients": "left behind by random load steps",
}
PLACE = {"grid": "grid", "sobol": "box", "latin": "box", "ball": "ball", "transients": "set"}
STATES = {"zero": "slip zero", "given": "the given state", "critical": "the critical state"}
ENDS = {
    "shakedown": "shakes down",
    "cyclic-slip": "ends in cyclic slip",
    "ratchetting": "ends in ratchetting",
    "separation": "ends in separation",
    "undecided": "is undecided",
}
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


def named_in_words(found: InitialStateMap) -> str:
    """What becomes of slip zero, the given and the critical state."""
    work, none, said = units_of(found.problem).work, work_that_is_none(found), []
    for name, outcome, lost in zip(found.sampling.named, found.outcome, found.dissipation, strict=False):
        much = f" (dissipation {sized(lost, work)} per cycle)" if lost > none else ""
        said.append(f"{STATES[name]} {ENDS[str(outcome)]}{much}")
    return f"Load factor {found.load_factor:.10g}: {'; '.join(said)}."


def shares_in_words(found: InitialStateMap) -> list[str]:
    """Of how many initial states, chosen how, which share shakes down."""
    begin = f"Of {initial_states_in_words(found)}"
    if found.undecided == found.sampling.states:
        return [f"{begin}, none is decided."]
    known = interval_in_words(found)
    interval = f" (95 % confidence: {known})" if known else ""
    grid = "A grid is no random sample: it has no confidence interval."
    share = f"{begin}, {percent_of_states(found.shakedown_fraction)} shake down{interval}."
    return [f"{share} {share_of_what(found)}", *[grid] * (found.sampling.sampler == "grid")]


def share_of_what(found: InitialStateMap) -> str:
    """That a share depends on where the states are taken from."""
    place = PLACE[found.sampling.sampler]
    return f"A share is that of the {place}: another {place} has another share."


def outcomes_in_words(found: InitialStateMap) -> list[tuple[str, str, str]]:
    """The number of states per outcome, and what the words mean."""
    rest = found.sampled
    leave = int(np.count_nonzero((found.outcome[rest] == "separation") & (found.period[rest] == 0)))
    rows = []
    for word, count in found.outcomes.items():
        name = word.replace("-", " ")
        if word == "separation" and leave:
            rows += [(name, str(count - leave), MEANING[word])] * (count > leave)
            rows.append((name, str(leave), "the body leaves for good"))
        else:
            rows.append((name, str(count), MEANING[word]))
    return rows


def dissipation_in_words(found: InitialStateMap) -> str:
    """The spread of what the decided states dissipate."""
    quartiles = without_round_off(found.dissipation_quartiles, work_that_is_none(found))
    least, first, median, third, most = (few(value, FEW_DIGITS + 1) for value in quartiles)
    heading = with_unit("Dissipation per cycle", units_of(found.problem).work)
    over = "the decided ones of them" if found.undecided else "all of them"
    spread = f"from {least} to {most}; quartiles {first}, {median}, {third}"
    return f"{heading} over {over}: {least if least == most else spread}."


def slips_in_words(found: InitialStateMap) -> str:
    """The share of the states from which slip ranges stay below the requested length."""
    length, criterion = units_of(found.problem).length, found.slip_criterion
    if criterion is None:
        return ""
    below, largest = (sized(x, length) for x in (criterion.below, criterion.largest))
    share = f"{percent_of_states(criterion.met_fraction)} of the states"
    who = f"from {'every state' if criterion.met else share}"
    return f"Every slip range stays below {below} {who} (largest: {largest})."


def undecided_in_words(found: InitialStateMap, begin: str = "") -> str:
    """Why states are undecided, and whether more cycles can help."""
    count, looked_at, reasons = found.undecided, found.looked_at_again, found.undecided_reasons
    who = "1 state is" if count == 1 else f"{count} states are"
    why = [
        one.reason
        + ("" if looked_at == one.count == count else f" ({_of(one.count, looked_at)} looked at again)")
        for one in reasons
    ]
    them = "it" if count == 1 else "them"
    advice = f"More --cycles may decide {them}." if any(one.more_cycles for one in reasons) else ""
    return f"{begin}{who} undecided: {'; '.join(why)}. {advice}".rstrip()


def _of(count: int, states: int) -> str:
    return f"all {states}" if count == states else f"{count} of {states}"


def uniqueness_in_words(found: InitialStateMap) -> list[str]:
    """Whether the outcome, and whether the final state, is the same for all."""
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
    untried = ""
    if found.same_outcome:
        untried = " Of states not tried only λ_U says something (solve)."
        if found.impossible_everywhere:
            untried = (
                " This load factor lies above λ_max: while all nodes stay in contact no state shakes down."
            )
        if found.proved_everywhere:
            untried = (
                " This load factor lies below λ_U: proved for all states with all nodes in contact and "
                "within their friction limits."
            )
    return [f"{outcome}{word}.{untried}", f"{state}: {found.evidence}."]


def cycles_in_words(found: InitialStateMap) -> str:
    """What the columns of a table of limit cycles mean."""
    spread = with_unit("spread", units_of(found.problem).length)
    apart = (
        f"{spread}: how far apart the slips lie that these states end on; 0: one and the same motion, more: "
        "several of a continuum."
    )
    for cycle in found.limit_cycles:
        if not cycle.count:
            who = " and ".join(STATES[name] for name in cycle.named)
            apart += f" 0 states: only {who} lead{'s' * (len(cycle.named) == 1)} there."
    return apart


def region_in_words(found: InitialStateMap) -> list[str]:
    """The type of the regions of two slips, where there is one."""
    kind = found.region_type
    return [f"Regions of slip space: type ({kind}), {REGIONS[kind]}."] if kind else []


def work_that_is_none(found: InitialStateMap) -> float:
    """The work below which it counts as none."""
    return float(resolution(found.problem, found.load_factor, found.sampling.tolerances)[1].max())


def initial_states_in_words(found: InitialStateMap) -> str:
    """How many there are, and where."""
    centre = found.sampling.centre_is
    where = SAMPLED[found.sampling.sampler].format(centre=("the " if "safe" in centre else "") + centre)
    states = found.sampling.states
    return f"{states} initial state{'s' * (states != 1)} {where}"


def percent_of_states(share: float) -> str:
    """A share of the states in per cent, with a non-breaking space."""
    return f"{100 * share:.1f}\u00a0%"  # no line break in between


def interval_in_words(found: InitialStateMap) -> str:
    """The 95 % confidence interval of the share; empty where it is not known."""
    low, high = found.interval
    return "" if low != low else f"{100 * low:.1f}–{100 * high:.1f} %"
