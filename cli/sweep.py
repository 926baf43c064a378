"""`shakedown-bounds sweep`: how the limits move with one or two parameters of a joint."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import click

import shakedown
from shakedown import Problem
from shakedown.campaign.cluster import cluster_executor
from shakedown.ground.constants import FloatArray
from shakedown.report.study_facts import sweep_sheet

from . import options
from .command import Answer, command, document, draw, progress
from .options import option


class Joint(options.ProblemFile):
    """A problem file, the name of a built-in problem, or an import configuration (.toml)."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, str) and value.lower().endswith(".toml"):
            options.reads(options.name_of(param), value)
            made = shakedown.import_model(value)
            for source in made.sources:
                options.reads(f"{source}, which {options.name_of(param)} names", Path(value).parent / source)
            return made
        return super().convert(value, param, ctx)


def varied(text: str) -> tuple[str, FloatArray] | None:
    """A parameter with its values."""
    name, _, numbers = text.partition("=")
    values = options.numbers_of(numbers)
    return (name.strip(), values) if name.strip() and values is not None else None


def bounds_of(text: str) -> tuple[str, ...] | None:
    """Names of limits with commas between them."""
    names = tuple(text.split(","))
    return names if set(names) <= set(shakedown.BOUNDS) and len(set(names)) == len(names) else None


@command(
    "The limits over one or two parameters.",
    "0 computed; 1 limits contradict each other; 2 bad usage or bad input.",
)
@click.argument("joint", metavar="FILE", type=Joint())
@option(
    "--vary",
    type=options.Parsed("parameter", f"NAME= and {options.FORM}, rising, at most {options.MOST:,}", varied),
    multiple=True,
    required=True,
    help="NAME=LOW:HIGH:COUNT or NAME=VALUE,VALUE,…; NAME is f, friction, amplitude, mean, phase, "
    "stiffness or coupling, or a key or constant load of CONFIG.toml. May be given twice.",
)
@option(
    "--bounds",
    type=options.Parsed("names", f"some of {','.join(shakedown.BOUNDS)}", bounds_of),
    help=f"Limits to compute: some of {','.join(shakedown.BOUNDS)}.  [default: all that the joint has]",
)
@option(
    "--load-factor",
    "load_factors",
    type=float,
    multiple=True,
    help="Simulate at this λ too; may be repeated. The first one (else 1) is the one spoken about.",
)
@options.initial
@option(
    "--open",
    "open_nodes",
    type=click.Choice(["auto", "none"]),
    default="auto",
    help="Whether limits may be those of a zone of open nodes.",
)
@option("--quick", is_flag=True, help="λ_T to 0.1 %.")
@options.slip_below
@options.table
@options.picture
@options.workers
@options.scheduler
@options.pieces
def sweep(
    joint: Problem | shakedown.Import,
    vary: tuple[tuple[str, FloatArray], ...],
    initial: str,
    output: Path | None,
    picture: Path | None,
    scheduler: str | None,
    **settings: Any,
) -> Answer:
    """How the limits on the load factor of FILE move with its parameters.

    f is the friction coefficient; friction, amplitude, mean, stiffness and coupling are
    factors on what the file has; phase, in periods, moves the tangential loads along
    against the normal ones. What is proved is proved at the values given, not between them.
    FILE may also be the CONFIG.toml of an import: then its numbers are parameters too, by
    keys like contact.gap or load.2.history.harmonics.1.sin (tables and entries of lists are
    counted from 1), a constant load is varied in its unit by its name ("bolt preload=8:16:5"),
    and the factor on the friction is friction.factor.
    """
    if len({name for name, _ in vary}) < len(vary):
        raise click.UsageError(f"--vary: expected each parameter once, found {vary[0][0]} twice")
    options.pieces_of(output, settings["resume"])
    problem = joint if isinstance(joint, Problem) else joint.problem
    with progress("points") as update, cluster_executor(scheduler) as executor:
        found = shakedown.sweep(
            joint,
            dict(vary),
            initial_slip=options.initial_state(problem, initial),
            executor=executor,
            output=output,
            progress=update,
            **settings,
        )
    if not any(point.exists for point in found.points):
        raise click.UsageError(f"--vary: no value makes a joint: {found.points[0].reason}")
    spoken = next(iter(settings["load_factors"]), 1.0)
    draw(picture, "regions", found, load_factor=spoken)
    sheet = partial(sweep_sheet, problem, found, spoken)
    return Answer(partial(document, problem, found), sheet, bool(found.contradictions))
