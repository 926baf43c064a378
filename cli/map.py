"""`shakedown-bounds map`: what becomes of a joint from many initial states."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

import shakedown
from shakedown import Problem
from shakedown.campaign.cluster import cluster_executor
from shakedown.report.map_facts import SAMPLED, map_sheet, maps_sheet

from .claims import PICTURES, OutputFile, pieces_of
from .options import (
    cycles_option,
    output_options,
    pieces_option,
    problem_argument,
    scheduler_option,
    slip_below_option,
)
from .output import echo_json, progress, show

if TYPE_CHECKING:  # they load what computes
    from shakedown import InitialStateMap, InitialStateMaps

LONGEST_NUMBER = 9  # digits of a node number
MOST_LOAD_FACTORS = 100_000  # more rows than anyone reads


class LoadFactors(click.ParamType):
    """A load factor, or several evenly spaced ones as FIRST:LAST:COUNT."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        try:
            if ":" not in value:
                return float(value)
            low, high, count = value.split(":")
            first, last, many = float(low), float(high), int(count)
            if not (isfinite(first) and isfinite(last) and 1 <= many <= MOST_LOAD_FACTORS):
                raise ValueError
            return np.linspace(first, last, many).tolist()
        except ValueError:
            wanted = f"a number or FIRST:LAST:COUNT like 0.5:1:11 (COUNT from 1 to {MOST_LOAD_FACTORS:,})"
            self.fail(f"expected {wanted}, found {value!r}", param, ctx)


class GridSlip(click.ParamType):
    """A slip that a grid varies: NODE, with two tangential directions NODE:x or NODE:y."""

    name = "slip"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, str]:
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
@click.option(
    "--load-factor", type=LoadFactors(), required=True, help="Load factor λ ≥ 0, or FIRST:LAST:COUNT."
)
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
@click.option(
    "--reach",
    type=float,
    default=1.0,
    show_default=True,
    help="Size of the box or the ball, relative to its own.",
)
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of what is random."
)
@cycles_option
@slip_below_option
@click.option("-o", "--output", type=OutputFile(), help="Write all states here (NPZ).")
@pieces_option
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    help="Number of processes; by default all cores, in one process where that is quicker.",
)
@scheduler_option
@click.option("--picture", type=OutputFile(PICTURES), help="Draw it here (PNG, PDF or SVG).")
@output_options
@click.pass_context
def map_command(
    context: click.Context,
    problem: Problem,
    load_factor: float | list[float],
    states: int,
    grid: tuple[tuple[int, str], tuple[int, str]] | None,
    sampler: str | None,
    reach: float,
    seed: int,
    cycles: int,
    slip_below: float | None,
    output: Path | None,
    resume: bool,
    workers: int | None,
    scheduler: str | None,
    picture: Path | None,
    as_json: bool,
) -> None:
    """What becomes of FILE from many initial states.

    First slip zero, the initial slip in FILE and the critical slip state; then states in a box or ball: the
    share of these that shakes down, the dissipation of the others, their limit cycles.
    """
    pieces_of(context, output, resume)
    with progress("pieces") as update, cluster_executor(scheduler) as executor:
        found = shakedown.initial_state_map(
            problem,
            load_factor,
            states=states,
            sampler=sampler or ("grid" if grid is not None else "sobol"),
            seed=seed,
            coordinates=None if grid is None else _places(problem, grid),
            reach=reach,
            path=output,
            resume=resume,
            workers=workers,
            executor=executor,
            max_cycles=cycles,
            slip_below=slip_below,
            progress=update,
        )
    if picture is not None:
        _draw(found, picture)
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


def _draw(found: InitialStateMap | InitialStateMaps, picture: Path) -> None:
    from shakedown import plot  # matplotlib is wanted only here

    drawn = plot.basin(found) if isinstance(found, shakedown.InitialStateMap) else plot.shakedown_share(found)
    plot.save(drawn, picture)
