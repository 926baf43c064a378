"""`shakedown-bounds map`, `sweep`, `refine`, `damping`: many states, designs, meshes, amplitudes."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path
from typing import Any

import click

import shakedown
from shakedown import Outcome, Problem
from shakedown.files.pieces import cluster_executor
from shakedown.ground.constants import FloatArray
from shakedown.ground.shown_values import shortened
from shakedown.report.study_facts import SAMPLED, damping_sheet, map_sheet, refinement_sheet, sweep_sheet

from . import options
from .command import Answer, command, document, draw, progress
from .options import option


@command(
    "Long-term states from many initial states.",
    "0 computed; 1 states are undecided; 2 bad usage or bad input.",
)
@options.problem
@option("--load-factor", type=float, required=True, help="Load factor λ ≥ 0.")
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
@option("-o", "--output", type=options.output_file(), help="Write all states here (NPZ).")
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
    load_factor: float,
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
    with progress("pieces") as update, cluster_executor(scheduler) as executor:
        found = shakedown.initial_state_map(
            problem,
            load_factor,
            sampler=sampler or ("grid" if grid is not None else "sobol"),
            coordinates=None if grid is None else _places(problem, grid),
            path=output,
            executor=executor,
            max_cycles=cycles,
            progress=update,
            **settings,
        )
    draw(picture, "basin", found)
    return Answer(
        found.to_dict,
        partial(map_sheet, problem, found),
        is_open=bool(found.undecided or "undecided" in found.named.values()),
    )


def _places(problem: Problem, grid: tuple[str, str]) -> Any:
    """Where the two slips of a grid stand among those of the joint."""
    d = problem.directions
    found = [re.fullmatch("([0-9]{1,9})" + ("(:[xy])" if d > 1 else "()"), text) for text in grid]
    if not all(found):
        wanted = "two node numbers" if d == 1 else "NODE:x or NODE:y twice, as the joint has two directions"
        raise click.UsageError(f"--grid: expected {wanted}, found {shortened(' '.join(grid))}")
    return [d * int(each[1]) + (each[2] == ":y") for each in found if each is not None]


def varied(text: str) -> tuple[str, FloatArray] | None:
    """A parameter with its values."""
    name, _, numbers = text.partition("=")
    values = options.numbers_of(numbers)
    return (name.strip(), values) if name.strip() and values is not None else None


@command(
    "The limits over one or two parameters.",
    "0 computed; 1 limits contradict each other; 2 bad usage or bad input.",
)
@click.argument("joint", metavar="FILE", type=options.problem_file(imports=True))
@option(
    "--vary",
    type=options.parsed(
        "parameter", f"NAME= and {options.FORM}, rising, at most {options.MOST_VALUES:,}", varied
    ),
    multiple=True,
    required=True,
    help="NAME=LOW:HIGH:COUNT or NAME=VALUE,VALUE,…; NAME is f, friction, amplitude, mean or "
    "phase, or a key of CONFIG.toml. May be given twice.",
)
@option(
    "--bounds",
    metavar="NAMES",
    help=f"Limits to compute: some of {','.join(shakedown.BOUNDS)}.  [default: all that the joint has but "
    "creep]",
)
@option("--load-factor", type=click.FloatRange(min=0.0), default=1.0, help="The λ that is spoken about.")
@options.initial
@options.open_nodes
@option("--quick", is_flag=True, help="λ_T to 0.1 %.")
@options.slip_below
@options.table
@options.picture
@options.workers
@options.scheduler
@options.pieces
def sweep(
    joint: Problem | shakedown.Import,
    vary: tuple[tuple[str, FloatArray], ...],
    bounds: str | None,
    load_factor: float,
    initial: str,
    output: Path | None,
    picture: Path | None,
    scheduler: str | None,
    **settings: Any,
) -> Answer:
    """How the limits on the load factor of FILE move with its parameters.

    f is the friction coefficient; friction, amplitude and mean are factors on what the file
    has; phase, in periods, moves the tangential loads along
    against the normal ones. What is proved is proved at the values given, not between them.
    FILE may also be the CONFIG.toml of an import: then its numbers are parameters too, by
    keys like contact.gap or load.2.history.harmonics.1.sin (tables and entries of lists are
    counted from 1), and the factor on the friction is friction.factor.
    """
    if len({name for name, _ in vary}) < len(vary):
        raise click.UsageError(f"--vary: expected each parameter once, found {vary[0][0]} twice")
    options.pieces_of(output, settings["resume"])
    problem = joint if isinstance(joint, Problem) else joint.problem
    with progress("points") as update, cluster_executor(scheduler) as executor:
        found = shakedown.sweep(
            joint,
            dict(vary),
            bounds=bounds and bounds.split(","),
            initial_slip=options.initial_state(problem, initial),
            executor=executor,
            output=output,
            progress=update,
            **settings,
        )
    if not any(point["exists"] for point in found.points):
        raise click.UsageError(f"--vary: no value makes a joint: {found.points[0]['reason']}")
    draw(picture, "regions", found, load_factor=load_factor)
    sheet = partial(sweep_sheet, problem, found, load_factor)
    return Answer(partial(document, problem, found), sheet, bool(found.contradictions))


@command("Which numbers converge with the mesh.", "0 computed; 2 bad usage or bad input.")
@click.argument("problems", metavar="FILE FILE …", type=options.problem_file(), nargs=-1, required=True)
@options.average
@options.load_factor
@options.slip_below
@options.table
@options.picture
@options.workers
@options.pieces
def refine(
    problems: tuple[Problem, ...],
    average: float | None,
    output: Path | None,
    picture: Path | None,
    **settings: Any,
) -> Answer:
    """Which numbers of one joint converge, from files of it on finer and finer meshes.

    The three numbers of `solve`, λ_max of slips averaged over a length (--average), friction
    work and the largest slip at one load factor, starting without slip; in the plane, where friction
    alone holds the joint, also when it creeps. The coarsest mesh comes first; three tell.
    """
    if len(problems) < 2:
        raise click.UsageError("FILE FILE …: expected several meshes of one joint, found one file")
    options.pieces_of(output, settings["resume"])
    meshes = {problem.n: problem for problem in problems}
    sizes = [problem.n for problem in problems]
    with progress("meshes") as update:
        found = shakedown.refine(meshes, sizes, radius=average, output=output, progress=update, **settings)
    draw(picture, "refinement", found)
    finest = problems[-1]
    return Answer(partial(document, finest, found), partial(refinement_sheet, finest, found))


@command(
    "Damping and stiffness versus the amplitude of a load.",
    "0 a long-term state was found at every amplitude, whichever; 1 undecided or slides away somewhere; "
    "2 bad usage or bad input.",
)
@options.problem
@option(
    "--amplitudes",
    type=options.NUMBERS,
    required=True,
    help="LOW:HIGH:COUNT or VALUE,VALUE,…: factors on the history of the load, rising.",
)
@option("--load", metavar="NAME", help="Which load, by name or number. Default: the first that varies.")
@option(
    "--initial",
    metavar="STATE",
    help="zero, given, given:K or PATH.npy. Default: given where the file has initial_slip, else zero.",
)
@options.open_nodes
@option(
    "--states",
    type=click.IntRange(min=1),
    help="Also from so many slips that random loads leave: the least and largest damping.",
)
@options.seed
@options.workers
@options.cycles
@options.table
@options.picture
def damping(
    problem: Problem,
    initial: str | None,
    cycles: int,
    output: Path | None,
    picture: Path | None,
    **settings: Any,
) -> Answer:
    """Follow FILE at rising amplitudes of one load to its long-term states.

    FILE has to know its loads (load_reactions, load_history; for stiffness and loss factor also
    load_compliance), as import and shakedown.fem write them. Each amplitude begins where the one
    before it ended; other loads stay as they are at λ = 1.
    """
    start = options.initial_state(problem, options.word_for(problem, initial))
    with progress("amplitudes") as update:
        curve = shakedown.damping(problem, initial_slip=start, max_cycles=cycles, progress=update, **settings)
    if output is not None:
        curve.save(output)
    draw(picture, "damping_curve", curve)
    undecided = Outcome.UNDECIDED in curve.outcome
    return Answer(partial(document, problem, curve), partial(damping_sheet, problem, curve), undecided)
