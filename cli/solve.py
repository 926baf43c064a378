"""`shakedown-bounds solve`: both bounds, the safe slip and the status of the guarantee."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import click

import shakedown
from shakedown import Problem
from shakedown.ground.evidence import Missing
from shakedown.ground.shown_values import down, up
from shakedown.ground.visible_text import shortened, with_unit
from shakedown.joint.constraints import SIDE_NAMES
from shakedown.report.json_documents import assessment_document, quick_document
from shakedown.report.node_words import node_in_words
from shakedown.report.words.assessment_words import (
    certain_in_words,
    loads_of_numbers,
    numbers_in_words,
    quickly_in_words,
    said_as_given_in_words,
)
from shakedown.report.words.bound_words import bounds_in_words
from shakedown.report.words.friction_words import friction_in_words
from shakedown.report.words.hint_words import hints_in_words
from shakedown.report.words.limit_words import coupling_in_words, curve_in_words
from shakedown.report.words.sensitivity_words import sensitivities_in_words
from shakedown.report.words.zone_words import open_in_words, zone_in_words

from .initial import initial_state
from .options import json_option, open_option, problem_argument, quiet_option
from .output import bound, echo_json, headline, length_unit, listing, node_table, number, paragraph, say

CLAIMS = {
    "proved-from-state": "proved_from_this_state",
    "proved-from-every-state": "proved_from_every_state",
}  # what may be required, and the number it is about
CURVE_RADII = (0.25, 1.0, 4.0)  # in multiples of the largest safe slip
F_THRESHOLD = (
    "f threshold: the friction coefficient at which a node alone, all others stuck, loses uniqueness, "
    "A_jj/|B_jj|."
)
CURVE_UP_TO = 40  # nodes; beyond, each point takes seconds
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
    """A load factor > 0, None where a text is none."""
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
    "--require",
    "required",
    type=Requirement(),
    multiple=True,
    help="Exit with 1 unless shakedown is proved up to load factor X: proved-from-state=X or "
    "proved-from-every-state=X. May be given twice.",
)
@open_option
@json_option
@quiet_option
@click.pass_context
def solve(
    context: click.Context,
    problem: Problem,
    initial: str,
    distance: float,
    quick: bool,
    required: tuple[tuple[str, float], ...],
    open_nodes: tuple[int, ...] | Literal["auto"],
    as_json: bool,
) -> None:
    """Up to which load factor FILE shakes down: proved from every state, from this one, impossible above.

    Then what the load as given (λ = 1) comes to where these decide, and every limit with its evidence.
    """
    if initial in ("safe", "witness"):
        raise click.UsageError(f"--initial {initial}: expected zero, given, given:K or PATH.npy")
    if quick and required:
        raise click.UsageError("--require: not with --quick, which leaves out what is proved")
    state = initial_state(problem, 0.0, initial)
    if quick:
        upper = shakedown.upper_bound(problem, open_nodes=open_nodes, certify=False)
        energy = shakedown.energy_bound(problem, state, distance, open_nodes=upper.open_nodes)
        if as_json:
            echo_json(quick_document(problem, energy, upper))
        else:
            say(_quick_text(problem, energy, upper))
        _leave(context, upper, energy)
    if problem.n >= ANNOUNCED_FROM:
        click.echo(
            f"{problem.n} linear programs for λ_1: this may take a minute (--quick leaves them out).",
            err=True,
        )
    found = shakedown.assess(problem, state, distance=distance, open_nodes=open_nodes)
    limits = found.details
    curve = limits.curve(CURVE_RADII, limits.upper.slip) if problem.n <= CURVE_UP_TO else None
    if as_json:
        echo_json(assessment_document(found, curve))
    else:
        say(_text(found, curve))
    unmet = [text for claim, least in required if (text := _unmet(found, claim, least))]
    _leave(context, limits.lower, limits.upper, limits.energy, limits.universal, unmet=unmet)


def _unmet(found: shakedown.Assessment, claim: str, least: float) -> str:
    """How a requirement is missed; empty where it is met."""
    proved = getattr(found, CLAIMS[claim])
    if proved >= least:
        return ""
    known = "open" if proved != proved else f"up to λ = {down(proved)}"
    return f"--require {claim}={least:g}: not met, proved is {known}"


def _leave(
    context: click.Context,
    *results: shakedown.LowerBound | shakedown.UpperBound | shakedown.EnergyBound | shakedown.UniversalBound,
    unmet: Sequence[str] = (),
) -> None:
    """Exit code 1, and why, where something stays open."""
    from shakedown.verification.open_ends import open_ends  # loads what the results were made with

    left = [*open_ends(*results), *unmet]
    for sentence in left:
        click.echo(sentence, err=True)
    context.exit(1 if left else 0)


def _quick_text(problem: Problem, energy: shakedown.EnergyBound, upper: shakedown.UpperBound) -> str:
    """What one linear and one cone program tell."""
    lines = [headline(problem), ""]
    lines += [paragraph(sentence) for sentence in quickly_in_words(energy, upper, problem)]
    if upper.open_nodes:
        lines += [paragraph(sentence) for sentence in zone_in_words(upper, problem)]
    elif upper.status != "optimal":
        lines += [paragraph(f"{upper.status}: {upper.reason}.")]
    return "\n".join([*lines, "", node_table(problem, _safe_columns(problem, upper))])


def _text(found: shakedown.Assessment, curve: shakedown.GuaranteeCurve | Missing | None) -> str:
    limits, problem = found.details, found.problem
    numbers = [
        (name, value, f"{loads}; {remark}" if loads else remark)
        for (name, value, remark), loads in zip(numbers_in_words(found), loads_of_numbers(found), strict=True)
    ]
    lines = [headline(problem), "", listing(numbers), ""]
    lines += [paragraph(said_as_given_in_words(found)), ""]
    lines += [paragraph(sentence) for sentence in certain_in_words(limits)]
    lines += [paragraph(hint) for hint in hints_in_words(problem)]
    if problem.initial_slip is not None and not limits.energy.initial_slip.any():
        lines += [paragraph("The file has initial slips: --initial given proves from the first of them.")]
    lines += ["", listing(_facts(found)), ""]
    lines += [paragraph(sentence) for sentence in bounds_in_words(limits)]
    lines += [paragraph(sentence) for sentence in sensitivities_in_words(limits)]
    if isinstance(curve, Missing):
        lines += [paragraph(f"The guarantee curve is missing: {curve.reason}.")]
    elif curve is not None:
        lines += [paragraph(curve_in_words(curve, problem))]
    lines += [paragraph(sentence) for sentence in friction_in_words(problem, limits.friction)]
    thresholds = [number(each, 5) for each in limits.friction.single_node]
    safe, active = _safe_columns(problem, limits.upper).items()
    slips = [number(slip) for slip in limits.lower.slip]
    witness = with_unit("witness", length_unit(problem)), slips
    columns = dict([safe, witness, active, ("f threshold", thresholds)])
    return "\n".join([*lines, "", node_table(problem, columns), "", paragraph(F_THRESHOLD)])


def _safe_columns(problem: Problem, upper: shakedown.UpperBound) -> dict[str, list[str]]:
    """The safe slip of every node, and its limits that are reached at λ_max."""
    heading = with_unit("safe slip", length_unit(problem))
    sides = [_sides(upper, node) for node in range(problem.n)]
    return {heading: [number(slip) for slip in upper.slip], "active at λ_max": sides}


def _facts(found: shakedown.Assessment) -> list[tuple[str, str, str]]:
    """(name, value, remark) of every number that stands for the whole joint."""
    limits = found.details
    lower, upper = limits.lower, limits.upper
    energy, universal, box = limits.energy, limits.universal, limits.box
    exactly = energy.certified
    certified = "" if exactly is None else f", certified to {1 - exactly / energy.load_factor:.0e}"
    least = upper.least_load_factor
    collapse = "no node collapses"
    if lower.node >= 0:
        labelled = lower.problem.label is not None
        collapse = node_in_words(lower.problem, lower.node) if labelled else f"collapse of node {lower.node}"
    return [
        ("from this state λ_E", bound(energy.load_factor), f"{energy.status}{certified}"),
        ("from this state, box", bound(box.load_factor), box.limited_by or box.status),
        ("from every state λ_U", bound(universal.load_factor), universal.argument),
        ("lower bound λ_1", bound(lower.load_factor), f"{collapse}{_certified(lower.certified)}"),
        ("  guarantee", lower.guarantee, ""),
        ("  single-node bound", bound(lower.single_node_bound, 7), "no node cycles alone below"),
        (
            "  coupling ratio ρ*",
            number(lower.coupling_ratio, 4),
            coupling_in_words(lower.coupling_ratio).partition(":")[0],
        ),
        ("least load factor λ_lo", _from_here_on(least), "safe slips exist from here on"),
        _largest(upper),
    ]


def _largest(upper: shakedown.UpperBound) -> tuple[str, str, str]:
    """λ_max, with the nodes that are open where it is that of a zone."""
    remark = f"{upper.status}{_certified(upper.certified)}"
    if upper.open_nodes:
        remark += f", with {open_in_words(upper.open_nodes)} open"
    name = "λ_max of the zone" if upper.open_nodes else "upper bound λ_max"
    return (name, bound(upper.load_factor, rounded=down if upper.open_nodes else up), remark)


def _from_here_on(least: float) -> str:
    """λ_lo where there is one, rounded up."""
    return bound(least, rounded=up) if least else "-"


def _certified(interval: tuple[float, float] | None) -> str:
    """How close an exact enclosure is, where there is one."""
    if interval is None:
        return ""
    low, high = interval
    size = max(abs(low), abs(high))
    if size in (0.0, float("inf")):
        return ", certified"
    return f", exact to {max(high - low, 0.0) / size:.0e}"


def _sides(upper: shakedown.UpperBound, node: int) -> str:
    """Which limits of a node are reached at λ_max."""
    return "+".join(SIDE_NAMES[side] for at, side in upper.active if at == node) or "-"
