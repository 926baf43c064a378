"""Stiffness matrices and meshes of any format: the content of a file decides, never its name."""

import os

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.formats import Content, format_of, formats, recognised
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.row_map import Rows
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.text import quoted


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
    what = quoted(Content(path).lines[0]) if found is None else found.title
    raise ProblemError(f"{os.fspath(path)}: expected a stiffness matrix ({known}), found {what}")


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
    found = next(each for each in formats() if each.name == name)
    given = {"rows": dof_map, "matrix": matrix, "superelement": superelement}
    for key, own, what, why in (
        ("rows", "rows", "map file", "has its own labels"),
        ("matrix", "matrix", "matrix name", "holds one matrix"),
        ("superelement", "matrix", "superelement", "is not Nastran's"),
    ):
        if given[key] is not None and own not in found.takes:
            raise ProblemError(
                f"{os.fspath(path)}: expected no {what}, because a {name} file {why}, found one"
            )
    return found.reads["stiffness"](path, **{key: given[key] for key in found.takes})


def read_any_mesh(path: str | os.PathLike[str], superelement: int | None = None) -> Mesh:
    """Read a mesh from a file of any format that carries one: a deck, bulk data, a list of nodes ….

    ``superelement`` picks one of a Nastran file with several.

    Raises
    ------
    ProblemError
        As the reader of the format raises it.
    """
    found = format_of(path, "mesh")
    return found.reads["mesh"](path, **dict.fromkeys(found.takes, superelement))
