"""Time functions of load cases as a configuration states them."""

from pathlib import Path
from typing import Any

import numpy as np

from shakedown.errors import ProblemError
from shakedown.importing.toml_table import Table
from shakedown.model.problem import FloatArray
from shakedown.readers.text import numbers, read_lines

MOST_STEPS = 1_000_000  # load steps of one period


def time_function(table: Table, steps: int | None, folder: Path) -> FloatArray:
    """The key ``history`` of a load, at the load steps t = k/m of one period.

    A number is a constant; a list holds the factors themselves; a table holds

    - ``constant`` and ``harmonics`` = [{order, cos, sin}, …]: constant +
      Σ cos · cos 2π order t + sin · sin 2π order t;
    - or ``points`` = [[t, factor], …], 0 ≤ t ≤ 1, straight lines between, closed
      from the last to the first;
    - or ``file`` (and ``column``, from 1): text with one line per load step.

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
    >>> load = Table({"history": {"constant": 1.0, "harmonics": [{"order": 1, "sin": 0.5}]}}, "load 1")
    >>> time_function(load, 4, Path("."))
    array([1. , 1.5, 1. , 0.5])
    """
    if isinstance(table.content.get("history"), dict):
        return _function(table.table("history"), steps, folder)
    value = table.take("history", "a number, a list or a table", required=True)
    if isinstance(value, list):
        table.content["history"] = value
        return np.array(table.array("history", float, (None,)), dtype=float)
    table.content["history"] = value
    return np.array(table.number("history"))


def _function(table: Table, steps: int | None, folder: Path) -> FloatArray:
    kinds = [key for key in ("harmonics", "points", "file") if table.has(key)]
    if len(kinds) != 1:
        raise ProblemError(f"{table.where}: expected one of harmonics, points and file, found {len(kinds)}")
    if kinds[0] == "file":
        values = _column(table, folder)
    else:
        if steps is None or not 1 <= steps <= MOST_STEPS:
            raise ProblemError(
                f"{table.where}: expected 'steps' from 1 to {MOST_STEPS} at the top of the file, "
                f"found {steps}"
            )
        t = np.arange(steps) / steps
        values = _harmonics(table, t) if kinds[0] == "harmonics" else _points(table, t)
    table.done()
    return values


def _harmonics(table: Table, t: FloatArray) -> FloatArray:
    total = np.full(len(t), table.number("constant", 0.0))
    for term in table.tables("harmonics"):
        order = term.number("order", 1.0)
        phase = 2 * np.pi * (order or 0.0) * t
        total += (term.number("cos", 0.0) or 0.0) * np.cos(phase)
        total += (term.number("sin", 0.0) or 0.0) * np.sin(phase)
        term.done()
    return total


def _points(table: Table, t: FloatArray) -> FloatArray:
    points = np.array(table.array("points", float, (None, 2)), dtype=float)
    times = points[:, 0]
    if times.min() < 0 or times.max() > 1 or np.any(np.diff(times) < 0):
        raise ProblemError(
            f"{table.where}: expected points with 0 <= t <= 1 in ascending order, found {times}"
        )
    return np.interp(t, times, points[:, 1], period=None if times[-1] == 1 and times[0] == 0 else 1.0)


def _column(table: Table, folder: Path) -> FloatArray:
    path = folder / str(table.text("file"))
    column = table.integer("column") or 1
    values: list[Any] = []
    for k, line in enumerate(read_lines(path), start=1):
        text = line.split("#")[0].replace(",", " ").split()
        if not text:
            continue
        if len(text) < column:
            raise ProblemError(f"{path}: line {k}: expected at least {column} columns, found {len(text)}")
        values += numbers([text[column - 1]], f"{path}: line {k}")
    return np.array(values)
