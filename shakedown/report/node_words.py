"""Nodes and their numbers as text shows them: by number, by label where they have one, without round-off."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import down, few, sized
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.visible_text import shortened
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.motion.contact_law import path_resolution, scales

if TYPE_CHECKING:
    from shakedown.assessment.slip_limit import SlipLimit

MOST_LABELS = 4  # that are listed beside the numbers
LONGEST_LABEL = 16  # characters of a label in a table
LONGEST_LISTING = 40  # rows


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
    """All of some nodes by number, neighbours in short, with the labels of a few.

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
    runs = [
        [node for _, node in run] for _, run in groupby(enumerate(nodes), key=lambda pair: pair[1] - pair[0])
    ]
    listed = [f"{run[0]}–{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs]
    text, labels = f"nodes {', '.join(listed)}", None if problem is None else problem.label
    if labels is None or len(nodes) > MOST_LABELS:
        return text
    return f"{text} (FE {', '.join(labels[i] for i in nodes)})"


def pinned_in_words(pinned: tuple[int, ...], problem: Problem | None = None) -> str:
    """What slips are relative to where friction alone holds a body; empty for a joint that is held.

    The slips that are set to zero are given by number: with one direction they are nodes.

    Examples
    --------
    >>> pinned_in_words((2,)), pinned_in_words(())
    ('The joint can move as a whole, only friction holds it: slips are given relative to node 2.', '')
    """
    if not pinned:
        return ""
    return (
        "The joint can move as a whole, only friction holds it: slips are given relative to "
        f"{open_in_words(pinned if problem is None else problem.layout.nodes_of(pinned), problem)}."
    )


def label_column(problem: Problem) -> dict[str, list[str]]:
    """The column of a table of nodes that names them in the model; none where they have no labels.

    Examples
    --------
    >>> import shakedown
    >>> label_column(shakedown.example("press-fit"))["FE"][:2], label_column(shakedown.example("two-node"))
    (['36/0', '37/1'], {})
    """
    labels = problem.label
    return {} if labels is None else {"FE": [shortened(label, LONGEST_LABEL) for label in labels]}


def slipping_nodes(slip: FloatArray, tolerances: Tolerances = DEFAULT) -> tuple[int, ...]:
    """Nodes that slip, by more than what counts as none beside the largest slip (``steadiness``).

    Examples
    --------
    >>> slipping_nodes(np.array([0.0, 2.0, 1e-15]))
    (1,)
    """
    return tuple(int(i) for i in np.flatnonzero(slip > tolerances.steadiness * slip.max(initial=0.0)))


def without_round_off(values: Sequence[float] | FloatArray, resolution: float) -> list[float]:
    """Values for people: what lies within the resolution of a result is zero.

    Examples
    --------
    >>> without_round_off([5.6e-15, 2.0, float("nan")], 1e-10)
    [0.0, 2.0, nan]
    """
    return [0.0 if abs(value) <= resolution else float(value) for value in values]


def resolution(problem: Problem, load_factor: float, tolerances: Tolerances = DEFAULT) -> tuple[float, float]:
    """The slip [length] and the work [force × length] per period that count as none in a long-term state.

    They are what a path resolves (:func:`path_resolution`) of the scales of the joint at that load factor.
    """
    scale, share = scales(problem, load_factor), path_resolution(problem, tolerances)
    return share * scale.length, share * scale.length * scale.force


def slip_limit_in_words(limit: SlipLimit, problem: Problem | None = None) -> str:
    """Up to where slips stay below a length, and what was simulated to say so.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown.assessment.slip_limit import slip_limit
    >>> joint = shakedown.example("press-fit")
    >>> slip_limit_in_words(slip_limit(joint, 1e-3), joint)
    'From its initial state every slip range stays below 0.001 mm up to λ = 1.321457: the largest there is
    0.0009998 mm, at node 4 (FE 40/4) (30 load factors up to 1.506 simulated).'
    """
    length = units_of(problem).length
    below = sized(limit.below, length)
    scan = f"({len(limit.scanned)} load factors up to {few(limit.scanned[-1])} simulated)"
    if np.isnan(limit.load_factor):
        return f"From its initial state slip ranges stay below {below} at no load factor {scan}."
    here = f"From its initial state every slip range stays below {below}"
    if np.isinf(limit.exceeded_at):
        return f"{here} at every load factor simulated {scan}."
    largest = "nothing slips there"
    if limit.node >= 0:
        where = node_in_words(problem, limit.node)
        largest = f"the largest there is {sized(limit.largest, length)}, at {where}"
    again = "" if limit.monotone else "; above it there are load factors at which it does again"
    return f"{here} up to λ = {down(limit.load_factor)}: {largest}{again} {scan}."


def table(
    headers: Sequence[str], rows: Sequence[Sequence[str]], indent: str = "  ", longest: int = LONGEST_LISTING
) -> str:
    """Right-aligned columns under their headers; long tables show their ends."""
    cut = len(rows) > longest
    half = longest // 2
    shown = [*rows[:half], *rows[-half:]] if cut else list(rows)
    widths = [max(map(len, column)) for column in zip(headers, *shown, strict=True)]
    lines = [_line(row, widths, indent) for row in [headers, *shown]]
    if cut:
        lines.insert(1 + half, f"{indent}… {len(rows) - 2 * half} rows more; --json has all …")
    return "\n".join(lines)


def _line(cells: Sequence[str], widths: Sequence[int], indent: str) -> str:
    return (indent + "  ".join(cell.rjust(width) for cell, width in zip(cells, widths, strict=True))).rstrip()
