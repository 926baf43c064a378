"""The program of λ_E and R(λ) stated plainly: a cone per node and load step in raw slips, by Clarabel."""

import warnings

import numpy as np
from numpy.typing import ArrayLike

from shakedown import Problem
from shakedown.ground.constants import FloatArray
from shakedown.joint.constraints import loading


def plainly(
    problem: Problem,
    share: FloatArray | None = None,
    *,
    start: ArrayLike = 0.0,
    distance: float = 0.0,
    load_factor: float | None = None,
    least: bool = False,
) -> float:
    """λ_E from a slip, the largest or the least, or the largest radius at a load factor; NaN without one.

    With these shares (n, d), by default the own ones, and a cone each load step.
    """
    import cvxpy as cp

    n, d, loop, f = problem.n, problem.directions, loading(problem), problem.f
    force, stiffness = float(np.abs(problem.p_w).max()), float(np.abs(problem.A).max())
    A, B, unit = problem.A / stiffness, problem.B / stiffness, force / np.sqrt(stiffness)
    share = own_shares(problem) if share is None else share
    rest = B - np.einsum("ij,ijk->ik", share, A.reshape(n, d, -1))
    values, vectors = np.linalg.eigh(A)
    kept = values > 1e-9 * values[-1]
    root = (vectors[:, kept] * np.sqrt(values[kept])).T
    gamma = np.linalg.norm(rest @ (vectors[:, kept] / np.sqrt(values[kept])), axis=1)
    stretch = np.ones(n) if d == 1 else np.sqrt(1 + f**2 * (share**2).sum(axis=1))
    v, radius, factor = cp.Variable(d * n), cp.Variable(nonneg=True), cp.Variable(nonneg=True)
    way = v - np.asarray(start) * stiffness / force
    limits = [
        cp.norm(root @ way) + distance / unit <= radius if load_factor is None else factor == load_factor
    ]
    q, p = loop.q0 / force + A @ v, loop.p0 / force + B @ v
    for q1, p1 in zip(loop.q1 / force, loop.p1 / force, strict=True):
        drawn = cp.reshape(q + factor * q1, (d, n), order="F") @ np.diag(stretch)
        limits.append(cp.SOC(cp.multiply(f, p + factor * p1 - gamma * radius), drawn))
    aim = radius if load_factor is not None else -factor if least else factor
    task = cp.Problem(cp.Maximize(aim), limits)
    with warnings.catch_warnings():  # "may be inaccurate"
        warnings.simplefilter("ignore", UserWarning)
        try:
            task.solve(solver="CLARABEL")
        except cp.SolverError:
            return np.nan
    known = task.status in ("optimal", "optimal_inaccurate")
    return float(abs(aim.value)) * (1.0 if load_factor is None else unit) if known else np.nan


def own_shares(problem: Problem) -> FloatArray:
    """A_ii⁻¹ B_ii of every node, (n, d)."""
    n, d, nodes = problem.n, problem.directions, np.arange(problem.n)
    blocks = problem.A.reshape(n, d, n, d)[nodes, :, nodes, :]
    return np.linalg.solve(blocks, problem.B.reshape(n, n, d)[nodes, nodes][..., None])[..., 0]
