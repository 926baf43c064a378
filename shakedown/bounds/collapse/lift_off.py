"""The load factor up to which no node can be lifted off by locked-in slip."""

from math import inf

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.collapse.least_box import Box
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import constraints, step_loads
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.programs.program import INF, Program
from shakedown.programs.simplex import Simplex

SEGMENTS_UP_TO = 2000


def lift_off_bound(
    problem: Problem, enough: float = inf, *, within: Box | None = None, tolerances: Tolerances = DEFAULT
) -> float:
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
    within
        Slips that matter; by default all that are admissible.
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
    every = np.arange(problem.m)
    hull = _first_lift_off(problem, steps, _at_risk(problem, enough, within, every), within, tolerances)
    reached = hull >= enough * (1 - tolerances.feasibility)
    if reached or problem.is_domain or problem.m < 3 or problem.n * problem.m > SEGMENTS_UP_TO:
        return hull
    ends = (np.array([k, (k + 1) % problem.m]) for k in range(problem.m))
    return min(
        _first_lift_off(problem, steps[pair], _at_risk(problem, enough, within, pair), within, tolerances)
        for pair in ends
    )


def relieved(problem: Problem, box: Box, load_factor: float, steps: NDArray[np.intp]) -> NDArray[np.intp]:
    """The nodes that some slip in a box relieves of pressure, at load factors up to a given one.

    While the load is between the mean and these load steps.
    """
    loop = loading(problem)
    least = loop.p1[steps].min(axis=0)
    p_load = loop.p0 + np.multiply(load_factor, least, out=np.zeros_like(least), where=least < 0)
    return np.flatnonzero(p_load + box.least(problem.B) <= 0.0)


def _at_risk(problem: Problem, enough: float, box: Box | None, steps: NDArray[np.intp]) -> NDArray[np.intp]:
    return np.arange(problem.n) if box is None else relieved(problem, box, enough, steps)


def _first_lift_off(
    problem: Problem, corners: FloatArray, nodes: NDArray[np.intp], within: Box | None, tolerances: Tolerances
) -> float:
    """Smallest Σ α with the load r⁰ + Σ α_k r_k, α ≥ 0, at which one of some nodes has p = q = 0."""
    if not nodes.size:
        return inf
    rows, count = constraints(problem), len(corners)
    all_slips = np.full(rows.n, INF)
    low, high = (-all_slips, all_slips) if within is None else (within.low, within.high)
    program = Simplex(
        Program(
            np.column_stack([rows.coefficients, corners.T]),
            rows.g,
            cost=np.append(np.zeros(rows.n), np.ones(count)),
            lower=np.append(low, np.zeros(count)),
            upper=np.append(high, np.full(count, INF)),
            tolerances=tolerances,
        )
    )
    first = inf
    for node in nodes.tolist():
        own = np.flatnonzero(rows.node == node)
        free = np.full(len(own), INF)
        program.set_rows(own, rows.g[own], free)
        found = program.solve()
        program.set_rows(own, -free, rows.g[own])
        if found.optimal:
            first = min(first, float(found.x[rows.n :].sum()))
    return first
