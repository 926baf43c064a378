"""`shakedown-bounds nodes`: what each node goes through in a period of the long-term state."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import click

import shakedown
from shakedown import Problem
from shakedown.files.vtk_points import series_paths
from shakedown.ground.blas_threads import on_one_thread
from shakedown.report.run_facts import nodes_sheet

from .claims import NODE_FILES, SERIES_FILES, OutputFile, writes_whole
from .initial import start_of
from .options import (
    output_options,
    run_options,
)
from .output import echo_json, show


@click.command(
    short_help="Slip, pressure, friction work of every node.",
    epilog="Exit codes: 0 a long-term state was found, whichever; 1 undecided after --cycles; "
    "2 bad usage or bad input.",
)
@run_options
@click.option(
    "--wear-coefficient",
    type=float,
    help="Archard's: wear depth = coefficient × pressure × sliding distance [length²/force].",
)
@click.option("--tractions", is_flag=True, help="Tractions and work per area in the table of -o, too.")
@click.option(
    "-o",
    "--output",
    type=OutputFile(NODE_FILES),
    help="Write every node here: .csv, or for ParaView .vtu or .vtp.",
)
@click.option(
    "--instants",
    type=click.IntRange(1, 500),
    help="With -o NAME.vtp or .vtu: also the nodes at so many instants, NAME_000.vtp … and NAME.pvd.",
)
@output_options
@click.pass_context
@on_one_thread
def nodes(
    context: click.Context,
    problem: Problem,
    load_factor: float,
    initial: str | None,
    open_nodes: tuple[int, ...] | Literal["auto"],
    cycles: int,
    wear_coefficient: float | None,
    tractions: bool,
    output: Path | None,
    instants: int | None,
    as_json: bool,
) -> None:
    """What each node of FILE goes through in one period of its long-term state.

    Slip range (max − min), slip per cycle, largest and smallest reactions, friction work per
    cycle, τ δ of Ruiz (largest shear traction × slip range), wear depth per cycle. At a sharp
    edge pressure, wear and τ δ of the last node depend on the mesh, however fine it is; slips
    and the sum of the work do not.
    """
    if problem.node_area is None and (tractions or wear_coefficient is not None):
        option = "--tractions" if tractions else "--wear-coefficient"
        raise click.UsageError(f"{option}: expected a joint with areas of its nodes, found no 'node_area'")
    if instants is not None:
        _claim_series(context, output, instants)
    word, opened, start = start_of(problem, load_factor, initial, open_nodes)
    run = shakedown.simulate(problem, load_factor, start, open_nodes=opened, cycles=cycles)
    found = shakedown.node_results(run, wear_coefficient=wear_coefficient)
    if output is not None:
        found.save(output, tractions=tractions)
    if output is not None and instants is not None and found.period:
        from shakedown.long_term.node_instants import save_node_instants  # it loads what computes

        save_node_instants(run, output, instants)
    if as_json:
        echo_json({"problem": problem.to_dict()} | found.to_dict())
    else:
        show(nodes_sheet(problem, found, word))
    if found.outcome == shakedown.Outcome.UNDECIDED:
        context.exit(1)


def _claim_series(context: click.Context, output: Path | None, instants: int) -> None:
    """Check before the work starts that the files of the instants can be written and are no others here."""
    if output is None or output.suffix.lower() not in SERIES_FILES:
        found = "none" if output is None else str(output)
        expected = f"-o with a name that ends in {' or '.join(SERIES_FILES)}"
        raise click.UsageError(f"--instants: expected {expected}, found {found}")
    for path in series_paths(output, instants):
        writes_whole(context, "--instants", path)
