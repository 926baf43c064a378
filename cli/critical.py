"""`shakedown-bounds critical`: every (n+1)-subset of the frictional constraints."""

from __future__ import annotations

import click

import shakedown
from shakedown import Problem
from shakedown.ground.visible_text import with_unit
from shakedown.joint.constraints import SIDE_NAMES
from shakedown.joint.units import units_of
from shakedown.report.data_facts import headline
from shakedown.report.facts import Fact, Section, Sheet, Table, number
from shakedown.report.node_names import node_column
from shakedown.report.subset_facts import critical_facts

from .options import output_options, problem_argument
from .output import echo_json, progress, remark, show


@click.command(
    short_help="All critical load factors.",
    epilog="Exit codes: 0 computed; 1 more subsets than the budget; 2 bad usage or bad input.",
)
@problem_argument
@click.option(
    "--budget",
    type=click.IntRange(min=1),
    default=200_000_000,
    show_default=True,
    help="Refuse to work through more subsets than this.",
)
@click.option("--all", "list_all", is_flag=True, help="List every critical load factor, sorted.")
@output_options
def critical(problem: Problem, budget: int, list_all: bool, as_json: bool) -> None:
    """All critical load factors of FILE: (n+1)-subsets of the 2n constraints."""
    if problem.directions == 1:
        n, smooth = problem.n, len(problem.law.smooth)
        count = shakedown.subset_count(n, smooth)
        subsets = "1 subset" if count == 1 else f"{count:,} subsets"
        remark(f"{subsets} of {n + 1} of {2 * n + smooth} constraints")
    with progress("subsets") as update:
        result = shakedown.critical_load_factors(problem, budget=budget, values=list_all, progress=update)
    if as_json:
        echo_json({"problem": problem.to_dict()} | result.to_dict())
    else:
        show(_sheet(problem, result))


def _sheet(problem: Problem, result: shakedown.CriticalLoadFactors) -> Sheet:
    """The smallest critical load factor, where its limits meet, and where asked for all of them."""
    facts, said = critical_facts(result, shakedown.shakedown_bounds(problem))
    smallest, sections = result.smallest_positive, []
    if smallest.rows:
        limits = ", ".join(f"{problem.node_name(node)} {SIDE_NAMES[side]}" for node, side in smallest.rows)
        facts.append(Fact("limits that meet", limits, note="(node, limit)"))
        slips = [number(slip, 7) for slip in smallest.slip]
        columns = node_column(problem) | {with_unit("slip there", units_of(problem).length): slips}
        sections.append(Section("", (), [Table.of(columns)]))
    if result.load_factors is not None:
        rows = [[str(k), number(value, 10)] for k, value in enumerate(result.load_factors)]
        sections.append(Section("", (), [Table(["", "critical load factors"], rows)]))
    return Sheet(headline(problem), (), None, facts, [Section("", (), (), said), *sections])
