"""What ``shakedown-bounds solve`` prints, of joints in the plane and in space."""

from __future__ import annotations

from typing import TYPE_CHECKING

import shakedown
from shakedown import Problem
from shakedown.ground.evidence import Missing
from shakedown.ground.shown_values import down, up
from shakedown.ground.visible_text import with_unit
from shakedown.joint.constraints import SIDE_NAMES
from shakedown.joint.units import units_of
from shakedown.report.assessment_words import (
    certain_in_words,
    loads_of_numbers,
    numbers_in_words,
    quickly_in_words,
    said_as_given_in_words,
)
from shakedown.report.bound_words import bounds_in_words, space_bounds_in_words
from shakedown.report.friction_words import friction_in_words
from shakedown.report.hint_words import doubts_in_words, hints_in_words
from shakedown.report.limit_words import coupling_in_words, curve_in_words
from shakedown.report.next_words import decides_in_words, margin_of_bounds, next_in_words
from shakedown.report.node_words import node_in_words
from shakedown.report.sensitivity_words import sensitivities_in_words
from shakedown.report.zone_words import open_in_words, zone_in_words

from .output import bound, headline, listing, node_table, number, paragraph

if TYPE_CHECKING:
    from shakedown.assessment.every_limit import JointLimits
    from shakedown.assessment.space_limits import SpaceLimits

F_THRESHOLD = (
    "f threshold: the friction coefficient at which a node alone, all others stuck, loses uniqueness, "
    "A_jj/|B_jj|."
)
MORE = "--details: every limit with its evidence, the safe slip, node by node."
MORE_QUICKLY = "--details: the safe slip, node by node."
LONGEST_RANGES = 24  # characters of a column
Fact = tuple[str, str, str]  # name, value, remark
DIRECTIONS = (
    "x, y: the two tangential directions of a node, in the order of the file; active at λ_max: the load "
    "steps, counted from 0, in which it reaches its friction limit."
)
OPEN_NODES = (
    "open: throughout; under safe slip stands the displacement of the node under the mean load. gap closes: "
    "at λ_max it does."
)


def quick_text(
    problem: Problem, energy: shakedown.EnergyBound, upper: shakedown.UpperBound, details: bool
) -> str:
    """What one linear and one cone program tell."""
    lines = [headline(problem), ""]
    lines += [paragraph(sentence) for sentence in quickly_in_words(energy, upper, problem)]
    if upper.open_nodes:
        lines += [paragraph(sentence) for sentence in zone_in_words(upper, problem)]
    elif upper.status != "optimal":
        lines += [paragraph(f"{upper.status}: {upper.reason}.")]
    table = ["", node_table(problem, _safe_columns(problem, upper))] if details else [MORE_QUICKLY]
    return "\n".join([*lines, *table])


def solve_text(found: shakedown.Assessment) -> str:
    """The three numbers, the margin, what decides, and the one thing to do next."""
    numbers = [
        (name, value, f"{loads}; {remark}" if loads else remark)
        for (name, value, remark), loads in zip(numbers_in_words(found), loads_of_numbers(found), strict=True)
    ]
    warned = [paragraph(text) for text in doubts_in_words(found.problem)]
    said = " ".join(filter(None, [said_as_given_in_words(found), margin_of_bounds(found)]))
    sentences = filter(None, [said, decides_in_words(found), next_in_words(found), MORE])
    return "\n".join([headline(found.problem), "", listing(numbers), "", *warned, *map(paragraph, sentences)])


def details_text(found: shakedown.Assessment, curve: shakedown.GuaranteeCurve | Missing | None) -> str:
    """What is certain, every limit, what they mean, and a table of the nodes."""
    limits, problem = found.details, found.problem
    lines = [paragraph(sentence) for sentence in certain_in_words(limits)]
    lines += [paragraph(hint) for hint in hints_in_words(problem, limits.open_nodes)]
    if problem.initial_slip is not None and not limits.energy.initial_slip.any():
        lines += [paragraph("The file has initial slips: --initial given proves from the first of them.")]
    from shakedown.assessment.space_limits import SpaceLimits  # loads what computes

    more = _in_space(limits) if isinstance(limits, SpaceLimits) else _in_the_plane(limits, curve)
    return "\n".join([*lines, "", *more])


def _in_the_plane(limits: JointLimits, curve: shakedown.GuaranteeCurve | Missing | None) -> list[str]:
    """Every limit with its evidence, what follows, and the nodes."""
    problem = limits.problem
    lines = [listing(_facts(limits)), ""]
    lines += [paragraph(sentence) for sentence in bounds_in_words(limits)]
    lines += [paragraph(sentence) for sentence in sensitivities_in_words(limits)]
    if isinstance(curve, Missing):
        lines += [paragraph(f"The guarantee curve is missing: {curve.reason}.")]
    elif curve is not None:
        lines += [paragraph(curve_in_words(curve, problem))]
    lines += [paragraph(sentence) for sentence in friction_in_words(problem, limits.friction)]
    thresholds = [number(each, 5) for each in limits.friction.single_node]
    safe, active = _safe_columns(problem, limits.upper).items()
    slips = [number(slip) for slip in limits.lower.slip]
    witness = with_unit("critical", units_of(problem).length), slips
    columns = dict([safe, witness, active, ("f threshold", thresholds)])
    remarks = [F_THRESHOLD, *[OPEN_NODES] * bool(limits.upper.open_nodes)]
    return [*lines, "", node_table(problem, columns), "", *map(paragraph, remarks)]


