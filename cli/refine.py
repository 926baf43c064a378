"""`shakedown-bounds refine`: which numbers of a joint converge as its mesh is refined."""

from __future__ import annotations

from pathlib import Path

import click

import shakedown
from shakedown import Problem
from shakedown.report.data_facts import headline
from shakedown.report.facts import Sheet
from shakedown.report.mesh_facts import refinement_section

from .claims import PICTURES, OutputFile, TableFile, pieces_of
from .options import ProblemFile, average_option, output_options, pieces_option
from .output import echo_json, progress, show


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
@click.option("--picture", type=OutputFile(PICTURES), help="Draw the numbers here (.png, .svg or .pdf).")
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Processes.")
@pieces_option
@output_options
@click.pass_context
def refine(
    context: click.Context,
    problems: tuple[Problem, ...],
    average: float | None,
    load_factor: float,
    slip_below: float | None,
    output: Path | None,
    picture: Path | None,
    workers: int,
    resume: bool,
    as_json: bool,
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
            load_factor=load_factor,
            slip_below=slip_below,
            workers=workers,
            output=output,
            resume=resume,
            progress=update,
        )
    if picture is not None:
        from shakedown import plot  # only where a picture is wanted

        plot.save(plot.refinement(found), picture)
    if as_json:
        echo_json({"problem": problems[-1].to_dict()} | found.to_dict())
    else:
        finest = problems[-1]
        show(Sheet(headline(finest), sections=[refinement_section(found, finest)]))
