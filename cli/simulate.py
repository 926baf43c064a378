"""`shakedown-bounds simulate`: evolution from one initial state, and the long-term state."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any, Literal

import click

import shakedown
from shakedown import Problem
from shakedown.ground.work_limit import on_one_thread
from shakedown.report.run_facts import run_sheet

from . import options
from .command import Answer, command, document
from .options import option


@command(
    "Evolution from one initial state.",
    "0 a long-term state was found, whichever; 1 undecided after --cycles; 2 bad usage or bad input.",
)
@options.run
@options.method
@options.slip_below
@option("-o", "--output", type=options.OutputFile(), help="Write the path here (NPZ): events or load steps.")
@option(
    "--loop",
    type=options.OutputFile(table=True),
    help="Write the loops of the loads here (.csv): load and displacement.",
)
@on_one_thread
def simulate(
    problem: Problem,
    load_factor: float,
    initial: str | None,
    open_nodes: tuple[int, ...] | Literal["auto"],
    output: Path | None,
    loop: Path | None,
    **settings: Any,
) -> Answer:
    """Follow FILE at one load factor from one initial state to its long-term state."""
    word, opened, start = options.start_of(problem, load_factor, initial, open_nodes)
    run = shakedown.simulate(
        problem, load_factor, start, open_nodes=opened, record=output is not None, **settings
    )
    if output is not None:
        shakedown.save_history(output, run)
    if loop is not None:
        _write_loops(problem, run, loop)
    undecided = run.outcome == shakedown.Outcome.UNDECIDED
    return Answer(partial(document, problem, run), partial(run_sheet, problem, run, word), undecided)


def _write_loops(problem: Problem, run: shakedown.Simulation, path: Path) -> None:
    """The loops of the loads over one period of the long-term state of a run."""
    from shakedown.long_term.conjugate_displacement import load_loops  # it loads compiled code

    if run.long_term is None or not run.long_term.period:
        raise click.UsageError(
            f"--loop: expected a period from event to event, found none ({run.method}, {run.outcome})"
        )
    load_loops(problem, run.long_term).save(path, problem)
