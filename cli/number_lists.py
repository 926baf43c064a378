"""Numbers on the command line: a list, or a range LOW:HIGH:COUNT."""

from __future__ import annotations

from math import isfinite
from typing import Any

import click
import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.visible_text import shortened

FORM = "LOW:HIGH:COUNT or VALUE,VALUE,…"
MOST = 1_000_000  # values of a range


def numbers_of(text: str) -> FloatArray | None:
    """The values of ``LOW:HIGH:COUNT``, which rise, or of ``VALUE,VALUE,…``; None where a text is neither."""
    try:
        if ":" not in text:
            values = np.array([float(part) for part in text.split(",")])
            return values if np.isfinite(values).all() else None
        first, last, many = text.split(":")
        low, high, count = float(first), float(last), int(many)
    except ValueError:
        return None
    if not (isfinite(high - low) and low < high and 2 <= count <= MOST):
        return None
    return np.linspace(low, high, count)


class NumberList(click.ParamType):
    """Numbers, as a list or a range."""

    name = "numbers"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        values = numbers_of(value)
        if values is None:
            option = "" if param is None else param.opts[0]
            raise click.UsageError(f"{option}: expected {FORM}, found '{shortened(value, 40)}'")
        return values


class Vary(click.ParamType):
    """A parameter with its values: NAME=LOW:HIGH:COUNT, or NAME=VALUE,VALUE,…"""

    name = "parameter"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        name, _, text = value.partition("=")
        values = numbers_of(text)
        if not name.strip() or values is None:
            raise click.UsageError(
                f"--vary: expected NAME= and {FORM}, rising, at most {MOST:,}, found '{shortened(value, 60)}'"
            )
        return name.strip(), values
