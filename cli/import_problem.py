"""`shakedown-bounds import`: a problem file from finite-element output."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import click

import shakedown
from shakedown.models.importing.templates import (
    import_template,
    import_template_names,
    write_import_example,
    write_import_template,
)
from shakedown.report.data_facts import import_sheet

from . import options
from .command import Answer, command, remark, say
from .options import option

EXAMPLE = "example"
WORDS = (
    "format", "rows", "zero_modes", "asymmetry", "residual", "static_run", "ready", "warnings", "notes",
)  # fmt: skip  # without --check


@command("Make a problem file from finite-element output.", "0 written, or shown; 2 bad usage or bad input.")
@click.argument("config", metavar="[CONFIG.toml]", required=False, type=click.Path(path_type=Path))
@option("-o", "--output", type=options.OutputFile(), help="Write the problem file here.")
@option("--check", is_flag=True, help="Write nothing; show what has been read.")
@option(
    "--picture",
    type=options.OutputFile(options.PICTURES),
    help="Draw nodes, normals, tangents (PNG, SVG, PDF).",
)
@option(
    "--template",
    type=click.Choice([*import_template_names(), EXAMPLE]),
    help="Show a commented CONFIG.toml to start from (-o writes it); 'example' writes a new folder.",
)
def import_command(
    config: Path | None, output: Path | None, check: bool, picture: Path | None, template: str | None
) -> Answer | None:
    """Make a problem file from the output of a finite-element code.

    CONFIG.toml names the stiffness matrix (or the reactions to unit
    displacements), the contact nodes and their normals, the friction and the
    loads with their time functions. The content of a file decides its format:
    Abaqus MATRIX INPUT, COORDINATE and substructures, CalculiX .sti and
    reactions, reactions as a table, Matrix Market and Harwell-Boeing (Ansys),
    Nastran DMIG and OUTPUT4. All keys: `python -m pydoc shakedown.import_model`.

    Start with --template, look with --check, then write with -o.
    """
    if template is not None:
        _write_template(template, config, output)
        return None
    if config is None:
        raise click.UsageError("Missing argument 'CONFIG.toml' (or --template)")
    if output is None and not check:
        raise click.UsageError("Missing option '-o' / '--output' (or --check)")
    options.reads("CONFIG.toml", config)
    to = [] if output is None else ["-o", str(output)]
    again = shlex.join(["shakedown-bounds", "import", str(config), *to])
    made = shakedown.import_model(config, command=again, announce=remark)
    for source in made.sources:
        options.reads(f"{source}, which CONFIG.toml names", config.parent / source)
    if picture is not None:
        from shakedown import plot  # only where a picture is wanted
        from shakedown.models.importing.contact_figure import contact_picture

        plot.save(contact_picture(made), picture)
    written = None if check or output is None else str(output)
    if written is not None:
        shakedown.save_problem(written, made.problem)
    return Answer(lambda: _document(made, written), lambda: import_sheet(made, written=written))


def _write_template(kind: str, config: Path | None, output: Path | None) -> None:
    if config is not None:
        raise click.UsageError("--template: expected no CONFIG.toml beside it")
    if kind == EXAMPLE:
        if output is None:
            raise click.UsageError("--template example: expected -o FOLDER")
        for path in write_import_example(output):
            say(f"wrote {path}")
        return
    if output is None:
        click.echo(import_template(kind), nl=False)
    else:
        say(f"wrote {write_import_template(kind, output)}")


def _document(made: shakedown.Import, written: str | None) -> dict[str, Any]:
    found = made.to_dict()
    shown = found if written is None else {word: found[word] for word in WORDS}
    return {"problem": found["problem"], "file": written} | shown
