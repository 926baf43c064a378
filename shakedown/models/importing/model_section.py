"""``[model]``: coordinates, node sets and surfaces, from a deck, bulk data or a list of nodes."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import LARGEST_LABEL
from shakedown.ground.errors import found_in
from shakedown.models.readers.formats import read_any_mesh
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.text import InputFiles, quoted, unfit
from shakedown.models.readers.toml_table import TomlTable, is_number, shown

NOTHING = Mesh("", np.zeros(0, dtype=np.intp), np.zeros((0, 3)))  # where the configuration names no file
Values = dict[tuple[int, int], float]  # {(node, direction): value}


def model_section(table: TomlTable, files: InputFiles, superelement: int | None = None) -> Mesh:
    """Read the section; without it nothing is known of the model.

    ``superelement`` picks one of a Nastran file with several, as in ``[stiffness]``.
    """
    if not table.content:
        return NOTHING
    name = str(table.text("file"))
    table.done()
    return files.read(name, lambda path: read_any_mesh(path, superelement))


def nodes_of(mesh: Mesh, name: str, where: str) -> NDArray[np.intp]:
    """Labels of a node set or surface.

    Raises
    ------
    ProblemError
        If there is no model, or no such set.
    """
    if not mesh.is_known:
        expected = "node labels, or [model] with a deck that names sets"
        raise unfit(where, expected, f"{quoted(name)} and no [model]")
    with found_in(where):
        return mesh.nodes(name)


def labels_of(mesh: Mesh, node: Any, where: str) -> NDArray[np.intp]:
    """The labels that a node, or the name of a set, stands for; ``ProblemError`` if it is neither."""
    if isinstance(node, str):
        return nodes_of(mesh, node, where)
    if not _is_label(node):
        raise unfit(where, "a node (a whole number, or the name of a set)", shown(node))
    return np.array([node], dtype=np.intp)


def values_of(mesh: Mesh, table: TomlTable, key: str, *, valued: bool = True) -> Values | None:
    """Entries [node or set, direction, value] as {(node, direction): value}; None where they are absent.

    Raises
    ------
    ProblemError
        If an entry is malformed, or a (node, direction) occurs twice.
    """
    entries = table.entries(key, 3 if valued else 2)
    if entries is None:
        return None
    found: Values = {}
    where = f"{table.where}: key '{key}'"
    for entry in entries:
        node, direction, value = entry if valued else (*entry, 0.0)
        if not _is_label(direction) or not is_number(value):
            raise unfit(where, "[node or set, whole direction, finite number]", shown(entry))
        for key_of_row in ((label, int(direction)) for label in labels_of(mesh, node, where).tolist()):
            if key_of_row in found:
                raise unfit(where, "every (node, direction) once", f"{key_of_row} twice")
            found[key_of_row] = float(value)
    return found


def _is_label(item: Any) -> bool:
    """Whether an item is a whole number in the range of labels; 21.0 counts as 21."""
    if isinstance(item, bool) or not isinstance(item, int | float):
        return False
    return abs(item) < LARGEST_LABEL and item == int(item)
