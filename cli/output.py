"""How results look: JSON for programs, tables within 80 columns for people."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import click

from shakedown import Problem
from shakedown.report.json_documents import as_text
from shakedown.report.text_table import table as table


def echo_json(document: dict[str, Any]) -> None:
    """The one document on stdout."""
    click.echo(as_text(document))


def number(value: float | None, digits: int = 7) -> str:
    """A number for people; undefined ones as a dash."""
    if value is None or value != value:
        return "-"
    return f"{value:.{digits}g}"


def tiny(value: float) -> str:
    """The order of magnitude of an error; undefined ones as a dash."""
    return f"{value:.1e}" if value == value else "-"


def listing(facts: Sequence[tuple[str, str, str]], indent: str = "  ") -> str:
    """Names, values and remarks in aligned columns; lines without a value are left out."""
    facts = [fact for fact in facts if fact[1] != "-"]
    name_width, value_width = (max(len(fact[k]) for fact in facts) for k in (0, 1))
    return "\n".join(
        f"{indent}{name:{name_width}}  {value:{value_width}}  {remark}".rstrip()
        for name, value, remark in facts
    )


def paragraph(text: str, indent: str = "") -> str:
    """Text wrapped to 80 columns."""
    return click.wrap_text(text, width=79, initial_indent=indent, subsequent_indent=indent)


def headline(problem: Problem) -> str:
    """Name, size and friction of a problem, in one or two lines."""
    f = problem.f
    friction = f"f = {f[0]:g}" if (f == f[0]).all() else f"f = {f.min():g} … {f.max():g}"
    nodes = f"{problem.n} node{'s' * (problem.n != 1)}"
    steps = f"{problem.m} load step{'s' * (problem.m != 1)}"
    units = f", units {problem.units}" if problem.units else ""
    return paragraph(f"{problem.name or 'unnamed problem'}: {nodes}, {steps}, {friction}{units}")


@contextmanager
def progress(label: str) -> Iterator[Callable[[int, int], None] | None]:
    """A callback (done, total) that draws a bar on stderr, or None where nobody watches."""
    if not sys.stderr.isatty():
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
