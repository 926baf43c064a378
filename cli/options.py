"""Arguments and options that several commands share."""

from __future__ import annotations

import logging
import os
import shlex
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import click

import shakedown
from shakedown.ground.shown_values import FEW_DIGITS
from shakedown.ground.size_limits import CYCLES
from shakedown.ground.visible_text import shortened

from .claims import PICTURES, OutputFile, name_of, reads
from .output import QUIET

F = TypeVar("F", bound=Callable[..., Any])


NAMED = f"{__name__}.file"  # in a context: the file or built-in problem that a command was given


class ProblemFile(click.ParamType):
    """A problem file or the name of a built-in problem; a file of that name wins."""

    name = "file"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, shakedown.Problem):
            return value
        if not value:
            raise click.UsageError("FILE: expected a file or the name of a built-in problem, found ''")
        if ctx is not None:
            ctx.meta[NAMED] = shlex.quote(value)
        if not os.path.exists(value) and value in shakedown.example_names():
            return shakedown.example(value)
        if not os.path.exists(value) and Path(value).suffix == "" and "/" not in value:
            names = ", ".join(shakedown.example_names())
            raise shakedown.ProblemError(
                f"{value}: no such file, and no built-in problem (there are {names})"
            )
        reads(ctx, name_of(param), value)
        return shakedown.load_problem(value)


class OpenNodes(click.ParamType):
    """Which nodes stay open: auto, none, or numbers with commas between them."""

    name = "nodes"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value in ("auto", "none"):
            return value if value == "auto" else ()
        numbers = value.split(",")
        if not all(number.isascii() and number.isdigit() and len(number) < 10 for number in numbers):
            shown = shortened(value)
            raise click.UsageError(f"--open: expected auto, none or node numbers like 0,3,7, found '{shown}'")
        return tuple(map(int, numbers))


def _keep_quiet(context: click.Context, _: click.Parameter, value: bool) -> None:
    context.meta[QUIET] = value
    if value:
        log = logging.getLogger("shakedown")
        context.find_root().call_on_close(partial(log.setLevel, log.level))  # as it was, also after bad usage
        log.setLevel(logging.ERROR)


def output_options(command: F) -> F:
    """What every command takes: ``--json`` and ``--quiet``."""
    quiet = click.option(
        "-q",
        "--quiet",
        is_flag=True,
        expose_value=False,
        is_eager=True,
        callback=_keep_quiet,
        help="No progress and no remarks on stderr.",
    )
    return click.option("--json", "as_json", is_flag=True, help="One JSON document on stdout.")(
        quiet(command)
    )


problem_argument = click.argument("problem", metavar="FILE", type=ProblemFile())
pieces_option = click.option(
    "--resume", is_flag=True, help="Go on with what a run that was stopped left in OUTPUT.parts."
)
scheduler_option = click.option(
    "--scheduler", metavar="ADDRESS", help="Work on the dask cluster of this scheduler instead."
)
picture_option = click.option(
    "--picture", type=OutputFile(PICTURES), help="Draw it here (.png, .svg or .pdf)."
)
open_option = click.option(
    "--open",
    "open_nodes",
    type=OpenNodes(),
    default="auto",
    show_default=True,
    help="Nodes that stay open: auto, none, or numbers like 0,3,7.",
)
average_option = click.option(
    "--average",
    type=float,
    metavar="RADIUS",
    help="Also with slips and reactions averaged over this length (in the joint's unit).",
)
digits_option = click.option(
    "--digits",
    type=click.IntRange(1, 15),
    default=FEW_DIGITS,
    show_default=True,
    help="Digits of load factors, at least.",
)
method_option = click.option(
    "--method",
    type=click.Choice(["event", "gauss-seidel"]),
    default="event",
    show_default=True,
    help="From event to event, or at fixed load steps.",
)
slip_below_option = click.option(
    "--slip-below",
    type=float,
    metavar="LENGTH",
    help="Say also whether every node's slip range in the long run stays below this length.",
)
cycles_option = click.option(
    "--cycles",
    type=click.IntRange(min=1),
    default=CYCLES,
    show_default=True,
    help="Give up as undecided after so many cycles.",
)


def workers_option(default: int | None) -> Callable[[F], F]:
    """How many processes; None: one for each core, or one where that is quicker."""
    many = "  [default: all cores, or one where that is quicker]" if default is None else ""
    kind = click.IntRange(min=1)
    return click.option(
        "--workers", type=kind, default=default, show_default=bool(default), help=f"Processes.{many}"
    )


def run_options(command: F) -> F:
    """What one run is of, where it begins, and how long it may take."""
    load_factor = click.option(
        "--load-factor",
        type=float,
        default=1.0,
        show_default=True,
        help="Load factor λ ≥ 0 of the periodic loading; 1 is the nominal load.",
    )
    start = click.option(
        "--initial",
        metavar="STATE",
        help="zero, safe (through the transient too, where there is such a slip), witness (the critical slip "
        "state of λ_1, in the plane), given, given:K (state K of the file) or PATH.npy. "
        "Default: given where the file has initial_slip, else zero.",
    )
    opened = click.option(
        "--open",
        "open_nodes",
        type=OpenNodes(),
        default="none",
        show_default=True,
        help="Nodes that are open at the start: none, numbers like 0,3,7, or auto: those of the zone "
        "of λ_max.",
    )
    return problem_argument(load_factor(start(opened(cycles_option(command)))))
