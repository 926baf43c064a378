"""``[model]``: coordinates, node sets and surfaces, from a deck, bulk data or a list of nodes."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import LARGEST_LABEL
from shakedown.ground.errors import found_in
from shakedown.models.readers.formats import read_any_mesh
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.text import InputFiles, quoted, unfit
from shakedown.models.readers.toml_table import TomlTable, shown

NOTHING = Mesh("", np.zeros(0, dtype=np.intp), np.zeros((0, 3)))
Values = dict[tuple[int, int], float]  # {(node, direction): value}


@dataclass(frozen=True, eq=False)
class Model:
    """What is known of the model beside its stiffness.

    Attributes
    ----------
    mesh : Mesh
        Nodes, sets and faces; without nodes where the configuration names no file.
    """

    mesh: Mesh = NOTHING

    @property
    def axisymmetric(self) -> bool:
        """Whether a deck says that the model is a section of a body of revolution."""
        return self.mesh.axisymmetric

    @property
    def is_known(self) -> bool:
        """Whether the configuration names a file of the model."""
        return bool(self.mesh.labels.size)

    def nodes(self, name: str, where: str) -> NDArray[np.intp]:
        """Labels of a node set or surface.

        Raises
        ------
        ProblemError
            If there is no model, or no such set.
        """
        if not self.is_known:
            raise unfit(
                where, "node labels, or [model] with a deck that names sets", f"{quoted(name)} and no [model]"
            )
        with found_in(where):
            return self.mesh.nodes(name)

    def values(self, table: TomlTable, key: str, *, valued: bool = True) -> Values | None:
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
            for k, what in enumerate(("node (a whole number, or the name of a set)", "whole direction")):
                if not (_is_label(entry[k]) or (k == 0 and isinstance(entry[k], str))):
                    raise unfit(where, f"a {what}", shown(entry))
            value = entry[2] if valued else 0.0
            if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= 1e308:
                raise unfit(where, "a finite number", shown(entry))
            labels = self.nodes(entry[0], where).tolist() if isinstance(entry[0], str) else [int(entry[0])]
            for label in labels:
                if (label, int(entry[1])) in found:
                    raise unfit(where, "every (node, direction) once", f"({label}, {int(entry[1])}) twice")
                found[label, int(entry[1])] = float(value)
        return found


def _is_label(item: Any) -> bool:
    """Whether an item is a whole number in the range of labels; 21.0 counts as 21."""
    if isinstance(item, bool) or not isinstance(item, int | float):
        return False
    return abs(item) < LARGEST_LABEL and item == int(item)


def model_section(table: TomlTable, files: InputFiles, superelement: int | None = None) -> Model:
    """Read the section; without it nothing is known of the model.

    ``superelement`` picks one of a Nastran file with several, as in ``[stiffness]``.
    """
    if not table.content:
        return Model()
    name = str(table.text("file"))
    table.done()
    return Model(files.read(name, lambda path: read_any_mesh(path, superelement)))
