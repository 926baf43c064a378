"""CalculiX ``*NODE PRINT`` output (``job.dat``), and the stiffness by unit displacements."""

import os
import re
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.constants import SEVEN_DIGITS, FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.ground.tolerances import DEFAULT
from shakedown.models.condensation.stiffness_checks import asymmetry
from shakedown.models.readers.formats import Format, has
from shakedown.models.readers.nodal_vectors import NodalVectors, What, refuse_as_stiffness
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.text import integers, number, numbers, quoted, read_lines

_HEADING = r"^\s*{} for set (\S+) and time\s+(\S+)"
HEADINGS: dict[What, re.Pattern[str]] = {
    "reactions": re.compile(_HEADING.format(r"forces \(fx,fy,fz\)"), re.IGNORECASE),
    "displacements": re.compile(_HEADING.format(r"displacements \(vx,vy,vz\)"), re.IGNORECASE),
}
COLUMNS: dict[What, str] = {"reactions": "node fx fy fz", "displacements": "node vx vy vz"}
LOCAL = "L"  # at the end of a row whose components are along the directions of a *TRANSFORM
LETTERS: dict[What, str] = {"reactions": "RF", "displacements": "U"}
_WORDS = {2: "two", 3: "three"}
Order = Literal["node-by-node", "direction-by-direction"]


class _Table(NamedTuple):
    """A table as it is read: its node set, time and rows, and the nodes with directions of their own."""

    node_set: str
    time: float
    rows: list[list[float]]
    local: set[int]


def read_calculix_output(path: str | os.PathLike[str], what: What = "reactions") -> list[NodalVectors]:
    """Read all tables of reactions, or of displacements, of a ``.dat`` file, in the order of the file.

    Tables of several node sets at one time are one step.

    Raises
    ------
    ProblemError
        If there is no table, or a line of one is malformed.
    """
    name, tables = os.fspath(path), list[_Table]()
    inside = False
    for k, line in enumerate(read_lines(path), start=1):
        where, fields = f"{name}: line {k}", line.split()
        if heading := HEADINGS[what].match(line):
            tables.append(_Table(heading[1], number(heading[2], where), [], set()))
            inside = True
        elif fields and not fields[0].isdigit():  # another kind of output
            inside = False
        elif fields and inside:
            own = fields[4:] == [LOCAL]
            if len(fields) != 4 + own:
                raise ProblemError(f"{where}: expected '{COLUMNS[what]}', found {quoted(line)}")
            tables[-1].rows.append([*integers(fields[:1], where), *numbers(fields[1:4], where)])
            tables[-1].local.update([int(fields[0])] if own else [])
    if not tables:
        raise ProblemError(
            f"{name}: expected {what} (*NODE PRINT, {LETTERS[what]}), found no table of "
            f"{'forces' if what == 'reactions' else what}"
        )
    steps: list[NodalVectors] = []
    for node_set, time, rows, local in tables:
        step = replace(step_of(what, (node_set,), time, rows, name), local=frozenset(local))
        if steps and time == steps[-1].time and node_set not in steps[-1].node_sets:
            step = _merged(steps.pop(), step)
        steps.append(step)
    return steps


def step_of(
    what: What, node_sets: tuple[str, ...], time: float, rows: list[list[float]], name: str
) -> NodalVectors:
    """One table of CalculiX; ``ProblemError`` if it is empty or repeats a node."""
    if not rows:
        raise ProblemError(f"{name}: expected {what} at time {time:g}, found an empty table")
    data = np.array(rows)
    nodes, count = np.unique(data[:, 0], return_counts=True)
    if count.max() > 1:
        raise ProblemError(
            f"{name}: expected every node once in a table, found node {nodes[np.argmax(count)]:g} twice at "
            f"time {time:g}"
        )
    return NodalVectors(what, node_sets, time, data[:, 0].astype(np.intp), data[:, 1:], by_calculix=True)


def _merged(first: NodalVectors, second: NodalVectors) -> NodalVectors:
    return replace(
        first,
        node_sets=first.node_sets + second.node_sets,
        nodes=np.concatenate([first.nodes, second.nodes]),
        vectors=np.concatenate([first.vectors, second.vectors]),
        local=first.local | second.local,
    )


def unit_displacement_stiffness(
    steps: list[NodalVectors],
    nodes: NDArray[np.intp],
    *,
    axes: tuple[int, ...] = (1, 2),
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
        The two directions of the plane, or the three of space, in the order in which they were moved.
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
        If there are not 2n steps (3n in space), a node was not printed, the reactions have the
        wrong sign, or the result is not symmetric to the digits that are printed.
    """
    n, d = len(nodes), len(axes)
    _check_steps(steps, n, d)
    if order not in ("node-by-node", "direction-by-direction"):
        raise ProblemError(f"order: expected 'node-by-node' or 'direction-by-direction', found '{order}'")
    columns = np.array([step.at(nodes, axes, tied).ravel() for step in steps]).T / amplitude
    by_direction = columns[:, np.arange(d * n).reshape(d, n).T.ravel()]
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
    dofs = np.column_stack([np.repeat(nodes, d), np.tile(axes, n)]).astype(np.intp)
    return Stiffness(
        sparse.csr_array(_with_rigid_motions(0.5 * K + 0.5 * K.T)),
        dofs,
        "reactions to unit displacements",
        superelement=True,
        accuracy=SEVEN_DIGITS,
    )


def _check_steps(steps: list[NodalVectors], n: int, d: int) -> None:
    """Raise ``ProblemError`` unless there is one step, along x, y, z, for each direction of each node."""
    turned = sorted(frozenset().union(*(step.local for step in steps)))
    if turned:
        raise ProblemError(
            "unit displacements: expected reactions along x, y, z, found those of node "
            f"{turned[0]} in a *TRANSFORM"
        )
    if len(steps) != d * n:
        hint = "" if len(steps) != 3 * n else "; with three for each say directions = 2"
        raise ProblemError(
            f"unit displacements: expected {d * n} steps, {_WORDS[d]} for each of {n} contact nodes, "
            f"found {len(steps)}{hint}"
        )


def _with_rigid_motions(K: FloatArray) -> FloatArray:
    """The stiffness with exact rigid motions: eigenvalues that drown in the printed digits become zero."""
    eigenvalues, modes = np.linalg.eigh(K)
    rigid = np.abs(eigenvalues) <= DEFAULT.printed_digits * eigenvalues[-1]
    if not rigid.any():
        return K
    return K - (modes[:, rigid] * eigenvalues[rigid]) @ modes[:, rigid].T


FORMATS = tuple(
    Format(what, what, has(heading), {"vectors": read_calculix_output, **more})
    for (what, heading), more in zip(HEADINGS.items(), ({"stiffness": refuse_as_stiffness}, {}), strict=True)
)
