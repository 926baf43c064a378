"""Nodes and their results as text: by number, by label where they have one, without round-off."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from shakedown.bounds.bound_result import Bound
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import FEW_DIGITS, down, few, sized, up
from shakedown.ground.size_limits import EACH_SHOWN
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.visible_text import shortened, with_unit
from shakedown.joint.constraints import SIDE_NAMES
from shakedown.joint.coupled_parts import coupled_parts, of_nodes
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.motion.checked_law import path_resolution, scales

if TYPE_CHECKING:
    from shakedown.assessment.slip_limit import SlipLimit
    from shakedown.bounds.uniqueness.friction_thresholds import FrictionThresholds
    from shakedown.long_term.node_table import NodeResults

AXES = "xy"  # of the two tangential directions of a node
COLUMNS = (  # of a table of results per node; the first ones are kept where the table is narrow
    "slip_range", "accumulated_slip", "work", "p_max", "p_min", "q_max",
    "pressure_max", "shear_max", "tau_delta", "wear_depth", "total_slip_bound",
)  # fmt: skip
LONGEST_ENTRY = 24  # characters in a column


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
    text, labels = f"nodes {_ranges(nodes)}", None if problem is None else problem.label
    if labels is None or len(nodes) > EACH_SHOWN:
        return text
    return f"{text} (FE {', '.join(labels[i] for i in nodes)})"


def pinned_in_words(pinned: tuple[int, ...], problem: Problem | None = None) -> str:
    """Which slip components are set to zero where only friction holds a body; empty for a joint that is held.

    The components are given by number; with one tangential direction these are nodes.

    Examples
    --------
    >>> print(pinned_in_words((2,)))
    Only friction keeps one body from sliding or turning on the other, as in a bolted joint. Slips are
    given relative to node 2, where slip is set to zero.
    """
    if not pinned:
        return ""
    d = 1 if problem is None else problem.directions
    named = [f"{'' if d == 1 else f'{AXES[k % d]} of '}{node_in_words(problem, k // d)}" for k in pinned]
    return (
        "Only friction keeps one body from sliding or turning on the other, as in a bolted joint. Slips are "
        f"given relative to {', '.join(named)}, where slip is set to zero."
    )


def label_column(problem: Problem) -> dict[str, list[str]]:
    """The column with the labels of the nodes in the model; none where they have no labels.

    Examples
    --------
    >>> import shakedown
    >>> label_column(shakedown.example("press-fit"))["FE"][:2], label_column(shakedown.example("two-node"))
    (['36/0', '37/1'], {})
    """
    labels = problem.label
    return {} if labels is None else {"FE": [shortened(label, LONGEST_ENTRY) for label in labels]}


def slipping_nodes(slip: FloatArray, tolerances: Tolerances = DEFAULT) -> tuple[int, ...]:
    """Nodes whose slip is not negligible beside the largest slip (``steadiness``).

    Examples
    --------
    >>> slipping_nodes(np.array([0.0, 2.0, 1e-15]))
    (1,)
    """
    return tuple(int(i) for i in np.flatnonzero(slip > tolerances.steadiness * slip.max(initial=0.0)))


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


def no_node_ever_slips(nodes: NodeResults) -> bool:
    """Whether it is proved that no node slips at all, from the initial state on."""
    return float(nodes.total_slip_bound.max()) == 0.0


def total_slip_in_words(nodes: NodeResults, problem: Problem) -> str:
    """The proved bound on the total slip of any node; empty where there is none.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> total_slip_in_words(shakedown.node_results(shakedown.long_term_state(joint, 0.7)), joint)
    'Proved: at λ = 0.7, from this initial state on, no node ever slips more than 1.252 in all.'
    """
    most = float(nodes.total_slip_bound.max())
    if np.isnan(most):
        return ""
    here = f"Proved: at λ = {nodes.load_factor:g}, from this initial state on, no node ever slips"
    if no_node_ever_slips(nodes):
        return f"{here}."
    return f"{here} more than {up(most, FEW_DIGITS)} {units_of(problem).length}".rstrip() + " in all."


def worst_first(nodes: NodeResults, problem: Problem) -> list[int]:
    """The nodes by decreasing slip range; equal ones by decreasing pressure."""
    slip = without_round_off(nodes.slip_range, resolution(problem, nodes.load_factor)[0])
    return np.lexsort([-np.nan_to_num(part, nan=-1.0) for part in (nodes.p_max, np.array(slip))]).tolist()


def slip_limit_in_words(limit: SlipLimit, problem: Problem | None = None) -> str:
    """The load factor up to which slips stay below a length, and what was simulated to find it.

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


def by_direction(problem: Problem, name: str, slips: FloatArray) -> dict[str, list[float]]:
    """A column of slips, or with two tangential directions one column for each.

    Examples
    --------
    >>> import shakedown
    >>> by_direction(shakedown.example("one-node-3d"), "slip", np.array([1.0, 2.0]))
    {'slip x': [1.0], 'slip y': [2.0]}
    """
    return dict(zip(of_directions(problem, name), problem.layout.by_node(slips).T.tolist(), strict=True))


def of_directions(problem: Problem, name: str, between: str = " ") -> list[str]:
    """The name of a tangential quantity, or with two directions the names of both components."""
    return [name] if problem.directions == 1 else [f"{name}{between}{axis}" for axis in AXES]


def bound_columns(
    problem: Problem,
    upper: Bound,
    shown: Callable[[float], str],
    lower: Bound | None = None,
    friction: FrictionThresholds | None = None,
) -> dict[str, list[str]]:
    """Columns of a table of nodes: the slips of the bounds, limits reached at λ_max, friction thresholds.

    ``shown`` formats a number; it must also accept NaN.
    """
    slips = by_direction(problem, "safe slip", upper.slip)
    slips |= {} if lower is None else {"critical": lower.slip.tolist()}
    unit = units_of(problem).length
    columns = {with_unit(name, unit): list(map(shown, values)) for name, values in slips.items()}
    reached = [_reached(problem, upper, node) for node in range(problem.n)]
    columns["reached at λ_max"] = [text or shown(np.nan) for text in reached]
    if friction is not None:
        columns["f threshold"] = list(map(shown, friction.single_node))
    return columns


def _reached(problem: Problem, upper: Bound, node: int) -> str:
    """The limits that a node reaches at λ_max: sides, or with two directions load steps."""
    reached = [where for at, where in upper.active if at == node]
    if node in upper.open_nodes:
        return "open; gap closes" if reached else "open"
    if problem.directions == 1:
        return "+".join(SIDE_NAMES[side] for side in reached)
    said = _ranges(sorted(reached))
    return said if len(said) <= LONGEST_ENTRY else f"{len(reached)} load steps"


def _ranges(numbers: Sequence[int]) -> str:
    """Increasing numbers, consecutive ones as ``first–last``."""
    runs = [
        [number for _, number in run]
        for _, run in groupby(enumerate(numbers), key=lambda pair: pair[1] - pair[0])
    ]
    return ", ".join(f"{run[0]}–{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs)
