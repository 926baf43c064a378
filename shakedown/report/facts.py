"""Facts, labels with their values: commands and pages show the same ones, by ``text`` and ``html``."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from itertools import combinations
from math import isfinite, isinf, isnan
from typing import TYPE_CHECKING, Literal

import numpy as np

from shakedown.ground.round_off import SIX_DIGITS
from shakedown.ground.shown_values import DIGITS, FEW_DIGITS, down, few, up

if TYPE_CHECKING:
    from shakedown.plot.inline_svg import Picture

Rounding = Literal["down", "up", "nearest"]
ROUNDED = {"down": down, "up": up, "nearest": few}
MOST_DIGITS = 16  # that a float has
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
        To which side a number is rounded, so that what is said of it stays true.
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
    for more in range(digits, MOST_DIGITS + 1):
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
    return all(one[1] != other[1] or _same(one[0], other[0]) for one, other in pairs)


def _same(one: float, other: float) -> bool:
    return abs(one - other) <= SIX_DIGITS * abs(one)


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
    per_cent = (Decimal(repr(float(load_factor))) - 1) * 100
    way = {"down": ROUND_FLOOR, "up": ROUND_CEILING}.get(rounding)
    value = float(Context(prec=FEW_DIGITS, rounding=way).plus(per_cent))
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
