"""Formats of input files: every module that reads some ends in its ``FORMATS``.

The content of a file decides, never its name: first how it begins, then what is in its lines. The first
format that fits is taken.
"""

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import Any, Literal

from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.parsing import quoted, read_bytes, read_lines, unfit
from shakedown.models.readers.stiffness import Rows, Stiffness

Holds = Literal["stiffness", "mesh", "rows", "vectors"]

OF_MODEL = "(it may be the file of [model])"  # in titles


def has(pattern: re.Pattern[str], mark: str = "") -> Callable[[list[str]], bool]:
    """What says whether any of the lines that have a mark, which is quick to find, begins with a pattern."""
    return lambda lines: any(pattern.match(line) for line in lines if mark in line)


@dataclass(frozen=True)
class Format:
    """A format of files. One that is known neither by its beginning nor by its lines is the last to be taken.

    Attributes
    ----------
    name, title
        What it is called in results and in messages.
    reads
        The reader of each thing that such a file may hold: of a stiffness
        (:class:`~shakedown.models.readers.stiffness.Stiffness`), of a mesh
        (:class:`~shakedown.models.readers.mesh.Mesh`), of the rows of a matrix, (N, 2), by the path and N, or
        of reactions and displacements.
    takes
        Which keywords these readers take: ``rows`` (the map), ``matrix``.
    begins
        Whether the first thousand bytes of a file, one character each, are those of one.
    contains
        Whether the lines of a file that are not blank are those of one.
    """

    name: str
    title: str
    reads: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    takes: tuple[str, ...] = ()
    begins: Callable[[str], object] | None = None
    contains: Callable[[list[str]], object] | None = None


@cache
def formats() -> tuple[Format, ...]:
    """Every format, in the order in which they are asked."""
    # by its lines a deck comes before what it may contain
    names = ("deck", "abaqus", "nastran", "nodal_vectors", "mapped_matrices", "mesh_files")
    modules = (import_module(f"{__package__}.{name}") for name in names)
    return tuple(each for module in modules for each in module.FORMATS)


def recognised(path: str | os.PathLike[str], holds: Holds | None = None) -> Format | None:
    """The first format that a file fits, of those that hold such a thing or of all; None where none does."""
    known = [each for each in formats() if holds is None or holds in each.reads]
    beginning = read_bytes(path, 1000).decode("latin-1")
    for each in known:
        if each.begins is not None and each.begins(beginning):
            return each
    lines = _filled(path)
    return next((each for each in known if each.contains is not None and each.contains(lines)), None)


def _filled(path: str | os.PathLike[str]) -> list[str]:
    """All lines that are not blank; ``ProblemError`` if it is no text."""
    return [line for line in read_lines(path) if line.strip()]


def format_of(path: str | os.PathLike[str], holds: Literal["mesh", "rows", "vectors"]) -> Format:
    """The format of a file that holds such a thing: a list or a table where it fits no other."""
    last = (each for each in formats() if not (each.begins or each.contains) and holds in each.reads)
    return recognised(path, holds) or next(last)


def stiffness_format(path: str | os.PathLike[str]) -> str:
    """The format of a stiffness file, from its content.

    Returns
    -------
    str
        One of ``"matrix-market"``, ``"harwell-boeing"``, ``"substructure"``,
        ``"abaqus-matrix"``, ``"numbered"`` (CalculiX ``.sti``, Abaqus
        ``COORDINATE``), ``"dmig"``, ``"op4"`` and ``"reactions"``.

    Raises
    ------
    ProblemError
        If it is none of these.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "whatever.txt"
    >>> _ = path.write_text("101,1, 101,1, 6.0e+01\\n")
    >>> stiffness_format(path)
    'abaqus-matrix'
    """
    found = recognised(path)
    if found is not None and "stiffness" in found.reads:
        return found.name
    known = ", ".join(sorted({each.title for each in formats() if "stiffness" in each.reads}))
    what = quoted(_filled(path)[0]) if found is None else found.title
    raise unfit(os.fspath(path), f"a stiffness matrix ({known})", what)


def read_stiffness(
    path: str | os.PathLike[str],
    *,
    dof_map: Rows = None,
    matrix: str | None = None,
    format: str | None = None,
) -> Stiffness:
    """Read a stiffness matrix from a file of any format that carries one.

    Parameters
    ----------
    path
        The file.
    dof_map
        The map, for the formats that hold none: a file of any kind that
        :func:`shakedown.models.readers.mapped_matrices.row_map` lists, or its content.
    matrix
        Which matrix of a Nastran file; ``"MASS"`` of an Abaqus substructure.
    format
        What :func:`stiffness_format` has found, where that is known already.

    Raises
    ------
    ProblemError
        If the format is not known, the file is malformed, or a map is missing or superfluous.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "job_STIF1.mtx"
    >>> _ = path.write_text("7,1, 7,1, 2.0e+00\\n7,2, 7,1, 1.0e+00\\n7,2, 7,2, 3.0e+00\\n")
    >>> read_stiffness(path).K.toarray()
    array([[2., 1.],
           [1., 3.]])
    """
    name = stiffness_format(path) if format is None else format
    found = next(each for each in formats() if each.name == name)
    given = {"rows": dof_map, "matrix": matrix}
    for key, what, why in (
        ("rows", "map file", "has its own labels"),
        ("matrix", "matrix name", "holds one matrix"),
    ):
        if given[key] is not None and key not in found.takes:
            raise unfit(os.fspath(path), f"no {what}, because a {name} file {why}", "one")
    return found.reads["stiffness"](path, **{key: given[key] for key in found.takes})


def read_any_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Read a mesh from a file of any format that carries one: a deck, bulk data, a list of nodes ….

    Raises
    ------
    ProblemError
        As the reader of the format raises it.
    """
    return format_of(path, "mesh").reads["mesh"](path)
