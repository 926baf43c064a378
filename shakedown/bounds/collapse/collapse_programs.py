"""The linear programs of the first collapse: one per node, its two rows reversed."""

from dataclasses import dataclass
from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import ITERATIONS, NEGLIGIBLE, SETTLED, FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import Constraints, by_side, rows_of
from shakedown.programs.program import INF, Solution, power_of_two
from shakedown.programs.simplex import Simplex

_NEWTON_UP_TO = 12  # nodes; one system of equations for each
_NEARLY_FIRST = 10 * NEGLIGIBLE  # nodes this close are distinguished by polishing, not by the solver's 1e-10


def mean_load_is_safe(rows: Constraints, program: Simplex, tolerances: Tolerances) -> bool:
    """Whether some slip is safe under the mean load alone."""
    if np.all(rows.g > 0) or _unloads(rows):  # slip zero is safe, or one found without a program
        return True
    start = program.solve()
    if not start.optimal:
        return False
    return bool(rows.relative_excess(rows.slips(start.x[:-1]), 0.0).max() <= tolerances.feasibility)


def _unloads(rows: Constraints) -> bool:
    """Whether the slip that removes all tangential reactions of the mean load is safe."""
    if rows.pinned:
        return False
    G, g = by_side(rows.G[rows.sided]), by_side(rows.g[rows.sided])
    pull = 0.5 * (g[:, 1] - g[:, 0])
    try:
        slip: FloatArray = np.asarray(np.linalg.solve(0.5 * (G[:, 0] - G[:, 1]), -pull), dtype=float)
    except np.linalg.LinAlgError:
        return False
    return bool(rows.relative_excess(slip, 0.0).max() < 0)


def collapses(
    rows: Constraints, program: Simplex, limits: "CollapseLimits", all_nodes: bool
) -> dict[int, Solution]:
    """The solutions of the programs of nodes: in one model the two rows of one node are reversed at a time.

    Each begins where its limit would be reached; where that is its vertex no solver is needed. Unless
    ``all_nodes`` are wanted, none is solved that cannot collapse first.
    """
    outcomes: dict[int, Solution] = {}
    free, earliest = np.full(2, INF), inf
    for node in np.argsort(limits.load_factors, kind="stable").tolist():
        if not all_nodes and limits.load_factors[node] > earliest * (1 + _NEARLY_FIRST):
            break
        pair = rows_of(node)
        program.set_rows(pair, rows.g[pair], free)
        met = program.at(limits.rows[node]) if limits.known[node] else None
        outcomes[node] = outcome = met or program.solve()
        program.set_rows(pair, -free, rows.g[pair])
        earliest = min(earliest, inf if np.isnan(outcome.value) else outcome.value)
        if not all_nodes and outcome.value <= 0.0 and _value(outcome) == 0.0:
            break
    return outcomes


@dataclass(frozen=True)
class CollapseLimits:
    """Load factors that no node collapses below, from one multiplier per node and no program.

    Attributes
    ----------
    load_factors : (n,)
        0 where nothing is known, inf where a node never collapses.
    rows : (n, n + 1)
        The rows that would meet there.
    known : (n,)
        Whether there is such a limit.
    """

    load_factors: FloatArray
    rows: NDArray[np.intp]
    known: NDArray[np.bool_]


def collapse_limits(rows: Constraints) -> CollapseLimits:
    """The limits that the multipliers of one row per node prove.

    The program of node j has the multipliers y of its own rows, y₊ + y₋ = 1, and at a vertex where no
    other node is at both its limits one y_i of each other node. With s_i = ± y_i, + in the backward
    row, and s_j = y₋ − y₊ they solve

        A s = (f B)ᵀ |s|,    |s_j| replaced by −1:

    neither loads nor the load factor are in it, so that it is iterated for all nodes at once. Whatever
    the vertex is, λ ≥ y·g / y·d by weak duality; up to the first collapse it is the value itself.
    """
    n = rows.n
    limits = CollapseLimits(np.zeros(n), np.zeros((n, n + 1), dtype=np.intp), np.zeros(n, dtype=bool))
    G = by_side(rows.G[rows.sided])
    backward, forward = G[:, 0], -G[:, 1]
    stiffness = 0.5 * np.diagonal(backward + forward)
    # Where a body floats, some nodes have no row in the vertex; a node without friction is at both limits.
    if rows.pinned or not (np.all(stiffness > 0) and rows.sided.all()):
        return limits
    size = np.array([power_of_two(float(root)) for root in np.sqrt(stiffness)])
    A, fB = (part / size / size[:, None] for part in (0.5 * (backward + forward), 0.5 * (forward - backward)))
    s, settled = _multipliers(A, fB)
    if not settled.any():
        return limits
    y = np.stack([-np.maximum(s.T, 0.0), np.minimum(s.T, 0.0)], axis=2)  # by node and side
    nodes, own = np.arange(n), np.diagonal(s)
    y[nodes, nodes] = np.column_stack([0.5 * (1.0 - own), 0.5 * (1.0 + own)])
    y /= size[:, None]  # so far in units of the rows divided by the size of their node
    return _limits(rows, y.reshape(n, -1), s, settled & (np.abs(own) <= 1.0))


