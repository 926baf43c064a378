"""The load factor below which no node alone can slip cyclically."""

from dataclasses import dataclass
from functools import partial
from math import inf, nan

import numpy as np

from shakedown.bounds.certificate import LOWER_CERTIFIED_UP_TO
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIDES, checked, require_plane
from shakedown.joint.constraints import Constraints, constraints, rows_of, step_loads
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.program import INF, Program
from shakedown.programs.solver import solve


@dataclass(frozen=True, eq=False, repr=False)
class SingleNodeCycle(Result):
    """The first cycle of one node alone that is not excluded.

    Attributes
    ----------
    load_factor
        The bound; inf where no node can cycle alone, NaN where a node is at or above
        its own critical friction, for a load domain (a cycle follows a loop), or for many
        nodes (not computed).
    node
        The node that would cycle; −1 where there is none.
    slip : (n,)
        Where the cycle would have ``node`` at its lowest slip [length]; NaN where there is none.
    """

    load_factor: float
    node: int
    slip: FloatArray


@checked
def single_node_cycle(problem: Problem, *, tolerances: Tolerances = DEFAULT) -> SingleNodeCycle:
    """A lower bound on every cycle in which one node slips to and fro and all others stick.

    For node j the slips of the others are constant and v_j(k) is its slip at
    load step k. In a cycle v_j is smallest where its backward row is extreme and
    active there, and largest where its forward row is; at every other step it lies
    between. Every row need only hold for the v_j of that step: eliminating v_j(k)
    between two rows that bound it from above and from below gives one inequality
    per pair, of which the extreme step counts. The smallest λ ≥ 0 that satisfies
    them all is the bound.

    Examples
    --------
    >>> import shakedown
    >>> cycle = single_node_cycle(shakedown.example("three-node"))
    >>> round(cycle.load_factor, 4), cycle.node
    (2.4442, 0)
    """
    require_plane("single-node cycle", problem, NO_SIDES)
    nowhere = np.full(problem.n, nan)
    own = np.diag(problem.A) - problem.f * np.abs(np.diag(problem.B))
    if problem.is_domain or problem.n > LOWER_CERTIFIED_UP_TO or np.any(own <= 0):
        return SingleNodeCycle(nan, -1, nowhere)
    first = SingleNodeCycle(inf, -1, nowhere)
    for node in range(problem.n):
        cycle = _first_cycle(problem, node, tolerances)
        if cycle.load_factor < first.load_factor:
            first = cycle
        if first.load_factor == 0.0:
            break
    return first


def _first_cycle(problem: Problem, node: int, tolerances: Tolerances) -> SingleNodeCycle:
    """The smallest λ ≥ 0 at which a cycle of one node is not excluded."""
    matrix, right, lowest = _cycle_rows(problem, node, tolerances.cancellation)
    x = _least_last(matrix, right, 4 * problem.n, tolerances)
    if x is None:
        return SingleNodeCycle(inf, -1, np.full(problem.n, nan))
    own = lowest @ np.append(x, 1.0)
    return SingleNodeCycle(float(x[-1]), node, np.insert(x[:-1], node, own))


def _least_last(
    matrix: FloatArray, right: FloatArray, core: int, tolerances: Tolerances
) -> FloatArray | None:
    """Minimise the last unknown ≥ 0 subject to matrix · x ≤ right; None where that is infeasible.

    Of many rows few matter: the first ``core`` are taken, then those found violated.
    """
    count = matrix.shape[1]
    taken = np.arange(len(right)) < core
    sizes = np.abs(matrix)
    while True:  # ends: every round takes further rows, and there are finitely many
        least, lower = np.append(np.zeros(count - 1), 1.0), np.append(np.full(count - 1, -INF), 0.0)
        found = solve(Program(matrix[taken], right[taken], cost=least, lower=lower, tolerances=tolerances))
        if not found.optimal:
            return None
        terms = np.maximum(sizes @ np.abs(found.x), np.abs(right))
        excess = (matrix @ found.x - right) / np.where(terms > 0, terms, 1.0)
        excess[taken] = 0.0
        worst = np.argsort(excess)[-count:]
        violated = worst[excess[worst] > tolerances.cancellation * count]
        if violated.size == 0:
            return found.x
        taken[violated] = True


def _cycle_rows(
    problem: Problem, node: int, cancellation: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rows ``matrix`` · (v without node, λ) ≤ ``right``, and v_j at its lowest as coefficients of (…, 1)."""
    rows, steps = constraints(problem), step_loads(problem)
    total, coefficients = partial(_sum, cancellation), rows.rigid.avoiding(node).columns(rows.G)
    share, G = coefficients[:, node], np.delete(coefficients, node, axis=1)
    pair = backward, forward = rows_of(node).tolist()
    lowest, highest = (_slip_where_active(rows, G, i, share[i]) for i in pair)
    blocks, bounds = [total(lowest[None, :-1], -highest[None, :-1])], [highest[-1:] - lowest[-1:]]
    for end, row in ((lowest, backward), (highest, forward)):
        block = total(np.column_stack([G, steps[rows.step[row]]]), share[:, None] * end[:-1])
        blocks.append(np.delete(block, row, axis=0))  # the row that defines the end holds there by itself
        bounds.append(np.delete(rows.g - share * end[-1], row))
    # The two ends bound v_j(k) like further rows: v_j − highest ≤ 0 and lowest − v_j ≤ 0.
    share = np.concatenate([share, [1.0, -1.0]])
    G = np.vstack([G, -highest[:-2], lowest[:-2]])
    steps = np.column_stack([steps, np.tile([-highest[-2], lowest[-2]], (problem.m, 1))])
    g = np.concatenate([rows.g, [highest[-1], -lowest[-1]]])
    implied = {(backward, len(g) - 1), (len(g) - 2, forward)}
    for upper in np.flatnonzero(share > 0):
        lower = np.array([i for i in np.flatnonzero(share < 0) if (upper, i) not in implied], dtype=np.intp)
        weight = -share[upper] / share[lower]
        load = total(steps[:, [upper]], weight * steps[:, lower]).max(axis=0)
        blocks.append(np.column_stack([total(G[upper], weight[:, None] * G[lower]), load]))
        bounds.append(g[upper] + weight * g[lower])
    still = np.flatnonzero(share == 0)
    blocks.append(np.column_stack([G[still], steps[:, still].max(axis=0)]))
    bounds.append(g[still])
    return np.vstack(blocks), np.concatenate(bounds), lowest


def _sum(cancellation: float, a: FloatArray, b: FloatArray) -> FloatArray:
    """a + b, with what round-off leaves of terms that cancel set to zero."""
    both = a + b
    noise = cancellation * (np.abs(a) + np.abs(b))
    return np.where(np.abs(both) <= noise, 0.0, both)


def _slip_where_active(rows: Constraints, G: FloatArray, row: int, share: float) -> FloatArray:
    """v_j where one of its rows is active: coefficients of (v without node, λ, 1)."""
    return np.concatenate([-G[row], [-rows.d[row], rows.g[row]]]) / share
