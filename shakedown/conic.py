"""The second road to the bounds: interior points (Clarabel through cvxpy).

Slow to import and less sharp than the simplex road; it is here to be compared with.
"""

import warnings
from dataclasses import dataclass
from math import inf, nan

import cvxpy as cp
import numpy as np

from shakedown.constraints import Constraints, constraints
from shakedown.loading import loading
from shakedown.problem import FloatArray, Problem
from shakedown.tolerances import DEFAULT

_SHARP = {"tol_gap_abs": 1e-11, "tol_gap_rel": 1e-11, "tol_feas": 1e-11}


@dataclass(frozen=True)
class ConicBound:
    """A bound from an interior-point solver.

    Attributes
    ----------
    status
        ``"optimal"``, ``"infeasible"``, ``"unbounded"`` or ``"undecided"`` (the solver
        stopped short of its tolerances: what it had is not reported as a number).
    load_factor
        λ_max or λ_1; inf where it does not exist because nothing limits it, NaN
        where infeasible or undecided.
    node
        The node that collapses (λ_1 only), else −1.
    slip : (n,)
        The safe slip or the witness [length]; NaN unless optimal.
    solver
        Name of the solver.
    """

    status: str
    load_factor: float
    node: int
    slip: FloatArray
    solver: str


def conic_upper_bound(problem: Problem, *, solver: str = "CLARABEL") -> ConicBound:
    """λ_max from |q| ≤ f p at every node and every load step: the program (5.16) as it stands.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    solver
        Name of a linear-programming solver that cvxpy knows.

    Examples
    --------
    >>> import shakedown
    >>> round(conic_upper_bound(shakedown.example("two-node")).load_factor, 6)
    0.739146
    """
    loop = loading(problem)
    force, length = _units(constraints(problem))
    v, load_factor = cp.Variable(problem.n), cp.Variable(nonneg=True)
    Av = (problem.A * (length / force)) @ v + loop.q0 / force
    Bv = (problem.B * (length / force)) @ v + loop.p0 / force
    limits = []
    for q1, p1 in zip(loop.q1 / force, loop.p1 / force, strict=True):
        q, fp = Av + load_factor * q1, cp.multiply(problem.f, Bv + load_factor * p1)
        limits += [q <= fp, -q <= fp]
    status = _solve(cp.Problem(cp.Maximize(load_factor), limits), solver)
    return _bound(status, load_factor, v, length, -1, solver)


def conic_lower_bound(problem: Problem, *, solver: str = "CLARABEL") -> ConicBound:
    """λ_1 from one program per node, its two rows reversed and every other row kept.

    Examples
    --------
    >>> import shakedown
    >>> round(conic_lower_bound(shakedown.example("two-node")).load_factor, 6)
    0.657373
    """
    rows = constraints(problem)
    force, length = _units(rows)
    G, d, g = rows.G * (length / force), rows.d / force, rows.g / force
    v, load_factor = cp.Variable(problem.n), cp.Variable(nonneg=True)
    sign = cp.Parameter(2 * problem.n)
    excess = G @ v + load_factor * d - g
    program = cp.Problem(cp.Minimize(load_factor), [cp.multiply(sign, excess) <= 0])
    best, open_nodes = ConicBound("unbounded", inf, -1, np.full(problem.n, nan), solver), 0
    for node in range(problem.n):
        sign.value = np.where(rows.node == node, -1.0, 1.0)
        status = _solve(program, solver)
        open_nodes += status == "undecided"
        if status == "optimal" and float(np.asarray(load_factor.value)) < best.load_factor:
            best = _bound(status, load_factor, v, length, node, solver)
    if open_nodes and best.load_factor > DEFAULT.feasibility:  # a node left open may collapse first
        return ConicBound("undecided", nan, -1, np.full(problem.n, nan), solver)
    return best


def _units(rows: Constraints) -> tuple[float, float]:
    """A typical force and slip: solvers with absolute tolerances need numbers near 1."""
    force = float(np.abs(rows.g).max()) or 1.0
    stiffness = float(np.abs(rows.G).max()) or 1.0
    return force, force / stiffness


def _solve(program: cp.Problem, solver: str) -> str:
    with warnings.catch_warnings():  # an inaccurate answer is a status here, not a warning
        warnings.simplefilter("ignore", UserWarning)
        try:
            program.solve(solver=solver, **(_SHARP if solver == "CLARABEL" else {}))
        except cp.SolverError:
            return "undecided"
    return str(program.status) if program.status in ("optimal", "infeasible", "unbounded") else "undecided"


def _bound(
    status: str, load_factor: cp.Variable, v: cp.Variable, length: float, node: int, solver: str
) -> ConicBound:
    if status == "optimal":
        value, slip = float(np.asarray(load_factor.value)), np.asarray(v.value) * length
        return ConicBound(status, value, node, slip, solver)
    value = inf if status == "unbounded" else nan
    return ConicBound(status, value, node, np.full(v.shape, nan), solver)
