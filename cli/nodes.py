"""`shakedown-bounds nodes`: what each node goes through in a period of the long-term state."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

import shakedown
from shakedown import Problem
from shakedown.files.vtk_points import series_paths
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.shown_values import few, sized
from shakedown.ground.visible_text import shortened
from shakedown.joint.units import units_of
from shakedown.report.node_words import (
    node_columns,
    resolution,
    total_slip_in_words,
    without_round_off,
    worst_first,
)
from shakedown.report.run_words import separated_in_words
from shakedown.report.text_table import table

from .claims import NODE_FILES, SERIES_FILES, OutputFile, writes_whole
from .initial import start_of
from .options import (
    output_options,
    run_options,
)
from .output import echo_json, headline, load_factor_in_words, paragraph, say

if TYPE_CHECKING:  # it loads what computes
    from shakedown import NodeResults

WORST, DIGITS = 10, 3  # nodes that are shown, and of their numbers
LONGEST_LABEL, WIDTH = 11, 80


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
        say(_text(problem, found, word))
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


def _text(problem: Problem, found: NodeResults, initial: str) -> str:
    factor = load_factor_in_words(problem, found.load_factor)
    begun = f"{factor}, initial state {shortened(initial)}: {found.outcome}"
    lines = [
        headline(problem),
        "",
        *[separated_in_words(problem)] * (set(found.status) == {"open"}),
        paragraph(begun),
        paragraph(f"({found.reason}).", "  "),
    ]
    if not found.period:
        return "\n".join([*lines, "There is no steady period, and so there are no numbers."])
    counts = ", ".join(f"{found.status.count(word)} {word}" for word in dict.fromkeys(found.status))
    works = without_round_off(found.work, resolution(problem, found.load_factor)[1])
    work = sized(sum(works), units_of(problem).work, DIGITS)
    if "slip" in found.status and not any(works):
        work = "a negligible amount"
    total = f"Friction dissipates {work} per cycle"
    said = filter(None, [f"Nodes: {counts}. {total}.", total_slip_in_words(found, problem)])
    return "\n".join([*lines, *map(paragraph, said), "", _worst(problem, found)])


def _worst(problem: Problem, found: NodeResults) -> str:
    """The nodes that move farthest."""
    columns, worst = node_columns(found, problem), worst_first(found, problem)[:WORST]
    label = {} if problem.label is None else {"FE": [shortened(name, LONGEST_LABEL) for name in found.label]}
    shown = {"node": list(map(str, range(problem.n)))} | label | {"status": list(found.status)}
    for name, values in columns.items():
        shown[name.replace("_", " ")] = ["-" if value != value else few(value, DIGITS) for value in values]
    text = table(list(shown), [[column[node] for column in shown.values()] for node in worst])
    while max(map(len, text.splitlines())) > WIDTH:  # what does not fit stands in the files
        shown.popitem()
        text = table(list(shown), [[column[node] for column in shown.values()] for node in worst])
    slips = bool((columns["slip_range"] > 0).any())
    return "\n".join([_heading(problem, len(worst), slips, "mixed" in found.status), "", text])


def _heading(problem: Problem, shown: int, slips: bool, mixed: bool) -> str:
    """What the table shows, in which units."""
    known = units_of(problem)
    units = f" ({known.length}, {known.force}, {known.work})" if known.work else ""
    most = "slip range" if slips else "p max"
    which = f"The {shown} nodes with the largest {most}" if shown < problem.n else "All nodes"
    what = "accumulated slip is Σ|Δv| in contact per cycle, p and q are normal and tangential force"
    what += "; mixed: open for part of the period" * mixed
    return paragraph(f"{which}; {what}{units}:")
