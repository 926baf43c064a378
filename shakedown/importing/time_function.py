"""Time functions of load cases as a configuration states them."""

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.readers.input_files import InputFiles
from shakedown.readers.table import NumberTable, read_table
from shakedown.readers.text import listed
from shakedown.readers.toml_table import Table

MOST_STEPS = 1_000_000  # load steps of one period
_ROUNDED = 1e-6  # of a period: times are printed with few digits


def time_function(table: Table, steps: int | None, files: InputFiles) -> FloatArray:
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

    Returns
    -------
    () or (m,)

    Raises
    ------
    ProblemError
        If the key is missing or malformed, or a function is given without the
        number of steps.

    Examples
    --------
    >>> from pathlib import Path
    >>> load = Table({"history": {"constant": 1.0, "harmonics": [{"order": 1, "sin": 0.5}]}}, "load 1")
    >>> time_function(load, 4, InputFiles(Path(".")))
    array([1. , 1.5, 1. , 0.5])
    """
    if isinstance(table.content.get("history"), dict):
        return _function(table.table("history"), steps, files)
    value = table.take("history", "a number, a list or a table", required=True)
    if isinstance(value, list):
        table.content["history"] = value
        return np.array(table.array("history", float, (None,)), dtype=float)
    table.content["history"] = value
    return np.array(table.number("history"))


def _function(table: Table, steps: int | None, files: InputFiles) -> FloatArray:
    kinds = [key for key in ("harmonics", "points", "file") if table.has(key)]
    if len(kinds) != 1:
        raise ProblemError(f"{table.where}: expected one of harmonics, points and file, found {len(kinds)}")
    if kinds[0] == "file":
        values = _from_file(table, steps, files)
    elif kinds[0] == "harmonics":
        values = _harmonics(table, _steps(table, steps))
    else:
        values = _points(table, _steps(table, steps))
    table.done()
    return values


def _steps(table: Table, steps: int | None) -> FloatArray:
    """t = k/m at the load steps."""
    if steps is None or not 1 <= steps <= MOST_STEPS:
        raise ProblemError(
            f"{table.where}: expected 'steps' from 1 to {MOST_STEPS} at the top of the file, found "
            f"{'none' if steps is None else steps}"
        )
    return np.arange(steps) / steps


def _harmonics(table: Table, t: FloatArray) -> FloatArray:
    total = np.full(len(t), table.number("constant", 0.0))
    for term in table.tables("harmonics"):
        order = term.integer("order") if term.has("order") else 1
        if order is None or order < 0:
            raise ProblemError(f"{term.where}: key 'order': expected a whole number from 0, found {order}")
        phase = 2 * np.pi * (order * t % 1.0)
        total += (term.number("cos", 0.0) or 0.0) * np.cos(phase)
        total += (term.number("sin", 0.0) or 0.0) * np.sin(phase)
        term.done()
    return total


def _points(table: Table, t: FloatArray) -> FloatArray:
    points = np.array(table.array("points", float, (None, 2)), dtype=float)
    times = points[:, 0]
    down = np.flatnonzero(np.diff(times) < 0)
    if times.min() < 0 or times.max() > 1 or down.size:
        found = f"t from {times.min():g} to {times.max():g}"
        if down.size:
            found = f"t = {times[down[0] + 1]:g} after {times[down[0]]:g}"
        raise ProblemError(
            f"{table.where}: expected points with 0 <= t <= 1 in ascending order, found {found}"
        )
    return np.interp(t, times, points[:, 1], period=None if times[-1] == 1 and times[0] == 0 else 1.0)


def _from_file(table: Table, steps: int | None, files: InputFiles) -> FloatArray:
    name, column, time = str(table.text("file")), table.key_of_column("column"), table.key_of_column("time")
    delimiter, decimal = table.text("delimiter", required=False), table.text("decimal", required=False)
    period, scale = table.number("period"), table.number("scale", 1.0) or 0.0
    rows = files.read(name, lambda path: read_table(path, delimiter=delimiter, decimal=decimal))
    width = rows.values.shape[1]
    if column is None and width > 1 + (time is not None):
        names = listed(rows.columns) if rows.columns else f"1 to {width}"
        raise ProblemError(f"{table.where}: expected the key 'column' (one of {names}), found none")
    if column is None:
        column = 1 if width == 1 or not np.array_equal(rows.column(time or 1), rows.column(1)) else 2
    values = scale * rows.column(column)
    if (time is None) != (period is None):
        found = "'time'" if period is None else "'period'"
        raise ProblemError(
            f"{table.where}: expected the keys 'time' and 'period' together, found {found} alone"
        )
    if time is None or period is None:
        return values
    return _resampled(rows, values, rows.column(time), period, _steps(table, steps))


def _resampled(
    rows: NumberTable, values: FloatArray, times: FloatArray, period: float, t: FloatArray
) -> FloatArray:
    """Values at the load steps of the period that begins with the first row."""
    down = np.flatnonzero(np.diff(times) < 0)
    if not period > 0 or down.size or times[-1] - times[0] > period * (1 + _ROUNDED):
        found = f"{times.min():g} to {times.max():g}"
        if down.size:
            found = f"{times[down[0] + 1]:g} after {times[down[0]]:g} in line {rows.lines[down[0] + 1]}"
        raise ProblemError(
            f"{rows.name}: expected times in ascending order within one period of {period:g}, found {found}"
        )
    passed = (times - times[0]) / period
    whole = abs(passed[-1] - 1.0) <= _ROUNDED
    return np.interp(t, passed, values, period=None if whole else 1.0)
