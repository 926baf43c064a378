"""`shakedown-bounds critical`: every (n+1)-subset of the frictional constraints."""

from __future__ import annotations

from functools import partial

import click

import shakedown
from shakedown import Problem
from shakedown.report.study_facts import critical_sheet

from . import options
from .command import Answer, command, document, progress, remark
from .options import option


@command(
    "All critical load factors.", "0 computed; 1 more subsets than the budget; 2 bad usage or bad input."
)
@options.problem
@option(
    "--budget",
    type=click.IntRange(min=1),
    default=200_000_000,
    help="Refuse to work through more subsets than this.",
)
@option("--all", "list_all", is_flag=True, help="List every critical load factor, sorted.")
def critical(problem: Problem, budget: int, list_all: bool) -> Answer:
    """All critical load factors of FILE: (n+1)-subsets of the 2n constraints."""
    if problem.directions == 1:
        n, smooth = problem.n, len(problem.law.smooth)
        count = shakedown.subset_count(n, smooth)
        subsets = "1 subset" if count == 1 else f"{count:,} subsets"
        remark(f"{subsets} of {n + 1} of {2 * n + smooth} constraints")
    with progress("subsets") as update:
        found = shakedown.critical_load_factors(problem, budget=budget, values=list_all, progress=update)
    return Answer(partial(document, problem, found), partial(critical_sheet, problem, found))
