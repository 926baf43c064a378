"""`shakedown-bounds import`: a problem file from finite-element output."""

from __future__ import annotations

from pathlib import Path

import click

import shakedown
from shakedown.report.json_documents import plain, problem_document

from .options import OutputFile, json_option, quiet_option
from .output import echo_json, headline, number, paragraph, say


@click.command("import", short_help="Make a problem file from finite-element output.")
@click.argument("config", metavar="CONFIG.toml", type=click.Path(path_type=Path))
@click.option("-o", "--output", required=True, type=OutputFile(), help="Write the problem file here.")
@json_option
@quiet_option
def import_problem_command(config: Path, output: Path, as_json: bool) -> None:
    """Make a problem file from the output of a finite-element code.

    CONFIG.toml names the stiffness matrix (or the reactions to unit
    displacements), the contact nodes and their normals, the friction and the
    loads with their time functions. The content of a file decides its format:
    Abaqus MATRIX INPUT and substructures, CalculiX .sti and reactions, Matrix
    Market, Nastran DMIG and OP4. All keys: `python -m pydoc
    shakedown.importing.import_model`.
    """
    made = shakedown.import_model(config)
    shakedown.save_problem(output, made.problem)
    reduced = made.condensation
    if as_json:
        echo_json(
            {
                "problem": problem_document(made.problem),
                "file": str(output),
                "format": made.format,
                "rows": {"contact": 2 * reduced.n, "condensed": reduced.interior, "held": reduced.held},
                "zero_modes": reduced.zero_modes,
                "asymmetry": reduced.asymmetry,
                "residual": reduced.residual,
                "static_run": plain(made.static_run),
                "notes": list(made.notes),
            }
        )
        return
    say(f"wrote {output}")
    say(headline(made.problem))
    say(f"from {made.format}: {reduced.interior} rows condensed, {reduced.held} held")
    if made.static_run == made.static_run:
        say(f"agrees with the static run to {number(made.static_run, 2)}")
    for note in made.notes:
        say(paragraph(f"note: {note}"))
