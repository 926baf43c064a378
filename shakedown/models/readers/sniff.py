"""Which format a file has: its content decides, never its name."""

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.abaqus_matrix import read_abaqus_matrix
from shakedown.models.readers.abaqus_substructure import read_abaqus_substructure
from shakedown.models.readers.calculix_frd import is_frd
from shakedown.models.readers.calculix_reactions import HEADINGS
from shakedown.models.readers.calculix_storage import read_calculix_storage
from shakedown.models.readers.deck import is_deck
from shakedown.models.readers.harwell_boeing import is_harwell_boeing, read_harwell_boeing
from shakedown.models.readers.matrix_market import is_matrix_market, read_matrix_market
from shakedown.models.readers.nastran_bulk import is_bulk_data
from shakedown.models.readers.nastran_dmig import read_nastran_dmig
from shakedown.models.readers.nastran_op4 import is_op4, read_nastran_op4
from shakedown.models.readers.reactions_table import is_reactions_table
from shakedown.models.readers.row_map import Rows
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.text import LOOKED_AT, quoted, read_bytes, read_lines

_REAL = r"[-+]?(\d+\.?\d*|\.\d+)([EeDd][-+]?\d+)?"
_LABELLED = re.compile(rf"^\s*-?\d+\s*,\s*\d+\s*,\s*-?\d+\s*,\s*\d+\s*,\s*{_REAL}\s*,?\s*$")
_NUMBERED = re.compile(rf"^\s*\d+\s+\d+\s+{_REAL}\s*$")
_ELEMENT = re.compile(r"\s*\*USER ELEMENT\b", re.IGNORECASE)
_DMIG = re.compile(r"DMIG\b", re.IGNORECASE)


@dataclass(frozen=True)
class Format:
    """A format of stiffness files; a new one is an entry of ``FORMATS``.

    Attributes
    ----------
    name, title
        What it is called in results and in messages.
    read
        What reads a file of it.
    takes
        Which arguments of :func:`read_stiffness` its reader takes: ``rows`` (the map), ``matrix``,
        ``superelement``.
    by_bytes, by_lines, by_line
        How it is recognised: by the first bytes of a file, by all lines that are not blank, or by any one
        line.
    unless
        Whether a file with such a line is of another kind, from its first lines.
    """

    name: str
    title: str
    read: Callable[..., Stiffness]
    takes: tuple[str, ...] = ()
    by_bytes: Callable[[bytes], bool] | None = None
    by_lines: Callable[[list[str]], bool] | None = None
    by_line: re.Pattern[str] | None = None
    unless: Callable[[list[str]], bool] | None = None

    def has(self, line: str, lines: list[str]) -> bool:
        """Whether a line of a file is one of this format."""
        known = self.by_line is not None and self.by_line.match(line)
        return bool(known) and not (self.unless is not None and self.unless(lines[:LOOKED_AT]))


def _refuse(path: str | os.PathLike[str]) -> Stiffness:
    raise ProblemError(
        f"{os.fspath(path)}: expected a matrix, found reactions; they make a stiffness only with the list of "
        f"contact nodes that were moved (import {Path(path).name} with a configuration)"
    )


FORMATS = (  # in the order in which they are tried
    Format("op4", "Nastran OUTPUT4", read_nastran_op4, ("rows", "matrix"), by_bytes=is_op4),
    Format("matrix-market", "Matrix Market", read_matrix_market, ("rows",), by_lines=is_matrix_market),
    Format("harwell-boeing", "Harwell-Boeing", read_harwell_boeing, ("rows",), by_lines=is_harwell_boeing),
    Format("reactions", "reactions", _refuse, by_lines=is_reactions_table, by_line=HEADINGS["reactions"]),
    Format("substructure", "Abaqus substructure", read_abaqus_substructure, by_line=_ELEMENT),
    Format("dmig", "Nastran DMIG", read_nastran_dmig, ("matrix", "superelement"), by_line=_DMIG),
    Format("abaqus-matrix", "Abaqus MATRIX INPUT", read_abaqus_matrix, by_line=_LABELLED),
    Format(
        "numbered", "Abaqus COORDINATE, CalculiX .sti", read_calculix_storage, ("rows",),
        by_line=_NUMBERED, unless=is_bulk_data,
    ),
)  # fmt: skip


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
    first = read_bytes(path, 256)
    for each in FORMATS:
        if each.by_bytes is not None and each.by_bytes(first):
            return each.name
    if is_frd([first.decode("latin-1")]):
        raise ProblemError(
            f"{os.fspath(path)}: expected a stiffness matrix, found the results of a CalculiX run (.frd); "
            "they are of a load: its key 'open', 'reactions' or 'thermal'"
        )
    lines = [line for line in read_lines(path) if line.strip()]
    for each in FORMATS:
        if each.by_lines is not None and each.by_lines(lines):
            return each.name
    for line in [] if is_deck(lines) else lines:
        for each in FORMATS:
            if each.has(line, lines):
                return each.name
    what = quoted(lines[0])
    if is_bulk_data(lines):
        what = "Nastran bulk data without a DMIG matrix (it may be the 'map' of an OUTPUT4 file)"
    elif is_deck(lines):
        what = "an input deck (it may be the 'map' of a matrix, or the file of [model])"
    raise ProblemError(
        f"{os.fspath(path)}: expected a stiffness matrix ({', '.join(each.title for each in FORMATS)}), "
        f"found {what}"
    )


def read_stiffness(
    path: str | os.PathLike[str],
    *,
    dof_map: Rows = None,
    matrix: str | None = None,
    superelement: int | None = None,
) -> Stiffness:
    """Read a stiffness matrix from a file of any format that carries one.

    Parameters
    ----------
    path
        The file.
    dof_map
        The map, for the formats that hold none: a file of any kind that
        :func:`shakedown.models.readers.row_map.row_map` lists, or its content.
    matrix
        Which matrix of a Nastran file.
    superelement
        Which superelement of a Nastran punch file that holds several.

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
    name = stiffness_format(path)
    found = next(each for each in FORMATS if each.name == name)
    asked = {"rows": dof_map, "matrix": matrix, "superelement": superelement}
    if dof_map is not None and "rows" not in found.takes:
        raise ProblemError(
            f"{os.fspath(path)}: expected no map file, because a {name} file has its own labels"
        )
    if matrix is not None and "matrix" not in found.takes:
        raise ProblemError(
            f"{os.fspath(path)}: expected no matrix name, because a {name} file holds one matrix, found "
            f"{quoted(matrix)}"
        )
    if superelement is not None and "matrix" not in found.takes:
        raise ProblemError(
            f"{os.fspath(path)}: expected no superelement, because a {name} file is not Nastran's, found "
            f"{superelement}"
        )
    return found.read(path, **{word: asked[word] for word in found.takes})
