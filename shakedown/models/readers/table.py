"""Tables of numbers: a header or none, any usual delimiter, decimal point or comma."""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.models.readers.text import listed, number, quoted, read_lines, whole_numbers

DELIMITERS = {"tab": "\t", ";": ";", ",": ",", "space": None}
_NUMBER = re.compile(r"[-+]?[.,]?\d")  # how one begins
_COMMENT = ("#", "%", "!", "$", "**", "//")


@dataclass(frozen=True, eq=False)
class NumberTable:
    """Rows of numbers.

    Attributes
    ----------
    name : str
        The file, for messages.
    columns : tuple of str
        Headings, empty where the file has none.
    lines : tuple of int
        Line of the file of every row.
    values : (k, c)
        The numbers.
    """

    name: str
    columns: tuple[str, ...]
    lines: tuple[int, ...]
    values: FloatArray

    def column(self, key: str | int) -> FloatArray:
        """One column, by its heading or its number from 1.

        Raises
        ------
        ProblemError
            If there is none, or the heading occurs twice.
        """
        width = self.values.shape[1]
        if isinstance(key, int):
            if not 1 <= key <= width:
                raise ProblemError(f"{self.name}: expected a column from 1 to {width}, found {key}")
            return self.values[:, key - 1]
        places = [k for k, own in enumerate(self.columns) if own.casefold() == key.strip().casefold()]
        if len(places) != 1:
            raise ProblemError(
                f"{self.name}: expected one column {quoted(key)}, found {len(places)} of that name; columns "
                f"are {listed(self.columns)}"
            )
        return self.values[:, places[0]]

    def whole(self, key: str | int) -> list[int]:
        """A column of whole numbers."""
        which = f" in column {quoted(str(key))}"
        return whole_numbers(self.column(key)[:, None], self.lines, self.name, which).ravel().tolist()


def read_table(
    path: str | os.PathLike[str], *, delimiter: str | None = None, decimal: str | None = None
) -> NumberTable:
    """Read a table of numbers; see :func:`number_table`."""
    return number_table(read_lines(path), os.fspath(path), delimiter=delimiter, decimal=decimal)


def number_table(
    lines: Sequence[str], name: str, *, delimiter: str | None = None, decimal: str | None = None
) -> NumberTable:
    """A table of numbers from its lines.

    The delimiter is the first of tab, semicolon, comma and blank that splits all
    rows into the same number of numbers. Between tabs, semicolons and blanks a
    comma is a decimal comma; in a single column it must be said to be one.
    Blank lines and lines that start with ``#``, ``%``, ``!``, ``$``, ``**`` or
    ``//`` are skipped; the first other line is a header if it holds a word.

    Parameters
    ----------
    lines, name
        The lines of the file, and its name for messages.
    delimiter
        ``"tab"``, ``";"``, ``","`` or ``"space"``, where it is not to be found out.
    decimal
        ``"."`` or ``","``, likewise.

    Raises
    ------
    ProblemError
        If there is no row, or no delimiter makes a table of the lines; the
        message says where the most promising one fails.

    Examples
    --------
    >>> table = number_table(["time;factor", "0,0;1,5", "0,5;-2,0"], "a file")
    >>> table.columns, table.column("factor").tolist()
    (('time', 'factor'), [1.5, -2.0])
    """
    if delimiter not in (None, *DELIMITERS) or decimal not in (None, ".", ","):
        raise ProblemError(
            f"{name}: expected the delimiter tab, ;, comma or space and the decimal mark . or a comma, found "
            f"{quoted(str(delimiter))} and {quoted(str(decimal))}"
        )
    stripped = enumerate(map(str.strip, lines), start=1)
    rows = [(k, text) for k, text in stripped if text and not text.startswith(_COMMENT)]
    if not rows:
        raise ProblemError(f"{name}: expected rows of numbers, found none")
    failures = []
    for mark in DELIMITERS if delimiter is None else (delimiter,):
        split = DELIMITERS[mark]
        if delimiter is None and split is not None and not any(split in text for _, text in rows):
            continue
        try:
            found = _split(rows, name, mark, decimal)
        except ProblemError as error:
            failures.append(error)
            continue
        if not failures or found.values.shape[1] > 1:  # one column where a comma failed: a damaged row
            return found
    raise failures[0] from None


def _split(rows: list[tuple[int, str]], name: str, mark: str, decimal: str | None) -> NumberTable:
    header: tuple[str, ...] = ()
    (_, first), split = rows[0], DELIMITERS[mark]
    comma = decimal == "," or (decimal is None and mark != ",")
    fields = [field.strip().strip('"') for field in first.split(split)]
    if not all(map(_NUMBER.match, filter(None, fields))):
        header, rows = tuple(field for field in fields if field), rows[1:]
    if not rows:
        raise ProblemError(f"{name}: expected rows of numbers below the header, found none")
    values = []
    for k, text in rows:
        fields = text.rstrip("\t;, " if mark != "space" else None).split(split)
        where = f"{name}: line {k}"
        values.append([number(field.replace(",", ".") if comma else field, where) for field in fields])
        if len(fields) != len(values[0]) or (header and len(fields) != len(header)):
            expected = len(header) if header else len(values[0])
            raise ProblemError(f"{where}: expected {expected} columns, found {len(fields)}")
    return NumberTable(name, header, tuple(k for k, _ in rows), np.array(values))
