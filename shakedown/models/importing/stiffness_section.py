"""``[stiffness]``: the matrix with its map, or from unit displacements, in the directions of the model.

Of an axisymmetric model a matrix may stand for a part of the circumference. CalculiX turns axisymmetric
elements into a wedge of 2 degrees. The matrices that it stores are those of the wedge, ``*CLOAD`` is the
force on the whole circumference, of which it applies 1/180, and the reactions that it prints are those of the
wedge without what the stress around the circumference carries. Abaqus takes and writes everything for the
whole circumference.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import PER_CENT, FloatArray
from shakedown.ground.errors import ProblemError, found_in
from shakedown.joint.problem import COARSEST
from shakedown.models.condensation.stiffness_checks import check_condensed
from shakedown.models.importing.contact_section import ContactSection
from shakedown.models.readers import nastran
from shakedown.models.readers.abaqus import ABAQUS_MATRIX
from shakedown.models.readers.formats import read_stiffness, stiffness_format
from shakedown.models.readers.mapped_matrices import NUMBERED
from shakedown.models.readers.mesh import ABAQUS, CALCULIX, Mesh
from shakedown.models.readers.nodal_vectors import Order, read_nodal_vectors, unit_displacement_stiffness
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.text import InputFiles, read_lines, unfit
from shakedown.models.readers.toml_table import TomlTable, Values

HOOP = (
    "CalculiX prints the forces of a wedge of 2 degrees, and of the radial ones not what the stress around "
    "the circumference carries"
)


def circumference_factor(
    mesh: Mesh | None, format: str, angle: float | None, scale: float, where: str
) -> float:
    """By how much a matrix of an axisymmetric model is multiplied to stand for the whole circumference.

    Parameters
    ----------
    mesh
        The model; a matrix of one that is not axisymmetric is taken as it is.
    format
        What the matrix file was found to be.
    angle
        Degrees that the matrix stands for, where the configuration says it.
    scale
        The factor that the configuration itself gives, which must not be this one again.
    where
        The table of the configuration, for messages.

    Returns
    -------
    float
        360 over the angle: 180 for the ``.sti`` file of a deck with
        ``SOLVER=MATRIXSTORAGE`` (CalculiX), 1 for what Abaqus writes.

    Raises
    ------
    ProblemError
        If neither the deck nor the configuration says it, or they say it where
        nothing is axisymmetric, or the factor is in ``scale`` too.
    """
    flat = mesh is not None and bool(mesh.elements) and not mesh.axisymmetric
    if angle is not None and not 0 < angle <= (0 if flat else 360):
        raise unfit(f"{where}: key 'angle'", "degrees up to 360 of an axisymmetric model", f"{angle:g}")
    if mesh is None or not mesh.axisymmetric:
        return 360.0 / (angle or 360.0)
    found = _angle(mesh, format) if angle is None else angle
    if found is None:
        expected = (
            "the degrees that the matrix of an axisymmetric model stands for: 2 from CalculiX, 360 else"
        )
        raise unfit(f"{where}: key 'angle'", expected, "none")
    factor = 360.0 / found
    if factor != 1 and abs(scale / factor - 1) < PER_CENT:  # then it is the same factor
        raise ProblemError(
            f"{where}: key 'scale': expected no factor for the circumference, which is taken from the deck "
            f"(360/{found:g} = {factor:g}), found {scale:g}; leave it out"
        )
    return factor


def _angle(mesh: Mesh, format: str) -> float | None:
    """The degrees that a matrix stands for; None where neither deck nor format says it."""
    if format == ABAQUS_MATRIX:
        return 360.0
    return {CALCULIX: 2.0, ABAQUS: 360.0}.get(mesh.matrix_by) if format == NUMBERED else None


def circumference_notes(stiffness: Stiffness, mesh: Mesh | None) -> tuple[str, ...]:
    """What a user should know of the import of an axisymmetric model."""
    if stiffness.circumference == 1 and (mesh is None or not mesh.axisymmetric):
        return ()
    taken = f"{360 / stiffness.circumference:g} degrees, taken {stiffness.circumference:g} times"
    return (
        f"axisymmetric: the matrix is that of {taken}; forces and reactions are those on the whole "
        "circumference, areas 2 pi r times a length",
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

    def rows(self, where: str, values: Values) -> NDArray[np.intp]:
        """Rows of (node, direction) pairs."""
        with found_in(where):
            return self.stiffness.rows(list(values))


def stiffness_section(table: TomlTable, contact: ContactSection, mesh: Mesh, files: InputFiles) -> Stiffness:
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
    where = table.at("file")
    found = files.read(name, stiffness_format, where)
    if found == "reactions":
        read = partial(_unit_displacements, contact, str(order), amplitude, mesh.axisymmetric)
        stiffness = files.read(name, read, where)
    else:
        map_name = map_name or _beside(name, found, files)
        read = partial(read_stiffness, format=found, matrix=matrix, superelement=superelement)
        stiffness = _matrix(name, map_name, read, superelement, mesh, files, table)
        _check_whole(stiffness, map_name, str(files.path(name)))
    factor = circumference_factor(mesh, stiffness.format, angle, scale, table.where)
    if stiffness.superelement and not allow_sparse:
        with found_in(files.path(name)):
            moving = stiffness.are_displacements
            check_condensed(stiffness.K[moving][:, moving], stiffness.dofs[moving, 0])
    return replace(
        stiffness,
        K=scale * factor * stiffness.K,
        dofs=_with_internal_nodes(stiffness.dofs, mesh, table.where),
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
    # nodes that CalculiX makes for the incompatible modes of an element C3D8I
    are_made = len(unknown) == 3 * mesh.incompatible and unknown.min() > mesh.labels.max()
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
    # maps that codes write beside the matrix
    for suffix in {"numbered": (".dof",), "op4": (".pch", ".asm")}.get(found, ()):
        beside = str(Path(name).with_suffix(suffix))
        if beside != name and files.path(beside).is_file():
            return beside
    return None


def _matrix(
    name: str,
    map_name: str | None,
    read: Callable[..., Stiffness],
    superelement: int | None,
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
            own = rows if superelement is None else nastran.read_analysis_set(rows, superelement)
            return files.read(name, partial(read, dof_map=own), table.at("file"))

        stiffness = files.read(map_name, with_map, table.at("map"))
        if not mesh.is_known and stiffness.format == "Nastran OUTPUT4":
            frames = files.read(map_name, partial(_frames, superelement), table.at("map"))
    with found_in(files.path(name)):
        return stiffness.in_basic_directions(frames)


def _frames(superelement: int | None, path: Path) -> Mapping[int, FloatArray]:
    """Directions of the grid points of a punch file, where it holds any."""
    lines = read_lines(path)
    if not nastran.is_bulk_data(lines):
        return {}
    lines = nastran.of_superelement(lines, superelement, str(path))
    if not any(card == "GRID" for _, card, _ in nastran.cards(lines)):
        return {}
    return nastran.read_grids(path, superelement).frames


def _unit_displacements(
    contact: ContactSection, order: str, amplitude: float, axisymmetric: bool, path: Path
) -> Stiffness:
    tables = read_nodal_vectors(path)
    if axisymmetric and tables[0].by_calculix:
        raise unfit(path, "the matrix of an axisymmetric model (SOLVER=MATRIXSTORAGE)", f"reactions ({HOOP})")
    with found_in(path):
        return unit_displacement_stiffness(
            tables,
            contact.moved,
            axes=contact.axes,
            order=cast(Order, order),
            amplitude=amplitude,
            tied=contact.tied,
        )
