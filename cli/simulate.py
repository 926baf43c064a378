"""`shakedown-bounds simulate`: evolution from one initial state, and the long-term state."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import click

import shakedown
from shakedown import Problem
from shakedown.ground.blas_threads import on_one_thread
from shakedown.report.run_facts import run_sheet

from .claims import OutputFile, TableFile
from .initial import start_of
from .options import (
    method_option,
    output_options,
    run_options,
    slip_below_option,
)
from .output import echo_json, show


@click.command(
    short_help="Evolution from one initial state.",
    epilog="Exit codes: 0 a long-term state was found, whichever; 1 undecided after --cycles; "
    "2 bad usage or bad input.",
)
@run_options
@method_option
@slip_below_option
@click.option("-o", "--output", type=OutputFile(), help="Write the path here (NPZ): events or load steps.")
@click.option(
    "--loop", type=TableFile(), help="Write the loops of the loads here (.csv): load and displacement."
)
@output_options
@click.pass_context
@on_one_thread
def simulate(
    context: click.Context,
    problem: Problem,
    load_factor: float,
    initial: str | None,
    open_nodes: tuple[int, ...] | Literal["auto"],
    cycles: int,
    method: str,
    slip_below: float | None,
    output: Path | None,
    loop: Path | None,
    as_json: bool,
) -> None:
    """Follow FILE at one load factor from one initial state to its long-term state."""
    word, opened, start = start_of(problem, load_factor, initial, open_nodes)
    run = shakedown.simulate(
        problem,
        load_factor,
        start,
        open_nodes=opened,
        cycles=cycles,
        method=method,
        record=output is not None,
        slip_below=slip_below,
    )
    if output is not None:
        shakedown.save_history(output, run)
    if loop is not None:
        _write_loops(problem, run, loop)
    if as_json:
        echo_json({"problem": problem.to_dict()} | run.to_dict())
    else:
        show(run_sheet(problem, run, word, transient_moves=_transient_moves(problem, run, word)))
    if run.outcome == shakedown.Outcome.UNDECIDED:
        context.exit(1)


def _write_loops(problem: Problem, run: shakedown.Simulation, path: Path) -> None:
    """The loops of the loads over one period of the long-term state of a run."""
    from shakedown.long_term.conjugate_displacement import load_loops  # it loads compiled code

    if run.long_term is None or not run.long_term.period:
        raise click.UsageError(
            f"--loop: expected a period from event to event, found none ({run.method}, {run.outcome})"
        )
    load_loops(problem, run.long_term).save(path, problem)


def _transient_moves(problem: Problem, run: shakedown.Simulation, initial: str) -> bool:
    """Whether the transient load steps move every safe slip, and so the one that the run begins with."""
    from shakedown.bounds.named_start import moved_by_transient

    return initial == "safe" and not run.open_nodes and moved_by_transient(problem, run.load_factor)
