"""A table of points as a CSV or a Parquet file."""

import csv
import io
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from os import PathLike
from typing import Any

from shakedown.files.atomic_write import atomic_write, check_target
from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import UsageError
from shakedown.ground.visible_text import shortened, visible
from shakedown.joint.result import frame

Columns = Mapping[str, Sequence[Any]]


def write_csv(path: str | PathLike[str], columns: Columns) -> None:
    """One row per point under the headings; numbers with all their digits, undefined ones empty."""
    text = io.StringIO(newline="")
    table = csv.writer(text, lineterminator="\n")
    table.writerow(columns)
    table.writerows([_cell(entry) for entry in row] for row in zip(*columns.values(), strict=True))
    with atomic_write(path) as file:
        file.write(text.getvalue().encode())


def write_parquet(path: str | PathLike[str], columns: Columns) -> None:
    """The same as Parquet, of which pandas needs pyarrow."""
    buffer = io.BytesIO()
    frame(columns).to_parquet(buffer, index=False)
    with atomic_write(path) as file:
        file.write(buffer.getvalue())


def _cell(entry: float | str) -> str:
    if isinstance(entry, float):
        return "" if entry != entry else repr(entry)
    return visible(str(entry))


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
