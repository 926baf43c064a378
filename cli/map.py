"""`shakedown-bounds map`: what becomes of a joint from many initial states."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

import shakedown
from shakedown import Problem
from shakedown.report.json_documents import plain
from shakedown.report.node_words import resolution, without_round_off

from .options import (
    OutputFile,
    cycles_option,
    json_option,
    problem_argument,
    quiet_option,
    refuse_overwriting_input,
)
from .output import (
    echo_json,
    headline,
    listing,
    number,
    paragraph,
    progress,
    say,
    table,
    with_unit,
    work_unit,
)
from .pictures import PictureFile

if TYPE_CHECKING:  # they load what computes
    from shakedown import InitialStateMap, InitialStateMaps, LimitCycle

SAMPLED = {  # after "of N states"
    "grid": "on a grid about {centre}",
    "sobol": "in a box about {centre}",
    "latin": "in a box about {centre}",
    "ball": "in a ball about the centre of the energy ball",
    "transients": "left behind by random load steps",
}
STABILITY = {  # where no multiplier is 1
    "stable": "stable",
    "unstable": "unstable",
    "unknown": "jumps",
}
MEANING = {
    "shakedown": "slip has ceased",
    "cyclic-slip": "nodes slip in every period and return",
    "ratchetting": "slips grow by the same amount in every period",
    "separation": "nodes open and close in every period; none slips in contact",
    "undecided": "none of these could be established",
}


class LoadFactors(click.ParamType):
    """A load factor, or several evenly spaced ones as FIRST:LAST:COUNT."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        try:
            if ":" not in value:
                return float(value)
            first, last, count = value.split(":")
            return np.linspace(float(first), float(last), int(count)).tolist()
        except ValueError:
            self.fail(f"expected a number or FIRST:LAST:COUNT like 0.5:1:11, found {value!r}", param, ctx)


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
    type=(int, int),
    metavar="I J",
    help="A grid in the slips of nodes I and J, all others at the safe slip.",
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
@click.option("-o", "--output", type=OutputFile(), help="Write all states here (NPZ).")
@click.option("--resume", is_flag=True, help="Go on with what a run that was stopped left in OUTPUT.partial.")
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    help="Number of processes; all cores by default, where it is worth while.",
)
@click.option("--scheduler", metavar="ADDRESS", help="Work on the dask cluster of this scheduler instead.")
@click.option("--picture", type=PictureFile(), help="Draw it here (PNG, PDF or SVG).")
@json_option
@quiet_option
@click.pass_context
def map_command(
    context: click.Context,
    problem: Problem,
    load_factor: float | list[float],
    states: int,
    grid: tuple[int, int] | None,
    sampler: str | None,
    reach: float,
    seed: int,
    cycles: int,
    output: Path | None,
    resume: bool,
    workers: int | None,
    scheduler: str | None,
    picture: Path | None,
    as_json: bool,
) -> None:
    """What becomes of FILE from many initial states: the share that shakes
    down, the dissipation of the others, their limit cycles.
    """
    for file in (output, picture):
        refuse_overwriting_input(context, file)
    if resume and output is None:
        raise click.UsageError("--resume: expected -o FILE, the map to go on with")
    with progress("pieces") as update:
        found = shakedown.initial_state_map(
            problem,
            load_factor,
            states=states,
            sampler=sampler or ("grid" if grid is not None else "sobol"),
            seed=seed,
            coordinates=grid,
            reach=reach,
            path=output,
            resume=resume,
            workers=workers,
            scheduler=scheduler,
            max_cycles=cycles,
            progress=update,
        )
    if picture is not None:
        _draw(found, picture)
    if as_json:
        echo_json(plain(found.to_dict()))
    else:
        say(_text(problem, found))
    maps = found.maps if isinstance(found, shakedown.InitialStateMaps) else (found,)
    if any(one.undecided for one in maps):
        context.exit(1)


def _draw(found: InitialStateMap | InitialStateMaps, picture: Path) -> None:
    from shakedown import plot  # matplotlib is wanted only here

    drawn = plot.basin(found) if isinstance(found, shakedown.InitialStateMap) else plot.shakedown_share(found)
    plot.save(drawn, picture)


