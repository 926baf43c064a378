"""`shakedown-bounds verify`: the bounds against time integration, with a report."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import click

import shakedown
from shakedown import Problem
from shakedown.report.run_facts import verify_sheet

from . import options
from .command import Answer, command, progress
from .options import option


@command(
    "Prediction against time integration; report.",
    "0 prediction and simulation agree in every run; 1 they disagree, or a run "
    "slides away or is left open; 2 bad usage or bad input.",
)
@options.problem
@option("-o", "--output", type=options.OutputFile(), help="Write the report (HTML) here, JSON beside it.")
@option(
    "--load-factor", "load_factors", type=float, multiple=True, help="Simulate at this λ; may be repeated."
)
@option(
    "--random",
    "random_states",
    type=click.IntRange(min=0),
    default=None,
    show_default="3; above 50 node pairs in space 1",
    help="Number of initial states: what random loads leave behind.",
)
@options.seed
@options.open_nodes
@options.cycles
@options.method
@options.slip_below
@option("--details", is_flag=True, help="Also every limit, and a table of the runs.")
@options.digits
def verify(
    problem: Problem,
    output: Path | None,
    load_factors: tuple[float, ...],
    details: bool,
    digits: int,
    **settings: Any,
) -> Answer:
    """Hold the bounds of FILE against time integration from several states."""
    if output is not None:
        from shakedown.report.html import report_path, write_report  # what draws is wanted only here

        report_path(output)  # before the work, not after
        options.writes("the JSON beside -o", output.with_suffix(".json"))
    with progress("verification", rest=int(output is not None)) as update:
        result = shakedown.verify(problem, load_factors=load_factors or None, progress=update, **settings)
        if output is not None:
            write_report(output, result)
    return Answer(
        result.to_dict,
        partial(verify_sheet, result, options.file_named(), page=output, details=details, digits=digits),
        is_open=not result.agrees,
    )
