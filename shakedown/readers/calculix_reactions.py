"""CalculiX ``*NODE PRINT`` reactions (``job.dat``), and the stiffness by unit displacements."""

import os
import re
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.condensation.stiffness_checks import asymmetry
from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT
from shakedown.readers.stiffness import Stiffness
from shakedown.readers.text import integers, number, quoted, read_lines

SEVEN_DIGITS = 1e-7  # of printed reactions
HEADING = re.compile(r"^\s*forces \(fx,fy,fz\) for set (\S+) and time\s+(\S+)", re.IGNORECASE)
Order = Literal["node-by-node", "direction-by-direction"]


@dataclass(frozen=True, eq=False)
class Reactions:
    """Nodal reactions of one static step.

    Attributes
    ----------
    node_sets : tuple of str
        Node sets they were printed for.
    time : float
        Time of the step.
    nodes : (n,)
        Node labels.
    forces : (n, 3)
        Forces on the body at the nodes [force].
    by_calculix : bool
        Whether CalculiX printed them, whose axisymmetric models lack a part of their forces.
    """

    node_sets: tuple[str, ...]
    time: float
    nodes: NDArray[np.intp]
    forces: FloatArray
    by_calculix: bool = False

    def at(
        self, nodes: NDArray[np.intp], axes: tuple[int, int], tied: NDArray[np.intp] | None = None
    ) -> FloatArray:
        """Forces at nodes in two directions, (k, 2) [force], with those of nodes tied to them added.

        Raises
        ------
        ProblemError
            If a node was not printed, or there is not one tied node for each.
        """
        if tied is not None:
            if tied.shape != nodes.shape:
                raise ProblemError(
                    f"tied: expected one node for each of {len(nodes)} contact nodes, found {len(tied)}"
                )
            return self.at(nodes, axes) + self.at(tied, axes)
        index = {int(node): k for k, node in enumerate(self.nodes)}
        absent = [int(node) for node in nodes if int(node) not in index]
        if absent:
            raise ProblemError(
                f"reactions at time {self.time:g}: expected contact node {absent[0]}, found it not printed "
                f"({len(absent)} of {len(nodes)} are missing)"
            )
        return self.forces[[index[int(node)] for node in nodes]][:, [axes[0] - 1, axes[1] - 1]]


def read_calculix_reactions(path: str | os.PathLike[str]) -> list[Reactions]:
    """Read all ``forces (fx,fy,fz)`` tables of a ``.dat`` file, in the order of the file.

    Tables of several node sets at one time are one step.

    Raises
    ------
    ProblemError
        If there is no table, or a line of one is malformed.
    """
    name = os.fspath(path)
    tables: list[tuple[str, float, list[list[float]]]] = []
    reading = False
    for k, line in enumerate(read_lines(path), start=1):
        where, heading = f"{name}: line {k}", HEADING.match(line)
        if heading:
            tables.append((heading[1], number(heading[2], where), []))
            reading = True
            continue
        fields = line.split()
        if not fields or not reading:
            continue
        if not re.fullmatch(r"\d+", fields[0]):  # another kind of output
            reading = False
            continue
        if len(fields) != 4:
            raise ProblemError(f"{where}: expected 'node fx fy fz', found {quoted(line)}")
        tables[-1][2].append([*integers(fields[:1], where), *(number(field, where) for field in fields[1:])])
    if not any(rows for _, _, rows in tables):
        raise ProblemError(f"{name}: expected reactions (*NODE PRINT, RF), found no table of forces")
    steps: list[Reactions] = []
    for node_set, when, rows in tables:
        table = _table(node_set, when, rows, name)
        if steps and when == steps[-1].time and node_set not in steps[-1].node_sets:
            table = _merged(steps.pop(), table)
        steps.append(table)
    return steps


