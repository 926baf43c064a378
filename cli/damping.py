"""`shakedown-bounds damping`: dissipation and stiffness over the amplitude of a load."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import shakedown
from shakedown import Outcome, Problem
from shakedown.report.study_facts import damping_sheet

from . import options
from .command import Answer, command, document, draw, progress
from .options import option


@command(
    "Damping and stiffness over the amplitude of a load.",
    "0 a long-term state was found at every amplitude, whichever; 1 undecided somewhere; "
    "2 bad usage or bad input.",
)
@options.problem
@option(
    "--amplitudes",
    type=options.NUMBERS,
    required=True,
    help="LOW:HIGH:COUNT or VALUE,VALUE,…: factors on the history of the load, rising.",
)
@option("--load", default="0", metavar="NAME", help="Which load, by name or number.")
@option(
    "--initial",
    metavar="STATE",
    help="zero, given, given:K or PATH.npy. Default: given where the file has initial_slip, else zero.",
)
@option(
    "--open",
    "open_nodes",
    type=options.OPEN_NODES,
    default="auto",
    help="Nodes open at the start: none or numbers like 0,3,7; auto: none; proofs: the best zone.",
)
@option("--from-zero", is_flag=True, help="Every amplitude from that state too; say where it differs.")
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

    FILE has to know its loads (load_reactions, load_history; for displacements
    load_compliance), as import writes them. Each amplitude begins where the one before it ended.
    """
    start = options.initial_state(problem, options.word_for(problem, initial))
    with progress("amplitudes") as update:
        curve = shakedown.damping(problem, initial_slip=start, max_cycles=cycles, progress=update, **settings)
    if output is not None:
        curve.save(output)
    draw(picture, "damping_curve", curve)
    undecided = Outcome.UNDECIDED in curve.outcome
    return Answer(partial(document, problem, curve), partial(damping_sheet, problem, curve), undecided)