def _multipliers(A: FloatArray, fB: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """s of every node as columns, and which of them have settled."""
    try:
        influence: FloatArray = np.asarray(np.linalg.solve(A, fB.T), dtype=float)
        return _iterated(influence) if len(A) > _NEWTON_UP_TO else _by_newton(influence)
    except np.linalg.LinAlgError:
        return np.zeros_like(A), np.zeros(len(A), dtype=bool)


def _iterated(influence: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    s = -influence
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(ITERATIONS):
            folded = np.abs(s)
            np.fill_diagonal(folded, -1.0)
            before, s = s, influence @ folded
            change, largest = np.abs(s - before).max(axis=0), np.maximum(np.abs(s).max(axis=0), 1.0)
            if np.all(change <= SETTLED * largest):
                break
    settled: NDArray[np.bool_] = change <= SETTLED * largest
    return s, settled


def _by_newton(influence: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """The same for few nodes: with the signs of the last s the equations are linear; few change twice."""
    n = len(influence)
    nodes, s = np.arange(n), -influence
    for _ in range(ITERATIONS):
        signs = np.where(s.T < 0.0, -1.0, 1.0)  # by node of the program, then by node
        signs[nodes, nodes] = 0.0
        matrices = np.eye(n) - influence * signs[:, None, :]
        s = np.asarray(np.linalg.solve(matrices, -influence.T[:, :, None])[:, :, 0].T, dtype=float)
        changed = (np.where(s.T < 0.0, -1.0, 1.0) != signs) & (signs != 0.0)
        if not changed.any():
            break
    return s, ~changed.any(axis=1)


def _limits(rows: Constraints, y: FloatArray, s: FloatArray, known: NDArray[np.bool_]) -> CollapseLimits:
    n, terms = rows.n, np.abs(y) @ np.abs(rows.d)
    value, slope = y @ rows.g, y @ rows.d
    rising, never = slope > SETTLED * n * terms, value > SETTLED * n * (np.abs(y) @ np.abs(rows.g))
    with np.errstate(divide="ignore", invalid="ignore"):
        load_factors = np.where(rising, np.maximum(value / slope, 0.0), np.where(never, inf, 0.0))
    sides = 2 * np.arange(n) + (s.T <= 0.0)
    others = sides[~np.eye(n, dtype=bool)].reshape(n, n - 1)
    own = 2 * np.arange(n)[:, None] + np.arange(2)
    meeting = np.sort(np.hstack([others, own]), axis=1)
    return CollapseLimits(np.where(known, load_factors, 0.0), meeting, known)


def collapse_values(n: int, outcomes: dict[int, Solution]) -> FloatArray:
    """Where each node collapses, to the accuracy of the solver; inf where never, NaN where not requested."""
    values = np.full(n, nan)
    for node, outcome in outcomes.items():
        values[node] = inf if np.isnan(outcome.value) else outcome.value
    return values


def first_to_collapse(outcomes: dict[int, Solution]) -> int:
    """The node that collapses first; ties beyond the solver's accuracy are resolved to round-off."""
    values = {node: inf if np.isnan(end.value) else end.value for node, end in sorted(outcomes.items())}
    least = min(values.values())
    if least == inf:
        return min(values)
    near = [node for node, value in values.items() if value <= least + _NEARLY_FIRST * abs(least)]
    return min(near, key=lambda node: _value(outcomes[node]))


def _value(outcome: Solution) -> float:
    return float(outcome.x[-1]) if outcome.optimal else inf


def collapse_excess(rows: Constraints, node: int, x: FloatArray) -> float:
    """Largest relative violation of the rows, those of the collapsing node reversed."""
    excess = rows.relative_excess(x[:-1], float(x[-1]))
    return float(np.where(rows.limits_of(node), -excess, excess).max())
