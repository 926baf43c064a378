"""Time functions of load cases as a configuration states them."""

from typing import NamedTuple

import numpy as np

from shakedown.ground.constants import DIRECTIONS, MANY, PER_CENT, SIX_DIGITS, FloatArray
from shakedown.models.readers.text import InputFiles, NumberTable, listed, read_table, unfit
from shakedown.models.readers.toml_table import TomlTable

_UNRECORDED = 0.05  # share of the period that may be missing after the last row of a record


class TimeFunction(NamedTuple):
    """Factors of a load case over one period, and what the load steps do not show of it.

    Attributes
    ----------
    factors : () or (m,)
        The factors at the load steps t = k/m.
    doubts : tuple of str
        Doubts: peaks between load steps, waves that they alias, a record that ends long before the period.
    """

    factors: FloatArray
    doubts: tuple[str, ...] = ()


def time_function(table: TomlTable, steps: int | None, files: InputFiles) -> TimeFunction:
    """The key ``history`` of a load, at the load steps t = k/m of one period.

    A number is a constant; a list holds the factors themselves; a table holds

    - ``constant`` and ``harmonics`` = [{order, cos, sin}, …]: constant +
      Σ cos · cos 2π order t + sin · sin 2π order t;
    - or ``points`` = [[t, factor], …], 0 ≤ t ≤ 1, straight lines between, closed
      from the last to the first;
    - or ``file``: a table of numbers, with ``column`` (its heading, or its number
      from 1) where it has several. With ``time`` (a column) and ``period`` (in the
      same unit) the values are sampled at the load steps, straight lines between;
      else each row is one load step. ``delimiter`` (tab, ;, comma, space) and
      ``decimal`` (. or comma) where they are not to be found out, ``scale`` a factor.

    Raises
    ------
    ProblemError
        If the key is missing or malformed, or a function is given without the
        number of steps.

    Examples
    --------
    >>> from pathlib import Path
    >>> load = TomlTable({"history": {"constant": 1.0, "harmonics": [{"order": 1, "sin": 0.5}]}}, "load 1")
    >>> time_function(load, 4, InputFiles(Path("."))).factors
    array([1. , 1.5, 1. , 0.5])
    """
    if isinstance(table.content.get("history"), dict):
        return _function(table.table("history"), steps, files)
    if not table.has("history"):
        raise table.missing("history", "a number, a list or a table")
    if isinstance(table.content["history"], list):
        return TimeFunction(np.array(table.array("history", float, (None,)), dtype=float))
    return TimeFunction(np.array(table.number("history")))


def _function(table: TomlTable, steps: int | None, files: InputFiles) -> TimeFunction:
    kinds = [key for key in ("harmonics", "points", "file") if table.has(key)]
    if len(kinds) != 1:
        raise table.unfit("one of harmonics, points and file", len(kinds))
    if kinds[0] == "file":
        found = _from_file(table, steps, files)
    elif kinds[0] == "harmonics":
        found = _harmonics(table, _steps(table, steps))
    else:
        found = _points(table, _steps(table, steps))
    table.done()
    return found


def _steps(table: TomlTable, steps: int | None) -> FloatArray:
    """t = k/m at the load steps."""
    if steps is None or not 1 <= steps <= MANY:
        found = "none" if steps is None else steps
        raise table.unfit(f"'steps' from 1 to {MANY} at the top of the file", found)
    return np.arange(steps) / steps


