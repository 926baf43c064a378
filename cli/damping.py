"""`shakedown-bounds damping`: dissipation and stiffness over the amplitude of a load."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import shakedown
from shakedown import Outcome, Problem
from shakedown.ground.float_array import FloatArray
from shakedown.report.design_facts import damping_sheet

from .claims import TableFile
from .initial import refuse_at_load_factor, start_of
from .number_lists import NumberList
from .options import (
    OpenNodes,
    cycles_option,
    output_options,
    picture_option,
    problem_argument,
)
from .output import draw, echo_json, progress, show


@click.command(
    short_help="Damping and stiffness over the amplitude of a load.",
    epilog="Exit codes: 0 a long-term state was found at every amplitude, whichever; 1 undecided somewhere; "
    "2 bad usage or bad input.",
)
@problem_argument
@click.option(
    "--amplitudes",
    type=NumberList(),
    required=True,
    help="LOW:HIGH:COUNT or VALUE,VALUE,…: factors on the history of the load, rising.",
)
@click.option("--load", default="0", metavar="NAME", show_default=True, help="Which load, by name or number.")
@click.option(
    "--initial",
    metavar="STATE",
    help="zero, given, given:K or PATH.npy. Default: given where the file has initial_slip, else zero.",
)
@click.option(
    "--open",
    "open_nodes",
    type=OpenNodes(),
    default="auto",
    show_default=True,
    help="Nodes open at the start: none or numbers like 0,3,7; auto: none; proofs: the best zone.",
)
@click.option("--from-zero", is_flag=True, help="Every amplitude from that state too; say where it differs.")
@cycles_option
@click.option("-o", "--output", type=TableFile(), help="Write one row per amplitude (.csv or .parquet).")
@picture_option
@output_options
@click.pass_context
def damping(
    context: click.Context,
    /,
    problem: Problem,
    amplitudes: FloatArray,
    initial: str | None,
    cycles: int,
    output: Path | None,
    picture: Path | None,
    as_json: bool,
    **settings: Any,
) -> None:
    """Follow FILE at rising amplitudes of one load to its long-term states.

    FILE has to know its loads (load_reactions, load_history; for displacements
    load_compliance), as import writes them. Each amplitude begins where the one before it ended.
    """
    refuse_at_load_factor(initial)
    with progress("amplitudes") as update:
        curve = shakedown.damping(
            problem,
            amplitudes,
            initial_slip=start_of(problem, 0.0, initial, ())[2],
            max_cycles=cycles,
            progress=update,
            **settings,
        )
    if output is not None:
        curve.save(output)
    draw(picture, "damping_curve", curve)
    if as_json:
        echo_json({"problem": problem.to_dict()} | curve.to_dict())
    else:
        show(damping_sheet(problem, curve))
    if Outcome.UNDECIDED in curve.outcome:
        context.exit(1)
