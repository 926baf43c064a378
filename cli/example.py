"""`shakedown-bounds example`: list or write the built-in problems."""

from __future__ import annotations

from pathlib import Path

import click

import shakedown
from shakedown.report.data_facts import examples_sheet, written_sheet

from . import options
from .command import Answer, command
from .options import option


@command("List or write the built-in problems.", "0 listed or written; 2 bad usage.")
@click.argument("name", required=False)
@option("-o", "--output", type=options.OutputFile(), help="Write the problem file here.")
def example(name: str | None, output: Path | None) -> Answer:
    """List the built-in problems, or write one to a file."""
    if name is None:
        if output is not None:
            raise click.UsageError("-o needs the NAME of a built-in problem")
        known = {each: shakedown.example(each) for each in shakedown.example_names()}
        listed = [{"example": each} | problem.to_dict() for each, problem in known.items()]
        return Answer(lambda: {"examples": listed}, lambda: examples_sheet(known))
    problem = shakedown.example(name)
    target = output or Path(f"{name}.npz")
    if output is None and target.exists():
        raise click.UsageError(f"{target} exists; name the file to write with -o")
    shakedown.save_problem(target, problem)
    return Answer(
        lambda: {"example": name, "file": str(target)} | problem.to_dict(),
        lambda: written_sheet(problem, str(target)),
    )
