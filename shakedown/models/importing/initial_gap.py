"""``[contact] gap``: how far the bodies lie apart before they are loaded; negative is interference."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.models.importing.model_section import Model
from shakedown.models.readers.input_files import InputFiles
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.table import read_table
from shakedown.models.readers.text import quoted
from shakedown.models.readers.toml_table import TomlTable, is_number, shown

COORDINATES = "coordinates"  # the word for a gap between the nodes as the deck places them


@dataclass(frozen=True, eq=False)
class InitialGap:
    """A gap as a configuration gives it, before the contact nodes stand in their order.

    Attributes
    ----------
    where : str
        The table, for messages.
    listed : () or (n,)
        One number, or one per node in the order of the configuration.
    points : (k, 2) or None
        Positions and gaps, with straight lines between.
    nodes : dict or None
        Gaps of single nodes, by label; the others touch.
    measured : bool
        Whether the gap is the distance of the nodes of each pair in the deck.
    """

    where: str
    listed: FloatArray
    points: FloatArray | None = None
    nodes: dict[int, float] | None = None
    measured: bool = False

    def at(
        self, labels: NDArray[np.intp], normals: FloatArray, x: FloatArray | None, mesh: Mesh | None
    ) -> FloatArray:
        """The gap of contact nodes (n,) or pairs (n, 2): one number, or (n,) [length].

        Parameters
        ----------
        labels, normals, x, mesh
            The contact in its order: labels, normals (n, 3) into the first body, positions (n,), the model.

        Raises
        ------
        ProblemError
            If what the gap needs is not known, or a node is not one of the contact.
        """
        if self.nodes is not None:
            return self._of_nodes(self.nodes, labels)
        if self.measured:
            return self._measured(labels, normals, mesh)
        if self.points is not None:
            if x is None:
                raise ProblemError(
                    f"{self.where}: key 'gap': expected positions ('x', or [model]) beside points, found none"
                )
            if x.ndim > 1:
                raise ProblemError(
                    f"{self.where}: key 'gap': expected points where nodes slip in one direction, found two; "
                    "give a list, a file, nodes or 'coordinates'"
                )
            return np.interp(x, self.points[:, 0], self.points[:, 1])
        if self.listed.ndim and len(self.listed) != len(labels):
            raise ProblemError(
                f"{self.where}: key 'gap': expected one for each of {len(labels)} nodes, found "
                f"{len(self.listed)}"
            )
        return self.listed

    def _of_nodes(self, nodes: dict[int, float], labels: NDArray[np.intp]) -> FloatArray:
        gap = np.zeros(len(labels))
        for node, value in nodes.items():
            place = np.flatnonzero((labels.reshape(len(labels), -1) == node).any(axis=1))
            if not place.size:
                raise ProblemError(f"{self.where}: key 'gap': expected contact nodes, found node {node}")
            gap[place] = value
        return gap

    def _measured(self, labels: NDArray[np.intp], normals: FloatArray, mesh: Mesh | None) -> FloatArray:
        if mesh is None or labels.ndim == 1:
            found = "nodes of one body" if labels.ndim == 1 else "no [model]"
            raise ProblemError(
                f"{self.where}: key 'gap': expected pairs in a model with coordinates beside "
                f"'{COORDINATES}', found {found}"
            )
        apart = mesh.at(labels[:, 0]) - mesh.at(labels[:, 1])
        return np.asarray((apart * normals).sum(axis=1) / np.linalg.norm(normals, axis=1))


def initial_gap(table: TomlTable, model: Model, files: InputFiles) -> InitialGap:
    """Take the key ``gap`` of ``[contact]``: a number, a list, a word or a table; absent it is 0."""
    where, value = table.where, table.content.get("gap", 0.0)
    if isinstance(value, list):
        return InitialGap(where, np.array(table.array("gap", float, (None,)), dtype=float))
    if isinstance(value, str):
        if table.text("gap") != COORDINATES:
            raise ProblemError(
                f"{where}: key 'gap': expected '{COORDINATES}', a number, a list or a table, found "
                f"{quoted(value)}"
            )
        return InitialGap(where, np.zeros(()), measured=True)
    if not isinstance(value, dict):
        return InitialGap(where, np.array(table.number("gap", 0.0)))
    source = table.table("gap")
    kinds = [key for key in ("points", "nodes", "file") if source.has(key)]
    if len(kinds) != 1:
        found = " and ".join(f"'{kind}'" for kind in kinds) or "none"
        raise ProblemError(
            f"{source.where}: expected one of the keys 'points', 'nodes' and 'file', found {found}"
        )
    gap = _of_table(source, kinds[0], InitialGap(where, np.zeros(())), model, files)
    source.done()
    return gap


def _of_table(source: TomlTable, kind: str, gap: InitialGap, model: Model, files: InputFiles) -> InitialGap:
    if kind == "points":
        points = np.array(source.array("points", float, (None, 2)), dtype=float)
        return replace(gap, points=_ascending(points, source.where))
    if kind == "nodes":
        entries = source.entries("nodes", 2) or []
        return replace(gap, nodes=_by_label(entries, model, f"{source.where}: key 'nodes'"))
    name, column = str(source.text("file")), source.key_of_column("column") or 1
    return replace(gap, listed=files.read(name, lambda path: read_table(path).column(column)))


def _ascending(points: FloatArray, where: str) -> FloatArray:
    down = np.flatnonzero(np.diff(points[:, 0]) <= 0)
    if down.size:
        before, after = points[down[0] : down[0] + 2, 0]
        raise ProblemError(
            f"{where}: key 'points': expected [x, gap] with x ascending, found {after:g} after {before:g}"
        )
    return points


def _by_label(entries: list[list[object]], model: Model, where: str) -> dict[int, float]:
    """Gaps by label, of [node or set, gap] entries."""
    found: dict[int, float] = {}
    for entry in entries:
        name, value = entry
        if not (isinstance(name, str) or (isinstance(name, int) and not isinstance(name, bool))):
            raise ProblemError(f"{where}: expected a node, or the name of a set, found {shown(entry)}")
        if not is_number(value):
            raise ProblemError(f"{where}: expected a finite number, found {shown(entry)}")
        assert isinstance(value, int | float)
        labels = model.nodes(name, where).tolist() if isinstance(name, str) else [name]
        twice = [label for label in labels if label in found]
        if twice:
            raise ProblemError(f"{where}: expected every node once, found node {twice[0]} twice")
        found |= dict.fromkeys(labels, float(value))
    return found
