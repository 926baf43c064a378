"""The load factor up to which no node can be lifted off by locked-in slip."""

from math import inf

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import constraints, step_loads
from shakedown.joint.problem import Problem
from shakedown.programs.program import INF, Program
from shakedown.programs.simplex import Simplex

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
    ends = ([k, (k + 1) % problem.m] for k in range(problem.m))
    return min(_first_lift_off(problem, steps[pair], tolerances) for pair in ends)


def _first_lift_off(problem: Problem, corners: FloatArray, tolerances: Tolerances) -> float:
    """Smallest Σ α with the load r⁰ + Σ α_k r_k, α ≥ 0, at which some node has p = q = 0."""
    rows, count = constraints(problem), len(corners)
    all_slips = np.full(rows.n, INF)
    program = Simplex(
        Program(
            np.column_stack([rows.coefficients, corners.T]),
            rows.g,
            cost=np.append(np.zeros(rows.n), np.ones(count)),
            lower=np.append(-all_slips, np.zeros(count)),
            upper=np.append(all_slips, np.full(count, INF)),
            tolerances=tolerances,
        )
    )
    first = inf
    for node in range(problem.n):
        own = np.flatnonzero(rows.node == node)
        free = np.full(len(own), INF)
        program.set_rows(own, rows.g[own], free)
        found = program.solve()
        program.set_rows(own, -free, rows.g[own])
        if found.optimal:
            first = min(first, float(found.x[rows.n :].sum()))
    return first
