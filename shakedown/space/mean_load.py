"""Whether any slip is safe under the mean load: one program with a cone per node."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.program import INF, Program
from shakedown.programs.solver import solve
from shakedown.space.scaled_joint import scaled_joint

ROUND_OFF = 2.0**-44  # of loads, relative to the largest: no size of anything


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
    rough = joint.f > 0
    law, both = Law(joint.f[rough], 2), np.repeat(rough, 2)
    parts = [  # frictionless nodes: q = 0 and p ≥ t
        _Part(A[~both], joint.q0[~both], 0.0),
        _Part(-B[~rough], joint.p0[~rough], 1.0),
        _Part(law.stiffness(A[both], B[rough]), law.cone(joint.q0[both], joint.p0[rough]), _heads(rough)),
    ]
    matrix = np.vstack(
        [np.column_stack([each.matrix, np.broadcast_to(each.margin, len(each.matrix))]) for each in parts]
    )
    right = np.concatenate([-parts[0].right, parts[1].right, parts[2].right])
    size = max(float(np.abs(right).max()), float(np.finfo(float).tiny))
    right[np.abs(right) <= ROUND_OFF * size] = 0.0
    matrix[:, :-1] /= size
    left = np.full(len(right), -INF)
    left[: len(parts[0].matrix)] = right[: len(parts[0].matrix)] / size
    upper = np.append(np.full(len(A), INF), 1.0)
    cost = np.append(np.zeros(len(A)), -1.0)
    found = solve(Program(matrix, right / size, cost, cones=(3,) * int(rough.sum()), left=left, upper=upper))
    return bool(found.optimal and found.x[-1] >= -tolerances.feasibility)


class _Part(NamedTuple):
    matrix: FloatArray
    right: FloatArray
    margin: FloatArray | float


def _heads(rough: NDArray[np.bool_]) -> FloatArray:
    """1 in the first row of every cone."""
    return np.tile([1.0, 0.0, 0.0], int(rough.sum()))