def _in_space(limits: SpaceLimits) -> list[str]:
    """The limits that exist with two tangential directions, what follows, and the nodes."""
    problem, upper = limits.problem, limits.upper
    from_state = [_from_here(limits.energy), _from_every_state(limits.universal)]
    facts = [*from_state, _least(upper), _largest(upper, "certified")]
    listed = listing(facts)
    lines = [listed, ""] if listed else []
    lines += [paragraph(sentence) for sentence in space_bounds_in_words(limits)]
    remarks = [DIRECTIONS, *[OPEN_NODES] * bool(upper.open_nodes)]
    return [*lines, "", node_table(problem, _safe_columns(problem, upper)), "", *map(paragraph, remarks)]


def _safe_columns(problem: Problem, upper: shakedown.UpperBound) -> dict[str, list[str]]:
    """The safe slip of every node, and its limits that are reached at λ_max."""
    unit = units_of(problem).length
    parts = zip(*problem.layout.by_node(upper.slip).tolist(), strict=True)
    names = ["safe slip"] if problem.directions == 1 else ["safe slip x", "safe slip y"]
    columns = {
        with_unit(name, unit): list(map(number, part)) for name, part in zip(names, parts, strict=True)
    }
    return columns | {"active at λ_max": [_reached(problem, upper, node) for node in range(problem.n)]}


def _facts(limits: JointLimits) -> list[Fact]:
    """(name, value, remark) of every number that stands for the whole joint."""
    lower, box = limits.lower, limits.box
    collapse = "no node collapses"
    if lower.node >= 0:
        labelled = lower.problem.label is not None
        collapse = node_in_words(lower.problem, lower.node) if labelled else f"collapse of node {lower.node}"
    return [
        _from_here(limits.energy),
        ("from this state, box", bound(box.load_factor), box.limited_by or box.status),
        _from_every_state(limits.universal),
        ("lower bound λ_1", bound(lower.load_factor), f"{collapse}{_certified(lower.certified)}"),
        ("  guarantee", lower.guarantee, ""),
        ("  single-node bound", bound(lower.single_node_bound), "no node cycles alone below"),
        (
            "  coupling ratio ρ*",
            number(lower.coupling_ratio, 4),
            coupling_in_words(lower.coupling_ratio).partition(":")[0],
        ),
        _least(limits.upper),
        _largest(limits.upper),
    ]


def _from_here(energy: shakedown.EnergyBound) -> Fact:
    """λ_E, with what exact arithmetic confirms."""
    exactly = energy.certified
    certified = "" if exactly is None else f", certified to {1 - exactly / energy.load_factor:.0e}"
    return ("from this state λ_E", bound(energy.load_factor), f"{energy.status}{certified}")


def _from_every_state(universal: shakedown.UniversalBound) -> Fact:
    """λ_U, with its argument."""
    return ("from every state λ_U", bound(universal.load_factor), universal.argument)


def _least(upper: shakedown.UpperBound) -> Fact:
    """λ_lo, where there is one."""
    return ("least load factor λ_lo", _from_here_on(upper.least_load_factor), "safe slips exist from here on")


def _largest(upper: shakedown.UpperBound, how: str = "exact") -> Fact:
    """λ_max, with the nodes that are open where it is that of a zone."""
    remark = f"{upper.status}{_certified(upper.certified, how)}"
    if upper.open_nodes:
        remark += f", with {open_in_words(upper.open_nodes)} open"
    name = "λ_max of the zone" if upper.open_nodes else "upper bound λ_max"
    return (name, bound(upper.load_factor, rounded=down if upper.open_nodes else up), remark)


def _from_here_on(least: float) -> str:
    """λ_lo where there is one, rounded up."""
    return bound(least, rounded=up) if least else "-"


def _certified(interval: tuple[float, float] | None, how: str = "exact") -> str:
    """How close an enclosure is, where there is one."""
    if interval is None:
        return ""
    low, high = interval
    size = max(abs(low), abs(high))
    if size in (0.0, float("inf")):
        return ", certified"
    return f", {how} to {max(high - low, 0.0) / size:.0e}"


def _reached(problem: Problem, upper: shakedown.UpperBound, node: int) -> str:
    """Which limits of a node are reached at λ_max: sides, or with two directions load steps."""
    reached = [where for at, where in upper.active if at == node]
    if node in upper.open_nodes:
        return "open; gap closes" if reached else "open"
    if problem.directions == 1:
        return "+".join(SIDE_NAMES[side] for side in reached) or "-"
    return _ranges(sorted(reached)) or "-"


def _ranges(steps: list[int]) -> str:
    """Numbers in order, neighbours as ``first–last``; how many there are where that is long."""
    starts = [step for step in steps if step - 1 not in steps]
    ends = [step for step in steps if step + 1 not in steps]
    runs = (f"{a}" if a == b else f"{a}–{b}" for a, b in zip(starts, ends, strict=True))
    said = ", ".join(runs)
    return said if len(said) <= LONGEST_RANGES else f"{len(steps)} load steps"