def _text(problem: Problem, found: InitialStateMap | InitialStateMaps) -> str:
    lines = [headline(problem), ""]
    if isinstance(found, shakedown.InitialStateMap):
        return "\n".join([*lines, *_one(found)])
    lines.append(
        paragraph(f"{len(found.maps[0])} initial states {_where(found.maps[0])} at every load factor.")
    )
    heads = ["λ", "shake down", "95 % [%]", "separate", "undecided", "cycles", "dissipation ≤"]
    rows = [[*_row(one)] for one in found.maps]
    for one in found.missing:
        rows.insert(one.place, [number(one.load_factor), "no energy ball", *[""] * (len(heads) - 2)])
    lines += ["", table(*_without_idle(heads, rows, idle=("separate", "undecided")))]
    notes = [_why_undecided(one, f"λ = {one.load_factor:.7g}: ") for one in found.maps if one.undecided]
    reasons = dict.fromkeys(one.reason for one in found.missing)
    notes += [paragraph(f"No energy ball: {reason}.") for reason in reasons]
    return "\n".join([*lines, *([""] if notes else []), *notes])


def _row(one: InitialStateMap) -> list[str]:
    """One load factor in the table of several."""
    (most,) = without_round_off(one.dissipation_quartiles[-1:], _none(one)[1])
    known = one.undecided < len(one)
    return [
        number(one.load_factor),
        _percent(one.shakedown_fraction) if known else "-",
        _interval(one).removesuffix(" %") if known else "-",
        str(one.outcomes.get("separation", 0)),
        str(one.undecided),
        str(sum(cycle.outcome != "separation" for cycle in one.limit_cycles)),
        number(most, 5),
    ]


def _without_idle(
    heads: list[str], rows: list[list[str]], idle: tuple[str, ...]
) -> tuple[list[str], list[list[str]]]:
    """A table without those of some columns in which nothing but zeros stands."""
    kept = [k for k, head in enumerate(heads) if head not in idle or {row[k] for row in rows} - {"0", ""}]
    return [heads[k] for k in kept], [[row[k] for k in kept] for row in rows]


def _one(found: InitialStateMap) -> list[str]:
    """Everything about one load factor."""
    states, unit, none = len(found), work_unit(found.problem), _none(found)[1]
    begin = f"Load factor {found.load_factor:.10g}: of {states} initial states {_where(found)}"
    if found.undecided == states:
        return [paragraph(f"{begin}, none is decided."), "", _why_undecided(found)]
    interval = f" (95 %: {_interval(found)})" if _interval(found) != "-" else ""
    lines = [paragraph(f"{begin}, {_percent(found.shakedown_fraction)} shake down{interval}.")]
    if found.sampling.sampler == "grid":
        lines.append(paragraph("A grid is no random sample: it has no confidence interval."))
    lines += ["", _outcomes(found), ""]
    if found.undecided:
        lines += [_why_undecided(found), ""]
    quartiles = without_round_off(found.dissipation_quartiles, none)
    least, first, median, third, most = (number(value, 5) for value in quartiles)
    heading = with_unit("Dissipation per cycle", unit)
    over = "the decided states" if found.undecided else "all states"
    spread = f"from {least} to {most}; quartiles {first}, {median}, {third}"
    lines.append(paragraph(f"{heading} over {over}: {least if least == most else spread}."))
    for heading, separation in (("Limit cycles", False), ("Motions with separation", True)):
        cycles = [c for c in found.limit_cycles if (c.outcome == "separation") == separation]
        lines += ["", heading, _cycles(found, cycles)] if cycles else []
    if found.limit_cycles:
        lines.append(_legend(found))
    lines += ["", *(paragraph(sentence) for sentence in _uniqueness(found))]
    if found.problem.n == 2:
        kind = found.plane.region_type
        lines.append(paragraph(f"Regions of slip space: type ({kind}), {found.plane.region}."))
    return lines


def _outcomes(found: InitialStateMap) -> str:
    """How many states have which outcome, and what the words mean."""
    leave = int(np.count_nonzero((found.outcome == "separation") & (found.period == 0)))
    rows = []
    for word, count in found.outcomes.items():
        meaning = MEANING[word] + (f"; {leave}: the body leaves" if word == "separation" and leave else "")
        rows.append((word.replace("-", " "), str(count), meaning))
    return listing(rows)


