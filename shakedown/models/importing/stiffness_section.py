"""``[stiffness]``: the matrix with its map, or from unit displacements, in the directions of the model.

Of an axisymmetric model a matrix may stand for a part of the circumference. CalculiX turns axisymmetric
elements into a wedge of 2 degrees. The matrices that it stores are those of the wedge, ``*CLOAD`` is the
force on the whole circumference, of which it applies 1/180, and the reactions that it prints are those of the
wedge without what the stress around the circumference carries. Abaqus takes and writes everything for the
whole circumference.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from shakedown.ground.constants import MINOR, FloatArray, IntArray
from shakedown.ground.errors import ProblemError, found_in
from shakedown.joint.fields import COARSEST
from shakedown.models.importing.contact_section import ContactSection
from shakedown.models.readers import nastran
from shakedown.models.readers.abaqus import ABAQUS_MATRIX
from shakedown.models.readers.formats import read_stiffness, stiffness_format
from shakedown.models.readers.mapped_matrices import NUMBERED
from shakedown.models.readers.mesh import ABAQUS, CALCULIX, Mesh
from shakedown.models.readers.nodal_vectors import read_nodal_vectors, unit_displacement_stiffness
from shakedown.models.readers.parsing import InputFiles, read_lines, unfit
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.toml_table import TomlTable, Values

HOOP = (
    "CalculiX prints the forces of a wedge of 2 degrees, and of the radial ones not what the stress around "
    "the circumference carries"
)


def _circumference(mesh: Mesh, format: str, scale: float | None, where: str) -> float | None:
    """By how much a matrix of an axisymmetric model is multiplied to stand for the whole circumference.

    180 for the ``.sti`` file of a deck with ``SOLVER=MATRIXSTORAGE`` (CalculiX), 1 for what Abaqus writes;
    None where neither deck nor format tells it, as ``scale`` must.
    """
    if not mesh.axisymmetric:
        return 1.0
    by_code = {CALCULIX: 180.0, ABAQUS: 1.0}.get(mesh.matrix_by) if format == NUMBERED else None
    factor = 1.0 if format == ABAQUS_MATRIX else by_code
    if factor is None and scale is None:
        expected = (
            "360 over the degrees that the matrix of an axisymmetric model stands for: 180 from CalculiX, "
            "1 else"
        )
        raise unfit(f"{where}: key 'scale'", expected, "none")
    if factor == 180 and scale is not None and abs(scale / factor - 1) < MINOR:
        raise ProblemError(
            f"{where}: key 'scale': expected no factor for the circumference, which is taken from the deck "
            f"({factor:g}), found {scale:g}; leave it out"
        )
    return factor


def circumference_notes(stiffness: Stiffness, mesh: Mesh) -> Iterator[str]:
    """What a user should know of the import of an axisymmetric model."""
    if mesh.axisymmetric:
        times = stiffness.circumference
        yield (
            f"axisymmetric: the matrix is that of {360 / times:g} degrees, taken {times:g} times; forces and "
            "reactions are those on the whole circumference, areas 2 pi r times a length"
        )


@dataclass(frozen=True)
class ImportContext:
    """What all loads need: the stiffness with its rows, the contact, the model and the files."""

    stiffness: Stiffness
    contact: ContactSection
    mesh: Mesh
    files: InputFiles
    steps: int | None
    checked: bool = False  # whether [check] names a run that the reactions of others can rely on

    def rows(self, where: str, values: Values) -> IntArray:
        """Rows of (node, direction) pairs."""
        with found_in(where):
            return self.stiffness.rows(list(values))


def stiffness_section(table: TomlTable, contact: ContactSection, mesh: Mesh, files: InputFiles) -> Stiffness:
    """Read the section.

    Raises
    ------
    ProblemError
        If it is malformed or a file cannot be read.
    """
    name, map_name = str(table.text("file")), table.text("map", required=False)
    matrix, scale = table.text("matrix", required=False), table.number("scale")
    accuracy = table.number("accuracy")
    table.done()
    if scale is not None and not scale > 0:
        raise table.wrong("scale", "a number > 0", f"{scale:g}")
    if accuracy is not None and not 0 < accuracy <= COARSEST:
        raise table.wrong("accuracy", f"a number above 0 and up to {COARSEST:g}", f"{accuracy:g}")
    where = table.at("file")
    found = files.read(name, stiffness_format, where)
    if found == "reactions":
        read = partial(_unit_displacements, contact, mesh.axisymmetric)
        stiffness = files.read(name, read, where)
    else:
        # maps that codes write beside the matrix
        for suffix in {"numbered": (".dof",), "op4": (".pch", ".asm")}.get(found, ()):
            beside = str(Path(name).with_suffix(suffix))
            if map_name is None and beside != name and files.path(beside).is_file():
                map_name = beside
        read = partial(read_stiffness, format=found, matrix=matrix)
        stiffness = _matrix(name, map_name, read, mesh, files, table)
        _check_whole(stiffness, map_name, str(files.path(name)))
    factor = _circumference(mesh, stiffness.format, scale, table.where)
    return replace(
        stiffness,
        K=(scale or 1.0) * (factor or 1.0) * stiffness.K,
        dofs=_with_internal_nodes(stiffness.dofs, mesh, table.where),
        circumference=factor or scale or 1.0,
        accuracy=stiffness.accuracy if accuracy is None else accuracy,
    )


def _with_internal_nodes(dofs: IntArray, mesh: Mesh, where: str) -> IntArray:
    """The rows, those that are no displacements as internal nodes: bolts' sections, incompatible modes."""
    if mesh.sections and mesh.matrix_by != CALCULIX:
        raise ProblemError(
            f"{where}: expected a *PRE-TENSION SECTION in decks of CalculiX only, found one of "
            f"{mesh.matrix_by or 'another code'}, whose matrix is not known to have it; leave the bolt "
            "out of the model and say [[bolt]] with 'head', 'nut' and 'stiffness'"
        )
    internal = list(mesh.sections)
    if mesh.incompatible and mesh.matrix_by == CALCULIX:
        unknown = np.setdiff1d(dofs[:, 0], mesh.labels)
        # CalculiX makes three nodes for the incompatible modes of an element C3D8I
        if len(unknown) == 3 * mesh.incompatible and unknown.min() > mesh.labels.max():
            internal += unknown.tolist()
    return np.where(np.isin(dofs[:, 0], internal)[:, None] & [True, False], -dofs, dofs)


