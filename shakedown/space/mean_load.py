"""Whether any slip is safe under the mean load: one program with a cone per node."""

import numpy as np

from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.program import INF, Program
from shakedown.programs.solver import solve
from shakedown.space.scaled_joint import scaled_joint


def safe_under_mean_load(problem: Problem, tolerances: Tolerances) -> bool:
    """Whether some slip keeps every node within its limit under the mean load alone.

    Maximise t subject to |q_i| + t ≤ f_i p_i. To the tolerance ``feasibility`` t = 0 will do.

    Raises
    ------
    SolverError
        If the program ends without an answer.
    """
    joint, pinned = scaled_joint(problem), list(rigid_slips(problem).pinned)
    A, B = joint.A.copy(), joint.B.copy()
    A[:, pinned] = B[:, pinned] = 0.0
    right, smooth = problem.law.cone(joint.q0, joint.p0), joint.f == 0
    pressed = np.arange(len(right)) >= 3 * joint.n  # p ≥ t without friction
    heads = ~pressed & (np.arange(len(right)) % 3 == 0)
    rows = np.column_stack([problem.law.stiffness(A, B), heads | pressed])
    in_cones = np.append(np.repeat(~smooth, 3), np.zeros(smooth.sum(), dtype=bool))
    none = ~in_cones & ~heads & ~pressed  # q = 0
    matrix = np.vstack([rows[none], rows[pressed], rows[in_cones]])
    right = np.concatenate([right[none], right[pressed], right[in_cones]])
    size = float(np.abs(right).max()) or 1.0
    matrix[:, :-1], right = matrix[:, :-1] / size, right / size
    left = np.where(np.arange(len(right)) < none.sum(), right, -INF)
    cost = np.append(np.zeros(len(A)), -1.0)
    upper = np.append(np.full(len(A), INF), 1.0)
    found = solve(Program(matrix, right, cost, cones=(3,) * int((~smooth).sum()), left=left, upper=upper))
    return bool(found.optimal and found.x[-1] >= -tolerances.feasibility)
