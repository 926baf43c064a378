"""How results look: JSON for programs, text as wide as the terminal for people."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from shakedown import Problem
from shakedown.ground.shown_values import DIGITS, down, sized
from shakedown.ground.visible_text import LONGEST_NAME, one_line, visible
from shakedown.joint.units import loads_in_words
from shakedown.report.hint_words import doubts_in_words
from shakedown.report.json_documents import as_text
from shakedown.report.node_words import label_column
from shakedown.report.text_table import table

if TYPE_CHECKING:  # it loads what computes
    from shakedown.long_term.slip_criterion import SlipCriterion

QUIET = "shakedown.quiet"  # key of the command's context
COLUMNS = 80  # where there is no terminal to ask
NARROW = 24  # columns that are too few to wrap a remark in


def echo_json(document: dict[str, Any]) -> None:
    """The one document on stdout."""
    click.echo(as_text(document))


def say(text: str) -> None:
    """Text on stdout, with nothing in it that a terminal would obey."""
    click.echo(visible(text, keep="\n"))


def remark(text: str) -> None:
    """A line on stderr beside the result, unless the user wants none."""
    if not is_quiet():
        click.echo(visible(text), err=True)


def is_quiet() -> bool:
    """Whether the command was called with ``--quiet``."""
    return bool(click.get_current_context().meta.get(QUIET))


def number(value: float | None, digits: int = DIGITS) -> str:
    """A number for people; undefined ones as a dash."""
    if value is None or value != value:
        return "-"
    return f"{value:.{digits}g}"


def bound(value: float, *, rounded: Callable[[float, int], str] = down) -> str:
    """A limit of the load factor, rounded down (or up) so that what is said of it stays true."""
    return "-" if value != value else rounded(value, DIGITS)


def tiny(value: float) -> str:
    """The order of magnitude of an error; undefined ones as a dash."""
    return f"{value:.1e}" if value == value else "-"


def listing(facts: Sequence[tuple[str, str, str]], indent: str = "  ") -> str:
    """Names, values and remarks in aligned columns, remarks wrapped; lines without a value are left out."""
    facts = [fact for fact in facts if fact[1] != "-"]
    name_width, value_width = (max((len(fact[k]) for fact in facts), default=0) for k in (0, 1))
    starts = [f"{indent}{name:{name_width}}  {value:{value_width}}  " for name, value, _ in facts]
    return "\n".join(
        _hanging(start, remark) if remark else start.rstrip()
        for start, (_, _, remark) in zip(starts, facts, strict=True)
    )


def _hanging(start: str, text: str) -> str:
    """Text after the start of its line, wrapped below itself where the terminal leaves room for that."""
    width = columns() - 1
    if width - len(start) < NARROW:
        return f"{start}{text}".rstrip()
    return click.wrap_text(text, width=width, initial_indent=start, subsequent_indent=" " * len(start))


def slip_facts(criterion: SlipCriterion | None, length: str) -> list[tuple[str, str, str]]:
    """The largest slip range, and whether it is below the limit, where there is one."""
    if criterion is None:
        return []
    met = {True: "yes", False: "no", None: "undecided"}[criterion.met]
    where = f"{length} at node {criterion.node}".strip() if criterion.node >= 0 else length
    return [
        ("largest slip range", number(criterion.largest, 4), where),
        (f"below {sized(criterion.below, length)}", met, ""),
    ]


def paragraph(text: str, indent: str = "") -> str:
    """Text wrapped to the width of the terminal."""
    return click.wrap_text(text, width=columns() - 1, initial_indent=indent, subsequent_indent=indent)


def load_factor_in_words(problem: Problem, load_factor: float) -> str:
    """A load factor, and what it means in the loads of the problem where these are said."""
    loads = loads_in_words(problem, load_factor)
    return f"Load factor {load_factor:.10g}{f' ({loads})' if loads else ''}"


def columns() -> int:
    """Columns of the terminal; 80 where stdout is none."""
    if sys.stdout is None or not sys.stdout.isatty():
        return COLUMNS
    return max(shutil.get_terminal_size((COLUMNS, 24)).columns, 40)


def node_table(problem: Problem, more: Mapping[str, Sequence[str]]) -> str:
    """A table with one row per node: its number, its label where it has one, and columns by heading."""
    named = {"node": list(map(str, range(problem.n)))} | label_column(problem) | dict(more)
    return table(list(named), list(zip(*named.values(), strict=True)))


def headline(problem: Problem) -> str:
    """Name, size and friction of a problem; on lines of their own its loads, and what is doubtful."""
    f = problem.f
    friction = f"f = {f[0]:g}" if (f == f[0]).all() else f"f = {f.min():g} … {f.max():g}"
    nodes = f"{problem.n} node{'s' * (problem.n != 1)}"
    nodes += " in space" * (problem.directions > 1)
    steps = f"{problem.m} load step{'s' * (problem.m != 1)}"
    if problem.is_domain:
        steps = f"load domain of {problem.m} corner{'s' * (problem.m != 1)}"
    units = f", in {one_line(problem.units, LONGEST_NAME)}" if problem.units else ""
    name = one_line(problem.name, LONGEST_NAME) or "unnamed problem"
    lines = [paragraph(f"{name}: {nodes}, {steps}, {friction}{units}")]
    lines += [paragraph(f"loads at λ = 1: {loads_in_words(problem)}")] if problem.loads else []
    lines += [paragraph(f"warning: {doubt}") for doubt in doubts_in_words(problem)]
    return "\n".join(lines)


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
