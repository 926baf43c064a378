"""Tables and pictures of the rows of a study."""

from collections.abc import Callable, Iterable, Mapping
from string import Formatter
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shakedown.report.facts import table

Column = str | Callable[[dict], str]


class _Dashes(Formatter):
    """What a row does not have, or has as None, is a dash."""

    def get_field(self, name: str, args: Any, kwargs: Any) -> tuple[Any, Any]:
        try:
            return super().get_field(name, args, kwargs)
        except KeyError:
            return None, name

    def format_field(self, value: Any, form: str) -> str:
        return "-" if value is None else super().format_field(value, form)


def listed(rows: Iterable[dict], columns: Mapping[str, Column]) -> str:
    """A line per row, a column per heading: a format of the row's keys, or a function of the row."""
    return lines(columns, ([shown(row, column) for column in columns.values()] for row in rows))


def shown(row: dict, column: Column) -> str:
    """One cell of a table."""
    return column(row) if callable(column) else _Dashes().vformat(column, (), row)


def lines(heads: Iterable[str], cells: Iterable[list[str]]) -> str:
    """A table of texts, however long."""
    return table(list(heads), list(cells), longest=10_000)


def panels(count: int, wide: int = 3, size: tuple[float, float] = (4.2, 3.4)) -> tuple[Figure, list[Axes]]:
    """A figure with so many panels, ``wide`` of them in a row; those that are left over are empty."""
    across, high = min(wide, count), -(-count // wide)
    figure = Figure(figsize=(size[0] * across, size[1] * high), layout="constrained")
    axes = list(figure.subplots(high, across, squeeze=False).ravel())
    for unused in axes[count:]:
        unused.set_axis_off()
    for used in axes[:count]:
        used.grid(alpha=0.3)
    return figure, axes[:count]


def curve(axes: Axes, rows: Iterable[dict], x: str, y: str, look: str = "o-", **how: Any) -> None:
    """One quantity of the rows over another, on logarithmic axes; nothing where no row has both."""
    points = sorted((row[x], row[y]) for row in rows if row.get(x) is not None and row.get(y) is not None)
    if points:
        axes.loglog(*zip(*points, strict=True), look, **{"ms": 4} | how)
