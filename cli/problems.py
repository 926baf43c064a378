"""`shakedown-bounds example`, `import`: a problem file, built in or from finite-element output."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

import shakedown
from shakedown.models.importing.templates import (
    import_template,
    import_template_names,
    write_import_example,
    write_import_template,
)
from shakedown.report.data_facts import examples_sheet, headline, import_sheet
from shakedown.report.facts import Sheet

from . import options
from .command import Answer, command, say
from .options import option


@command("List or write the built-in problems.", "0 listed or written; 2 bad usage.")
@click.argument("name", required=False)
@option("-o", "--output", type=options.output_file(), help="Write the problem file here.")
def example(name: str | None, output: Path | None) -> Answer:
    """List the built-in problems, or write one to a file."""
    if name is None:
        if output is not None:
            raise click.UsageError("-o needs the NAME of a built-in problem")
        known = {each: shakedown.example(each) for each in shakedown.example_names()}
        listed = [{"example": each} | problem.to_dict() for each, problem in known.items()]
        return Answer(lambda: {"examples": listed}, lambda: examples_sheet(known))
    problem = shakedown.example(name)
    target = output or Path(f"{name}.npz")
    if output is None and target.exists():
        raise click.UsageError(f"{target} exists; name the file to write with -o")
    shakedown.save_problem(target, problem)
    return Answer(
        lambda: {"example": name, "file": str(target)} | problem.to_dict(),
        lambda: Sheet([f"wrote {target}", *headline(problem)]),
    )


@command("Make a problem file from finite-element output.", "0 written, or shown; 2 bad usage or bad input.")
@click.argument("config", metavar="[CONFIG.toml]", required=False, type=click.Path(path_type=Path))
@option("-o", "--output", type=options.output_file(), help="Write the problem file here.")
@option("--check", is_flag=True, help="Write nothing; show what has been read.")
@option(
    "--picture",
    type=options.output_file(options.PICTURES),
    help="Draw nodes, normals, tangents (PNG, SVG, PDF).",
)
@option(
    "--template",
    type=click.Choice([*import_template_names(), "example"]),
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
    to = [] if output is None else ["-o", str(output)]
    again = shlex.join(["shakedown-bounds", "import", str(config), *to])
    made = options.imported("CONFIG.toml", config, command=again)
    if picture is not None:
        from shakedown import plot  # only where a picture is wanted
        from shakedown.models.importing.contact_figure import contact_picture

        plot.save(contact_picture(made), picture)
    written = None if check or output is None else str(output)
    if written is not None:
        shakedown.save_problem(written, made.problem)
    return Answer(lambda: {"file": written} | made.to_dict(), lambda: import_sheet(made, written=written))


def _write_template(kind: str, config: Path | None, output: Path | None) -> None:
    if config is not None:
        raise click.UsageError("--template: expected no CONFIG.toml beside it")
    if kind == "example":
        if output is None:
            raise click.UsageError("--template example: expected -o FOLDER")
        for path in write_import_example(output):
            say(f"wrote {path}")
        return
    if output is None:
        click.echo(import_template(kind), nl=False)
    else:
        say(f"wrote {write_import_template(kind, output)}")
