"""The linear programs of the first collapse: one per node, its two rows reversed."""

from math import inf

import numpy as np

from shakedown.bounds.certificate import starts_safe
from shakedown.model.constraints import Constraints
from shakedown.model.problem import FloatArray, Problem
from shakedown.programs.linear_program import INF, LinearProgram, Solution
from shakedown.tolerances import Tolerances

_NEARLY_FIRST = 1e-8  # relative; nodes this near are told apart by polish, not by the solver's 1e-10


def mean_load_is_safe(
    problem: Problem, rows: Constraints, program: LinearProgram, certify: bool, tolerances: Tolerances
) -> bool:
    """Whether some slip is safe under the mean load alone."""
    if np.all(rows.g > 0):  # slip zero is
        return True
    start = program.solve()
    exact = starts_safe(problem, start, tolerances) if certify else None
    if exact is not None or start.vertex is None:
        return bool(exact)
    return bool(rows.relative_excess(rows.slips(start.vertex.x[:-1]), 0.0).max() <= tolerances.feasibility)


def collapses(rows: Constraints, program: LinearProgram, all_nodes: bool) -> list[Solution]:
    """The end of every node's program: in one model the two rows of one node are reversed at a time.

    Unless ``all_nodes`` are wanted, the first one that collapses at λ = 0 is the last:
    none can collapse earlier.
    """
    outcomes: list[Solution] = []
    free = np.full(2, INF)
    for node in range(rows.n):
        pair = np.array([2 * node, 2 * node + 1])
        program.set_rows(pair, rows.g[pair], free)
        outcomes.append(program.solve())
        program.set_rows(pair, -free, rows.g[pair])
        if not all_nodes and outcomes[-1].value <= 0.0 and _value(outcomes[-1]) == 0.0:
            break
    return outcomes


def collapse_values(outcomes: list[Solution]) -> FloatArray:
    """Where each node collapses, to the accuracy of the solver; inf where it never does."""
    return np.array([inf if np.isnan(outcome.value) else outcome.value for outcome in outcomes])


def first_to_collapse(outcomes: list[Solution]) -> int:
    """The node that collapses first: of those that the solver cannot tell apart, the first to round-off."""
    values = collapse_values(outcomes)
    least = values.min()
    near = (
        np.flatnonzero(values <= least + _NEARLY_FIRST * abs(least)) if np.isfinite(least) else np.array([0])
    )
    return min(near.tolist(), key=lambda node: _value(outcomes[node]))


def _value(outcome: Solution) -> float:
    return inf if outcome.vertex is None else float(outcome.vertex.x[-1])


def collapse_excess(rows: Constraints, node: int, x: FloatArray) -> float:
    """Largest relative violation of the rows, those of the collapsing node reversed."""
    excess = rows.relative_excess(x[:-1], float(x[-1]))
    return float(np.where(rows.node == node, -excess, excess).max())
