"""What a static step gave at nodes, reactions or displacements: ``.dat`` and ``.frd`` of CalculiX, tables."""

import os
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, NoReturn

import numpy as np
from scipy import sparse

from shakedown.ground.constants import SEVEN_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import ProblemError
from shakedown.ground.tolerances import DEFAULT
from shakedown.models.condensation.stiffness_checks import asymmetry
from shakedown.models.readers import parsing
from shakedown.models.readers.formats import Format, format_of, has
from shakedown.models.readers.parsing import quoted, unfit
from shakedown.models.readers.stiffness import Stiffness

What = Literal["reactions", "displacements"]


@dataclass(frozen=True, eq=False)
class NodalVectors:
    """Reactions (forces on the body) or displacements at nodes.

    Attributes
    ----------
    what : str
        Which of the two.
    node_sets : tuple of str
        Node sets they were printed for.
    time : float
        Time of the step.
    nodes : (n,)
        Node labels.
    vectors : (n, 3)
        Components along x, y, z [force or length].
    by_calculix : bool
        Whether CalculiX printed them. Its reactions are the internal forces, without loads that act at the
        node itself; those of axisymmetric models lack a part.
    local
        Nodes whose components are along directions of their own (``*TRANSFORM``).
    """

    what: What
    node_sets: tuple[str, ...]
    time: float
    nodes: IntArray
    vectors: FloatArray
    by_calculix: bool = False
    local: frozenset[int] = frozenset()

    def at(self, nodes: IntArray, axes: tuple[int, ...], tied: IntArray | None = None) -> FloatArray:
        """Components at nodes in two or three directions, (k, 2), with those of nodes tied to them added.

        Raises
        ------
        ProblemError
            If a node was not printed, or there is not one tied node for each.
        """
        if tied is not None:
            if tied.shape != nodes.shape:
                raise unfit("tied", f"one node for each of {len(nodes)} contact nodes", len(tied))
            return self.at(nodes, axes) + self.at(tied, axes)
        return self.vectors[self.places(nodes)][:, [axis - 1 for axis in axes]]

    def places(self, nodes: IntArray, what: str = "contact node") -> list[int]:
        """The positions of nodes in the table; ``ProblemError`` if one was not printed."""
        index = {int(node): k for k, node in enumerate(self.nodes)}
        absent = [int(node) for node in nodes if int(node) not in index]
        if absent:
            raise ProblemError(
                f"{self.what} at time {self.time:g}: expected {what} {absent[0]}, found it not printed "
                f"({len(absent)} of {len(nodes)} are missing)"
            )
        return [index[int(node)] for node in nodes]


def in_model_directions(run: NodalVectors, directions: Callable[[IntArray], FloatArray]) -> NodalVectors:
    """The vectors in components along x, y, z; ``directions`` has the axes of every node, (k, 3, 3).

    Examples
    --------
    >>> turned = np.array([[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
    >>> one, nodes = np.array([[5.0, 0.0, 2.0]]), np.array([7])
    >>> run = NodalVectors("reactions", ("N",), 1.0, nodes, one, local=frozenset([7]))
    >>> in_model_directions(run, lambda nodes: turned).vectors
    array([[0., 5., 2.]])
    """
    own = np.isin(run.nodes, list(run.local))
    if not own.any():
        return run
    vectors = run.vectors.copy()
    vectors[own] = np.einsum("ki,kij->kj", vectors[own], directions(run.nodes[own]))
    return replace(run, vectors=vectors, local=frozenset())


def refuse_as_stiffness(path: str | os.PathLike[str]) -> NoReturn:
    """Say that reactions alone are no stiffness."""
    raise ProblemError(
        f"{os.fspath(path)}: expected a matrix, found reactions; they make a stiffness only with the list of "
        f"contact nodes that were moved (import {Path(path).name} with a configuration)"
    )


