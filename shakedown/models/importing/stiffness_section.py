"""``[stiffness]``: the matrix with its map, or from unit displacements, in the directions of the model."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import ProblemError, found_in
from shakedown.joint.problem import COARSEST
from shakedown.models.condensation.stiffness_checks import check_condensed
from shakedown.models.importing.contact_section import ContactSection
from shakedown.models.importing.model_section import Model, Values
from shakedown.models.readers.circumference import HOOP, circumference_factor
from shakedown.models.readers.formats import read_stiffness, stiffness_format
from shakedown.models.readers.mesh import CALCULIX, Mesh
from shakedown.models.readers.nastran import (
    cards,
    is_bulk_data,
    of_superelement,
    read_analysis_set,
    read_grids,
)
from shakedown.models.readers.nodal_vectors import Order, read_nodal_vectors, unit_displacement_stiffness
from shakedown.models.readers.stiffness import Rows, Stiffness
from shakedown.models.readers.text import InputFiles, read_lines, unfit
from shakedown.models.readers.toml_table import TomlTable

_BESIDE = {"numbered": (".dof",), "op4": (".pch", ".asm")}  # maps that codes write beside the matrix
MODES = 3  # nodes that CalculiX makes for the incompatible modes of an element C3D8I


@dataclass(frozen=True)
class ImportContext:
    """What all loads need: the stiffness with its rows, the contact, the model and the files."""

    stiffness: Stiffness
    contact: ContactSection
    model: Model
    files: InputFiles
    steps: int | None
    checked: bool = False  # whether [check] names a run that the reactions of others can rely on

    def rows(self, where: str, values: Values) -> NDArray[np.intp]:
        """Rows of (node, direction) pairs."""
        with found_in(where):
            return self.stiffness.rows(list(values))


def stiffness_section(
    table: TomlTable, contact: ContactSection, model: Model, files: InputFiles
) -> Stiffness:
    """Read the section; a superelement is checked to be condensed.

    Raises
    ------
    ProblemError
        If it is malformed or a file cannot be read.
    """
    name, map_name = str(table.text("file")), table.text("map", required=False)
    matrix, superelement = table.text("matrix", required=False), table.integer("superelement")
    scale = table.number("scale", 1.0) or 0.0
    allow_sparse = table.flag("allow_sparse")
    angle, accuracy = table.number("angle"), table.number("accuracy")
    order, amplitude = table.text("order", "node-by-node"), table.number("amplitude", 1.0) or 0.0
    table.done()
    if not scale > 0 or amplitude == 0:
        found = f"'scale' = {scale:g} and 'amplitude' = {amplitude:g}"
        raise table.unfit("'scale' > 0 and 'amplitude' other than 0", found)
    if accuracy is not None and not 0 < accuracy <= COARSEST:
        raise table.wrong("accuracy", f"a number above 0 and up to {COARSEST:g}", f"{accuracy:g}")
    found = files.read(name, stiffness_format)
    if found == "reactions":
        stiffness = files.read(
            name, lambda path: _unit_displacements(path, contact, str(order), amplitude, model.axisymmetric)
        )
    else:
        map_name = map_name or _beside(name, found, files)
        read = partial(read_stiffness, format=found, matrix=matrix, superelement=superelement)
        stiffness = _matrix(name, map_name, read, superelement, model, files)
        _check_whole(stiffness, map_name, str(files.path(name)))
    factor = circumference_factor(model.mesh, stiffness.format, angle, scale, table.where)
    if stiffness.superelement and not allow_sparse:
        with found_in(files.path(name)):
            moving = stiffness.are_displacements
            check_condensed(stiffness.K[moving][:, moving], stiffness.dofs[moving, 0])
    return replace(
        stiffness,
        K=scale * factor * stiffness.K,
        dofs=_with_internal_nodes(stiffness.dofs, model.mesh, table.where),
        superelement=stiffness.superelement or allow_sparse,
        circumference=factor,
        accuracy=stiffness.accuracy if accuracy is None else accuracy,
    )


def _with_internal_nodes(dofs: NDArray[np.intp], mesh: Mesh, where: str) -> NDArray[np.intp]:
    """The rows, those that are no displacements as internal nodes: bolts' sections, incompatible modes."""
    if mesh.sections and mesh.matrix_by != CALCULIX:
        raise ProblemError(
            f"{where}: expected a *PRE-TENSION SECTION in decks of CalculiX only, found one of "
            f"{mesh.matrix_by or 'another code'}, whose matrix is not known to have it; leave the bolt "
            "out of the model and say [[bolt]] with 'head', 'nut' and 'stiffness'"
        )
    own = np.isin(dofs[:, 0], [*mesh.sections, *_of_modes(dofs, mesh)])
    return np.where(own[:, None] & [True, False], -dofs, dofs)


