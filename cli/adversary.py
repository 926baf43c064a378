"""`shakedown-bounds adversary`: the smallest load factor at which a cycle is found."""

from __future__ import annotations

from math import isfinite
from pathlib import Path

import click

import shakedown
from shakedown import Problem
from shakedown.ground.shown_values import at_lambda, up
from shakedown.ground.status import Search, named
from shakedown.ground.visible_text import with_unit
from shakedown.joint.units import units_of
from shakedown.report.design_words import cycle_in_words
from shakedown.report.hint_words import simulated_path_in_words
from shakedown.report.node_words import by_direction

from .claims import OutputFile, record_of
from .options import output_options, problem_argument, resume_option
from .output import (
    bound,
    echo_json,
    headline,
    listing,
    node_table,
    number,
    paragraph,
    progress,
    say,
)


@click.command(short_help="The smallest load factor with a cycle.")
@problem_argument
@click.option(
    "--states", type=click.IntRange(min=1), default=64, show_default=True, help="Initial slips per round."
)
@click.option("--rounds", type=click.IntRange(min=1), default=10, show_default=True, help="Rounds.")
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the random slips."
)
@click.option("--largest", type=float, help="Begin at this load factor, by default a little above λ_max.")
@click.option(
    "-o", "--output", type=OutputFile(), help="Write the slip that cycles here (NPY), for simulate --initial."
)
@resume_option
@output_options
@click.pass_context
def adversary(
    context: click.Context,
    problem: Problem,
    states: int,
    rounds: int,
    seed: int,
    largest: float | None,
    output: Path | None,
    resume: bool,
    as_json: bool,
) -> None:
    """Search the initial states of FILE for the smallest load factor with a cycle.

    A cycle is slip in contact that never ceases. Separation is none: nodes open and close in
    every period, or contact is lost, without slip in contact; the smallest load factor at
    which it was met is given apart. The smaller of the two and λ_U, below which shakedown
    from every state is proved, enclose the true limit of the joint. Exit code 1 where no
    cycle is found, and where something contradicts what is proved.
    """
    record = record_of(context, output, resume)

    def save(found: shakedown.SmallestCycle) -> None:
        if output is not None and found.state is not None:
            shakedown.save_initial_slip(output, found.initial_slip)

    with progress("rounds") as update:
        found = shakedown.smallest_cycle(
            problem,
            states=states,
            rounds=rounds,
            seed=seed,
            largest=largest,
            partial=record,
            resume=resume,
            save=save,
            progress=update,
        )
    if as_json:
        echo_json({"problem": problem.to_dict()} | found.to_dict())
    else:
        say(_text(problem, found))
        if output is not None and found.state is not None:
            say(f"\nwrote {output}: simulate FILE --load-factor {found.load_factor!r} --initial {output}")
    if found.status != Search.FOUND:
        context.exit(1)


def _text(problem: Problem, found: shakedown.SmallestCycle) -> str:
    said = [*cycle_in_words(found, problem), *simulated_path_in_words(problem)]
    if problem.q_transient is not None:
        said += ["The transient load steps of the file were left out: a cycle knows of none."]
    lines = [headline(problem), "", *map(paragraph, said), ""]
    limits = found.limits
    lower, upper, universal = limits.lower, limits.upper, limits.universal
    first = []
    if lower:
        first = [(named("λ_1"), bound(lower.load_factor), f"guarantee: {lower.guarantee}")]
    facts = [
        (named("λ_U"), bound(universal.load_factor), universal.argument),
        *first,
        ("λ_cycle, smallest cycle", up(found.load_factor), _period(found)),
        ("smallest separation", up(found.separation_load_factor), _separation(found)),
        (named("λ_max"), bound(upper.load_factor, rounded=up), str(upper.status)),
        ("dissipation per cycle", number(found.dissipation_per_cycle), units_of(problem).work),
        ("least that counts", number(found.least_dissipation, 2), "less is round-off: no cycle"),
        ("simulations", str(found.tries), f"up to {at_lambda(found.tried_up_to)}, seed {found.seed}"),
    ]
    lines += [listing(facts)]
    if found.state is not None:
        length = units_of(problem).length
        columns = {
            **by_direction(problem, "initial slip", found.initial_slip),
            "slip per period": found.slip_per_cycle.tolist(),
        }
        shown = {with_unit(name, length): [number(x) for x in slips] for name, slips in columns.items()}
        lines += ["", node_table(problem, shown)]
    return "\n".join(lines)


def _separation(found: shakedown.SmallestCycle) -> str:
    return "opens and closes, or contact lost" if isfinite(found.separation_load_factor) else "none met"


def _period(found: shakedown.SmallestCycle) -> str:
    return f"{found.outcome}, period {found.period}" if found.state is not None else "none found"
