"""``[contact] gap``: how far the bodies lie apart before they are loaded; negative is interference."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.models.importing.model_section import Model
from shakedown.models.readers.input_files import InputFiles
from shakedown.models.readers.table import read_table
from shakedown.models.readers.toml_table import TomlTable, is_number, shown

COORDINATES = "coordinates"  # the word for a gap between the nodes as the deck places them
Labels = NDArray[np.intp]
# The gap of nodes (n,) or pairs (n, 2) in the order of the contact, () or (n,) [length], from labels,
# normals (n, 3) into the first body and positions.
Gap = Callable[[Labels, FloatArray, FloatArray | None], FloatArray]


def initial_gap(table: TomlTable, model: Model, files: InputFiles) -> Gap:
    """Take the key ``gap`` of ``[contact]``: a number, a list, a word or a table; absent it is 0.

    Raises
    ------
    ProblemError
        If it is malformed; the gap itself raises it where what it needs is not known.
    """
    value = table.content.get("gap", 0.0)
    if isinstance(value, list):
        return _listed(table, np.array(table.array("gap", float, (None,)), dtype=float))
    if isinstance(value, str):
        if table.text("gap") != COORDINATES:
            raise table.wrong("gap", f"'{COORDINATES}', a number, a list or a table", shown(value))
        return _measured(table, model)
    if not isinstance(value, dict):
        return _listed(table, np.array(table.number("gap", 0.0)))
    source = table.table("gap")
    kinds = [key for key in ("points", "nodes", "file") if source.has(key)]
    if len(kinds) != 1:
        raise source.unfit(
            "one of the keys 'points', 'nodes' and 'file'", " and ".join(map(repr, kinds)) or "none"
        )
    if kinds == ["points"]:
        gap = _of_points(table, source)
    elif kinds == ["nodes"]:
        gap = _of_nodes(table, _by_label(source, model))
    else:
        name, column = str(source.text("file")), source.key_of_column("column") or 1
        gap = _listed(table, files.read(name, lambda path: read_table(path).column(column)))
    source.done()
    return gap


def _listed(table: TomlTable, given: FloatArray) -> Gap:
    """One number, or one per node in the order of the configuration."""

    def at(labels: Labels, normals: FloatArray, x: FloatArray | None) -> FloatArray:
        if given.ndim and len(given) != len(labels):
            raise table.wrong("gap", f"one for each of {len(labels)} nodes", len(given))
        return given

    return at


def _measured(table: TomlTable, model: Model) -> Gap:
    """The distance of the nodes of each pair in the deck."""

    def at(labels: Labels, normals: FloatArray, x: FloatArray | None) -> FloatArray:
        if model.mesh is None or labels.ndim == 1:
            found = "nodes of one body" if labels.ndim == 1 else "no [model]"
            raise table.wrong("gap", f"pairs in a model with coordinates beside '{COORDINATES}'", found)
        apart = model.mesh.at(labels[:, 0]) - model.mesh.at(labels[:, 1])
        return np.asarray((apart * normals).sum(axis=1) / np.linalg.norm(normals, axis=1))

    return at


def _of_points(table: TomlTable, source: TomlTable) -> Gap:
    """Straight lines between [position, gap]."""
    points = np.array(source.array("points", float, (None, 2)), dtype=float)
    down = np.flatnonzero(np.diff(points[:, 0]) <= 0)
    if down.size:
        before, after = points[down[0] : down[0] + 2, 0]
        raise source.wrong("points", "[x, gap] with x ascending", f"{after:g} after {before:g}")

    def at(labels: Labels, normals: FloatArray, x: FloatArray | None) -> FloatArray:
        if x is None:
            raise table.wrong("gap", "positions ('x', or [model]) beside points", "none")
        if x.ndim > 1:
            expected = "points where nodes slip in one direction; give a list, a file, nodes or 'coordinates'"
            raise table.wrong("gap", expected, "two")
        return np.interp(x, points[:, 0], points[:, 1])

    return at


def _of_nodes(table: TomlTable, nodes: dict[int, float]) -> Gap:
    """Gaps of single nodes; the others touch."""

    def at(labels: Labels, normals: FloatArray, x: FloatArray | None) -> FloatArray:
        gap = np.zeros(len(labels))
        for node, value in nodes.items():
            place = np.flatnonzero((labels.reshape(len(labels), -1) == node).any(axis=1))
            if not place.size:
                raise table.wrong("gap", "contact nodes", f"node {node}")
            gap[place] = value
        return gap

    return at


def _by_label(source: TomlTable, model: Model) -> dict[int, float]:
    """Gaps by label, of [node or set, gap] entries."""
    found: dict[int, float] = {}
    for name, value in source.entries("nodes", 2) or []:
        if not isinstance(name, str | int) or isinstance(name, bool):
            raise source.wrong("nodes", "a node, or the name of a set", shown([name, value]))
        if not is_number(value):
            raise source.wrong("nodes", "a finite number", shown([name, value]))
        where = f"{source.where}: key 'nodes'"
        labels = model.nodes(name, where).tolist() if isinstance(name, str) else [name]
        twice = [label for label in labels if label in found]
        if twice:
            raise source.wrong("nodes", "every node once", f"node {twice[0]} twice")
        found |= dict.fromkeys(labels, float(value))
    return found