_HEADING = r"^\s*{} for set (\S+) and time\s+(\S+)"
HEADINGS: dict[What, re.Pattern[str]] = {
    "reactions": re.compile(_HEADING.format(r"forces \(fx,fy,fz\)"), re.IGNORECASE),
    "displacements": re.compile(_HEADING.format(r"displacements \(vx,vy,vz\)"), re.IGNORECASE),
}
LETTERS: dict[What, str] = {"reactions": "RF", "displacements": "U"}


def read_calculix_output(path: str | os.PathLike[str], what: What = "reactions") -> list[NodalVectors]:
    """Read all tables of reactions, or of displacements, of a ``.dat`` file, in the order of the file.

    Tables of several node sets at one time are one step.

    Raises
    ------
    ProblemError
        If there is no table, or a line of one is malformed.
    """
    name, inside = os.fspath(path), False
    steps: list[tuple[list[str], float, list[list[float]], set[int]]] = []  # sets, time, rows, turned nodes
    for k, line in enumerate(parsing.read_lines(path), start=1):
        where, fields = f"{name}: line {k}", line.split()
        if heading := HEADINGS[what].match(line):
            time, inside = parsing.number(heading[2], where), True
            if not steps or time != steps[-1][1] or heading[1] in steps[-1][0]:
                steps.append(([], time, [], set()))
            steps[-1][0].append(heading[1])
        elif fields and not fields[0].isdigit():  # another kind of output
            inside = False
        elif fields and inside:
            own = fields[4:] == ["L"]  # components along the directions of a *TRANSFORM
            if len(fields) != 4 + own:
                letter = "f" if what == "reactions" else "v"
                raise unfit(where, f"'node {letter}x {letter}y {letter}z'", quoted(line))
            steps[-1][2].append([*parsing.integers(fields[:1], where), *parsing.numbers(fields[1:4], where)])
            steps[-1][3].update([int(fields[0])] if own else [])
    if not steps:
        raise ProblemError(
            f"{name}: expected {what} (*NODE PRINT, {LETTERS[what]}), found no table of "
            f"{'forces' if what == 'reactions' else what}"
        )
    return [
        replace(step_of(what, tuple(sets), time, rows, name), local=frozenset(local))
        for sets, time, rows, local in steps
    ]


def step_of(
    what: What, node_sets: tuple[str, ...], time: float, rows: list[list[float]], name: str
) -> NodalVectors:
    """One step of CalculiX; ``ProblemError`` if it is empty, or has two vectors of a node."""
    if not rows:
        raise unfit(name, f"{what} at time {time:g}", "an empty table")
    data = np.unique(rows, axis=0)  # a node of two sets is printed twice
    twice = np.flatnonzero(np.diff(data[:, 0]) == 0)
    if twice.size:
        raise unfit(name, f"every node once at time {time:g}", f"node {data[twice[0], 0]:g} twice")
    return NodalVectors(what, node_sets, time, data[:, 0].astype(np.intp), data[:, 1:], by_calculix=True)


