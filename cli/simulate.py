"""`shakedown-bounds simulate`: evolution from one initial state, and the long-term state."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import click

import shakedown
from shakedown import Problem
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.shown_values import few
from shakedown.ground.visible_text import shortened, with_unit
from shakedown.joint.units import units_of
from shakedown.report.hint_words import simulated_path_in_words
from shakedown.report.node_words import by_direction, open_in_words, resolution, without_round_off
from shakedown.report.run_words import SEPARATION, margin_at_rest, separated_in_words, sliding_in_words

from .claims import OutputFile, TableFile
from .initial import start_of
from .options import (
    method_option,
    output_options,
    run_options,
    slip_below_option,
)
from .output import (
    echo_json,
    headline,
    listing,
    load_factor_in_words,
    node_table,
    number,
    paragraph,
    say,
    slip_facts,
    tiny,
)

DIGITS_IN_SPACE = 5  # so that the numbers of two directions fit a line
IN_SPACE = "x, y: the two tangential directions of a node; Σ|Δv|: its slip per period, added up"


@click.command(
    short_help="Evolution from one initial state.",
    epilog="Exit codes: 0 a long-term state was found, whichever; 1 undecided after --cycles; "
    "2 bad usage or bad input.",
)
@run_options
@method_option
@slip_below_option
@click.option("-o", "--output", type=OutputFile(), help="Write the path here (NPZ): events or load steps.")
@click.option(
    "--loop", type=TableFile(), help="Write the loops of the loads here (.csv): load and displacement."
)
@output_options
@click.pass_context
@on_one_thread
def simulate(
    context: click.Context,
    problem: Problem,
    load_factor: float,
    initial: str | None,
    open_nodes: tuple[int, ...] | Literal["auto"],
    cycles: int,
    method: str,
    slip_below: float | None,
    output: Path | None,
    loop: Path | None,
    as_json: bool,
) -> None:
    """Follow FILE at one load factor from one initial state to its long-term state."""
    word, opened, start = start_of(problem, load_factor, initial, open_nodes)
    run = shakedown.simulate(
        problem,
        load_factor,
        start,
        open_nodes=opened,
        cycles=cycles,
        method=method,
        record=output is not None,
        slip_below=slip_below,
    )
    if output is not None:
        shakedown.save_history(output, run)
    if loop is not None:
        _write_loops(problem, run, loop)
    if as_json:
        echo_json({"problem": problem.to_dict()} | run.to_dict())
    else:
        say(_text(problem, run, word))
    if run.outcome == shakedown.Outcome.UNDECIDED:
        context.exit(1)


def _write_loops(problem: Problem, run: shakedown.Simulation, path: Path) -> None:
    """The loops of the loads over one period of the long-term state of a run."""
    from shakedown.long_term.conjugate_displacement import load_loops  # it loads compiled code

    if run.long_term is None or not run.long_term.period:
        raise click.UsageError(
            f"--loop: expected a period from event to event, found none ({run.method}, {run.outcome})"
        )
    load_loops(problem, run.long_term).save(path, problem)


def _jump_facts(run: shakedown.Simulation, work: str) -> list[tuple[str, str, str]]:
    """Jumps of the long-term state, where it has any."""
    if not run.jumps_per_cycle > 0:
        return []
    return [
        ("  by friction", number(run.friction_dissipation_per_cycle), work),
        ("  by damping in jumps", number(run.jump_dissipation_per_cycle), work),
        ("jumps per cycle", number(run.jumps_per_cycle), ""),
    ]


def _proof_facts(run: shakedown.Simulation) -> list[tuple[str, str, str]]:
    """What is proved of a shakedown, and which nodes stay open."""
    facts = []
    if run.open_nodes:
        facts.append(("open throughout", str(len(run.open_nodes)), open_in_words(tuple(run.open_nodes))))
    if run.outcome == shakedown.Outcome.SHAKEDOWN:
        facts.append(("shakedown proved", "yes" if run.proved else "no", ""))
    return facts


def _text(problem: Problem, run: shakedown.Simulation, initial: str) -> str:
    work, length = units_of(problem).work, units_of(problem).length
    from shakedown.bounds.named_start import moved_by_transient

    none_of_slip, none_of_work = resolution(problem, run.load_factor)
    (dissipation,) = without_round_off([run.dissipation_per_cycle], none_of_work.max())
    lines = [headline(problem), "", *[separated_in_words(problem)] * run.separated]
    factor = load_factor_in_words(problem, run.load_factor)
    lines.append(paragraph(f"{factor}, initial state {shortened(initial)}: {run.outcome}"))
    reason = sliding_in_words(run) if run.slides_away else run.reason
    lines.append(paragraph(f"({reason}).", "  "))
    if run.slides_away:
        lines.append(paragraph("The joint does not hold."))
    if run.outcome == shakedown.Outcome.SEPARATION and run.period:
        lines.append(paragraph(SEPARATION))
    lines += [paragraph(sentence) for sentence in simulated_path_in_words(problem)]
    if initial == "safe" and not run.open_nodes and moved_by_transient(problem, run.load_factor):
        lines.append(paragraph("The transient load steps move every slip that is safe in the loop."))
    if run.proved and not run.separated:
        lines.append(paragraph(f"Shakedown is proved. {margin_at_rest(run, length, problem)}."))
    lines.append("")
    facts = [
        ("cycles simulated", str(run.cycles_simulated), ""),
        ("period", str(run.period) if run.period else "-", "cycles" if run.period > 1 else "cycle"),
        ("dissipation per cycle", number(dissipation), work),
        *_jump_facts(run, work),
        *_proof_facts(run),
        *slip_facts(run.slip_criterion, length),
        ("friction law residual", tiny(run.residual), "relative"),
        ("method", run.method, f"{run.events} events" if run.events is not None else ""),
    ]
    facts += [
        (f"jump at {few(jump.cycle)} cycles", number(jump.energy_released), f"{work} released".strip())
        for jump in run.jumps
    ]
    lines.append(listing(facts))
    lines.append("")
    lines += _node_lines(problem, run, without_round_off(run.slip_per_cycle, none_of_slip))
    return "\n".join(lines)


def _node_lines(problem: Problem, run: shakedown.Simulation, per_period: list[float]) -> list[str]:
    """The table of the nodes; with two directions it is narrower, and its unit stands below it."""
    plane, length = problem.directions == 1, units_of(problem).length
    columns = {
        **by_direction(problem, "initial slip" if plane else "initial", run.initial_slip),
        **by_direction(problem, "final slip" if plane else "final", run.final_slip),
        "slip per period" if plane else "Σ|Δv|": per_period,
    }
    if plane:
        shown = {with_unit(name, length): [number(x) for x in values] for name, values in columns.items()}
        return [node_table(problem, shown)]
    digits = {name: [number(x, DIGITS_IN_SPACE) for x in values] for name, values in columns.items()}
    return [node_table(problem, digits), "", paragraph(f"{IN_SPACE}{with_unit('', length)}.")]
