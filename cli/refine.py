"""`shakedown-bounds refine`: which numbers of a joint converge as its mesh is refined."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import shakedown
from shakedown import Problem
from shakedown.report.data_facts import headline
from shakedown.report.facts import Sheet
from shakedown.report.mesh_facts import refinement_section

from .claims import TableFile, pieces_of
from .options import (
    ProblemFile,
    average_option,
    output_options,
    picture_option,
    pieces_option,
    workers_option,
)
from .output import draw, echo_json, progress, show


@click.command(short_help="Which numbers converge with the mesh.")
@click.argument("problems", metavar="FILE FILE …", type=ProblemFile(), nargs=-1, required=True)
@average_option
@click.option(
    "--load-factor",
    type=float,
    default=1.0,
    show_default=True,
    help="Load factor of friction work and slips, the same on every mesh.",
)
@click.option(
    "--slip-below",
    type=float,
    metavar="LENGTH",
    help="Also up to which load factor every node's slip range stays below this length.",
)
@click.option("-o", "--output", type=TableFile(), help="Write one row per mesh here (.csv or .parquet).")
@picture_option
@workers_option(1)
@pieces_option
@output_options
@click.pass_context
def refine(
    context: click.Context,
    /,
    problems: tuple[Problem, ...],
    average: float | None,
    output: Path | None,
    picture: Path | None,
    resume: bool,
    as_json: bool,
    **settings: Any,
) -> None:
    """Which numbers of one joint converge, from files of it on finer and finer meshes.

    The three numbers of `solve`, λ_max of slips averaged over a length (--average), friction
    work and the largest slip at one load factor, starting without slip. The coarsest mesh comes first;
    three tell.
    """
    if len(problems) < 2:
        raise click.UsageError("FILE FILE …: expected several meshes of one joint, found one file")
    pieces_of(context, output, resume)
    with progress("meshes") as update:
        found = shakedown.refine(
            {problem.n: problem for problem in problems},
            [problem.n for problem in problems],
            radius=average,
            output=output,
            resume=resume,
            progress=update,
            **settings,
        )
    draw(picture, "refinement", found)
    if as_json:
        echo_json({"problem": problems[-1].to_dict()} | found.to_dict())
    else:
        finest = problems[-1]
        show(Sheet(headline(finest), sections=[refinement_section(found, finest)]))
