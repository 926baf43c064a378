"""Which format a file has: its content decides, never its name."""

import os

from shakedown.ground.errors import ProblemError
from shakedown.models.readers import (  # noqa: F401  (each registers its format)
    abaqus_matrix,
    abaqus_substructure,
    calculix_storage,
    harwell_boeing,
    matrix_market,
    nastran_dmig,
    nastran_op4,
    reactions_table,
)
from shakedown.models.readers.calculix_frd import is_frd
from shakedown.models.readers.deck import is_deck
from shakedown.models.readers.formats import FORMATS
from shakedown.models.readers.nastran_bulk import is_bulk_data
from shakedown.models.readers.row_map import Rows
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.text import LOOKED_AT, quoted, read_bytes, read_lines

_BEGINNING = 1000  # bytes


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
    beginning = read_bytes(path, _BEGINNING).decode("latin-1")
    for each in FORMATS:
        if each.begins is not None and each.begins(beginning):
            return each.name
    if is_frd(beginning):
        raise ProblemError(
            f"{os.fspath(path)}: expected a stiffness matrix, found the results of a CalculiX run (.frd); "
            "they are of a load: its key 'open', 'reactions' or 'thermal'"
        )
    lines = [line for line in read_lines(path) if line.strip()]
    bulk = is_bulk_data(lines[:LOOKED_AT])  # whose continuations look like numbered entries
    known = [each for each in FORMATS if each.line and not (bulk and each.name == "numbered")]
    deck = is_deck(lines)
    for line in [] if deck else lines:
        for each in known:
            if each.line and each.line.match(line):
                return each.name
    what = quoted(lines[0])
    if is_bulk_data(lines):
        what = "Nastran bulk data without a DMIG matrix (it may be the 'map' of an OUTPUT4 file)"
    elif deck:
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
    format: str | None = None,
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
    found = next(each for each in FORMATS if each.name == name)
    asked = {"rows": dof_map, "matrix": matrix, "superelement": superelement}
    nastran = "matrix" in found.takes
    for key, known, expected in (
        ("rows", "rows" in found.takes, f"no map file, because a {name} file has its own labels"),
        ("matrix", nastran, f"no matrix name, because a {name} file holds one matrix"),
        ("superelement", nastran, f"no superelement, because a {name} file is not Nastran's"),
    ):
        if asked[key] is not None and not known:
            given = "one" if key == "rows" else quoted(str(asked[key]))
            raise ProblemError(f"{os.fspath(path)}: expected {expected}, found {given}")
    return found.read(path, **{word: asked[word] for word in found.takes})