def _check_whole(stiffness: Stiffness, map_name: str | None, where: str) -> None:
    """Refuse the matrix of a file that was cut off: rows without their diagonal, or without any entry.

    Internal nodes (multipliers) may have zeros on the diagonal. CalculiX names in its ``.dof``
    file only rows that have entries; other maps may name more.
    """
    K, dofs = stiffness.K, stiffness.dofs
    coupled = abs(K).sum(axis=1) > 0
    lacking = (K.diagonal() == 0) & coupled & (dofs[:, 0] > 0) & np.isin(dofs[:, 1], (1, 2, 3))
    if map_name is not None and Path(map_name).suffix == ".dof":
        lacking |= np.diff(K.indptr) == 0
    if lacking.any():
        node, direction = dofs[np.argmax(lacking)].tolist()
        raise ProblemError(
            f"{where}: expected an entry on the diagonal of every row, found none in {lacking.sum()} of "
            f"{len(dofs)} rows, first ({node}, {direction}); is the file cut off?"
        )


def _matrix(
    name: str,
    map_name: str | None,
    read: Callable[..., Stiffness],
    mesh: Mesh,
    files: InputFiles,
    table: TomlTable,
) -> Stiffness:
    """The matrix of a file, its rows in the directions of the model."""
    frames = mesh.frames
    if map_name is None:
        stiffness = files.read(name, read, table.at("file"))
    else:

        def with_map(rows: Path) -> Stiffness:
            return files.read(name, partial(read, dof_map=rows), table.at("file"))

        stiffness = files.read(map_name, with_map, table.at("map"))
        if not mesh.is_known and stiffness.format == "Nastran OUTPUT4":
            frames = files.read(map_name, _frames, table.at("map"))
    with found_in(files.path(name)):
        return stiffness.in_basic_directions(frames)


def _frames(path: Path) -> Mapping[int, FloatArray]:
    """Directions of the grid points of a punch file, where it holds any."""
    lines = read_lines(path)
    bulk = nastran.is_bulk_data(lines) and any(card == "GRID" for _, card, _ in nastran.cards(lines))
    return nastran.read_grids(path).frames if bulk else {}


def _unit_displacements(contact: ContactSection, axisymmetric: bool, path: Path) -> Stiffness:
    tables = read_nodal_vectors(path)
    if axisymmetric and tables[0].by_calculix:
        raise unfit(path, "the matrix of an axisymmetric model (SOLVER=MATRIXSTORAGE)", f"reactions ({HOOP})")
    with found_in(path):
        return unit_displacement_stiffness(tables, contact.moved, axes=contact.axes, tied=contact.tied)
