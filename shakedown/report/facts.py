"""Facts: a label, a value, its unit and a note; how lists of them, tables and documents become text."""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from importlib.resources import files
from itertools import combinations, zip_longest
from math import isfinite, isinf, isnan
from tomllib import loads
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from shakedown.ground.constants import SIX_DIGITS
from shakedown.ground.shown_values import DIGITS, FEW_DIGITS, down, few, one_line, up, visible

if TYPE_CHECKING:
    from shakedown.plot.inline_svg import Picture


Rounding = Literal["down", "up", "nearest"]
ROUNDED = {"down": down, "up": up, "nearest": few}
notes = SimpleNamespace(
    **loads(files("shakedown.report").joinpath("templates/notes.toml").read_text("utf-8"))
)
"""What text and pages say in sentences: a fixed list."""
NEGATIVE = "−"  # as long as a plus sign


@dataclass(frozen=True)
class Fact:
    """One thing that is known.

    Attributes
    ----------
    label
        What it is.
    value
        A number, NaN where it is not known, or a word.
    unit
        The unit of the number; empty where it has none.
    rounding
        To which side a number is rounded, so that the statement about it stays true.
    note
        What follows from it, or where it holds.
    """

    label: str
    value: float | str
    unit: str = ""
    rounding: Rounding = "nearest"
    note: str = ""

    @property
    def shown(self) -> str:
        """The value with its unit."""
        if isinstance(self.value, str):
            return self.value
        return f"{number(self.value, FEW_DIGITS, self.rounding)} {self.unit}".rstrip()


