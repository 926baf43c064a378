"""The second road to the bounds: interior points (Clarabel through cvxpy).

Slow to import and less sharp than the simplex road; it is here to be compared with.
"""

import warnings
from dataclasses import dataclass
from math import inf, nan

import cvxpy as cp
import numpy as np

from shakedown.model.constraints import Constraints, constraints
from shakedown.model.loading import loading
from shakedown.model.problem import FloatArray, Problem
from shakedown.programs.equilibration import equilibration, typical_size
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
    loop, scale = loading(problem), _scale(constraints(problem))
    v, load_factor = cp.Variable(problem.n), cp.Variable(nonneg=True)
    rows = scale.rows.reshape(-1, 2)
    limits = []
    for side, weight in zip((+1.0, -1.0), rows.T, strict=True):
        G = (side * problem.A - problem.f[:, None] * problem.B) * weight[:, None] * scale.slips
        reach = (problem.f * loop.p0 - side * loop.q0) * weight / scale.size
        for q1, p1 in zip(loop.q1, loop.p1, strict=True):
            d = (side * q1 - problem.f * p1) * weight * scale.load_factor
            limits.append(G @ v + load_factor * d <= reach)
    status = _solve(cp.Problem(cp.Maximize(load_factor), limits), solver)
    return _bound(status, load_factor, v, scale, -1, solver)


def conic_lower_bound(problem: Problem, *, solver: str = "CLARABEL") -> ConicBound:
    """λ_1 from one program per node, its two rows reversed and every other row kept.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    solver
        Name of the cvxpy solver.

    Examples
    --------
    >>> import shakedown
    >>> round(conic_lower_bound(shakedown.example("two-node")).load_factor, 6)
    0.657373
    """
    rows = constraints(problem)
    scale = _scale(rows)
    G, d = rows.G * scale.rows[:, None] * scale.slips, rows.d * scale.rows * scale.load_factor
    g = rows.g * scale.rows / scale.size
    v, load_factor = cp.Variable(problem.n), cp.Variable(nonneg=True)
    sign = cp.Parameter(2 * problem.n)
    excess = G @ v + load_factor * d - g
    program = cp.Problem(cp.Minimize(load_factor), [cp.multiply(sign, excess) <= 0])
    best, open_nodes = ConicBound("unbounded", inf, -1, np.full(problem.n, nan), solver), 0
    for node in range(problem.n):
        sign.value = np.where(rows.node == node, -1.0, 1.0)
        status = _solve(program, solver)
        open_nodes += status == "undecided"
        if status == "optimal":
            best = min(best, _bound(status, load_factor, v, scale, node, solver), key=_value)
    if open_nodes and best.load_factor > DEFAULT.feasibility:  # a node left open may collapse first
        return ConicBound("undecided", nan, -1, np.full(problem.n, nan), solver)
    return best


def _value(bound: ConicBound) -> float:
    return bound.load_factor


@dataclass(frozen=True)
class _Scale:
    """Solvers with absolute tolerances need numbers near 1: units for rows, slips, load factor, reach."""

    rows: FloatArray
    slips: FloatArray
    load_factor: float
    size: float


def _scale(rows: Constraints) -> _Scale:
    row_scale, columns = equilibration(np.column_stack([rows.G, rows.d]))
    return _Scale(row_scale, columns[:-1], float(columns[-1]), typical_size(np.abs(rows.g) * row_scale))


def _solve(program: cp.Problem, solver: str) -> str:
    with warnings.catch_warnings():  # an inaccurate answer is a status here, not a warning
        warnings.simplefilter("ignore", UserWarning)
        try:
            program.solve(solver=solver, **(_SHARP if solver == "CLARABEL" else {}))
        except cp.SolverError:
            return "undecided"
    return str(program.status) if program.status in ("optimal", "infeasible", "unbounded") else "undecided"


def _bound(
    status: str, load_factor: cp.Variable, v: cp.Variable, scale: _Scale, node: int, solver: str
) -> ConicBound:
    if status == "optimal":
        value = float(np.asarray(load_factor.value)) * scale.load_factor * scale.size
        slip = np.asarray(v.value) * scale.slips * scale.size
        return ConicBound(status, value, node, slip, solver)
    value = inf if status == "unbounded" else nan
    return ConicBound(status, value, node, np.full(v.shape, nan), solver)
