"""Which format a file has: its content decides, never its name."""

import os
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shakedown.errors import ProblemError
from shakedown.readers.abaqus_matrix import read_abaqus_matrix
from shakedown.readers.abaqus_substructure import read_abaqus_substructure
from shakedown.readers.calculix_reactions import HEADING
from shakedown.readers.calculix_storage import read_calculix_storage
from shakedown.readers.dof_map import read_dof_map
from shakedown.readers.matrix_market import read_matrix_market
from shakedown.readers.nastran_dmig import read_nastran_dmig
from shakedown.readers.nastran_op4 import HEADER, read_nastran_op4
from shakedown.readers.stiffness import Stiffness
from shakedown.readers.text import read_lines

_REAL = r"[-+]?(\d+\.?\d*|\.\d+)([EeDd][-+]?\d+)?"
_LABELLED = re.compile(rf"^\s*-?\d+\s*,\s*\d+\s*,\s*-?\d+\s*,\s*\d+\s*,\s*{_REAL}\s*,?\s*$")
_NUMBERED = re.compile(rf"^\s*\d+\s+\d+\s+{_REAL}\s*$")


def stiffness_format(path: str | os.PathLike[str]) -> str:
    """The format of a stiffness file, from its content.

    Returns
    -------
    str
        One of ``"matrix-market"``, ``"substructure"``, ``"abaqus-matrix"``,
        ``"numbered"`` (CalculiX ``.sti``, Abaqus ``COORDINATE``), ``"dmig"``,
        ``"op4"`` and ``"reactions"``.

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
    lines = [line for line in read_lines(path) if line.strip()]
    if lines[0].lower().startswith("%%matrixmarket"):
        return "matrix-market"
    if HEADER.match(lines[0]):
        return "op4"
    for line in lines:
        if re.match(r"\s*\*USER ELEMENT\b", line, re.IGNORECASE):
            return "substructure"
        if re.match(r"DMIG\b", line, re.IGNORECASE):
            return "dmig"
        if HEADING.match(line):
            return "reactions"
        if not line.lstrip().startswith(("*", "$")):
            if _LABELLED.match(line):
                return "abaqus-matrix"
            if _NUMBERED.match(line):
                return "numbered"
    raise ProblemError(
        f"{os.fspath(path)}: expected a stiffness matrix (Abaqus MATRIX INPUT or substructure, CalculiX .sti "
        f"or reactions, Matrix Market, Nastran DMIG or OP4), found '{lines[0].strip()[:60]}'"
    )


def read_stiffness(
    path: str | os.PathLike[str],
    *,
    dof_map: str | os.PathLike[str] | None = None,
    matrix: str | None = None,
) -> Stiffness:
    """Read a stiffness matrix from a file of any format that carries one.

    Parameters
    ----------
    path
        The file.
    dof_map
        Map file (lines ``node direction``) for the formats that hold none.
    matrix
        Which matrix of a Nastran file.

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
    if dof_map is not None and found not in ("matrix-market", "op4", "numbered"):
        raise ProblemError(
            f"{os.fspath(path)}: expected no map file, because a {found} file has its own labels"
        )
    dofs = None if dof_map is None else read_dof_map(dof_map)
    if matrix is not None and found not in ("dmig", "op4"):
        raise ProblemError(
            f"{os.fspath(path)}: expected no matrix name, because a {found} file holds one matrix"
        )
    return _read(found, path, dofs, matrix)


def _read(
    found: str, path: str | os.PathLike[str], dofs: NDArray[np.intp] | None, matrix: str | None
) -> Stiffness:
    match found:
        case "matrix-market":
            return read_matrix_market(path, dofs)
        case "op4":
            return read_nastran_op4(path, dofs, matrix)
        case "dmig":
            return read_nastran_dmig(path, matrix)
        case "substructure":
            return read_abaqus_substructure(path)
        case "abaqus-matrix":
            return read_abaqus_matrix(path)
        case "numbered":
            return read_calculix_storage(path, dofs)
    raise ProblemError(
        f"{os.fspath(path)}: expected a matrix, found reactions; they make a stiffness only with the list of "
        f"contact nodes that were moved (import {Path(path).name} with a configuration)"
    )
