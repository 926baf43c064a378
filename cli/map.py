"""`shakedown-bounds map`: what becomes of a joint from many initial states."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path
from typing import Any

import click

import shakedown
from shakedown import Problem
from shakedown.campaign.cluster import cluster_executor
from shakedown.ground.constants import FloatArray
from shakedown.ground.shown_values import shortened
from shakedown.report.study_facts import SAMPLED, map_sheet

from . import options
from .command import Answer, command, draw, progress
from .options import option

GRID_SLIP = "([0-9]{{1,9}}){}"  # a node, with two tangential directions one of them


@command(
    "Long-term states from many initial states.",
    "0 computed; 1 states are undecided; 2 bad usage or bad input.",
)
@options.problem
@option("--load-factor", type=options.NUMBERS, required=True, help="Load factor λ ≥ 0, or LOW:HIGH:COUNT.")
@option("--states", type=click.IntRange(min=1), default=1024, help="Number of initial states.")
@option(
    "--grid",
    nargs=2,
    metavar="I J",
    help="A grid in the slips of nodes I and J, all others at the safe slip. With two tangential directions "
    "NODE:x or NODE:y each.",
)
@option(
    "--sampler",
    type=click.Choice(list(SAMPLED)),
    help="How states are chosen: grid or sobol in a box about the safe slip, in the "
    "energy ball, or left behind by random transients.  [default: sobol; grid with --grid]",
)
@option("--reach", type=float, default=1.0, help="Size of box or ball, relative.")
@options.seed
@options.cycles
@options.slip_below
@option("-o", "--output", type=options.OutputFile(), help="Write all states here (NPZ).")
@options.pieces
@option(
    "--workers",
    type=click.IntRange(min=1),
    help="Processes.  [default: all cores, or one where that is quicker]",
)
@options.scheduler
@options.picture
def map_command(
    problem: Problem,
    load_factor: FloatArray,
    grid: tuple[str, str] | None,
    sampler: str | None,
    cycles: int,
    output: Path | None,
    scheduler: str | None,
    picture: Path | None,
    **settings: Any,
) -> Answer:
    """What becomes of FILE from many initial states.

    First slip zero, the initial slip in FILE and the critical slip state; then states in a box or ball: the
    share of these that shakes down, the dissipation of the others, their limit cycles.
    """
    options.pieces_of(output, settings["resume"])
    factors: Any = load_factor.tolist()
    with progress("pieces") as update, cluster_executor(scheduler) as executor:
        found = shakedown.initial_state_map(
            problem,
            factors[0] if len(factors) == 1 else factors,
            sampler=sampler or ("grid" if grid is not None else "sobol"),
            coordinates=None if grid is None else _places(problem, grid),
            path=output,
            executor=executor,
            max_cycles=cycles,
            progress=update,
            **settings,
        )
    maps = found.maps if isinstance(found, shakedown.InitialStateMaps) else (found,)
    draw(picture, "basin" if found in maps else "shakedown_share", found)
    return Answer(
        found.to_dict,
        partial(map_sheet, problem, found),
        is_open=any(one.undecided or "undecided" in one.named.values() for one in maps),
    )


def _places(problem: Problem, grid: tuple[str, str]) -> Any:
    """Where the two slips of a grid stand among those of the joint."""
    d = problem.directions
    found = [re.fullmatch(GRID_SLIP.format("(:[xy])" if d > 1 else "()"), text) for text in grid]
    if not all(found):
        wanted = "two node numbers" if d == 1 else "NODE:x or NODE:y twice, as the joint has two directions"
        raise click.UsageError(f"--grid: expected {wanted}, found {shortened(' '.join(grid))}")
    return [d * int(each[1]) + (each[2] == ":y") for each in found if each is not None]
