"""What one call reads and writes: no file is written over another of the same call."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NamedTuple

import click

import shakedown
from shakedown.ground.visible_text import shortened

CLAIMS = "shakedown.claims"  # key of the command's context
PICTURES = (".png", ".svg", ".pdf")
NODE_FILES = (".csv", ".vtu", ".vtp")
SERIES_FILES = NODE_FILES[1:]  # of these a file is written for every instant


class Claim(NamedTuple):
    """A file of this call, under the option or argument that names it."""

    name: str
    path: str
    written: bool


def reads(context: click.Context | None, name: str, path: str | os.PathLike[str]) -> None:
    """Note a file that is read; raises ``UsageError`` where an output of this call would replace it."""
    _claim(context, Claim(name, os.fspath(path), written=False))


def writes(context: click.Context | None, name: str, path: str | os.PathLike[str]) -> None:
    """Note a file to write; raises ``UsageError`` where it is another file of this call."""
    _claim(context, Claim(name, os.fspath(path), written=True))


def writes_whole(context: click.Context | None, name: str, path: Path) -> None:
    """As :func:`writes`, after a check that the file can be written."""
    from shakedown.files.atomic_write import check_target  # only where a file is asked for

    check_target(path)
    writes(context, name, path)


def pieces_of(context: click.Context, output: Path | None, resume: bool) -> None:
    """Note the folder beside the output in which a run keeps its pieces."""
    if output is not None:
        from shakedown.files.atomic_write import pieces_beside  # only where a file is asked for

        writes(context, "the pieces of -o", pieces_beside(output))
    elif resume:
        raise click.UsageError("--resume: expected -o FILE, beside which the pieces of the run are kept")


def _claim(context: click.Context | None, new: Claim) -> None:
    if context is None:
        return
    claims: list[Claim] = context.meta.setdefault(CLAIMS, [])
    for old in claims:
        output, other = (new, old) if new.written else (old, new)
        if output.written and _is_same(new.path, old.path):
            found = shortened(output.path)
            raise click.UsageError(f"{output.name}: expected another file than {other.name}, found {found}")
    claims.append(new)


def _is_same(one: str, other: str) -> bool:
    """Whether two paths lead to the same file, which need not exist yet."""
    try:
        if os.path.samefile(one, other):
            return True
    except (OSError, ValueError):  # one of them does not exist, or no file can have that name
        pass
    try:
        return os.path.normcase(os.path.realpath(one)) == os.path.normcase(os.path.realpath(other))
    except (OSError, ValueError):
        return False


def name_of(param: click.Parameter | None) -> str:
    """A parameter as the user types it: ``-o``, ``--picture``, ``FILE``."""
    if param is None:
        return "-o"
    return param.metavar or param.opts[0] if isinstance(param, click.Argument) else param.opts[0]


class OutputFile(click.Path):
    """A file to write: before the work starts it is checked to be writable and no other file of the call."""

    def __init__(self, endings: tuple[str, ...] = ()) -> None:
        super().__init__(path_type=Path)
        self.endings = endings

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        name = name_of(param)
        if not value or str(value).endswith(("/", os.sep)):
            raise click.UsageError(f"{name}: expected the name of a file, found '{value}'")
        if self.endings and not str(value).lower().endswith(self.endings):
            known = " or ".join(filter(None, [", ".join(self.endings[:-1]), self.endings[-1]]))
            raise shakedown.UsageError(f"{value}: expected a name that ends in {known}")
        writes_whole(ctx, name, value)
        return super().convert(value, param, ctx)


class TableFile(OutputFile):
    """A table to write: before the work starts it is checked to be writable."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        from shakedown.files.table_file import check_table  # only where a table is asked for

        path = super().convert(value, param, ctx)
        check_table(path)
        return path
