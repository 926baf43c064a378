"""What ``shakedown-bounds solve`` prints, of joints in the plane and in space."""

from __future__ import annotations

from typing import TYPE_CHECKING

import shakedown
from shakedown import Problem
from shakedown.ground.errors import present
from shakedown.ground.shown_values import FEW_DIGITS, down, up
from shakedown.ground.status import named
from shakedown.report.assessment_words import (
    HEADING,
    argument_in_words,
    certain_in_words,
    loads_of_numbers,
    numbers_in_words,
    quickly_in_words,
    said_as_given_in_words,
)
from shakedown.report.bound_words import bounds_in_words
from shakedown.report.friction_words import friction_in_words
from shakedown.report.hint_words import last_digit_in_words, relative_in_words
from shakedown.report.limit_words import (
    coupling_in_words,
    onsets_in_words,
    proved_by_following,
    sensitivities_in_words,
)
from shakedown.report.mesh_words import mesh_warning_in_words
from shakedown.report.next_words import decides_in_words, margin_in_words, next_in_words
from shakedown.report.node_words import bound_columns, node_in_words, open_in_words
from shakedown.report.zone_words import zone_in_words

from .output import bound, headline, listing, node_table, number, paragraph

if TYPE_CHECKING:
    from shakedown.assessment.every_limit import JointLimits

F_THRESHOLD = (
    "f threshold: the friction coefficient at which a node alone, all others stuck, loses uniqueness, "
    "A_jj/|B_jj|."
)
MORE = "--details: every limit with its evidence, the safe slip, node by node."
MORE_QUICKLY = "--details: the safe slip, node by node."
Fact = tuple[str, str, str]  # name, value, remark
DIRECTIONS = (
    "x, y: the two tangential directions of a node, in the order of the file; reached at λ_max: the load "
    "steps, counted from 0, in which it reaches its friction limit."
)
OPEN_NODES = (
    "open: throughout; under safe slip stands the displacement of the node under the mean load. gap closes: "
    "at λ_max it does."
)


def quick_text(problem: Problem, energy: shakedown.Bound, upper: shakedown.Bound, details: bool) -> str:
    """What one linear and one cone program tell."""
    lines = [headline(problem), ""]
    lines += [paragraph(sentence) for sentence in quickly_in_words(energy, upper, problem)]
    if upper.open_nodes:
        lines += [paragraph(sentence) for sentence in zone_in_words(upper, problem)]
    elif upper.status != "optimal":
        lines += [paragraph(f"{upper.status}: {upper.reason}.")]
    table = ["", node_table(problem, bound_columns(problem, upper, number))] if details else [MORE_QUICKLY]
    return "\n".join([*lines, *table])


def solve_text(found: shakedown.Assessment, file: str, *, details: bool, follow: bool = False) -> str:
    """The three numbers, the margin, what decides, and the one thing to do next.

    Also what is proved once cycles are followed, where that is asked for.
    """
    said = numbers_in_words(found)
    width = max(len(value) for _, value, _ in said)
    numbers = [
        (name, value.rjust(width * ("=" in value)), f"{loads}; {remark}" if loads else remark)
        for (name, value, remark), loads in zip(said, loads_of_numbers(found), strict=True)
    ]
    if follow:
        numbers.insert(2, proved_by_following(found.details))
    sentences = [
        *last_digit_in_words(found.problem),
        " ".join(filter(None, [said_as_given_in_words(found), margin_in_words(found)])),
        mesh_warning_in_words(found),
        decides_in_words(found),
        next_in_words(found, file),
        "" if details else MORE,
    ]
    table = [HEADING, listing(numbers)]
    return "\n".join([headline(found.problem), "", *table, "", *map(paragraph, filter(None, sentences))])


def details_text(found: shakedown.Assessment) -> str:
    """What is certain, every limit with its evidence, what they mean, and a table of the nodes."""
    limits, problem = found.details, found.problem
    certain = [*certain_in_words(limits), *filter(None, [relative_in_words(problem, limits.open_nodes)])]
    if problem.initial_slip is not None and not limits.energy.initial_slip.any():
        certain.append("The file has initial slips: --initial given proves from the first of them.")
    said = bounds_in_words(limits)
    if not limits.absent:
        said += [*sensitivities_in_words(limits), *friction_in_words(problem, limits.friction)]
    listed = listing(_facts(limits))
    lines = [*map(paragraph, certain), "", *([listed, ""] if listed else []), *map(paragraph, said)]
    remarks = [DIRECTIONS if limits.absent else F_THRESHOLD]
    remarks += [OPEN_NODES] * bool(limits.upper.open_nodes)
    evidence = present(limits.lower), present(limits.friction)
    columns = bound_columns(problem, limits.upper, number, *evidence)
    return "\n".join([*lines, "", node_table(problem, columns), "", *map(paragraph, remarks)])


def _facts(limits: JointLimits) -> list[Fact]:
    """(name, value, remark) of every number that stands for the whole joint."""
    lower = present(limits.lower)
    facts = [(name, bound(load_factor), remark) for name, load_factor, remark in onsets_in_words(limits)]
    facts.append(_from_here(limits.energy))
    slip = limits.accumulated
    facts.append((named("λ_S"), bound(slip.load_factor), slip.limited_by or slip.status))
    facts.append((named("λ_U"), bound(limits.universal.load_factor), argument_in_words(limits.universal)))
    facts += [] if lower is None else _of_first_collapse(lower)
    return [*facts, _least(limits.upper), _largest(limits.upper, "certified" if lower is None else "exact")]


def _of_first_collapse(lower: shakedown.Bound) -> list[Fact]:
    """λ_1 and what it rests on."""
    collapse = "no node collapses"
    if lower.node >= 0:
        labelled = lower.problem.label is not None
        collapse = node_in_words(lower.problem, lower.node) if labelled else f"collapse of node {lower.node}"
    ratio = lower.coupling_ratio
    return [
        (named("λ_1"), bound(lower.load_factor), f"{collapse}{_certified(lower.certified, 'exact')}"),
        ("  guarantee", lower.guarantee, ""),
        ("  coupling ratio ρ*", number(ratio, FEW_DIGITS), coupling_in_words(ratio).partition(":")[0]),
    ]


def _from_here(energy: shakedown.Bound) -> Fact:
    """λ_E, with what exact arithmetic confirms."""
    exactly = energy.certified
    certified = "" if exactly is None else f", certified to {1 - exactly / energy.load_factor:.0e}"
    return (named("λ_E"), bound(energy.load_factor), f"{energy.status}{certified}")


def _least(upper: shakedown.Bound) -> Fact:
    """λ_lo where there is one, rounded up."""
    least = upper.least_load_factor
    begins = bound(least, rounded=up) if least else "-"
    return ("λ_lo, least load factor", begins, "safe slips exist from here on")


def _largest(upper: shakedown.Bound, how: str) -> Fact:
    """λ_max, with the nodes that are open where it is that of a zone."""
    remark = f"{upper.status}{_certified(upper.certified, how)}"
    if upper.open_nodes:
        remark += f", with {open_in_words(upper.open_nodes)} open"
    name = "λ_max of the zone" if upper.open_nodes else named("λ_max")
    return (name, bound(upper.load_factor, rounded=down if upper.open_nodes else up), remark)


def _certified(interval: tuple[float, float] | None, how: str) -> str:
    """How close an enclosure is, where there is one."""
    if interval is None:
        return ""
    low, high = interval
    size = max(abs(low), abs(high))
    if size in (0.0, float("inf")):
        return ", certified"
    return f", {how} to {max(high - low, 0.0) / size:.0e}"
