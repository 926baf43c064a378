"""Reactions as a table that any report tool can write: step, node, fx, fy and maybe fz."""

import os

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.readers.calculix_reactions import HEADING, Reactions, read_calculix_reactions
from shakedown.readers.table import NumberTable, read_table
from shakedown.readers.text import read_lines

_NAMES = (  # accepted headings of the columns
    ("step", "load step", "loadstep", "frame", "run"),
    ("node", "node label", "label", "node number", "nid"),
    ("fx", "rf1", "rf.rf1", "reaction x"),
    ("fy", "rf2", "rf.rf2", "reaction y"),
    ("fz", "rf3", "rf.rf3", "reaction z"),
)


def is_reactions_table(lines: list[str]) -> bool:
    """Whether the first line names the columns step, node, fx, fy."""
    first = next((line for line in lines if line.strip() and not line.lstrip().startswith("#")), "")
    for mark in ("\t", ";", ","):
        headings = {field.strip().strip('"').casefold() for field in first.split(mark)}
        if all(headings & set(names) for names in _NAMES[:4]):
            return True
    headings = set(first.casefold().split())
    return all(headings & set(names) for names in _NAMES[:4])


def read_reactions(path: str | os.PathLike[str]) -> list[Reactions]:
    """Read reactions of any kind: a CalculiX ``.dat`` file, or a table; its content decides."""
    lines = read_lines(path)
    if any(HEADING.match(line) for line in lines):
        return read_calculix_reactions(path)
    return read_reactions_table(path)


def read_reactions_table(path: str | os.PathLike[str]) -> list[Reactions]:
    """Read a table with the columns step, node, fx, fy and maybe fz, one table per step.

    Without a header the columns must stand in this order. The header names them
    step, node, fx, fy, fz or RF1, RF2, RF3; others beside them are passed over.
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
    >>> [(step.time, step.nodes.tolist(), step.forces.tolist()) for step in read_reactions_table(path)]
    [(1.0, [7], [[0.5, -2.0, 0.0]]), (2.0, [7], [[1.0, 3.0, 0.0]])]
    """
    table = read_table(path)
    keys = _keys(table)
    steps, nodes = np.array(table.whole(keys[0])), np.array(table.whole(keys[1]), dtype=np.intp)
    forces = np.zeros((len(steps), 3))
    for k, key in enumerate(keys[2:]):
        forces[:, k] = table.column(key)
    place, first = np.unique(np.column_stack([steps, nodes]), axis=0, return_index=True)
    if len(place) < len(steps):
        k = int(np.setdiff1d(np.arange(len(steps)), first)[0])
        raise ProblemError(
            f"{table.name}: line {table.lines[k]}: expected every node once in a step, found node "
            f"{nodes[k]} twice "
            f"in step {steps[k]}"
        )
    return [
        Reactions(("table",), float(step), nodes[steps == step], forces[steps == step])
        for step in np.unique(steps)
    ]


def _keys(table: NumberTable) -> list[str | int]:
    """The columns step, node, fx, fy and, where there is one, fz."""
    if not table.columns:
        width = table.values.shape[1]
        if width not in (4, 5):
            raise ProblemError(
                f"{table.name}: expected the columns step, node, fx, fy and maybe fz, found {width}"
            )
        return list(range(1, width + 1))
    found: list[str | int] = []
    for names in _NAMES:
        own = [heading for heading in table.columns if heading.casefold() in names]
        if len(own) > 1 or (not own and names is not _NAMES[4]):
            raise ProblemError(
                f"{table.name}: expected one column '{names[0]}', found {len(own)} (step, node, fx, "
                "fy and maybe fz)"
            )
        found += own
    return found
