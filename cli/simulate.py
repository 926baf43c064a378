"""`shakedown-bounds simulate`: evolution from one initial state, and the long-term state."""

from __future__ import annotations

from pathlib import Path

import click

import shakedown
from shakedown import Problem
from shakedown.report.json_documents import simulation_document
from shakedown.visible_text import shortened

from .initial import initial_state
from .options import (
    OutputFile,
    cycles_option,
    json_option,
    method_option,
    problem_argument,
    quiet_option,
    refuse_overwriting_input,
)
from .output import echo_json, headline, listing, number, paragraph, say, table, tiny


@click.command(short_help="Evolution from one initial state.")
@problem_argument
@click.option("--load-factor", type=float, required=True, help="Load factor λ ≥ 0 of the periodic loading.")
@click.option(
    "--initial",
    metavar="STATE",
    help="zero, safe, witness, given, given:K (state K of the file) or PATH.npy. "
    "Default: given where the file has initial_slip, else zero.",
)
@cycles_option
@method_option
@click.option("-o", "--output", type=OutputFile(), help="Write the path here (NPZ): events or load steps.")
@json_option
@quiet_option
@click.pass_context
def simulate(
    context: click.Context,
    problem: Problem,
    load_factor: float,
    initial: str | None,
    cycles: int,
    method: str,
    output: Path | None,
    as_json: bool,
) -> None:
    """Follow FILE at one load factor from one initial state to its long-term state."""
    refuse_overwriting_input(context, output)
    if initial is None:
        initial = "zero" if problem.initial_slip is None else "given"
    start = initial_state(problem, load_factor, initial)
    run = shakedown.simulate(
        problem, load_factor, start, cycles=cycles, method=method, record=output is not None
    )
    if output is not None:
        shakedown.save_history(output, run)
    if as_json:
        echo_json(simulation_document(run, problem))
    else:
        say(_text(problem, run, initial))
    if run.outcome == shakedown.Outcome.UNDECIDED:
        context.exit(1)


def _jump_facts(run: shakedown.Simulation) -> list[tuple[str, str, str]]:
    """Jumps of the long-term state, where it has any."""
    if not run.jumps_per_cycle > 0:
        return []
    return [
        ("  by friction", number(run.friction_dissipation_per_cycle), ""),
        ("  by damping in jumps", number(run.jump_dissipation_per_cycle), ""),
        ("jumps per cycle", number(run.jumps_per_cycle), ""),
    ]


def _proof_facts(run: shakedown.Simulation) -> list[tuple[str, str, str]]:
    """What is proved of a shakedown, and which nodes stay open."""
    facts = []
    if run.open_nodes:
        facts.append(("open throughout", ", ".join(map(str, run.open_nodes)), "nodes"))
    if run.outcome == shakedown.Outcome.SHAKEDOWN:
        facts.append(("shakedown proved", "yes" if run.proved else "no", ""))
    if run.proved and run.long_term is not None:
        facts.append(("one node may be off by", number(run.long_term.single_node_margin), "slip"))
    return facts


def _text(problem: Problem, run: shakedown.Simulation, initial: str) -> str:
    lines = [headline(problem), ""]
    lines.append(
        paragraph(f"Load factor {run.load_factor:.10g}, initial state {shortened(initial)}: {run.outcome}")
    )
    lines.append(paragraph(f"({run.reason}).", "  "))
    lines.append("")
    facts = [
        ("cycles simulated", str(run.cycles_simulated), ""),
        ("period", str(run.period) if run.period else "-", "cycles" if run.period > 1 else "cycle"),
        ("dissipation per cycle", number(run.dissipation_per_cycle), ""),
        *_jump_facts(run),
        *_proof_facts(run),
        ("friction law residual", tiny(run.residual), "relative"),
        ("method", run.method, f"{run.events} events" if run.events is not None else ""),
    ]
    facts += [
        (f"jump at {jump.cycle:.4g} cycles", number(jump.energy_released), "energy released")
        for jump in run.jumps
    ]
    lines.append(listing(facts))
    lines.append("")
    rows = [
        [str(j), number(run.initial_slip[j]), number(run.final_slip[j]), number(run.slip_per_cycle[j])]
        for j in range(problem.n)
    ]
    lines.append(table(["node", "initial slip", "final slip", "slip per period"], rows))
    return "\n".join(lines)
