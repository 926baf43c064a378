"""Reactions or displacements as a table that any report tool can write: step, node, fx, fy and maybe fz."""

import os
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.formats import Format, begins, format_of
from shakedown.models.readers.nodal_vectors import NodalVectors, What, refuse_as_stiffness
from shakedown.models.readers.table import NumberTable, read_table

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
_EXPECTED: dict[What, str] = {
    "reactions": "step, node, fx, fy and maybe fz",
    "displacements": "step, node, ux, uy and maybe uz",
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
    table = read_table(path)
    keys = _keys(table, what)
    steps, nodes = np.array(table.whole(keys[0])), np.array(table.whole(keys[1]), dtype=np.intp)
    vectors = np.zeros((len(steps), 3))
    for k, key in enumerate(keys[2:]):
        vectors[:, k] = table.column(key)
    place, first = np.unique(np.column_stack([steps, nodes]), axis=0, return_index=True)
    if len(place) < len(steps):
        k = int(np.setdiff1d(np.arange(len(steps)), first)[0])
        raise ProblemError(
            f"{table.name}: line {table.lines[k]}: expected every node once in a step, found node {nodes[k]} "
            f"twice in step {steps[k]}"
        )
    return [
        NodalVectors(what, ("table",), float(step), nodes[own], vectors[own])
        for step, own in ((step, steps == step) for step in np.unique(steps))
    ]


def _keys(table: NumberTable, what: What) -> list[str | int]:
    """The columns step, node, fx, fy and, where there is one, fz."""
    expected, width = _EXPECTED[what], table.values.shape[1]
    if not table.columns:
        if width not in (4, 5):
            raise ProblemError(f"{table.name}: expected the columns {expected}, found {width}")
        return list(range(1, width + 1))
    found: list[str | int] = []
    for k, pattern in enumerate(_HEADINGS[what]):
        own = [heading for heading in table.columns if re.fullmatch(pattern, heading.casefold())]
        if len(own) > 1 or (not own and k < 4):
            one = expected.replace(" and maybe", ",").split(", ")[k]
            raise ProblemError(f"{table.name}: expected one column '{one}', found {len(own)} ({expected})")
        found += own
    return found


_READS: dict[str, Callable[..., Any]] = {"stiffness": refuse_as_stiffness, "vectors": read_vectors_table}
FORMATS = (
    Format("reactions", "reactions", begins(is_reactions_table), _READS),
    Format("vectors", "a table", None, {"vectors": read_vectors_table}),
)
