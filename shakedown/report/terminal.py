"""Facts as text, as wide as a terminal."""

import re
import textwrap
from collections.abc import Sequence

from shakedown.ground.visible_text import one_line, visible
from shakedown.report.facts import Fact, Section, Sheet, Table
from shakedown.report.text_table import table

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
