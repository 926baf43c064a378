"""`shakedown-bounds solve`, `critical`: the bounds of a joint, and all its critical load factors."""

from __future__ import annotations

from functools import partial
from typing import Any, Literal

import click

import shakedown
from shakedown import Problem
from shakedown.bounds.bound_result import open_ends
from shakedown.ground.shown_values import down, plain
from shakedown.ground.work_limit import on_one_thread
from shakedown.report.limit_facts import assessment_document, nothing_is_known, solve_sheet
from shakedown.report.study_facts import critical_sheet

from . import options
from .command import Answer, command, document, is_quiet, progress, remark
from .options import option

CLAIMS = {
    "proved-from-state": "proved_from_this_state",
    "proved-from-every-state": "proved_from_every_state",
}  # what may be required, and the number it is about


def required(text: str) -> tuple[str, float] | None:
    """What has to be proved, and up to which load factor."""
    claim, _, number = text.partition("=")
    try:
        least = float(number)
    except ValueError:
        return None
    return (claim, least) if claim in CLAIMS and 0.0 < least < float("inf") else None


@command(
    "What is proved, bounds, safe slip.",
    "0 computed, whatever the bounds are; 1 every claim is unknown, a bound is undecided or disputed in "
    "exact arithmetic, or what is required is not proved; 2 bad usage or bad input.",
)
@options.problem
@options.initial
@option("--distance", type=float, default=0.0, help="How far the state may be from it, in the energy norm.")
@option("--details", is_flag=True, help="Also every limit with its evidence, and a table of the nodes.")
@option(
    "--follow",
    is_flag=True,
    help="Also what is proved once its cycles are followed (simulates: seconds, the first time more).",
)
@option(
    "--require",
    type=options.parsed("claim", f"{'=X or '.join(CLAIMS)}=X with X > 0", required),
    multiple=True,
    help="\b\nproved-from-state=X or proved-from-every-state=X:\n"
    "exit with 1 unless shakedown is proved up to load\nfactor X. May be given twice; with --quiet nothing\n"
    "else is printed.",
)
@options.open_nodes
@options.average
@options.digits
@on_one_thread
def solve(
    problem: Problem,
    initial: str,
    distance: float,
    require: tuple[tuple[str, float], ...],
    open_nodes: tuple[int, ...] | Literal["auto"],
    average: float | None,
    **shown: Any,
) -> Answer:
    """Up to which load factor FILE shakes down: proved from every state, from this one, impossible above.

    Then what becomes of the nominal load (λ = 1) where these decide, its margin, and what decides.
    """
    state = options.initial_state(problem, initial)
    found = shakedown.assess(problem, state, distance=distance, open_nodes=open_nodes)
    limits, between = found.details, None if average is None else (found.averaged(average), average)
    asked, unmet = [], []
    for claim, least in require:
        proved = getattr(found, CLAIMS[claim])
        asked.append(plain({"claim": claim, "load_factor": least, "proved": proved, "met": proved >= least}))
        if not proved >= least:
            known = "open" if proved != proved else f"up to λ = {down(proved)}"
            unmet.append(f"--require {claim}={least:g}: not met, proved is {known}")
    more = {"required": asked} if asked else {}
    sheet = partial(solve_sheet, found, options.file_named(), averaged=between, **shown)
    return Answer(
        lambda: assessment_document(found, between, follow=shown["follow"]) | more,
        # with --quiet the lines on what is not met, and the exit code, are the answer
        None if require and is_quiet() else sheet,
        is_open=nothing_is_known(found),
        open_ends=[*open_ends(limits.lower, limits.upper, limits.energy, limits.universal), *unmet],
    )


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
    from shakedown.bounds.critical import subset_count  # loads a solver

    if problem.directions == 1:
        n, frictionless = problem.n, len(problem.law.frictionless)
        count = subset_count(n, frictionless)
        subsets = "1 subset" if count == 1 else f"{count:,} subsets"
        remark(f"{subsets} of {n + 1} of {2 * n + frictionless} constraints")
    with progress("subsets") as update:
        found = shakedown.critical_load_factors(problem, budget=budget, values=list_all, progress=update)
    return Answer(partial(document, problem, found), partial(critical_sheet, problem, found))
