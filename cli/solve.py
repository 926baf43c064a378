"""`shakedown-bounds solve`: both bounds, the safe slip and the status of the guarantee."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import click

import shakedown
from shakedown import Problem
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.errors import Missing
from shakedown.ground.shown_values import down, plain
from shakedown.ground.visible_text import shortened
from shakedown.report.json_documents import assessment_document, averaged_document, quick_document
from shakedown.report.limit_facts import averaged_section, quick_sheet, solve_sheet

from .initial import AT_NONE, initial_state, refuse_at_load_factor
from .options import NAMED, average_option, digits_option, open_option, output_options, problem_argument
from .output import echo_json, is_quiet, show

CLAIMS = {
    "proved-from-state": "proved_from_this_state",
    "proved-from-every-state": "proved_from_every_state",
}  # what may be required, and the number it is about
ANNOUNCED_FROM = 250  # nodes; from here on the lower bound may take a minute


class Requirement(click.ParamType):
    """What has to be proved, and up to which load factor: CLAIM=X."""

    name = "claim"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        claim, _, text = value.partition("=")
        number = load_factor_of(text)
        if claim not in CLAIMS or number is None:
            expected = "=X or ".join(CLAIMS)
            raise click.UsageError(
                f"--require: expected {expected}=X with X > 0, found '{shortened(value, 60)}'"
            )
        return claim, number


def load_factor_of(text: str) -> float | None:
    """The load factor > 0 that a text stands for; None where it is not one."""
    try:
        number = float(text)
    except ValueError:
        return None
    return number if 0.0 < number < float("inf") else None


@click.command(
    short_help="What is proved, bounds, safe slip.",
    epilog="Exit codes: 0 computed, whatever the bounds are; 1 an answer is open, or disputed in exact "
    "arithmetic, or what is required is not proved; 2 bad usage or bad input.",
)
@problem_argument
@click.option(
    "--initial",
    metavar="STATE",
    default="zero",
    show_default=True,
    help="State for which shakedown is to be proved: zero, given, given:K or PATH.npy.",
)
@click.option(
    "--distance",
    type=float,
    default=0.0,
    show_default=True,
    help="How far the state may be from it, in the energy norm.",
)
@click.option(
    "--quick",
    is_flag=True,
    help="Only what takes few programs: λ_E, λ_max and the safe slip (no λ_1, λ_U, thresholds).",
)
@click.option(
    "--details",
    is_flag=True,
    help="Also every limit with its evidence, and a table of the nodes.",
)
@click.option(
    "--follow",
    is_flag=True,
    help="Also what is proved once its cycles are followed (simulates: seconds, the first time more).",
)
@click.option(
    "--require",
    "required",
    type=Requirement(),
    multiple=True,
    help="\b\nproved-from-state=X or proved-from-every-state=X:\n"
    "exit with 1 unless shakedown is proved up to load\nfactor X. May be given twice; with --quiet nothing\n"
    "else is said.",
)
@open_option
@average_option
@digits_option
@output_options
@click.pass_context
@on_one_thread
def solve(
    context: click.Context,
    problem: Problem,
    initial: str,
    distance: float,
    quick: bool,
    details: bool,
    follow: bool,
    required: tuple[tuple[str, float], ...],
    open_nodes: tuple[int, ...] | Literal["auto"],
    average: float | None,
    digits: int,
    as_json: bool,
) -> None:
    """Up to which load factor FILE shakes down: proved from every state, from this one, impossible above.

    Then what becomes of the nominal load (λ = 1) where these decide, its margin, and what decides.
    """
    refuse_at_load_factor(initial)
    for option, given in (("average", average), ("require", required), ("follow", follow)):
        if quick and given:
            raise click.UsageError(f"--{option}: not with --quick, which proves and simulates less")
    state = initial_state(problem, 0.0, initial, expected=AT_NONE)
    if quick:
        upper = shakedown.upper_bound(problem, open_nodes=open_nodes, certify=False)
        energy = shakedown.energy_bound(problem, state, distance, open_nodes=upper.open_nodes)
        if as_json:
            echo_json(quick_document(problem, energy, upper))
        else:
            show(quick_sheet(problem, energy, upper, details=details, digits=digits))
        _leave(context, upper, energy)
    if problem.n >= ANNOUNCED_FROM and problem.directions == 1:
        click.echo(
            f"{problem.n} linear programs for λ_1: this may take a minute (--quick leaves them out).",
            err=True,
        )
    found = shakedown.assess(problem, state, distance=distance, open_nodes=open_nodes)
    limits = found.details
    between = None if average is None else (found.averaged(average), average)
    if as_json:
        asked = {"required": [_asked(found, *each) for each in required]} if required else {}
        asked |= averaged_document(*between) if between else {}
        echo_json(assessment_document(found, follow=follow) | asked)
    elif not (required and is_quiet()):  # then the line on what is not met, and the exit code, are the answer
        sheet = solve_sheet(found, context.meta[NAMED], details=details, follow=follow, digits=digits)
        show(sheet, *([averaged_section(*between, digits)] if between else []))
    unmet = [text for claim, least in required if (text := _unmet(found, claim, least))]
    _leave(context, limits.lower, limits.upper, limits.energy, limits.universal, unmet=unmet)


def _asked(found: shakedown.Assessment, claim: str, least: float) -> dict[str, Any]:
    """A requirement for JSON: what was to be proved, up to where it is proved, and whether that suffices."""
    proved = getattr(found, CLAIMS[claim])
    return {"claim": claim, "load_factor": least, "proved": plain(proved), "met": bool(proved >= least)}


def _unmet(found: shakedown.Assessment, claim: str, least: float) -> str:
    """How a requirement is missed; empty where it is met."""
    proved = getattr(found, CLAIMS[claim])
    if proved >= least:
        return ""
    known = "open" if proved != proved else f"up to λ = {down(proved)}"
    return f"--require {claim}={least:g}: not met, proved is {known}"


def _leave(
    context: click.Context,
    *results: shakedown.Bound | Missing,
    unmet: Sequence[str] = (),
) -> None:
    """Exit code 1, and why, where something stays open."""
    from shakedown.assessment.three_numbers import open_ends  # loads what the results were made with

    left = [*open_ends(*results), *unmet]
    for sentence in left:
        click.echo(sentence, err=True)
    context.exit(1 if left else 0)
