"""A table of points as a CSV or a Parquet file."""

import csv
import io
import re
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from os import PathLike
from typing import Any

from shakedown.files.atomic_write import atomic_write, check_target
from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import ProblemError, UsageError, found_in
from shakedown.ground.regular_file import open_regular
from shakedown.ground.size_limits import READ_AT_ONCE
from shakedown.ground.visible_text import shortened, visible
from shakedown.joint.result import frame

Columns = Mapping[str, Sequence[Any]]
FORMULA = tuple("=+-@＝＋－＠")  # first characters that a spreadsheet takes for a formula
NUMBER = re.compile(r"[+-]?\d+(\.\d*)?([eE][+-]?\d+)?")


def write_csv(path: str | PathLike[str], columns: Columns) -> None:
    """One row per entry under the headings, in UTF-8; numbers with all their digits, undefined ones empty.

    A text, headings too, that a spreadsheet would run as a formula (it begins with = + - @ and is no number)
    has an apostrophe before it. Quotation marks are as in RFC 4180.
    """
    text = io.StringIO(newline="")
    table = csv.writer(text, lineterminator="\n")
    table.writerow(map(cell, columns))
    table.writerows([cell(entry) for entry in row] for row in zip(*columns.values(), strict=True))
    with atomic_write(path) as file:
        file.write(text.getvalue().encode())


def read_csv(path: str | PathLike[str], headings: Sequence[str]) -> dict[str, list[str]]:
    """The columns of a CSV with these headings, as texts.

    Raises
    ------
    ProblemError
        If there is no such file, or it is another one.
    """
    with found_in(shortened(str(path))), open_regular(path) as file:
        text = file.read(READ_AT_ONCE).decode(errors="replace")
        try:
            rows = list(csv.reader(text.splitlines()))
        except csv.Error:  # an unterminated entry
            rows = []
        if not rows or rows[0] != list(map(cell, headings)) or any(len(row) != len(headings) for row in rows):
            first = ", ".join(headings[:3])
            raise ProblemError(f"expected a table with the columns {first}, …, found another file")
    return {name: [row[k] for row in rows[1:]] for k, name in enumerate(headings)}


def write_table(path: str | PathLike[str], columns: Columns) -> None:
    """Write the table: CSV, or Parquet where the name ends in .parquet; refuses as :func:`check_table`."""
    check_table(path)
    if str(path).lower().endswith("csv"):
        write_csv(path, columns)
        return
    buffer = io.BytesIO()
    frame(columns).to_parquet(buffer, index=False)
    with atomic_write(path) as file:
        file.write(buffer.getvalue())


@checked
def check_table(path: str | PathLike[str]) -> None:
    """Raise ``UsageError`` unless a .csv, or with pandas and pyarrow a .parquet, can be written there."""
    ending = str(path).rpartition(".")[2].lower()
    if ending not in ("csv", "parquet"):
        found = shortened(str(path))
        raise UsageError(f"table: expected a file name that ends in .csv or .parquet, found {found}")
    check_target(path)
    missing = [name for name in ("pandas", "pyarrow") if ending == "parquet" and not find_spec(name)]
    if missing:
        raise UsageError(f"{path}: expected the packages pandas and pyarrow, found no {missing[0]}; use .csv")


def cell(entry: float | str) -> str:
    r"""An entry as it is written, before quotation marks.

    Examples
    --------
    >>> cell(0.1), cell(float("nan")), cell("=1+1"), cell("-12"), cell("PART-1.7")
    ('0.1', '', "'=1+1", '-12', 'PART-1.7')
    """
    if isinstance(entry, float):
        return "" if entry != entry else repr(float(entry))
    text = visible(str(entry))
    runs = text.startswith(FORMULA) and not NUMBER.fullmatch(text)
    return f"'{text}" if runs else text
