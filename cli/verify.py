"""`shakedown-bounds verify`: the bounds against time integration, with a report."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import click

import shakedown
from shakedown import Problem
from shakedown.ground.visible_text import with_unit
from shakedown.joint.units import units_of
from shakedown.report.assessment_words import certain_in_words
from shakedown.report.bound_words import bounds_in_words
from shakedown.report.friction_words import friction_in_words
from shakedown.report.hint_words import last_digit_in_words, relative_in_words
from shakedown.report.json_documents import verification_document
from shakedown.report.limit_words import transient_beside_in_words
from shakedown.report.mesh_words import averaged_in_words, mesh_warning_in_words
from shakedown.report.node_words import slip_limit_in_words
from shakedown.report.run_words import SEPARATION, as_given_in_words
from shakedown.report.text_table import table

from .claims import NODE_FILES, OutputFile, reads, writes
from .options import (
    average_option,
    cycles_option,
    method_option,
    open_option,
    output_options,
    problem_argument,
    slip_below_option,
)
from .output import (
    echo_json,
    headline,
    paragraph,
    progress,
    say,
)

MORE = "--details: every limit, and a table of the runs."
HEAD = ["λ", "initial", "predicted", "simulated", "agree", "Σ|Δv|", "residual"]  # shorter than on the page
SUMMED = "slip per period of the node that slips most, to and fro added up."


@click.command(
    short_help="Prediction against time integration; report.",
    epilog="Exit codes: 0 prediction and simulation agree in every run; 1 they disagree, or a run "
    "slides away or is left open; 2 bad usage or bad input.",
)
@problem_argument
@click.option("-o", "--output", type=OutputFile(), help="Write the report (HTML) here, JSON beside it.")
@click.option(
    "--load-factor", "load_factors", type=float, multiple=True, help="Simulate at this λ; may be repeated."
)
@click.option(
    "--random",
    "random_states",
    type=click.IntRange(min=0),
    default=None,
    show_default="3; above 50 node pairs in space 1",
    help="Number of initial states: what random loads leave behind.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Seed of the random loads.",
)
@open_option
@average_option
@click.option(
    "--refinement",
    type=click.Path(),
    metavar="TABLE",
    help="What `refine … -o TABLE.csv` wrote, FILE among its meshes: a section of the report.",
)
@cycles_option
@method_option
@slip_below_option
@click.option(
    "--nodes",
    type=OutputFile(NODE_FILES),
    help="Write what every node goes through at λ = 1 here (.csv, .vtu or .vtp).",
)
@click.option("--details", is_flag=True, help="Also every limit, and a table of the runs.")
@output_options
@click.pass_context
def verify(
    context: click.Context,
    problem: Problem,
    output: Path | None,
    load_factors: tuple[float, ...],
    random_states: int | None,
    seed: int,
    open_nodes: tuple[int, ...] | Literal["auto"],
    average: float | None,
    refinement: str | None,
    cycles: int,
    method: str,
    slip_below: float | None,
    nodes: Path | None,
    details: bool,
    as_json: bool,
) -> None:
    """Hold the bounds of FILE against time integration from several states."""
    beside = _beside(context, problem, average, refinement)
    if output is not None:
        from shakedown.report.html import report_path  # what draws is wanted only here

        report_path(output)  # before the work, not after
        writes(context, "the JSON beside -o", output.with_suffix(".json"))
    with progress("verification", rest=int(output is not None)) as update:
        result = shakedown.verify(
            problem,
            open_nodes=open_nodes,
            load_factors=load_factors or None,
            random_states=random_states,
            seed=seed,
            cycles=cycles,
            method=method,
            slip_below=slip_below,
            progress=update,
        )
        if output is not None:
            from shakedown.report.html import write_report

            write_report(output, result, **beside)
    if nodes is not None:
        result.nodes.save(nodes)
    if as_json:
        echo_json(verification_document(result, **beside))
    else:
        say(_text(problem, result, details))
        if average is not None:
            say("\n" + paragraph(averaged_in_words(result.assessment.averaged(average), average)))
        if output is not None:
            say(f"\nreport: {output}, {output.with_suffix('.json')}")
    if not result.agrees:
        context.exit(1)


def _beside(
    context: click.Context, problem: Problem, average: float | None, path: str | None
) -> dict[str, Any]:
    """What else is reported; it is refused before the work if it belongs to another joint."""
    if average is not None:
        shakedown.averaged(problem, average)
    found = None
    if path is not None:
        from shakedown.report.html import check_refinement
        from shakedown.studies.refined import Refinement

        reads(context, "--refinement", path)
        found = Refinement.load(path)
        check_refinement(found, problem)
    return {"average": average, "refinement": found}


def _text(problem: Problem, result: shakedown.Verification, details: bool) -> str:
    from shakedown.report.answer_words import (  # loads compiled code
        answer_in_words,
        margin_of_answer,
        verdict_in_words,
    )

    answer = [answer_in_words(result), margin_of_answer(result)]
    mesh = mesh_warning_in_words(result.assessment)
    lines = [headline(problem), "", paragraph(" ".join(filter(None, answer)))]
    lines += [paragraph(mesh), ""] if mesh else [""]
    findings = [*result.disagreements, *result.open_questions]
    if findings:
        lines += [paragraph(verdict_in_words(result))]
        lines += [paragraph(f"- {finding}", "  ") for finding in findings]
        lines += [""]
    sentences = [*last_digit_in_words(problem), *transient_beside_in_words(result)]
    if result.slip_limit is not None:
        sentences.append(slip_limit_in_words(result.slip_limit, problem))
    lines += [paragraph(sentence) for sentence in sentences]
    if not findings:
        lines += ["", paragraph(verdict_in_words(result))]
    more = _details(problem, result) if details else [MORE]
    return "\n".join([*lines, *more])


def _details(problem: Problem, result: shakedown.Verification) -> list[str]:
    """What is certain, every limit and every run."""
    from shakedown.report.page_tables import runs_table  # loads compiled code

    limits, length = result.limits, units_of(problem).length
    lines = ["", paragraph(as_given_in_words(result.as_given, length, problem, limits.universal))]
    lines += [paragraph(sentence) for sentence in certain_in_words(limits)]
    if relative := relative_in_words(problem, limits.open_nodes):
        lines += [paragraph(relative)]
    lines += [paragraph(f"Note: {note}.") for note in result.notes]
    lines += [paragraph(sentence) for sentence in bounds_in_words(limits)]
    lines += [paragraph(sentence) for sentence in friction_in_words(problem, limits.friction)]
    lines += ["", table(HEAD, runs_table(result, brief=True).rows)]
    lines += ["", paragraph(f"{with_unit('Σ|Δv|', units_of(problem).length)}: {SUMMED}")]
    if any(run.case.after_transient for run in result.runs):
        lines += ["", "(after): locked in when the transient load steps are over."]
    if any(run.simulation.outcome == shakedown.Outcome.SEPARATION for run in result.runs):
        lines += ["", paragraph(SEPARATION)]
    return lines
