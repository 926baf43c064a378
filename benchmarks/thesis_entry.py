"""One line of the comparison with the thesis: where it stands, where it is here, what both say."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

NOTHING = "–"


class Entry(NamedTuple):
    """One line of ``docs/thesis.md``."""

    where: str  # equation, figure or section of the thesis
    what: str  # what stands there
    homes: tuple[str, ...]  # where it is in the toolkit, as dotted names
    printed: tuple[str, ...] = ()  # numbers with the digits that the thesis prints; none where it prints none
    computed: tuple[float, ...] = ()  # the same numbers from the toolkit
    note: str = ""  # in place of the relative difference
    figure: str = ""  # our picture of it, in ``benchmarks/results``


def entry(
    where: str,
    what: str,
    homes: str,
    printed: str = "",
    computed: ArrayLike = (),
    note: str = "",
    figure: str = "",
) -> Entry:
    """An entry from texts: homes and printed numbers separated by spaces."""
    numbers = tuple(float(x) for x in np.ravel(np.real(np.asarray(computed))))
    return Entry(where, what, tuple(homes.split()), tuple(printed.split()), numbers, note, figure)


def markdown(entries: Sequence[Entry]) -> str:
    """A table of entries."""
    lines = [
        "| thesis | what | in the toolkit | printed | computed | largest relative difference |",
        "|---|---|---|---|---|---|",
    ]
    return "\n".join([*lines, *map(_line, entries)])


def _line(one: Entry) -> str:
    homes = ", ".join(f"`{home}`" for home in one.homes)
    shown = ", ".join(f"{value:.6g}" for value in one.computed)
    if one.figure:
        picture = f"[figure](../benchmarks/results/{one.figure}.png)"
        shown = f"{shown}, {picture}" if shown else picture
    cells = (one.where, one.what, homes, ", ".join(one.printed) or NOTHING, shown or NOTHING, _verdict(one))
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _verdict(one: Entry) -> str:
    if not one.printed or one.note:
        return one.note or NOTHING
    difference = relative_difference(one)
    return f"{difference:.1e}, same digits" if same_digits(one) else f"{difference:.1e}"


def relative_difference(one: Entry) -> float:
    """Of the number that differs most; a printed 0 counts as 0 difference only where 0 is computed."""
    pairs = zip((float(x) for x in one.printed), one.computed, strict=True)
    return max(abs(c - p) / abs(p) if p else abs(c) for p, c in pairs)


def same_digits(one: Entry) -> bool:
    """Whether every computed number rounds to the digits that are printed."""
    pairs = zip(one.printed, one.computed, strict=True)
    return all(round(c, len(p.partition(".")[2])) == float(p) for p, c in pairs)
