"""The load factor up to which no node can be lifted off by locked-in slip."""

from math import inf

import numpy as np

from shakedown.model.constraints import constraints, step_loads
from shakedown.model.problem import FloatArray, Problem
from shakedown.programs.linear_program import INF, LinearProgram
from shakedown.tolerances import DEFAULT, Tolerances

SEGMENTS_UP_TO = 2000


def lift_off_bound(problem: Problem, enough: float = inf, *, tolerances: Tolerances = DEFAULT) -> float:
    """A load factor below which all nodes stay closed, whatever admissible slips they have.

    A closed node j lifts off where both its limits are met at once, p = q = 0,
    while every other node is within its limits *of that instant*. The smallest
    load factor at which that is possible is a linear program in v and the load.
    The load is first taken anywhere in the convex hull of the loop (one program
    per node); where that falls short of ``enough``, on every segment of the loop. The corners
    of a load domain have no segments: there the hull it is.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    enough
        The load factor up to which the answer matters.
    tolerances
        A bound that falls short of ``enough`` by no more than ``feasibility`` reaches it.

    Returns
    -------
        The load factor; inf where no load factor lifts any node.

    Examples
    --------
    >>> import shakedown
    >>> lift_off_bound(shakedown.example("two-node"), enough=0.6574) >= 0.6574
    True
    """
    steps = step_loads(problem)
    hull = _first_lift_off(problem, steps, tolerances)
    reached = hull >= enough * (1 - tolerances.feasibility)
    if reached or problem.is_domain or problem.m < 3 or problem.n * problem.m > SEGMENTS_UP_TO:
        return hull
    ends = zip(steps, np.roll(steps, -1, axis=0), strict=True)
    return min(_first_lift_off(problem, np.array(pair), tolerances) for pair in ends)


def _first_lift_off(problem: Problem, corners: FloatArray, tolerances: Tolerances) -> float:
    """Smallest Σ α with the load r⁰ + Σ α_k r_k, α ≥ 0, at which some node has p = q = 0."""
    rows, count = constraints(problem), len(corners)
    program = LinearProgram(
        np.column_stack([rows.coefficients, corners.T]),
        cost=np.append(np.zeros(rows.n), np.ones(count)),
        lower=np.full(len(rows.g), -INF),
        upper=rows.g,
        column_lower=np.append(np.full(rows.n, -INF), np.zeros(count)),
        column_upper=np.full(rows.n + count, INF),
        tolerances=tolerances,
    )
    first, free = inf, np.full(2, INF)
    for node in range(rows.n):
        pair = np.array([2 * node, 2 * node + 1])
        program.set_rows(pair, rows.g[pair], free)
        vertex = program.solve().vertex
        program.set_rows(pair, -free, rows.g[pair])
        if vertex is not None:
            first = min(first, float(vertex.x[rows.n :].sum()))
    return first
