"""Which format a file has: its content decides, never its name."""

import os
import re
from pathlib import Path

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.abaqus_matrix import read_abaqus_matrix
from shakedown.models.readers.abaqus_substructure import read_abaqus_substructure
from shakedown.models.readers.calculix_reactions import HEADINGS
from shakedown.models.readers.calculix_storage import read_calculix_storage
from shakedown.models.readers.deck import is_deck
from shakedown.models.readers.harwell_boeing import is_harwell_boeing, read_harwell_boeing
from shakedown.models.readers.matrix_market import read_matrix_market
from shakedown.models.readers.nastran_bulk import is_bulk_data
from shakedown.models.readers.nastran_dmig import read_nastran_dmig
from shakedown.models.readers.nastran_op4 import is_op4, read_nastran_op4
from shakedown.models.readers.reactions_table import is_reactions_table
from shakedown.models.readers.row_map import Rows
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.text import open_regular, quoted, read_lines

_REAL = r"[-+]?(\d+\.?\d*|\.\d+)([EeDd][-+]?\d+)?"
_LABELLED = re.compile(rf"^\s*-?\d+\s*,\s*\d+\s*,\s*-?\d+\s*,\s*\d+\s*,\s*{_REAL}\s*,?\s*$")
_NUMBERED = re.compile(rf"^\s*\d+\s+\d+\s+{_REAL}\s*$")
_MAPPED = ("matrix-market", "op4", "numbered", "harwell-boeing")  # formats without labels of their own


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
    if is_op4(_beginning(path)):
        return "op4"
    lines = [line for line in read_lines(path) if line.strip()]
    if lines[0].lower().startswith("%%matrixmarket"):
        return "matrix-market"
    if is_harwell_boeing(lines):
        return "harwell-boeing"
    if is_reactions_table(lines):
        return "reactions"
    for line in [] if is_deck(lines) else lines:
        if re.match(r"\s*\*USER ELEMENT\b", line, re.IGNORECASE):
            return "substructure"
        if re.match(r"DMIG\b", line, re.IGNORECASE):
            return "dmig"
        if HEADINGS["reactions"].match(line):
            return "reactions"
        if line.lstrip().startswith(("*", "$")):
            continue
        if _LABELLED.match(line):
            return "abaqus-matrix"
        if _NUMBERED.match(line) and not is_bulk_data(lines[:1000]):
            return "numbered"
    what = quoted(lines[0])
    if is_bulk_data(lines):
        what = "Nastran bulk data without a DMIG matrix (it may be the 'map' of an OUTPUT4 file)"
    elif is_deck(lines):
        what = "an input deck (it may be the 'map' of a matrix, or the file of [model])"
    raise ProblemError(
        f"{os.fspath(path)}: expected a stiffness matrix (Abaqus MATRIX INPUT, COORDINATE or substructure, "
        f"CalculiX .sti, reactions, Matrix Market, Harwell-Boeing, Nastran DMIG or OUTPUT4), found {what}"
    )


def _beginning(path: str | os.PathLike[str]) -> bytes:
    open_regular(path)
    try:
        with open(path, "rb") as file:
            return file.read(256)
    except OSError as error:
        raise ProblemError(f"{os.fspath(path)}: cannot be read ({error.strerror})") from None


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
    found = stiffness_format(path)
    if dof_map is not None and found not in _MAPPED:
        raise ProblemError(
            f"{os.fspath(path)}: expected no map file, because a {found} file has its own labels"
        )
    if matrix is not None and found not in ("dmig", "op4"):
        raise ProblemError(
            f"{os.fspath(path)}: expected no matrix name, because a {found} file holds one matrix, found "
            f"{quoted(matrix)}"
        )
    if superelement is not None and found not in ("dmig", "op4"):
        raise ProblemError(
            f"{os.fspath(path)}: expected no superelement, because a {found} file is not Nastran's, found "
            f"{superelement}"
        )
    if found == "dmig":
        return read_nastran_dmig(path, matrix, superelement)
    return _read(found, path, dof_map, matrix)


def _read(found: str, path: str | os.PathLike[str], rows: Rows, matrix: str | None) -> Stiffness:
    match found:
        case "matrix-market":
            return read_matrix_market(path, rows)
        case "harwell-boeing":
            return read_harwell_boeing(path, rows)
        case "op4":
            return read_nastran_op4(path, rows, matrix)
        case "substructure":
            return read_abaqus_substructure(path)
        case "abaqus-matrix":
            return read_abaqus_matrix(path)
        case "numbered":
            return read_calculix_storage(path, rows)
    raise ProblemError(
        f"{os.fspath(path)}: expected a matrix, found reactions; they make a stiffness only with the list of "
        f"contact nodes that were moved (import {Path(path).name} with a configuration)"
    )
