"""Tables as text: numbers to the right, words to the left, wide ones wrapped or split."""

import textwrap
from collections.abc import Mapping, Sequence
from itertools import zip_longest

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
