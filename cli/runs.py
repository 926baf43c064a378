"""`shakedown-bounds simulate`, `nodes`, `verify`: a joint followed from one state, or from several."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any, Literal

import click

import shakedown
from shakedown import Problem
from shakedown.files.vtk_points import series_paths
from shakedown.ground.work_limit import on_one_thread
from shakedown.report.run_facts import nodes_sheet, run_sheet, verify_sheet

from . import options
from .command import Answer, command, document, progress
from .options import option


@command(
    "Evolution from one initial state.",
    "0 a long-term state was found; 1 undecided, or the body slides away; 2 bad usage or bad input.",
)
@options.run
@options.method
@options.slip_below
@option("-o", "--output", type=options.output_file(), help="Write the path here (NPZ): events or load steps.")
@on_one_thread
def simulate(
    problem: Problem,
    load_factor: float,
    initial: str | None,
    open_nodes: tuple[int, ...] | Literal["auto"],
    output: Path | None,
    **settings: Any,
) -> Answer:
    """Follow FILE at one load factor from one initial state to its long-term state."""
    word, opened, start = options.start_of(problem, load_factor, initial, open_nodes)
    run = shakedown.simulate(
        problem, load_factor, start, open_nodes=opened, record=output is not None, **settings
    )
    if output is not None:
        shakedown.save_history(output, run)
    undecided = run.outcome == shakedown.Outcome.UNDECIDED
    return Answer(partial(document, problem, run), partial(run_sheet, problem, run, word), undecided)


@command(
    "Slip, pressure, friction work of every node.",
    "0 a long-term state was found; 1 undecided, or the body slides away; 2 bad usage or bad input.",
)
@options.run
@option(
    "--wear-coefficient",
    type=float,
    help="Archard's: wear depth = coefficient × pressure × sliding distance [length²/force].",
)
@option(
    "-o",
    "--output",
    type=options.output_file(options.NODE_FILES),
    help="Write every node here: .csv, or for ParaView .vtu or .vtp.",
)
@option(
    "--instants",
    type=click.IntRange(1, 500),
    help="With -o NAME.vtp or .vtu: also the nodes at so many instants, NAME_000.vtp … and NAME.pvd.",
)
@on_one_thread
def nodes(
    problem: Problem,
    load_factor: float,
    initial: str | None,
    open_nodes: tuple[int, ...] | Literal["auto"],
    cycles: int,
    wear_coefficient: float | None,
    output: Path | None,
    instants: int | None,
) -> Answer:
    """What each node of FILE goes through in one period of its long-term state.

    Slip range (max − min), slip per cycle, largest and smallest reactions, friction work per
    cycle, τ δ of Ruiz (largest shear traction × slip range), wear depth per cycle. At a sharp
    edge pressure, wear and τ δ of the last node depend on the mesh, however fine it is; slips
    and the sum of the work do not.
    """
    if problem.node_area is None and wear_coefficient is not None:
        raise click.UsageError("--wear-coefficient: expected a joint with areas of its nodes, found none")
    if instants is not None:
        _claim_series(output, instants)
    word, opened, start = options.start_of(problem, load_factor, initial, open_nodes)
    run = shakedown.simulate(problem, load_factor, start, open_nodes=opened, cycles=cycles)
    found = shakedown.node_results(run, wear_coefficient=wear_coefficient)
    if output is not None:
        found.save(output)
    if output is not None and instants is not None and found.period:
        from shakedown.long_term.node_results import save_node_instants  # it loads what computes

        save_node_instants(run, output, instants)
    return Answer(
        partial(document, problem, found),
        partial(nodes_sheet, problem, found, word),
        is_open=found.outcome == shakedown.Outcome.UNDECIDED,
    )


def _claim_series(output: Path | None, instants: int) -> None:
    """Check before the work starts that the files of the instants can be written and are no others here."""
    if output is None or output.suffix.lower() not in options.NODE_FILES[1:]:
        found = "none" if output is None else str(output)
        expected = f"-o with a name that ends in {' or '.join(options.NODE_FILES[1:])}"
        raise click.UsageError(f"--instants: expected {expected}, found {found}")
    for path in series_paths(output, instants):
        options.writes_whole("--instants", path)


@command(
    "Prediction against time integration; report.",
    "0 prediction and simulation agree in every run; 1 they disagree, or a run "
    "slides away or is left open; 2 bad usage or bad input.",
)
@options.problem
@option("-o", "--output", type=options.output_file(), help="Write the report (HTML) here, JSON beside it.")
@option(
    "--load-factor", "load_factors", type=float, multiple=True, help="Simulate at this λ; may be repeated."
)
@option(
    "--random",
    "random_states",
    type=click.IntRange(min=0),
    default=None,
    show_default="3; above 50 node pairs in space 1",
    help="Number of initial states: what random loads leave behind.",
)
@options.seed
@options.open_nodes
@options.cycles
@options.method
@options.slip_below
@option("--details", is_flag=True, help="Also every limit, and a table of the runs.")
@options.digits
def verify(
    problem: Problem,
    output: Path | None,
    load_factors: tuple[float, ...],
    details: bool,
    digits: int,
    **settings: Any,
) -> Answer:
    """Hold the bounds of FILE against time integration from several states."""
    if output is not None:
        from shakedown.report.html import report_path, write_report  # what draws is wanted only here

        report_path(output)  # before the work, not after
        options.claim("the JSON beside -o", output.with_suffix(".json"), written=True)
    with progress("verification") as update:
        result = shakedown.verify(problem, load_factors=load_factors or None, progress=update, **settings)
    if output is not None:
        write_report(output, result)
    return Answer(
        result.to_dict,
        partial(verify_sheet, result, options.file_named(), page=output, details=details, digits=digits),
        is_open=not result.agrees,
    )
