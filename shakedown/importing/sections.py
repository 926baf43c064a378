"""The sections of an import configuration, each turned into what it describes."""

from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from shakedown.condensation.condense import Condensation
from shakedown.condensation.load_case import LoadCase
from shakedown.condensation.stiffness_checks import check_condensed
from shakedown.errors import ProblemError
from shakedown.importing.time_function import time_function
from shakedown.importing.toml_table import Table
from shakedown.model.problem import FloatArray
from shakedown.readers import (
    Reactions,
    Stiffness,
    read_calculix_reactions,
    read_nodal_loads,
    read_stiffness,
    stiffness_format,
    unit_displacement_stiffness,
)
from shakedown.readers.calculix_reactions import Order


@dataclass(frozen=True)
class ContactSection:
    """``[contact]``: nodes or pairs, normals into the first body, axes of the plane, positions."""

    labels: NDArray[np.intp]
    normals: FloatArray
    axes: tuple[int, int]
    free_out_of_plane: bool
    tied: NDArray[np.intp] | None
    x: FloatArray | None

    @property
    def first(self) -> NDArray[np.intp]:
        """Contact nodes of the first body, (n,)."""
        return self.labels if self.labels.ndim == 1 else self.labels[:, 0]

    @classmethod
    def read(cls, table: Table) -> "ContactSection":
        """Take the section from its table."""
        nodes = table.array("nodes", int, (None,), required=False)
        pairs = table.array("pairs", int, (None, 2), required=False)
        if (nodes is None) == (pairs is None):
            raise ProblemError(f"{table.where}: expected one of 'nodes' and 'pairs', found both or none")
        normal = table.array("normal", float, (2,), required=False)
        normals = table.array("normals", float, (None, 2), required=False)
        if (normal is None) == (normals is None):
            raise ProblemError(f"{table.where}: expected one of 'normal' and 'normals', found both or none")
        axes = table.array("axes", int, (2,), required=False) or [1, 2]
        tied = table.array("tied", int, (None,), required=False)
        x = table.array("x", float, (None,), required=False)
        contact = cls(
            np.array(nodes if pairs is None else pairs),
            np.array(normal if normals is None else normals, dtype=float),
            (axes[0], axes[1]),
            table.flag("free_out_of_plane"),
            None if tied is None else np.array(tied),
            None if x is None else np.array(x, dtype=float),
        )
        table.done()
        if sorted({1, 2, 3} & set(axes)) != sorted(axes):
            raise ProblemError(f"{table.where}: key 'axes': expected two of 1, 2, 3, found {axes}")
        return contact


def friction(root: Table) -> FloatArray:
    """``friction``: one coefficient, or one per contact node."""
    if isinstance(root.content.get("friction"), list):
        return np.array(root.array("friction", float, (None,)), dtype=float)
    if not root.has("friction"):
        raise ProblemError(f"{root.where}: expected the key 'friction' (a number or a list), found none")
    return np.array(root.number("friction"))


def stiffness_section(table: Table, contact: ContactSection, folder: Path) -> Stiffness:
    """``[stiffness]``: the matrix with its map; a superelement is checked to be condensed."""
    path = folder / str(table.text("file"))
    map_name, matrix = table.text("map", required=False), table.text("matrix", required=False)
    scale, allow_sparse = table.number("scale", 1.0) or 0.0, table.flag("allow_sparse")
    order, amplitude = table.text("order", "node-by-node"), table.number("amplitude", 1.0) or 0.0
    table.done()
    if not scale > 0 or amplitude == 0:
        raise ProblemError(f"{table.where}: expected scale > 0 and an amplitude other than 0")
    if stiffness_format(path) == "reactions":
        if contact.labels.ndim != 1:
            raise ProblemError(f"{table.where}: expected one body for reactions, found contact pairs")
        found = _unit_displacements(path, contact, str(order), amplitude)
    else:
        found = read_stiffness(path, dof_map=folder / map_name if map_name else None, matrix=matrix)
    if found.superelement and not allow_sparse:
        try:
            check_condensed(found.K, found.dofs[:, 0])
        except ProblemError as error:
            raise ProblemError(f"{path}: {error}") from None
    return Stiffness(scale * found.K, found.dofs, found.format, found.superelement or allow_sparse)


