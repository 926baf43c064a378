"""`shakedown-bounds map`: what becomes of a joint from many initial states."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import shakedown
from shakedown import Problem
from shakedown.campaign.cluster import cluster_executor
from shakedown.ground.float_array import FloatArray
from shakedown.report.map_facts import SAMPLED, map_sheet, maps_sheet

from .claims import OutputFile, pieces_of
from .number_lists import NumberList
from .options import (
    cycles_option,
    output_options,
    picture_option,
    pieces_option,
    problem_argument,
    scheduler_option,
    slip_below_option,
    workers_option,
)
from .output import draw, echo_json, progress, show

LONGEST_NUMBER = 9  # digits of a node number


class GridSlip(click.ParamType):
    """A slip that a grid varies: NODE, with two tangential directions NODE:x or NODE:y."""

    name = "slip"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        node, _, axis = value.partition(":")
        if not (node.isdecimal() and len(node) <= LONGEST_NUMBER and axis in ("", "x", "y")):
            self.fail(f"expected a node number, or NODE:x or NODE:y, found {value!r}", param, ctx)
        return int(node), axis


@click.command(
    "map",
    short_help="Long-term states from many initial states.",
    epilog="Exit codes: 0 computed; 1 states are undecided; 2 bad usage or bad input.",
)
@problem_argument
@click.option("--load-factor", type=NumberList(), required=True, help="Load factor λ ≥ 0, or LOW:HIGH:COUNT.")
@click.option(
    "--states", type=click.IntRange(min=1), default=1024, show_default=True, help="Number of initial states."
)
@click.option(
    "--grid",
    type=(GridSlip(), GridSlip()),
    metavar="I J",
    help="A grid in the slips of nodes I and J, all others at the safe slip. With two tangential directions "
    "NODE:x or NODE:y each.",
)
@click.option(
    "--sampler",
    type=click.Choice(list(SAMPLED)),
    help="How states are chosen: grid, sobol or latin hypercube in a box about the safe slip, in the "
    "energy ball, or left behind by random transients.  [default: sobol; grid with --grid]",
)
@click.option("--reach", type=float, default=1.0, show_default=True, help="Size of box or ball, relative.")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of what is random.")
@cycles_option
@slip_below_option
@click.option("-o", "--output", type=OutputFile(), help="Write all states here (NPZ).")
@pieces_option
@workers_option(None)
@scheduler_option
@picture_option
@output_options
@click.pass_context
def map_command(
    context: click.Context,
    /,
    problem: Problem,
    load_factor: FloatArray,
    grid: tuple[tuple[int, str], tuple[int, str]] | None,
    sampler: str | None,
    cycles: int,
    output: Path | None,
    resume: bool,
    scheduler: str | None,
    picture: Path | None,
    as_json: bool,
    **settings: Any,
) -> None:
    """What becomes of FILE from many initial states.

    First slip zero, the initial slip in FILE and the critical slip state; then states in a box or ball: the
    share of these that shakes down, the dissipation of the others, their limit cycles.
    """
    pieces_of(context, output, resume)
    with progress("pieces") as update, cluster_executor(scheduler) as executor:
        found = shakedown.initial_state_map(
            problem,
            load_factor.tolist() if len(load_factor) > 1 else float(load_factor[0]),
            sampler=sampler or ("grid" if grid is not None else "sobol"),
            coordinates=None if grid is None else _places(problem, grid),
            path=output,
            resume=resume,
            executor=executor,
            max_cycles=cycles,
            progress=update,
            **settings,
        )
    draw(picture, "basin" if isinstance(found, shakedown.InitialStateMap) else "shakedown_share", found)
    if as_json:
        echo_json(found.to_dict())
    elif isinstance(found, shakedown.InitialStateMaps):
        show(maps_sheet(problem, found))
    else:
        show(map_sheet(problem, found))
    maps = found.maps if isinstance(found, shakedown.InitialStateMaps) else (found,)
    if any(one.undecided or "undecided" in one.named.values() for one in maps):
        context.exit(1)


def _places(problem: Problem, grid: tuple[tuple[int, str], tuple[int, str]]) -> tuple[int, int]:
    """Where the two slips of a grid stand among those of the joint."""
    d = problem.directions
    if any(bool(axis) != (d > 1) for _, axis in grid):
        wanted = "two node numbers" if d == 1 else "NODE:x or NODE:y twice, as the joint has two directions"
        found = " ".join(str(node) + f":{axis}" * bool(axis) for node, axis in grid)
        raise click.UsageError(f"--grid: expected {wanted}, found {found}")
    first, second = (d * node + "xy".find(axis) if d > 1 else node for node, axis in grid)
    return first, second
