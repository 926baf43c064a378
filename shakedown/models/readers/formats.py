"""Formats of stiffness files: each is registered at the end of the module that reads it."""

import re
from collections.abc import Callable
from dataclasses import dataclass

from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.text import LOOKED_AT


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
    unless
        Whether a file with such a line is of another kind, from its first lines.
    """

    name: str
    title: str
    read: Callable[..., Stiffness]
    takes: tuple[str, ...] = ()
    begins: Callable[[str], bool] | None = None
    line: re.Pattern[str] | None = None
    unless: Callable[[list[str]], bool] | None = None

    def has(self, line: str, lines: list[str]) -> bool:
        """Whether a line of a file is one of this format."""
        known = self.line is not None and self.line.match(line)
        return bool(known) and not (self.unless is not None and self.unless(lines[:LOOKED_AT]))


FORMATS: list[Format] = []


def register(format: Format) -> None:
    """Make a format known to :func:`~shakedown.models.readers.sniff.read_stiffness`."""
    FORMATS.append(format)
