"""What all commands have in common: how they answer, in text or JSON, and with which exit code."""

from __future__ import annotations

import logging
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial, wraps
from pathlib import Path
from typing import Any, NamedTuple

import click

from shakedown import Problem
from shakedown.ground.shown_values import visible
from shakedown.report.facts import WIDTH, Sheet, as_text, sheet_as_text

QUIET = "shakedown.quiet"  # key of the command's context


class Answer(NamedTuple):
    """What a command has found.

    Attributes
    ----------
    document
        Makes the one document of ``--json``.
    sheet
        Makes what is shown otherwise; None where nothing is.
    is_open
        Whether the answer is negative or open, so that the exit code is 1.
    open_ends
        What is open, one line each on stderr; then the exit code is 1, too.
    """

    document: Callable[[], dict[str, Any]]
    sheet: Callable[[], Sheet] | None
    is_open: bool = False
    open_ends: Sequence[str] = ()


def document(problem: Problem, found: Any) -> dict[str, Any]:
    """A result and the joint that it is about, as ``--json`` shows them."""
    return {"problem": problem.to_dict()} | found.to_dict()


def command(short_help: str, codes: str) -> Callable[[Callable[..., Answer | None]], click.Command]:
    """A command made from a function that returns its answer, with ``--json`` and ``--quiet``.

    Parameters
    ----------
    short_help
        What it does, in the list of commands.
    codes
        What its exit codes mean.
    """

    def made(function: Callable[..., Answer | None]) -> click.Command:
        @wraps(function)
        def called(as_json: bool, **given: Any) -> None:
            answer = function(**given)
            if answer is None:
                return
            if as_json:
                click.echo(as_text(answer.document()))
            elif answer.sheet is not None:
                say(sheet_as_text(answer.sheet(), _columns()))
            for line in answer.open_ends:
                click.echo(line, err=True)
            click.get_current_context().exit(1 if answer.is_open or answer.open_ends else 0)

        found = click.command(short_help=short_help, epilog=f"Exit codes: {codes}")(called)
        found.params += [
            click.Option(["--json", "as_json"], is_flag=True, help="One JSON document on stdout."),
            click.Option(
                ["-q", "--quiet"],
                is_flag=True,
                expose_value=False,
                is_eager=True,
                callback=_keep_quiet,
                help="No progress and no remarks on stderr.",
            ),
        ]
        return found

    return made


def _keep_quiet(context: click.Context, _: click.Parameter, value: bool) -> None:
    context.meta[QUIET] = value
    if value:
        log = logging.getLogger("shakedown")
        context.find_root().call_on_close(partial(log.setLevel, log.level))  # as it was, also after bad usage
        log.setLevel(logging.ERROR)


def is_quiet() -> bool:
    """Whether the command was called with ``--quiet``."""
    return bool(click.get_current_context().meta.get(QUIET))


def say(text: str) -> None:
    """Text on stdout, with nothing in it that a terminal would obey."""
    click.echo(visible(text, keep="\n"))


def remark(text: str) -> None:
    """A line on stderr beside the result, unless the user wants none."""
    if not is_quiet():
        click.echo(visible(text), err=True)


def draw(path: Path | None, name: str, found: Any, **settings: Any) -> None:
    """Write a picture of a result by a function of ``shakedown.plot``; nothing where none is asked for."""
    if path is not None:
        from shakedown import plot  # only where a picture is wanted

        plot.save(getattr(plot, name)(found, **settings), path)


def _columns() -> int:
    """Columns of the terminal; 80 where stdout is none."""
    if sys.stdout is None or not sys.stdout.isatty():
        return WIDTH
    return max(shutil.get_terminal_size((WIDTH, 24)).columns, 40)


@contextmanager
def progress(label: str) -> Iterator[Callable[[int, int], None] | None]:
    """A callback (done, total) that draws a bar on stderr, or None where nobody watches."""
    if is_quiet() or sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    bar: Any = None

    def update(done: int, total: int) -> None:
        nonlocal bar
        if bar is None:
            bar = click.progressbar(length=total, label=label, file=sys.stderr).__enter__()
        bar.update(done - bar.pos)

    try:
        yield update
    finally:
        if bar is not None:
            bar.render_finish()
