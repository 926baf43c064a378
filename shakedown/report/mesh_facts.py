"""Meshes of one joint that get finer: which of its numbers converge."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shakedown.ground.shown_values import sized
from shakedown.ground.visible_text import with_unit
from shakedown.joint.units import units_of
from shakedown.report import notes
from shakedown.report.facts import Fact, Section, Table, number

if TYPE_CHECKING:  # importing it would load the solvers
    from shakedown.joint.problem import Problem
    from shakedown.studies.refined import Refinement

NUMBERS = {  # first those that converge for most joints
    "work": "friction work",
    "largest_slip": "largest slip",
    "slip_limit": "slips small up to λ",
    "averaged_impossible_above": "impossible above, averaged",
    "impossible_above": "impossible above",
    "proved_from_this_state": "proved from this state",
    "proved_from_every_state": "proved from every state",
}


def refinement_section(found: Refinement, problem: Problem, meshes: int = 3) -> Section:
    """For each number its values on the finest meshes, its verdict, limit and order.

    Examples
    --------
    >>> import shakedown
    >>> joints = {n: shakedown.example(f"block-{n}") for n in (9, 33)}
    >>> section = refinement_section(shakedown.refine(joints, [9, 33]), joints[33])
    >>> for row in section.tables[0].rows:
    ...     print(*row, sep=" | ")
    friction work [N mm] | 0 | 0 | zero | – | –
    largest slip [mm] | 0 | 0 | zero | – | –
    impossible above | 4.715 | 5.008 | undecided | – | –
    proved from this state | 4.663 | 4.709 | undecided | – | –
    proved from every state | 0 | 0 | zero | – | –
    """
    units, last = units_of(problem), slice(max(0, len(found.nodes) - meshes), None)
    asked = {"averaged_impossible_above": found.radius, "slip_limit": found.slip_below}
    of = {"work": units.work, "largest_slip": units.length}
    rows = []
    for word, name in NUMBERS.items():
        if asked.get(word, found.load_factor) is not None:
            trend = found.trends[word]
            values = [number(float(value)) for value in found.numbers[word][last]]
            about = [str(trend.verdict), number(trend.limit), number(trend.order, 2)]
            rows.append([with_unit(name, of.get(word, "")), *values, *about])
    heads = ["", *(f"{count} nodes" for count in found.nodes[last]), "verdict", "limit", "order"]
    table = Table(heads, rows, (0, len(heads) - 3))
    facts = [
        Fact("work and slip at", f"λ = {found.load_factor:g}", note="per cycle, starting with zero slip")
    ]
    if found.slip_below is not None:
        facts.append(Fact("small slips", f"below {sized(found.slip_below, units.length)}"))
    if found.radius is not None:
        facts.append(Fact("averaged over", sized(found.radius, units.length)))
    verdicts = set(found.verdict.values())
    said = [notes.TREND, notes.FALLING] if {"falls", "grows"} & verdicts else [notes.TREND]
    said += [notes.ZERO_MESHES] * ("zero" in verdicts)
    said += [notes.FEW_MESHES] * ({"undecided"} <= verdicts <= {"undecided", "zero"})
    return Section("", facts, [table], said)
