"""`shakedown-bounds sweep`: how the limits move with one or two parameters of a joint."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import shakedown
from shakedown import Problem
from shakedown.campaign.cluster import cluster_executor
from shakedown.ground.float_array import FloatArray
from shakedown.ground.visible_text import shortened
from shakedown.report.design_facts import sweep_sheet

from .claims import TableFile, name_of, pieces_of, reads
from .initial import initial_state, refuse_at_load_factor
from .number_lists import Vary
from .options import (
    ProblemFile,
    output_options,
    picture_option,
    pieces_option,
    scheduler_option,
    slip_below_option,
    workers_option,
)
from .output import draw, echo_json, progress, show


class Joint(ProblemFile):
    """A problem file, the name of a built-in problem, or an import configuration (.toml)."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, str) and value.lower().endswith(".toml"):
            reads(ctx, name_of(param), value)
            made = shakedown.import_model(value)
            for source in made.sources:
                reads(ctx, f"{source}, which {name_of(param)} names", Path(value).parent / source)
            return made
        return super().convert(value, param, ctx)


class Bounds(click.ParamType):
    """Names of limits with commas between them."""

    name = "names"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        names = value if isinstance(value, tuple) else tuple(value.split(","))
        if not set(names) <= set(shakedown.BOUNDS) or len(set(names)) < len(names):
            raise click.UsageError(
                f"--bounds: expected some of {','.join(shakedown.BOUNDS)}, found {shortened(str(value))}"
            )
        return names


@click.command(short_help="The limits over one or two parameters.")
@click.argument("joint", metavar="FILE", type=Joint())
@click.option(
    "--vary",
    type=Vary(),
    multiple=True,
    required=True,
    help="NAME=LOW:HIGH:COUNT or NAME=VALUE,VALUE,…; NAME is f, friction, amplitude, mean, phase, "
    "stiffness or coupling, or a key or constant load of CONFIG.toml. May be given twice.",
)
@click.option(
    "--bounds",
    type=Bounds(),
    help=f"Limits to compute: some of {','.join(shakedown.BOUNDS)}.  [default: all that the joint has]",
)
@click.option(
    "--load-factor",
    "load_factors",
    type=float,
    multiple=True,
    help="Simulate at this λ too; may be repeated. The first one (else 1) is the one spoken about.",
)
@click.option(
    "--initial",
    metavar="STATE",
    default="zero",
    show_default=True,
    help="State of proofs and simulations: zero, given, given:K or PATH.npy.",
)
@click.option(
    "--open",
    "open_nodes",
    type=click.Choice(["auto", "none"]),
    default="auto",
    show_default=True,
    help="Whether limits may be those of a zone of open nodes.",
)
@click.option("--quick", is_flag=True, help="λ_T to 0.1 %.")
@slip_below_option
@click.option("-o", "--output", type=TableFile(), help="Write one row per point here (.csv or .parquet).")
@picture_option
@workers_option(1)
@scheduler_option
@pieces_option
@output_options
@click.pass_context
def sweep(
    context: click.Context,
    /,
    joint: Problem | shakedown.Import,
    vary: tuple[tuple[str, FloatArray], ...],
    load_factors: tuple[float, ...],
    initial: str,
    output: Path | None,
    picture: Path | None,
    scheduler: str | None,
    resume: bool,
    as_json: bool,
    **settings: Any,
) -> None:
    """How the limits on the load factor of FILE move with its parameters.

    f is the friction coefficient; friction, amplitude, mean, stiffness and coupling are
    factors on what the file has; phase, in periods, moves the tangential loads along
    against the normal ones. What is proved is proved at the values given, not between them.
    FILE may also be the CONFIG.toml of an import: then its numbers are parameters too, by
    keys like contact.gap or load.2.history.harmonics.1.sin (tables and entries of lists are
    counted from 1), a constant load is varied in its unit by its name ("bolt preload=8:16:5"),
    and the factor on the friction is friction.factor. Exit code 1 where
    limits contradict each other.
    """
    if len({name for name, _ in vary}) < len(vary):
        raise click.UsageError(f"--vary: expected each parameter once, found {vary[0][0]} twice")
    pieces_of(context, output, resume)
    refuse_at_load_factor(initial)
    problem = joint if isinstance(joint, Problem) else joint.problem
    with progress("points") as update, cluster_executor(scheduler) as executor:
        found = shakedown.sweep(
            joint,
            dict(vary),
            load_factors=load_factors,
            initial_slip=initial_state(problem, 0.0, initial),
            executor=executor,
            output=output,
            resume=resume,
            progress=update,
            **settings,
        )
    if not any(point.exists for point in found.points):
        raise click.UsageError(f"--vary: no value makes a joint: {found.points[0].reason}")
    spoken = load_factors[0] if load_factors else 1.0
    draw(picture, "regions", found, load_factor=spoken)
    if as_json:
        echo_json({"problem": problem.to_dict()} | found.to_dict())
    else:
        show(sweep_sheet(problem, found, spoken))
    if found.contradictions:
        context.exit(1)