def _why_undecided(found: InitialStateMap, begin: str = "") -> str:
    """Why states are undecided, and whether more cycles can help."""
    count, looked_at, reasons = found.undecided, found.looked_at_again, found.undecided_reasons
    who = "1 state is" if count == 1 else f"{count} states are"
    why = [
        one.reason
        + ("" if looked_at == one.count == count else f" ({_of(one.count, looked_at)} looked at again)")
        for one in reasons
    ]
    advice = "More --cycles may decide them." if any(one.more_cycles for one in reasons) else ""
    return paragraph(f"{begin}{who} undecided: {'; '.join(why)}. {advice}".rstrip())


def _of(count: int, states: int) -> str:
    return f"all {states}" if count == states else f"{count} of {states}"


def _uniqueness(found: InitialStateMap) -> list[str]:
    """Whether the outcome, and whether the state itself, is one and the same for all."""
    outcome = {
        True: "The outcome is the same for all states",
        False: "The outcome is not the same for all states",
        None: "The outcome is not known to be the same for all states",
    }[found.same_outcome]
    word = f": {next(iter(found.outcomes)).replace('-', ' ')}" if found.same_outcome else ""
    state = {True: "unique", False: "not unique", None: "not known to be unique"}[found.unique]
    return [f"{outcome}{word}.", f"The final state is {state}: {found.evidence}."]


def _cycles(found: InitialStateMap, cycles: list[LimitCycle]) -> str:
    still, none = _none(found)
    slip = any(cycle.slipping_nodes for cycle in cycles)
    rows = []
    for cycle in cycles[:20]:
        low, high = (number(value, 5) for value in without_round_off(cycle.dissipation, none))
        (spread,) = without_round_off([cycle.spread], still)
        largest = max((abs(value) for value in cycle.multipliers), default=0.0)
        row = [
            str(cycle.count),
            str(cycle.period),
            low if low == high else f"{low} … {high}",
            _nodes(cycle.slipping_nodes),
            "-" if cycle.stability == "unknown" else f"{largest:.4f}",
            number(spread, 2),
            _kind(cycle),
        ]
        rows.append(row if slip else row[:3] + row[4:])
    heads = ["states", "period", "dissipation", "slip at", "multiplier", "spread", ""]
    text = table(heads if slip else heads[:3] + heads[4:], rows)
    more = len(cycles) - len(rows)
    return text + (f"\n  … {more} more; --json has all" if more > 0 else "")


def _kind(cycle: LimitCycle) -> str:
    """What the multiplier allows, and what was seen."""
    if cycle.stability != "border":
        return STABILITY[cycle.stability]
    if cycle.count == 1:
        return "seen once"
    return "one and the same" if cycle.coincide else "a continuum"


def _legend(found: InitialStateMap) -> str:
    length = shakedown.units_of(found.problem)[1]
    return paragraph(
        "multiplier: factor per period by which a small disturbance shrinks; below 1 the motion is stable, "
        "at 1 a continuum of neighbouring ones is possible. spread: how far apart the slips lie that these "
        f"states end on{f' [{length}]' if length else ''}.",
        "  ",
    )


def _none(found: InitialStateMap) -> tuple[float, float]:
    """The slip and the work that count as none."""
    return resolution(found.problem, found.load_factor, found.search.tolerances)


def _where(found: InitialStateMap) -> str:
    centre = found.sampling.centre_is
    return SAMPLED[found.sampling.sampler].format(centre=("the " if "safe" in centre else "") + centre)


def _percent(share: float) -> str:
    return f"{100 * share:.1f}\u00a0%"  # no line ends between them


def _interval(found: InitialStateMap) -> str:
    low, high = found.interval
    return "-" if low != low else f"{100 * low:.1f}–{100 * high:.1f} %"


def _nodes(nodes: tuple[int, ...], most: int = 6) -> str:
    return ", ".join(map(str, nodes[:most])) + (", …" if len(nodes) > most else "") or "-"