@dataclass(frozen=True)
class Table:
    """Rows of texts under their headings.

    Attributes
    ----------
    head, rows
        The headings and the cells.
    words
        The columns that hold words; the others hold numbers.
    keys
        How many of the first columns say which row it is: they are repeated where a table is too wide.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: tuple[int, ...] = (0,)
    keys: int = 1

    @classmethod
    def of(
        cls, columns: Mapping[str, Sequence[str]], words: Container[str] = ("FE",), keys: int = 1
    ) -> Table:
        """A table from its columns, by their headings."""
        rows = [list(row) for row in zip(*columns.values(), strict=True)]
        return cls(list(columns), rows, tuple(k for k, name in enumerate(columns) if name in words), keys)


@dataclass(frozen=True)
class Section:
    """What belongs together: facts, tables, sentences, and on a page pictures."""

    title: str = ""
    facts: Sequence[Fact] = ()
    tables: Sequence[Table] = ()
    notes: Sequence[str] = ()
    pictures: Sequence[Picture] = ()
    folded: bool = False  # a page shows its tables when asked to


@dataclass(frozen=True)
class Sheet:
    """The answer to a question: what it is about, the answer, what is claimed, and what supports it."""

    headline: Sequence[str]
    answer: Sequence[str] = ()
    claims: Table | None = None
    facts: Sequence[Fact] = ()
    sections: Sequence[Section] = ()


def number(value: float | None, digits: int = FEW_DIGITS, rounding: Rounding = "nearest") -> str:
    """A number as it is shown: a dash where there is none.

    Examples
    --------
    >>> number(0.65737347), number(0.65737347, rounding="down"), number(float("nan")), number(float("inf"))
    ('0.6574', '0.6573', '–', '∞')
    """
    if value is None or isnan(value):
        return "–"
    if isinf(value):
        return "∞" if value > 0 else "−∞"
    return ROUNDED[rounding](value, digits)


def limits_as_text(limits: Sequence[tuple[float, Rounding]], digits: int = FEW_DIGITS) -> list[str]:
    """Load factors, each rounded to the safe side, in as many digits as tell them from 1 and from each other.

    Examples
    --------
    >>> limits_as_text([(0.65737347, "down"), (0.73159346, "down"), (0.73914551, "up")])
    ['0.6573', '0.7315', '0.7392']
    >>> limits_as_text([(1.67999034, "down"), (1.67999361, "down"), (3.0, "up")])
    ['1.679990', '1.679993', '3']
    >>> limits_as_text([(1.00000004, "down")])
    ['1.00000004']
    """
    texts: list[str] = []
    for more in range(digits, 17):  # a float has 16
        texts = [_padded(value, rounding, more) for value, rounding in limits]
        if _tell(limits, texts, apart=more < DIGITS):
            break
    return texts


def _tell(limits: Sequence[tuple[float, Rounding]], texts: Sequence[str], *, apart: bool) -> bool:
    """Whether texts show on which side of 1 load factors lie, and where asked for that they differ."""
    known = [(value, text) for (value, _), text in zip(limits, texts, strict=True) if isfinite(value)]
    if any(np.sign(float(text) - 1) != np.sign(value - 1) for value, text in known):
        return False
    pairs = combinations(known, 2) if apart else ()
    return all(x != y or abs(one - other) <= SIX_DIGITS * abs(one) for (one, x), (other, y) in pairs)


def _padded(value: float, rounding: Rounding, digits: int) -> str:
    """A rounded number with the zeros that end it; an exact one without."""
    text = number(value, digits, rounding)
    if not isfinite(value) or "e" in text or float(text) == value or abs(value) < 1e-4:
        return text
    decimals = digits - 1 - Decimal(text).adjusted()
    return f"{float(text):.{max(decimals, 0)}f}"


def margin(load_factor: float, rounding: Rounding = "down") -> str:
    """How far a load factor lies from 1, in per cent of the cyclic load.

    Examples
    --------
    >>> margin(1.679993), margin(0.73159), margin(0.73914, "up"), margin(float("inf"))
    ('+67.99 %', '−26.85 %', '−26.08 %', 'any')
    """
    if isnan(load_factor):
        return "–"
    if isinf(load_factor):
        return "any"
    value = float(ROUNDED[rounding](float((Decimal(repr(float(load_factor))) - 1) * 100), FEW_DIGITS))
    padded = abs(value) < 100 and round(value, 2) == value
    return f"{value:+.2f} %".replace("-", NEGATIVE) if padded else signed(value, FEW_DIGITS)


def signed(per_cent: float, digits: int) -> str:
    """A change in per cent with its sign.

    Examples
    --------
    >>> signed(-0.975, 2), signed(3.8123, 2)
    ('−0.97 %', '+3.8 %')
    """
    return f"{per_cent:+.{digits}g} %".replace("-", NEGATIVE)


WIDTH = 80  # characters where there is no terminal
TOGETHER = re.compile(r" (?=%|±|= \d)|(?<=±) |(?<= =) (?=\d)")  # spaces at which no line ends
GLUE = "\u2060"


def sheet_as_text(sheet: Sheet, width: int = WIDTH) -> str:
    """A sheet from its headline to its last section."""
    blocks = ["\n".join(paragraph(line, width) for line in [*sheet.headline, *sheet.answer])]
    blocks += [] if sheet.claims is None else [table_as_text(sheet.claims, width)]
    blocks += [listing(sheet.facts, width)]
    blocks += [section_as_text(section, width) for section in sheet.sections]
    return "\n\n".join(filter(None, blocks))


def section_as_text(section: Section, width: int = WIDTH) -> str:
    """One section: its title, facts, tables and notes."""
    blocks = [listing(section.facts, width), *(table_as_text(each, width) for each in section.tables)]
    blocks += ["\n".join(paragraph(note, width) for note in section.notes)]
    text = "\n\n".join(filter(None, blocks))
    return f"{section.title}\n\n{text}" if section.title and text else text


def listing(facts: Sequence[Fact], width: int = WIDTH) -> str:
    """Labels, values and notes in aligned columns; notes are wrapped."""
    labels = max((len(fact.label) for fact in facts), default=0)
    shown = [(fact.label, one_line(fact.shown), fact.note) for fact in facts]
    # longer values have no column of their own
    values = max((len(value) for _, value, _ in shown if len(value) <= 24), default=0)
    lines = []
    for label, value, note in shown:
        start = f"  {label.ljust(labels)}  "
        if note and len(value) <= values and width - len(start) - values > 20:  # enough to wrap in
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


LONGEST = 40  # rows of a table


def table(head: Sequence[str], rows: Sequence[Sequence[str]], longest: int = LONGEST) -> str:
    """Columns of numbers under their headings, in lines as long as they have to be."""
    return table_as_text(Table(head, rows, ()), 10**6, longest)  # no line has so many characters


def table_as_text(table: Table, width: int = WIDTH, longest: int = LONGEST) -> str:
    """Columns under their headings, words wrapped and keys repeated where a line is too short for them.

    Of a table with more rows than the longest one only the first and last ones.
    """
    half, cut = longest // 2, len(table.rows) >= longest + 10  # so many at least are left out, or none
    left_out = f"  … {len(table.rows) - 2 * half} more rows, all in --json and in files …"
    rows = [table.head, *([*table.rows[:half], *table.rows[-half:]] if cut else table.rows)]
    cells = {k: " ".join(row[k] for row in rows) for k in table.words}
    least = {k: max(map(len, texts.split()), default=0) for k, texts in cells.items()}
    widths = _wrapped([max(map(len, column)) for column in zip(*rows, strict=True)], least, width)
    parts = []
    for columns in _split(widths, table.keys, width):
        lines = [_row([row[k] for k in columns], columns, widths, table.words) for row in rows]
        if cut:
            lines.insert(1 + half, left_out)
        parts.append("\n".join(lines))
    return "\n\n".join(parts)


def _wrapped(widths: list[int], least: Mapping[int, int], width: int) -> list[int]:
    """Widths with which a table fits a line as far as its columns of words can be wrapped between words."""
    while sum(widths) + 2 * len(widths) > width:
        wide = [k for k in least if widths[k] > max(10, least[k])]  # characters left of a column
        if not wide:
            break
        widths[max(wide, key=lambda k: (k > 0, widths[k]))] -= 1
    return widths


def _split(widths: Sequence[int], keys: int, width: int) -> list[list[int]]:
    """The columns of each part of a table; the keys are in every one."""
    first = list(range(min(keys, len(widths))))
    parts, used = [first.copy()], sum(widths[k] + 2 for k in first)
    for k in range(len(first), len(widths)):
        if used + widths[k] + 2 > width and len(parts[-1]) > len(first):
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


def as_text(document: dict[str, Any]) -> str:
    """A JSON document as written to files and stdout, without control characters."""
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
    return visible(text, keep="\n", escape=_json_escape)


def _json_escape(character: str) -> str:
    code = ord(character)
    return f"\\u{code:04x}" if code < 0x10000 else json.dumps(character)[1:-1]
