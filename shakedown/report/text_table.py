"""Facts and tables as text, as wide as a terminal."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from itertools import zip_longest

from shakedown.ground.visible_text import one_line, visible
from shakedown.report.facts import Fact, Section, Sheet, Table

WIDTH = 80  # characters where there is no terminal
LONGEST_VALUE = 24  # characters of a value that has a column of its own
NARROW = 20  # characters that are too few to wrap a note in
TOGETHER = re.compile(r"(?<=\d) (?=%)|(?<=±) | (?=±)|(?<=λ) (?== )|(?<=λ_max) (?== )|(?<= =) (?=\d)")
GLUE = "\u2060"


def sheet_as_text(sheet: Sheet, width: int = WIDTH) -> str:
    """A sheet from its headline to its last section."""
    blocks = ["\n".join(paragraph(line, width) for line in [*sheet.headline, *sheet.answer])]
    blocks += [] if sheet.claims is None else [_table(sheet.claims, width)]
    blocks += [listing(sheet.facts, width)]
    blocks += [section_as_text(section, width) for section in sheet.sections]
    return "\n\n".join(filter(None, blocks))


def section_as_text(section: Section, width: int = WIDTH) -> str:
    """One section: its title, facts, tables and notes."""
    blocks = [listing(section.facts, width), *(_table(each, width) for each in section.tables)]
    blocks += ["\n".join(paragraph(note, width) for note in section.notes)]
    text = "\n\n".join(filter(None, blocks))
    return f"{section.title}\n\n{text}" if section.title and text else text


def listing(facts: Sequence[Fact], width: int = WIDTH) -> str:
    """Labels, values and notes in aligned columns; notes are wrapped."""
    labels = max((len(fact.label) for fact in facts), default=0)
    shown = [(fact.label, one_line(fact.shown), fact.note) for fact in facts]
    values = max((len(value) for _, value, _ in shown if len(value) <= LONGEST_VALUE), default=0)
    lines = []
    for label, value, note in shown:
        start = f"  {label.ljust(labels)}  "
        if note and len(value) <= values and width - len(start) - values > NARROW:
            lines.append(paragraph(note, width, f"{start}{value.ljust(values)}  "))
        else:
            lines.append(paragraph(f"{value}  {note}".strip(), width, start))
    return "\n".join(lines)


def paragraph(text: str, width: int = WIDTH, start: str = "") -> str:
    """Text wrapped below itself after the start of its line; numbers stay with their signs.

    Examples
    --------
    >>> print(paragraph("The joint shakes down up to λ = 0.7315, 26.85 % below the nominal load.", 32, "- "))
    - The joint shakes down up to
      λ = 0.7315, 26.85 % below the
      nominal load.
    """
    glued, after = TOGETHER.sub(GLUE, visible(text)), " " * len(start)
    wrapped = textwrap.fill(
        glued, width - 1, initial_indent=start, subsequent_indent=after, break_on_hyphens=False
    )
    return wrapped.replace(GLUE, " ")


def _table(found: Table, width: int) -> str:
    return table(found.head, found.rows, words=found.words, width=width, keys=found.keys)


LEAST = 10  # characters to which a column of words may be wrapped
CUT = 10  # rows: so many at least are left out of a long table, or none


def table(
    headers: Sequence[str],
    rows: Sequence[Sequence[str]],
    longest: int = 40,
    *,
    words: Sequence[int] = (),
    width: int | None = None,
    keys: int = 1,
) -> str:
    """Columns under their headers; of a long table only its first and last rows.

    Parameters
    ----------
    headers, rows
        The texts.
    longest
        The number of rows from which on those in the middle are left out.
    words
        The columns that are aligned to the left, and wrapped where the table is too wide.
    width
        Characters of a line; None: as many as are needed.
    keys
        How many of the first columns are repeated where the others do not fit beside each other.
    """
    half, cut = longest // 2, len(rows) >= longest + CUT
    shown = [*rows[:half], *rows[-half:]] if cut else list(rows)
    left_out = f"  … {len(rows) - 2 * half} more rows, all in --json and in files …" if cut else ""
    widths = [max(map(len, column)) for column in zip(headers, *shown, strict=True)]
    if width is not None:
        cells = {k: " ".join(row[k] for row in [headers, *shown]) for k in words}
        widths = _wrapped(widths, {k: max(map(len, cells[k].split()), default=0) for k in words}, width)
    parts = []
    for columns in _split(widths, keys, width):
        lines = [_row([row[k] for k in columns], columns, widths, words) for row in [headers, *shown]]
        if cut:
            lines.insert(1 + half, left_out)
        parts.append("\n".join(lines))
    return "\n\n".join(parts)


def _wrapped(widths: list[int], least: Mapping[int, int], width: int) -> list[int]:
    """Widths with which a table fits a line as far as its columns of words can be wrapped between words."""
    widths = list(widths)
    while sum(widths) + 2 * len(widths) > width:
        wide = [k for k in least if widths[k] > max(LEAST, least[k])]
        if not wide:
            break
        widths[max(wide, key=lambda k: (k > 0, widths[k]))] -= 1
    return widths


def _split(widths: Sequence[int], keys: int, width: int | None) -> list[list[int]]:
    """The columns of each part of a table; the keys are in every one."""
    first = list(range(min(keys, len(widths))))
    parts, used = [first.copy()], sum(widths[k] + 2 for k in first)
    for k in range(len(first), len(widths)):
        if width is not None and used + widths[k] + 2 > width and len(parts[-1]) > len(first):
            parts.append(first.copy())
            used = sum(widths[j] + 2 for j in first)
        parts[-1].append(k)
        used += widths[k] + 2
    return parts


def _row(cells: Sequence[str], columns: Sequence[int], widths: Sequence[int], words: Sequence[int]) -> str:
    """One row, of several lines where cells are wrapped."""
    wrapped = [
        textwrap.wrap(cell, widths[k], break_on_hyphens=False) or [""] if k in words else [cell]
        for k, cell in zip(columns, cells, strict=True)
    ]
    lines = []
    for parts in zip_longest(*wrapped, fillvalue=""):
        placed = (
            part.ljust(widths[k]) if k in words else part.rjust(widths[k])
            for k, part in zip(columns, parts, strict=True)
        )
        lines.append(("  " + "  ".join(placed)).rstrip())
    return "\n".join(lines)