def _unit_displacements(path: Path, contact: ContactSection, order: str, amplitude: float) -> Stiffness:
    tables = read_calculix_reactions(path)
    try:
        return unit_displacement_stiffness(
            tables,
            contact.labels,
            axes=contact.axes,
            order=cast(Order, order),
            amplitude=amplitude,
            tied=contact.tied,
        )
    except ProblemError as error:
        raise ProblemError(f"{path}: {error}") from None


@dataclass(frozen=True)
class LoadSection:
    """``[[load]]``: a load case, and the rows whose displacement it prescribes."""

    case: LoadCase
    prescribed: NDArray[np.intp]


def load_section(
    table: Table, stiffness: Stiffness, contact: ContactSection, steps: int | None, folder: Path
) -> LoadSection:
    """Take one load case from its table."""
    force, displacement = np.zeros(len(stiffness.dofs)), np.zeros(len(stiffness.dofs))
    loaded, moved = _forces(table, folder), table.array("displacements", float, (None, 3), required=False)
    rows = _rows(table, "displacements", stiffness, moved or [])
    displacement[rows] = [entry[2] for entry in moved or []]
    force[_rows(table, "forces", stiffness, loaded or [])] = [entry[2] for entry in loaded or []]
    case = LoadCase(
        history=time_function(table, steps, folder),
        force=None if loaded is None else force,
        displacement=None if moved is None else displacement,
        reactions=_reactions(table, contact, folder),
        mean=table.number("mean"),
        transient=table.array("transient", float, (None,), required=False),
        name=table.text("name", table.where) or table.where,
    )
    table.done()
    return LoadSection(case, rows)


def _forces(table: Table, folder: Path) -> list[list[float]] | None:
    if isinstance(table.content.get("forces"), dict):
        source = table.table("forces")
        found = read_nodal_loads(folder / str(source.text("file")))
        source.done()
        return [[node, direction, value] for (node, direction), value in found.items()]
    entries: list[list[float]] | None = table.array("forces", float, (None, 3), required=False)
    return entries


def _reactions(table: Table, contact: ContactSection, folder: Path) -> FloatArray | None:
    if not isinstance(table.content.get("reactions"), dict):
        listed = table.array("reactions", float, (None, 2), required=False)
        return None if listed is None else np.array(listed, dtype=float)
    source = table.table("reactions")
    path, step = folder / str(source.text("file")), source.integer("step")
    scale = source.number("scale", 1.0) or 0.0
    source.done()
    runs = read_calculix_reactions(path)
    if not 1 <= (step or 1) <= len(runs) or (step is None and len(runs) > 1):
        raise ProblemError(f"{source.where}: key 'step': expected 1 to {len(runs)}, found {step}")
    run: Reactions = runs[(step or 1) - 1]
    return scale * run.at(contact.first, contact.axes, contact.tied)


def _rows(table: Table, key: str, stiffness: Stiffness, entries: list[list[float]]) -> NDArray[np.intp]:
    try:
        return stiffness.rows([entry[:2] for entry in entries])
    except ProblemError as error:
        raise ProblemError(f"{table.where}: key '{key}': {error}") from None


def held_rows(supports: Table, stiffness: Stiffness, loads: list[LoadSection]) -> NDArray[np.intp]:
    """``[supports]`` and prescribed displacements: rows that do not move freely."""
    fixed = supports.array("fixed", int, (None, 2), required=False)
    supports.done()
    return np.concatenate(
        [_rows(supports, "fixed", stiffness, fixed or []), *(load.prescribed for load in loads)]
    )


def static_run(table: Table, reduced: Condensation, contact: ContactSection, folder: Path) -> float:
    """``[check]``: the largest difference from a static run, NaN where there is none."""
    if not table.content:
        return float("nan")
    moved = table.array("displacements", float, (None, 3))
    reactions = _reactions(table, contact, folder)
    table.done()
    labels = contact.first.tolist()
    displacement = np.zeros((reduced.n, 2))
    for node, direction, value in moved:
        if node not in labels or direction not in contact.axes:
            raise ProblemError(
                f"{table.where}: key 'displacements': expected contact nodes and directions {contact.axes}, "
                f"found node {node:g}, direction {direction:g}"
            )
        displacement[labels.index(node), contact.axes.index(direction)] = value
    if reactions is None:
        raise ProblemError(f"{table.where}: expected the key 'reactions', found none")
    return reduced.check_against_run(displacement, reactions, what=table.where)
