"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import shakedown


class ProblemFile(click.ParamType):
    """A problem file or the name of a built-in problem; a file of that name wins."""

    name = "file"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, shakedown.Problem):
            return value
        if not value:
            raise click.UsageError("FILE: expected a file or the name of a built-in problem, found ''")
        if not Path(value).exists() and value in shakedown.example_names():
            return shakedown.example(value)
        if not Path(value).exists() and Path(value).suffix == "" and "/" not in value:
            names = ", ".join(shakedown.example_names())
            raise shakedown.ProblemError(
                f"{value}: no such file, and no built-in problem (there are {names})"
            )
        return shakedown.load_problem(value)


problem_argument = click.argument("problem", metavar="FILE", type=ProblemFile())
json_option = click.option("--json", "as_json", is_flag=True, help="One JSON document on stdout.")
method_option = click.option(
    "--method",
    type=click.Choice(["event", "gauss-seidel"]),
    default="event",
    show_default=True,
    help="Exact from event to event, or fixed load steps.",
)
cycles_option = click.option(
    "--cycles",
    type=click.IntRange(min=1),
    default=1000,
    show_default=True,
    help="Give up as undecided after so many cycles.",
)
