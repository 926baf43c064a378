"""Whether every node stays closed inside a ball, come what may: then no jump there opens one."""

import numpy as np

from shakedown.bounds.energy.energy_metric import EnergyMetric
from shakedown.ground.float_array import FloatArray
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem


def closed_radius(
    problem: Problem, metric: EnergyMetric, slip: FloatArray, load_factors: tuple[float, ...]
) -> float:
    """The radius [√(force · length)] up to which p*_i(t) ≥ ‖B_i‖_{A⁻¹} R (docs/energy.md, 8).

    For every node and load step, at the load factors given and so between them: slip inside such a ball
    changes no pressure by more. Not positive where a pressure is not; inf for B = 0.

    Parameters
    ----------
    problem, metric
        The joint, all nodes closed, and its energy norm.
    slip : (2n,)
        The centre of the ball [length].
    load_factors
        λ.
    """
    need = np.linalg.norm(problem.B @ metric.inverse, axis=1) / metric.unit
    loop, own = loading(problem), problem.B @ slip
    steps = [loop.p0 + load_factor * loop.p1 for load_factor in load_factors]
    if problem.p_transient is not None:
        steps.append(problem.p_transient)
    least = np.min([step.min(axis=0) for step in steps if len(step)], axis=0) + own
    return float(np.min(np.divide(least, need, out=np.where(least > 0, np.inf, -np.inf), where=need > 0)))


def holds_without_load(
    problem: Problem, metric: EnergyMetric, share: FloatArray, slip: FloatArray, radius: float
) -> bool:
    """Whether the ball keeps its slack under the constant load alone, with these shares (n, 2)."""
    loop, layout = loading(problem), problem.layout
    q, p = layout.by_node(loop.q0 + problem.A @ slip), loop.p0 + problem.B @ slip
    rows = problem.B - np.einsum("ik,ikj->ij", share, problem.A.reshape(problem.n, 2, -1))
    gamma = np.linalg.norm(rows @ metric.inverse, axis=1) * radius / metric.unit
    stretch = np.hypot(1.0, problem.f * np.linalg.norm(share, axis=1))
    return bool((stretch * np.linalg.norm(q, axis=1) + problem.f * gamma <= problem.f * p).all())
