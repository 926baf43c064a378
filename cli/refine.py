"""`shakedown-bounds refine`: which numbers of a joint converge as its mesh is refined."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import click

import shakedown
from shakedown import Problem
from shakedown.report.study_facts import refinement_sheet

from . import options
from .command import Answer, command, document, draw, progress


@command("Which numbers converge with the mesh.", "0 computed; 2 bad usage or bad input.")
@click.argument("problems", metavar="FILE FILE …", type=options.ProblemFile(), nargs=-1, required=True)
@options.average
@options.load_factor
@options.slip_below
@options.table
@options.picture
@options.workers
@options.pieces
def refine(
    problems: tuple[Problem, ...],
    average: float | None,
    output: Path | None,
    picture: Path | None,
    **settings: Any,
) -> Answer:
    """Which numbers of one joint converge, from files of it on finer and finer meshes.

    The three numbers of `solve`, λ_max of slips averaged over a length (--average), friction
    work and the largest slip at one load factor, starting without slip. The coarsest mesh comes first;
    three tell.
    """
    if len(problems) < 2:
        raise click.UsageError("FILE FILE …: expected several meshes of one joint, found one file")
    options.pieces_of(output, settings["resume"])
    meshes = {problem.n: problem for problem in problems}
    sizes = [problem.n for problem in problems]
    with progress("meshes") as update:
        found = shakedown.refine(meshes, sizes, radius=average, output=output, progress=update, **settings)
    draw(picture, "refinement", found)
    finest = problems[-1]
    return Answer(partial(document, finest, found), partial(refinement_sheet, finest, found))
