"""Nodes and their results as text: by number, by label where they have one, without round-off."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from shakedown.ground.constants import EACH_SHOWN, FloatArray
from shakedown.ground.shown_values import shortened
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.contact_zone import coupled_parts, of_nodes
from shakedown.joint.problem import Problem
from shakedown.motion.checked_law import path_resolution, scales

if TYPE_CHECKING:
    from shakedown.long_term.node_table import NodeResults

AXES = "xy"  # of the two tangential directions of a node
COLUMNS = (  # of a table of results per node; the first ones are kept where the table is narrow
    "slip_range", "accumulated_slip", "work", "p_max", "p_min", "q_max",
    "pressure_max", "shear_max", "tau_delta", "wear_depth", "total_slip_bound",
)  # fmt: skip
LONGEST_ENTRY = 24  # characters of a label in a table


def node_in_words(problem: Problem | None, node: int) -> str:
    """One node, with its label in the model where it has one.

    Examples
    --------
    >>> import shakedown
    >>> node_in_words(shakedown.example("press-fit"), 1), node_in_words(None, 1)
    ('node 1 (FE 37/1)', 'node 1')
    """
    return f"node {node if problem is None else problem.node_name(node)}"


def open_in_words(nodes: tuple[int, ...], problem: Problem | None = None) -> str:
    """Nodes by number, consecutive ones as ranges, with labels where they are few.

    Examples
    --------
    >>> import shakedown
    >>> open_in_words((3,)), open_in_words((0, 1, 2, 3, 7, 8))
    ('node 3', 'nodes 0–3, 7, 8')
    >>> open_in_words((0, 1, 8), shakedown.example("press-fit"))
    'nodes 0, 1, 8 (FE 36/0, 37/1, 44/8)'
    """
    if len(nodes) == 1:
        return node_in_words(problem, nodes[0])
    text, labels = f"nodes {ranges(nodes)}", None if problem is None else problem.label
    if labels is None or len(nodes) > EACH_SHOWN:
        return text
    return f"{text} (FE {', '.join(labels[i] for i in nodes)})"


def node_column(problem: Problem) -> dict[str, list[str]]:
    """The columns that say which node a row is about: its number, and its label where it has one.

    Examples
    --------
    >>> import shakedown
    >>> list(node_column(shakedown.example("press-fit"))), list(node_column(shakedown.example("two-node")))
    (['node', 'FE'], ['node'])
    """
    numbers = {"node": list(map(str, range(problem.n)))}
    labels = problem.label
    return (
        numbers if labels is None else numbers | {"FE": [shortened(label, LONGEST_ENTRY) for label in labels]}
    )


def without_round_off(values: Sequence[float] | FloatArray, resolution: float | FloatArray) -> list[float]:
    """Values for display: those within the resolution of a result, or of each, become zero.

    Examples
    --------
    >>> without_round_off([5.6e-15, 2.0, float("nan")], 1e-10)
    [0.0, 2.0, nan]
    """
    none = np.broadcast_to(resolution, len(values))
    return [0.0 if abs(value) <= least else float(value) for value, least in zip(values, none, strict=True)]


def resolution(
    problem: Problem, load_factor: float, tolerances: Tolerances = DEFAULT
) -> tuple[FloatArray, FloatArray]:
    """The slip [length] and the work [force × length] of each node per period that count as none, (n,).

    They are the resolution of a path (:func:`path_resolution`) times the scales of the joint there, of the
    part of it that the node is coupled with.
    """
    parts, share = coupled_parts(problem), path_resolution(problem, tolerances)
    known = [(part.joint.n, scales(part.joint, load_factor)) for part in parts]
    slip = of_nodes(parts, (np.full(n, share * each.length) for n, each in known))
    return slip, of_nodes(parts, (np.full(n, share * each.length * each.force) for n, each in known))


def node_columns(nodes: NodeResults, problem: Problem) -> dict[str, FloatArray]:
    """Results per node, round-off as 0, by their names in a file; without columns that are all unknown."""
    none = resolution(problem, nodes.load_factor)
    resolved = {"slip_range": none[0], "accumulated_slip": none[0], "work": none[1]}
    columns = {
        word: np.array(without_round_off(getattr(nodes, word), resolved.get(word, 0.0))) for word in COLUMNS
    }
    return {word: values for word, values in columns.items() if not np.isnan(values).all()}


def worst_first(nodes: NodeResults, problem: Problem) -> list[int]:
    """The nodes by decreasing slip range; equal ones by decreasing pressure."""
    slip = without_round_off(nodes.slip_range, resolution(problem, nodes.load_factor)[0])
    return np.lexsort([-np.nan_to_num(part, nan=-1.0) for part in (nodes.p_max, np.array(slip))]).tolist()


def by_direction(problem: Problem, name: str, slips: FloatArray) -> dict[str, list[float]]:
    """A column of slips, or with two tangential directions one column for each.

    Examples
    --------
    >>> import shakedown
    >>> by_direction(shakedown.example("one-node-3d"), "slip", np.array([1.0, 2.0]))
    {'slip x': [1.0], 'slip y': [2.0]}
    """
    names = [name] if problem.directions == 1 else [f"{name} {axis}" for axis in AXES]
    return dict(zip(names, problem.layout.by_node(slips).T.tolist(), strict=True))


def ranges(numbers: Sequence[int]) -> str:
    """Increasing numbers, consecutive ones as ``first–last``."""
    runs = [
        [number for _, number in run]
        for _, run in groupby(enumerate(numbers), key=lambda pair: pair[1] - pair[0])
    ]
    return ", ".join(f"{run[0]}–{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs)
