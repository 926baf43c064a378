"""`shakedown-bounds example`: list or write the built-in problems."""

from __future__ import annotations

from pathlib import Path

import click

import shakedown
from shakedown.report.data_facts import headline
from shakedown.report.facts import Sheet

from .claims import OutputFile
from .options import output_options
from .output import echo_json, say, show


@click.command(
    short_help="List or write the built-in problems.", epilog="Exit codes: 0 listed or written; 2 bad usage."
)
@click.argument("name", required=False)
@click.option("-o", "--output", type=OutputFile(), help="Write the problem file here.")
@output_options
def example(name: str | None, output: Path | None, as_json: bool) -> None:
    """List the built-in problems, or write one to a file."""
    if name is None:
        if output is not None:
            raise click.UsageError("-o needs the NAME of a built-in problem")
        names = shakedown.example_names()
        problems = [shakedown.example(each) for each in names]
        if as_json:
            named = zip(names, problems, strict=True)
            echo_json({"examples": [{"example": each} | problem.to_dict() for each, problem in named]})
            return
        width = max(map(len, names))
        for each, problem in zip(names, problems, strict=True):
            say(f"{each:{width}}  n = {problem.n:2}, m = {problem.m:2}  {problem.name}")
        return
    problem = shakedown.example(name)
    target = output or Path(f"{name}.npz")
    if output is None and target.exists():
        raise click.UsageError(f"{target} exists; name the file to write with -o")
    shakedown.save_problem(target, problem)
    if as_json:
        echo_json({"example": name, "file": str(target)} | problem.to_dict())
        return
    say(f"wrote {target}")
    show(Sheet(headline(problem)))