def _harmonics(table: TomlTable, t: FloatArray) -> TimeFunction:
    constant, terms = table.number("constant", 0.0) or 0.0, list[tuple[int, float, float]]()
    for term in table.tables("harmonics"):
        order = term.integer("order") if term.has("order") else 1
        if order is None or order < 0:
            raise term.wrong("order", "a whole number from 0", order)
        terms.append((order, term.number("cos", 0.0) or 0.0, term.number("sin", 0.0) or 0.0))
        term.done()

    def at(t: FloatArray) -> FloatArray:
        total = np.full(len(t), constant)
        for order, cos, sin in terms:
            phase = 2 * np.pi * (order * t % 1.0)
            total += cos * np.cos(phase) + sin * np.sin(phase)
        return total

    m, sampled = len(t), at(t)
    highest = max((order for order, *parts in terms if any(parts)), default=0)
    aliases = tuple(
        f"{m} load step(s) do not show its harmonic of order {order}: 'steps' above {2 * order} does"
        for order, cos, sin in terms
        if (cos or sin) and (2 * order > m or (2 * order == m and sin))
    )
    fine = np.linspace(0.0, 1.0, DIRECTIONS * min(highest, MANY // DIRECTIONS) + 1)
    return TimeFunction(sampled, aliases or _missed(sampled, at(fine)))


def _missed(sampled: FloatArray, peaks: FloatArray) -> tuple[str, ...]:
    """A doubt where a function goes further at its ``peaks``, between the load steps, than at them."""
    low, high = peaks.min(), peaks.max()
    share = max(high - sampled.max(), sampled.min() - low) / (high - low) if high > low else 0.0
    if share <= PER_CENT:
        return ()
    return (
        f"its {len(sampled)} load step(s) miss {100 * share:.2g} % of its range: it lies between "
        f"{low:.4g} and {high:.4g}, at the load steps between {sampled.min():.4g} and {sampled.max():.4g}; "
        "more 'steps' show it",
    )


def _sampled(t: FloatArray, times: FloatArray, values: FloatArray, *, whole: bool) -> TimeFunction:
    """Straight lines between values; closed from the last to the first, unless they are ``whole`` periods."""
    found = np.interp(t, times, values, period=None if whole else 1.0)
    return TimeFunction(found, _missed(found, values))


def _points(table: TomlTable, t: FloatArray) -> TimeFunction:
    times, values = np.array(table.array("points", float, (None, 2)), dtype=float).T
    down = np.flatnonzero(np.diff(times) < 0)
    if times.min() < 0 or times.max() > 1 or down.size:
        found = f"t from {times.min():g} to {times.max():g}"
        if down.size:
            found = f"t = {times[down[0] + 1]:g} after {times[down[0]]:g}"
        raise table.unfit("points with 0 <= t <= 1 in ascending order", found)
    return _sampled(t, times, values, whole=times[-1] == 1 and times[0] == 0)


def _from_file(table: TomlTable, steps: int | None, files: InputFiles) -> TimeFunction:
    name, column, time = str(table.text("file")), table.key_of_column("column"), table.key_of_column("time")
    delimiter, decimal = table.text("delimiter", required=False), table.text("decimal", required=False)
    period, scale = table.number("period"), table.number("scale", 1.0) or 0.0
    rows = files.read(name, lambda path: read_table(path, delimiter=delimiter, decimal=decimal))
    width = rows.values.shape[1]
    if column is None and width > 1 + (time is not None):
        names = listed(rows.columns) if rows.columns else f"1 to {width}"
        raise table.unfit(f"the key 'column' (one of {names})", "none")
    if column is None:
        column = 1 if width == 1 or not np.array_equal(rows.column(time or 1), rows.column(1)) else 2
    values = scale * rows.column(column)
    if (time is None) != (period is None):
        found = "'time'" if period is None else "'period'"
        raise table.unfit("the keys 'time' and 'period' together", f"{found} alone")
    if time is None or period is None:
        return TimeFunction(values)
    return _resampled(rows, values, rows.column(time), period, _steps(table, steps))


def _resampled(
    rows: NumberTable, values: FloatArray, times: FloatArray, period: float, t: FloatArray
) -> TimeFunction:
    """Values at the load steps of the period that begins with the first row."""
    down = np.flatnonzero(np.diff(times) < 0)
    # times are printed with few digits
    if not period > 0 or down.size or times[-1] - times[0] > period * (1 + SIX_DIGITS):
        found = f"{times.min():g} to {times.max():g}"
        if down.size:
            found = f"{times[down[0] + 1]:g} after {times[down[0]]:g} in line {rows.lines[down[0] + 1]}"
        raise unfit(rows.name, f"times in ascending order within one period of {period:g}", found)
    passed = (times - times[0]) / period
    sampled, doubts = _sampled(t, passed, values, whole=abs(passed[-1] - 1.0) <= SIX_DIGITS)
    unrecorded = 1.0 - passed[-1]
    if unrecorded > max(_UNRECORDED, 2 * np.diff(passed).max(initial=0.0)):
        doubts += (
            f"its record covers {100 * passed[-1]:.3g} % of the period of {period:g}, and goes straight back "
            "to its beginning for the rest: are 'time' and 'period' in one unit?",
        )
    return TimeFunction(sampled, doubts)
