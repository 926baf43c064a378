"""`shakedown-bounds verify`: the bounds against time integration, with a report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import shakedown
from shakedown import Problem
from shakedown.report.json_documents import verification_document
from shakedown.report.limit_facts import averaged_section

from .claims import NODE_FILES, OutputFile, reads, writes
from .options import (
    average_option,
    cycles_option,
    digits_option,
    method_option,
    open_option,
    output_options,
    problem_argument,
    slip_below_option,
)
from .output import echo_json, progress, say, show


@click.command(
    short_help="Prediction against time integration; report.",
    epilog="Exit codes: 0 prediction and simulation agree in every run; 1 they disagree, or a run "
    "slides away or is left open; 2 bad usage or bad input.",
)
@problem_argument
@click.option("-o", "--output", type=OutputFile(), help="Write the report (HTML) here, JSON beside it.")
@click.option(
    "--load-factor", "load_factors", type=float, multiple=True, help="Simulate at this λ; may be repeated."
)
@click.option(
    "--random",
    "random_states",
    type=click.IntRange(min=0),
    default=None,
    show_default="3; above 50 node pairs in space 1",
    help="Number of initial states: what random loads leave behind.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Seed of the random loads.",
)
@open_option
@average_option
@click.option(
    "--refinement",
    type=click.Path(),
    metavar="TABLE",
    help="What `refine … -o TABLE.csv` wrote, FILE among its meshes: a section of the report.",
)
@cycles_option
@method_option
@slip_below_option
@click.option(
    "--nodes",
    type=OutputFile(NODE_FILES),
    help="Write what every node goes through at λ = 1 here (.csv, .vtu or .vtp).",
)
@click.option("--details", is_flag=True, help="Also every limit, and a table of the runs.")
@digits_option
@output_options
@click.pass_context
def verify(
    context: click.Context,
    /,
    problem: Problem,
    output: Path | None,
    load_factors: tuple[float, ...],
    average: float | None,
    refinement: str | None,
    nodes: Path | None,
    details: bool,
    digits: int,
    as_json: bool,
    **settings: Any,
) -> None:
    """Hold the bounds of FILE against time integration from several states."""
    beside = _beside(context, problem, average, refinement)
    if output is not None:
        from shakedown.report.html import report_path  # what draws is wanted only here

        report_path(output)  # before the work, not after
        writes(context, "the JSON beside -o", output.with_suffix(".json"))
    with progress("verification", rest=int(output is not None)) as update:
        result = shakedown.verify(problem, load_factors=load_factors or None, progress=update, **settings)
        if output is not None:
            from shakedown.report.html import write_report

            write_report(output, result, **beside)
    if nodes is not None:
        result.nodes.save(nodes)
    if as_json:
        echo_json(verification_document(result, **beside))
    else:
        from shakedown.report.verification_facts import verify_sheet  # loads compiled code

        more = (
            []
            if average is None
            else [averaged_section(result.assessment.averaged(average), average, digits)]
        )
        show(verify_sheet(result, details=details, digits=digits), *more)
        if output is not None:
            say(f"\nreport: {output}, {output.with_suffix('.json')}")
    if not result.agrees:
        context.exit(1)


def _beside(
    context: click.Context, problem: Problem, average: float | None, path: str | None
) -> dict[str, Any]:
    """What else is reported; it is refused before the work if it belongs to another joint."""
    if average is not None:
        shakedown.averaged(problem, average)
    found = None
    if path is not None:
        from shakedown.report.html import check_refinement
        from shakedown.studies.refined import Refinement

        reads(context, "--refinement", path)
        found = Refinement.load(path)
        check_refinement(found, problem)
    return {"average": average, "refinement": found}