def unit_displacement_stiffness(
    steps: list[NodalVectors],
    nodes: IntArray,
    *,
    axes: tuple[int, ...] = (1, 2),
    tied: IntArray | None = None,
) -> Stiffness:
    """The condensed stiffness from one static step per contact degree of freedom.

    Each step moves one contact node by 1 in one direction and holds all others, in the order (node 1, x),
    (node 1, y), (node 2, x) … or x of all nodes, then y: the one in which the stiffness is symmetric. Its
    reactions are a column of the stiffness. Rigid motions of a
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
    if turned := sorted(frozenset().union(*(step.local for step in steps))):
        expected = "reactions to unit displacements along x, y, z"
        raise ProblemError(f"expected {expected}, found those of node {turned[0]} in a *TRANSFORM")
    if len(steps) != d * n:
        expected = f"{d * n} steps, {d} for each of {n} contact nodes ('directions' says how many)"
        raise unfit("unit displacements", expected, len(steps))
    columns = np.array([step.at(nodes, axes, tied).ravel() for step in steps]).T
    K = min(columns, columns[:, np.arange(d * n).reshape(d, n).T.ravel()], key=asymmetry)
    if np.diag(K).max() < 0:
        raise ProblemError(
            "unit displacements: expected reactions that point the way the node was moved (the force on the "
            "body), found them reversed"
        )
    error = asymmetry(K)
    if error > DEFAULT.printed_digits:
        found = f"an asymmetry of {error:.2g}, whether the steps go node by node or direction by direction"
        raise unfit("unit displacements", "a symmetric stiffness", found)
    K = 0.5 * K + 0.5 * K.T
    eigenvalues, modes = np.linalg.eigh(K)
    rigid = np.abs(eigenvalues) <= DEFAULT.printed_digits * eigenvalues[-1]  # drown in the printed digits
    if rigid.any():
        K = K - (modes[:, rigid] * eigenvalues[rigid]) @ modes[:, rigid].T
    dofs = np.column_stack([np.repeat(nodes, d), np.tile(axes, n)]).astype(np.intp)
    return Stiffness(
        sparse.csr_array(K),
        dofs,
        "reactions to unit displacements",
        superelement=True,
        accuracy=SEVEN_DIGITS,
    )


def read_frd(path: str | os.PathLike[str], what: What = "displacements") -> list[NodalVectors]:
    """Read all blocks of displacements (DISP), or of reactions (FORC), in the order of the file.

    They are those of ``*NODE FILE``, of text, with six digits.

    Raises
    ------
    ProblemError
        If there is no such block, or one is malformed.
    """
    name, found, block = os.fspath(path), list[NodalVectors](), "FORC" if what == "reactions" else "DISP"
    nodes = {"0": slice(3, 8), "1": slice(3, 13)}  # columns of the node, by the format of a block
    time, layout, rows = 0.0, "", list[list[float]]()
    inside = False
    for k, line in enumerate(parsing.read_lines(path), start=1):
        where = f"{name}: line {k}"
        if line.startswith("  100C"):  # how results begin
            time, layout = parsing.number(line[12:24].strip(), where), line[73:75].strip()
        elif line.split()[:2] == ["-4", block]:
            if layout not in nodes:
                raise unfit(where, "a block in text form (*NODE FILE)", f"the format {quoted(layout)}")
            inside, rows = True, []
        elif inside and line.startswith(" -1"):
            node = nodes[layout]  # then come numbers of 12 characters, which nothing separates
            fields = [line[node.stop + 12 * k : node.stop + 12 * (k + 1)].strip() for k in range(3)]
            if not fields[-1]:
                raise unfit(where, "a node with three numbers", quoted(line))
            rows.append([*parsing.integers([line[node].strip()], where), *parsing.numbers(fields, where)])
        elif inside and line.startswith(" -3"):
            found.append(step_of(what, ("file",), time, rows, name))
            inside = False
    if inside:
        raise unfit(name, "a block in text form that ends with -3", "no end")
    if not found:
        raise unfit(name, f"{what} (*NODE FILE, {LETTERS[what]})", f"no block {block}")
    return found


_HEADINGS = {  # of the columns, by regular expressions
    what: [
        r"step|load ?step|frame|run",
        r"node|(node )?label|node number|nid",
        *(rf"{letter}{x}|({full}\.)?{full}{k}|{word} {x}" for k, x in enumerate("xyz", start=1)),
    ]
    for what, letter, full, word in (
        ("reactions", "f", "rf", "reaction"),
        ("displacements", "u", "u", "displacement"),
    )
}


def is_reactions_table(text: str) -> bool:
    """Whether the first line of a text names the columns step, node, fx, fy."""
    lines = (line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#"))
    first = next(lines, "").casefold()
    splits = [[field.strip().strip('"') for field in first.split(mark)] for mark in ("\t", ";", ",", None)]
    wanted = [re.compile(pattern).fullmatch for pattern in _HEADINGS["reactions"][:4]]
    return any(all(any(map(fits, headings)) for fits in wanted) for headings in splits)


def read_nodal_vectors(path: str | os.PathLike[str], what: What = "reactions") -> list[NodalVectors]:
    """Read reactions or displacements: a ``.dat`` or ``.frd`` file of CalculiX, or a table: by content."""
    return format_of(path, "vectors").reads["vectors"](path, what)


def read_vectors_table(path: str | os.PathLike[str], what: What = "reactions") -> list[NodalVectors]:
    """Read a table with the columns step, node, fx, fy and maybe fz, one table per step.

    Without a header the columns must stand in this order. The header names them
    step, node, fx, fy, fz or RF1, RF2, RF3, and for displacements ux, uy, uz or U1, U2, U3; others
    beside them are passed over.
    Steps follow in the order of their numbers.

    Raises
    ------
    ProblemError
        If a column is missing, a step or node is not whole, or a node occurs
        twice in one step.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "rf.csv"
    >>> _ = path.write_text("step;node;fx;fy\\n1;7;0,5;-2\\n2;7;1;3\\n")
    >>> [(step.time, step.nodes.tolist(), step.vectors.tolist()) for step in read_vectors_table(path)]
    [(1.0, [7], [[0.5, -2.0, 0.0]]), (2.0, [7], [[1.0, 3.0, 0.0]])]
    """
    table = parsing.read_table(path)
    keys = _keys(table, what)
    steps, nodes = np.array(table.whole(keys[0])), np.array(table.whole(keys[1]), dtype=np.intp)
    vectors = np.zeros((len(steps), 3))
    for k, key in enumerate(keys[2:]):
        vectors[:, k] = table.column(key)
    seen, count = np.unique(np.column_stack([steps, nodes]), axis=0, return_counts=True)
    if len(seen) < len(steps):
        step, node = seen[np.argmax(count)]
        raise unfit(table.name, "every node once in a step", f"node {node} twice in step {step}")
    return [
        NodalVectors(what, ("table",), float(step), nodes[own], vectors[own])
        for step, own in ((step, steps == step) for step in np.unique(steps))
    ]


def _keys(table: parsing.NumberTable, what: What) -> list[str | int]:
    """The columns step, node, fx, fy and, where there is one, fz."""
    letter, width = "f" if what == "reactions" else "u", table.values.shape[1]
    expected = f"step, node, {letter}x, {letter}y and maybe {letter}z"
    if not table.columns:
        if width not in (4, 5):
            raise unfit(table.name, f"the columns {expected}", width)
        return list(range(1, width + 1))
    found: list[str | int] = []
    for k, pattern in enumerate(_HEADINGS[what]):
        own = [heading for heading in table.columns if re.fullmatch(pattern, heading.casefold())]
        if len(own) > 1 or (not own and k < 4):
            one = expected.replace(" and maybe", ",").split(", ")[k]
            raise unfit(table.name, f"one column '{one}'", f"{len(own)} ({expected})")
        found += own
    return found


_FRD = "the results of a CalculiX run (.frd); they are of a load: its key 'open', 'reactions' or 'thermal'"
_OF_RUN: dict[str, Callable[..., Any]] = {"vectors": read_calculix_output}
_OF_DAT = _OF_RUN | {"stiffness": refuse_as_stiffness}
_OF_TABLE = _OF_DAT | {"vectors": read_vectors_table}
FORMATS = (
    Format("frd", _FRD, {"vectors": read_frd}, begins=lambda text: text.startswith("    1C")),
    Format("reactions", "reactions", _OF_DAT, contains=has(HEADINGS["reactions"])),
    Format("displacements", "displacements", _OF_RUN, contains=has(HEADINGS["displacements"])),
    Format("reactions", "reactions", _OF_TABLE, begins=is_reactions_table),
    Format("vectors", "a table", {"vectors": read_vectors_table}),
)