def _of_modes(dofs: NDArray[np.intp], mesh: Mesh) -> list[int]:
    """Nodes of CalculiX for incompatible modes, three an element; none where others are unknown, too."""
    if not mesh.incompatible or mesh.matrix_by != CALCULIX:
        return []
    unknown = np.setdiff1d(dofs[:, 0], mesh.labels)
    are_made = len(unknown) == MODES * mesh.incompatible and unknown.min() > mesh.labels.max()
    return unknown.tolist() if are_made else []


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


def _beside(name: str, found: str, files: InputFiles) -> str | None:
    """The map file of the same name beside a matrix, where there is one."""
    for suffix in _BESIDE.get(found, ()):
        beside = str(Path(name).with_suffix(suffix))
        if beside != name and files.path(beside).is_file():
            return beside
    return None


def _matrix(
    name: str,
    map_name: str | None,
    read: Callable[..., Stiffness],
    superelement: int | None,
    model: Model,
    files: InputFiles,
) -> Stiffness:
    """The matrix of a file, its rows in the directions of the model."""
    frames = model.mesh.frames
    if map_name is None:
        stiffness = files.read(name, read)
    else:
        stiffness = files.read(
            map_name,
            lambda rows: files.read(name, lambda path: read(path, dof_map=_rows(rows, superelement))),
        )
        if not model.is_known and stiffness.format == "Nastran OUTPUT4":
            frames = files.read(map_name, lambda path: _frames(path, superelement))
    with found_in(files.path(name)):
        return stiffness.in_basic_directions(frames)


def _rows(path: Path, superelement: int | None) -> Rows:
    """A map, or the rows of one superelement of a punch file."""
    if is_bulk_data(read_lines(path)):
        return read_analysis_set(path, superelement)
    if superelement is not None:
        raise unfit(path, "a punch file beside the key 'superelement'", "a map without superelements")
    return path


def _frames(path: Path, superelement: int | None) -> Mapping[int, FloatArray]:
    """Directions of the grid points of a punch file, where it holds any."""
    lines = read_lines(path)
    if not is_bulk_data(lines):
        return {}
    lines = of_superelement(lines, superelement, str(path))
    if not any(card == "GRID" for _, card, _ in cards(lines)):
        return {}
    return read_grids(path, superelement).frames


def _unit_displacements(
    path: Path, contact: ContactSection, order: str, amplitude: float, axisymmetric: bool
) -> Stiffness:
    tables = read_nodal_vectors(path)
    if axisymmetric and tables[0].by_calculix:
        raise ProblemError(
            f"{path}: expected no reactions of an axisymmetric model: {HOOP}; write the matrix "
            "(*FREQUENCY, SOLVER=MATRIXSTORAGE)"
        )
    with found_in(path):
        return unit_displacement_stiffness(
            tables,
            contact.moved,
            axes=contact.axes,
            order=cast(Order, order),
            amplitude=amplitude,
            tied=contact.tied,
        )
