"""`shakedown-bounds adversary`: the smallest load factor at which a cycle is found."""

from __future__ import annotations

from pathlib import Path

import click

import shakedown
from shakedown import Problem
from shakedown.report.design_words import cycle_in_words

from .options import OutputFile, json_option, problem_argument, quiet_option, refuse_overwriting_input
from .output import echo_json, headline, listing, number, paragraph, progress, say, table


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
@json_option
@quiet_option
@click.pass_context
def adversary(
    context: click.Context,
    problem: Problem,
    states: int,
    rounds: int,
    seed: int,
    largest: float | None,
    output: Path | None,
    as_json: bool,
) -> None:
    """Search the initial states of FILE for the smallest load factor with a cycle.

    Beside λ_U, below which shakedown from every state is proved, it encloses the true
    limit of the joint. Exit code 1 where no cycle is found, and where one contradicts
    what is proved.
    """
    refuse_overwriting_input(context, output)
    with progress("rounds") as update:
        found = shakedown.smallest_cycle(
            problem, states=states, rounds=rounds, seed=seed, largest=largest, progress=update
        )
    if output is not None and found.state is not None:
        shakedown.save_initial_slip(output, found.initial_slip)
    if as_json:
        echo_json({"problem": problem.to_dict()} | found.to_dict())
    else:
        say(_text(problem, found))
        if output is not None and found.state is not None:
            say(f"\nwrote {output}: simulate FILE --load-factor {found.load_factor!r} --initial {output}")
    if found.status != "found":
        context.exit(1)


def _text(problem: Problem, found: shakedown.SmallestCycle) -> str:
    lines = [headline(problem), "", *(paragraph(sentence) for sentence in cycle_in_words(found)), ""]
    if problem.q_transient is not None:
        lines[-1:] = [
            paragraph("The transient load steps of the file were left out: a cycle knows of none."),
            "",
        ]
    lower, upper = found.lower, found.upper
    facts = [
        ("from every state λ_U", number(found.universal.load_factor, 10), found.universal.argument),
        ("first collapse λ_1", number(lower.load_factor, 10), f"guarantee: {lower.guarantee}"),
        ("smallest cycle λ_cycle", number(found.load_factor, 10), _period(found)),
        ("upper bound λ_max", number(upper.load_factor, 10), str(upper.status)),
        ("dissipation per cycle", number(found.dissipation_per_cycle), ""),
        ("simulations", str(found.tries), f"seed {found.seed}"),
    ]
    lines += [listing(facts)]
    if found.state is not None:
        slips = zip(found.initial_slip, found.slip_per_cycle, strict=True)
        rows = [[str(j), number(slip), number(per_cycle)] for j, (slip, per_cycle) in enumerate(slips)]
        lines += ["", table(["node", "initial slip", "slip per period"], rows)]
    return "\n".join(lines)


def _period(found: shakedown.SmallestCycle) -> str:
    return f"{found.outcome}, period {found.period}" if found.state is not None else "none found"