def _table(node_set: str, time: float, rows: list[list[float]], name: str) -> Reactions:
    if not rows:
        raise ProblemError(f"{name}: expected reactions at time {time:g}, found an empty table")
    data = np.array(rows)
    nodes, count = np.unique(data[:, 0], return_counts=True)
    if count.max() > 1:
        raise ProblemError(
            f"{name}: expected every node once in a table, found node {nodes[np.argmax(count)]:g} "
            "twice at time "
            f"{time:g}"
        )
    return Reactions((node_set,), time, data[:, 0].astype(np.intp), data[:, 1:], by_calculix=True)


def _merged(first: Reactions, second: Reactions) -> Reactions:
    return Reactions(
        first.node_sets + second.node_sets,
        first.time,
        np.concatenate([first.nodes, second.nodes]),
        np.concatenate([first.forces, second.forces]),
        by_calculix=True,
    )


def unit_displacement_stiffness(
    steps: list[Reactions],
    nodes: NDArray[np.intp],
    *,
    axes: tuple[int, int] = (1, 2),
    order: Order = "node-by-node",
    amplitude: float = 1.0,
    tied: NDArray[np.intp] | None = None,
) -> Stiffness:
    """The condensed stiffness from one static step per contact degree of freedom.

    Each step moves one contact node by ``amplitude`` in one direction and holds
    all others; its reactions are a column of the stiffness. Rigid motions of a
    body that is held by the contact alone come back exactly, in spite of the few
    digits that are printed.

    Parameters
    ----------
    steps
        Reactions, one table per step.
    nodes : (n,)
        Contact nodes in the order in which they were moved.
    axes
        The two directions of the plane, in the order in which they were moved.
    order
        ``"node-by-node"``: (node 1, x), (node 1, y), (node 2, x) …;
        ``"direction-by-direction"``: x of all nodes, then y.
    amplitude
        The displacement [length].
    tied : (n,), optional
        A node tied to each contact node by an equation: CalculiX prints the
        force on it apart, and the reaction of the contact node lacks it.

    Raises
    ------
    ProblemError
        If there are not 2n steps, a node was not printed, the reactions have the
        wrong sign, or the result is not symmetric to the digits that are printed.
    """
    n = len(nodes)
    if len(steps) != 2 * n:
        raise ProblemError(
            f"unit displacements: expected {2 * n} steps, two for each of {n} contact nodes, "
            f"found {len(steps)}"
        )
    if order not in ("node-by-node", "direction-by-direction"):
        raise ProblemError(f"order: expected 'node-by-node' or 'direction-by-direction', found '{order}'")
    columns = np.array([step.at(nodes, axes, tied).ravel() for step in steps]).T / amplitude
    by_direction = columns[:, np.arange(2 * n).reshape(2, n).T.ravel()]
    K, other = (columns, by_direction) if order == "node-by-node" else (by_direction, columns)
    if np.diag(K).max() < 0:
        raise ProblemError(
            "unit displacements: expected reactions that point the way the node was moved (the force on the "
            "body), found them reversed"
        )
    error = asymmetry(K)
    if error > DEFAULT.printed_digits:
        hint = ""
        if asymmetry(other) <= DEFAULT.printed_digits:
            hint = "; it is symmetric if the steps go the other way (order)"
        raise ProblemError(
            f"unit displacements: expected a symmetric stiffness, found an asymmetry of {error:.2g}{hint}"
        )
    dofs = np.column_stack([np.repeat(nodes, 2), np.tile(axes, n)]).astype(np.intp)
    return Stiffness(
        sparse.csr_array(_with_rigid_motions(0.5 * K + 0.5 * K.T)),
        dofs,
        "reactions to unit displacements",
        superelement=True,
        accuracy=SEVEN_DIGITS,
    )


def _with_rigid_motions(K: FloatArray) -> FloatArray:
    """The stiffness with eigenvalues that drown in the printed digits set to zero: rigid motions."""
    eigenvalues, modes = np.linalg.eigh(K)
    rigid = np.abs(eigenvalues) <= DEFAULT.printed_digits * eigenvalues[-1]
    if not rigid.any():
        return K
    return K - (modes[:, rigid] * eigenvalues[rigid]) @ modes[:, rigid].T
