"""Formats of input files: every module that reads one ends in its ``FORMATS``.

The content of a file decides, never its name: formats are asked in the order of :data:`MODULES`, and the
first that fits is taken.
"""

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from importlib import import_module
from typing import Any, Literal

from shakedown.models.readers.text import read_bytes, read_lines

Holds = Literal["stiffness", "mesh", "rows", "vectors"]

_BEGINNING = 1000  # bytes
OF_MODEL = "(it may be the file of [model])"  # in titles
# Formats that are known by how a file begins come first; then a deck, before what it may contain; then those
# of large matrices, which their first line settles.
MODULES = (
    "matrix_market",
    "harwell_boeing",
    "nastran_op4",
    "calculix_frd",
    "mesh_files",
    "row_map",
    "deck",
    "abaqus_substructure",
    "calculix_storage",
    "abaqus_matrix",
    "nastran_dmig",
    "nastran_bulk",
    "ansys_archive",
    "calculix_reactions",
    "reactions_table",
    "coordinates",
)


class Content:
    """What a file holds, read as far as it is asked for."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = path

    @cached_property
    def beginning(self) -> str:
        """The first thousand bytes, one character each."""
        return read_bytes(self.path, _BEGINNING).decode("latin-1")

    @cached_property
    def lines(self) -> list[str]:
        """All lines that are not blank; ``ProblemError`` if it is no text."""
        return [line for line in read_lines(self.path) if line.strip()]

    @cached_property
    def first(self) -> str:
        """The first line that is neither a keyword nor a remark."""
        return next((line for line in self.lines if line.lstrip()[0] not in "*#%$!"), "")


def begins(fits: Callable[[str], object]) -> Callable[[Content], object]:
    """What says whether the beginning of a file is of some kind."""
    return lambda content: fits(content.beginning)


def has(pattern: re.Pattern[str], mark: str = "") -> Callable[[Content], bool]:
    """What says whether any line of a file that has a mark, which is quick to find, begins with a pattern."""
    return lambda content: any(pattern.match(line) for line in content.lines if mark in line)


@dataclass(frozen=True)
class Format:
    """A format of files.

    Attributes
    ----------
    name, title
        What it is called in results and in messages.
    fits
        Whether a file is one of it; None where a file is taken for one if it is nothing else.
    reads
        The reader of each thing that such a file may hold: of a stiffness
        (:class:`~shakedown.models.readers.stiffness.Stiffness`), of a mesh
        (:class:`~shakedown.models.readers.mesh.Mesh`), of the rows of a matrix, (N, 2), by the path and N, or
        of reactions and displacements.
    takes
        Which keywords these readers take: ``rows`` (the map), ``matrix``, ``superelement``.
    """

    name: str
    title: str
    fits: Callable[[Content], object] | None
    reads: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    takes: tuple[str, ...] = ()


@cache
def formats() -> tuple[Format, ...]:
    """Every format, in the order in which they are asked."""
    modules = (import_module(f"{__package__}.{name}") for name in MODULES)
    return tuple(each for module in modules for each in module.FORMATS)


def recognised(path: str | os.PathLike[str], holds: Holds | None = None) -> Format | None:
    """The first format that a file fits, of those that hold such a thing or of all; None where none does."""
    content = Content(path)
    known = (each for each in formats() if holds is None or holds in each.reads)
    return next((each for each in known if each.fits is not None and each.fits(content)), None)


def format_of(path: str | os.PathLike[str], holds: Literal["mesh", "rows", "vectors"]) -> Format:
    """The format of a file that holds such a thing: a list or a table where it fits no other."""
    last = (each for each in formats() if each.fits is None and holds in each.reads)
    return recognised(path, holds) or next(last)
