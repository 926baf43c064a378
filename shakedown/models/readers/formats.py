"""Formats of stiffness files: each is registered at the end of the module that reads it."""

import re
from collections.abc import Callable
from dataclasses import dataclass

from shakedown.models.readers.stiffness import Stiffness


@dataclass(frozen=True)
class Format:
    """A format of stiffness files.

    Attributes
    ----------
    name, title
        What it is called in results and in messages.
    read
        What reads a file of it.
    takes
        Which arguments of :func:`~shakedown.models.readers.sniff.read_stiffness` its reader takes: ``rows``
        (the map), ``matrix``, ``superelement``.
    begins
        Whether the first thousand characters of a file are those of one of it.
    line
        What a line of such a file, any of them, looks like; where it does not begin in its own way.
    """

    name: str
    title: str
    read: Callable[..., Stiffness]
    takes: tuple[str, ...] = ()
    begins: Callable[[str], bool] | None = None
    line: re.Pattern[str] | None = None


FORMATS: list[Format] = []


def register(format: Format) -> None:
    """Make a format known to :func:`~shakedown.models.readers.sniff.read_stiffness`."""
    FORMATS.append(format)
