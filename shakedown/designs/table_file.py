"""A table of points as a CSV or a Parquet file, or as a pandas frame."""

import csv
import io
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from shakedown.errors import UsageError
from shakedown.files.atomic_write import atomic_write
from shakedown.visible_text import visible

if TYPE_CHECKING:
    from pandas import DataFrame

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
    """The same as Parquet; ``UsageError`` where pandas or pyarrow is not installed."""
    table, buffer = frame(columns), io.BytesIO()
    try:
        table.to_parquet(buffer, index=False)
    except ImportError:
        raise UsageError("parquet: expected the package pyarrow, found none (pip install pyarrow)") from None
    with atomic_write(path) as file:
        file.write(buffer.getvalue())


def frame(columns: Columns) -> "DataFrame":
    """A pandas frame; ``UsageError`` where pandas is not installed."""
    try:
        from pandas import DataFrame
    except ImportError:
        raise UsageError(
            "pandas: expected the extra 'frames' (pip install 'shakedown-bounds[frames]'), found none"
        ) from None
    return DataFrame(dict(columns))


def _cell(entry: float | str) -> str:
    if isinstance(entry, float):
        return "" if entry != entry else repr(entry)
    return visible(str(entry))
