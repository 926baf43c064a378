"""One line of the comparison with the thesis: where it stands, where it is here, what both say."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike


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
    """A table of the entries with printed numbers, then one of those that are only to be found."""
    tables = {
        "| thesis | what | in the toolkit | printed | computed | difference |": [
            _line(one) for one in entries if one.printed
        ],
        "| thesis | what | in the toolkit |": [_place(one) for one in entries if not one.printed],
    }
    return "\n\n".join(_table(head, lines) for head, lines in tables.items() if lines)


def _table(head: str, lines: list[str]) -> str:
    return "\n".join([head, "|---" * (head.count("|") - 1) + "|", *lines])


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _line(one: Entry) -> str:
    """Printed beside computed."""
    return _row(one.where, one.what, _homes(one), ", ".join(one.printed), _shown(one), _verdict(one))


def _place(one: Entry) -> str:
    """Where it is, and what is computed of it."""
    remarks = [text for text in (one.what, _shown(one), one.note) if text]
    return _row(one.where, ": ".join(remarks), _homes(one))


def _homes(one: Entry) -> str:
    return ", ".join(f"`{home}`" for home in one.homes)


def _shown(one: Entry) -> str:
    """The computed numbers, and the picture."""
    picture = [f"[figure](../benchmarks/results/{one.figure}.png)"] * bool(one.figure)
    return ", ".join([*(f"{value:.6g}" for value in one.computed), *picture])


def _verdict(one: Entry) -> str:
    if one.note:
        return one.note
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
