"""`shakedown-bounds damping`: dissipation and stiffness over the amplitude of a load."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click
import numpy as np

import shakedown
from shakedown import Outcome, Problem
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import MANY
from shakedown.ground.visible_text import shortened
from shakedown.report.design_facts import damping_sheet

from .claims import PICTURES, OutputFile, TableFile
from .initial import start_of
from .options import (
    OpenNodes,
    cycles_option,
    output_options,
    problem_argument,
)
from .output import echo_json, progress, show

if TYPE_CHECKING:
    from shakedown.assessment.amplitude_curve import DampingCurve


class Amplitudes(click.ParamType):
    """Amplitudes that rise: LOW:HIGH:COUNT, evenly spaced, or values with commas between them."""

    name = "amplitudes"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        parts = value.split(":") if ":" in value else value.split(",")
        try:
            numbers = [float(part) for part in parts]
        except ValueError:
            numbers = []
        values = np.array(_evenly_spaced(numbers) if ":" in value else numbers)
        if not values.size or not np.isfinite(values).all():
            raise click.UsageError(
                f"--amplitudes: expected LOW:HIGH:COUNT or VALUE,VALUE,…, found '{shortened(value, 40)}'"
            )
        return values


def _evenly_spaced(numbers: list[float]) -> list[float]:
    """The amplitudes of LOW:HIGH:COUNT; an empty list where the numbers make no such range."""
    if len(numbers) != 3 or not (isfinite(numbers[1] - numbers[0]) and 2 <= numbers[2] <= MANY):
        return []
    low, high, count = numbers
    return np.linspace(low, high, int(count)).tolist() if count.is_integer() else []


@click.command(
    short_help="Damping and stiffness over the amplitude of a load.",
    epilog="Exit codes: 0 a long-term state was found at every amplitude, whichever; 1 undecided somewhere; "
    "2 bad usage or bad input.",
)
@problem_argument
@click.option(
    "--amplitudes",
    type=Amplitudes(),
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
    help="Nodes open at the start: none or numbers like 0,3,7; auto: none, and λ_E of the best zone.",
)
@click.option("--from-zero", is_flag=True, help="Every amplitude from that state too; say where it differs.")
@cycles_option
@click.option("-o", "--output", type=TableFile(), help="Write one row per amplitude (.csv or .parquet).")
@click.option("--picture", type=OutputFile(PICTURES), help="Draw the curve here (.png, .svg or .pdf).")
@output_options
@click.pass_context
def damping(
    context: click.Context,
    problem: Problem,
    amplitudes: FloatArray,
    load: str,
    initial: str | None,
    open_nodes: tuple[int, ...] | Literal["auto"],
    from_zero: bool,
    cycles: int,
    output: Path | None,
    picture: Path | None,
    as_json: bool,
) -> None:
    """Follow FILE at rising amplitudes of one load to its long-term states.

    FILE has to know its loads (load_reactions, load_history; for displacements
    load_compliance), as import writes them. Each amplitude begins where the one before it ended.
    """
    with progress("amplitudes") as update:
        curve = shakedown.damping(
            problem,
            amplitudes,
            load=load,
            initial_slip=_start(problem, initial),
            open_nodes=open_nodes,
            from_zero=from_zero,
            max_cycles=cycles,
            progress=update,
        )
    if output is not None:
        curve.save(output)
    if picture is not None:
        _draw(curve, picture)
    if as_json:
        echo_json({"problem": problem.to_dict()} | curve.to_dict())
    else:
        show(damping_sheet(problem, curve))
    if Outcome.UNDECIDED in curve.outcome:
        context.exit(1)


def _start(problem: Problem, initial: str | None) -> FloatArray:
    """The initial slip of the first amplitude; words for states at some load factor are refused."""
    if initial in ("safe", "witness"):
        raise click.UsageError(f"--initial {initial}: expected zero, given, given:K or PATH.npy")
    return start_of(problem, 0.0, initial, ())[2]


def _draw(curve: DampingCurve, path: Path) -> None:
    from shakedown import plot  # only where a picture is wanted

    plot.save(plot.damping_curve(curve), path)
