"""A table as text: columns right-aligned under their headings."""

from collections.abc import Sequence


def table(headers: Sequence[str], rows: Sequence[Sequence[str]], longest: int = 40) -> str:
    """Right-aligned columns under their headers; of a long table only its first and last rows."""
    cut = len(rows) > longest
    half = longest // 2
    shown = [*rows[:half], *rows[-half:]] if cut else list(rows)
    widths = [max(map(len, column)) for column in zip(headers, *shown, strict=True)]
    lines = [_line(row, widths) for row in [headers, *shown]]
    if cut:
        lines.insert(1 + half, f"  … {len(rows) - 2 * half} rows more; --json has all …")
    return "\n".join(lines)


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    return ("  " + "  ".join(cell.rjust(width) for cell, width in zip(cells, widths, strict=True))).rstrip()
