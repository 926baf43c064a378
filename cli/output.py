"""How results look: JSON for programs, text as wide as the terminal for people."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from shakedown.ground.visible_text import visible
from shakedown.report.facts import Section, Sheet
from shakedown.report.json_documents import as_text
from shakedown.report.terminal import WIDTH, sheet_as_text

QUIET = "shakedown.quiet"  # key of the command's context


def echo_json(document: dict[str, Any]) -> None:
    """The one document on stdout."""
    click.echo(as_text(document))


def say(text: str) -> None:
    """Text on stdout, with nothing in it that a terminal would obey."""
    click.echo(visible(text, keep="\n"))


def show(sheet: Sheet, *more: Section) -> None:
    """A sheet on stdout, as wide as the terminal, with more sections below it."""
    whole = replace(sheet, sections=[*sheet.sections, *more])
    say(sheet_as_text(whole, columns()))


def draw(path: Path | None, name: str, found: Any, **settings: Any) -> None:
    """Write a picture of a result by a function of ``shakedown.plot``; nothing where none is asked for."""
    if path is not None:
        from shakedown import plot  # only where a picture is wanted

        plot.save(getattr(plot, name)(found, **settings), path)


def remark(text: str) -> None:
    """A line on stderr beside the result, unless the user wants none."""
    if not is_quiet():
        click.echo(visible(text), err=True)


def is_quiet() -> bool:
    """Whether the command was called with ``--quiet``."""
    return bool(click.get_current_context().meta.get(QUIET))


def columns() -> int:
    """Columns of the terminal; 80 where stdout is none."""
    if sys.stdout is None or not sys.stdout.isatty():
        return WIDTH
    return max(shutil.get_terminal_size((WIDTH, 24)).columns, 40)


@contextmanager
def progress(label: str, rest: int = 0) -> Iterator[Callable[[int, int], None] | None]:
    """A callback (done, total) that draws a bar on stderr, or None where nobody watches.

    The bar leaves room for ``rest`` more pieces of work, which count as done when the block ends.
    """
    if is_quiet() or sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    bar: Any = None

    def update(done: int, total: int) -> None:
        nonlocal bar
        if bar is None:
            bar = click.progressbar(length=total + rest, label=label, file=sys.stderr).__enter__()
        bar.update(done - bar.pos)

    try:
        yield update
        if bar is not None:
            bar.update(rest)
    finally:
        if bar is not None:
            bar.render_finish()
